#include "python/loading.h"

#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/filter/links_of_groups.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "python/path_caster.h"

#include <pybind11/pybind11.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::python {
namespace {

namespace py = pybind11;

[[noreturn]] void throwOsError(int error, const std::filesystem::path& path) {
  errno = error;
  PyErr_SetFromErrnoWithFilenameObject(PyExc_OSError, py::cast(path).ptr());
  throw py::error_already_set();
}

void requireLength(const std::string& name, double length) {
  if (std::isfinite(length) && length >= 0.0) return;
  std::ostringstream text;
  text << name << " is " << length << ", but must be a finite length of at least 0 m";
  throw std::invalid_argument(text.str());
}

scene::MeshResolver resolverOf(const RobotText& text, const LoadOptions& options, const scene::RobotConfig& config) {
  return options.packages ? scene::packageResolver(*options.packages, text.folder) : config.meshResolver(text.folder);
}

template <typename Value>
void replace(Value& value, const Value& given) {
  if (!given.empty()) value = given;
}

}  // namespace

scene::ConfigFile configOf(const RobotText& text, const LoadOptions& options) {
  scene::ConfigFile config;
  if (text.config) config = scene::configFrom(*text.config, text.config_name, text.config_folder);
  scene::ModelOptions& model = config.robot.model;
  model.mesh_tolerance = options.mesh_tolerance.value_or(model.mesh_tolerance);
  model.default_padding = options.padding.value_or(model.default_padding);
  requireLength("mesh_tolerance", model.mesh_tolerance);
  requireLength("padding", model.default_padding);
  model.allow_missing_meshes |= options.allow_missing_meshes;
  model.allow_broken_mimics |= options.allow_broken_mimics;
  model.progress = options.progress;
  config.robot.useMeshCache();
  replace(config.robot.filter.group, options.pairs.group);
  replace(config.robot.filter.exclude_pairs, options.pairs.exclude_pairs);
  replace(config.robot.filter.only_pairs, options.pairs.only_pairs);
  return config;
}

std::string readTextFile(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throwOsError(errno != 0 ? errno : EIO, path);
  if (std::filesystem::is_directory(path)) throwOsError(EISDIR, path);
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throwOsError(EIO, path);
  return text.str();
}

std::shared_ptr<const scene::SceneModel> load(const RobotText& text, const LoadOptions& options,
                                              const std::atomic<bool>* stop) {
  scene::RobotConfig config = configOf(text, options).robot;
  config.model.stop = stop;
  scene::RobotModel robot = withNameInErrors(text.urdf_name, [&] {
    return scene::loadRobotModel(text.urdf, resolverOf(text, options, config),
                                 withLinksOfGroups(config.model, {{"", text.urdf}}, {text.srdf}));
  });
  withNameInErrors(text.config_name, [&] { config.setInequalities(robot); });
  return withNameInErrors(text.srdf_name, [&] {
    return std::make_shared<const scene::SceneModel>(scene::makeSceneModel(std::move(robot), text.srdf, config.filter));
  });
}

scene::ObjectOptions objectOptions(const RobotText& text, const LoadOptions& options, const std::atomic<bool>* stop) {
  const scene::RobotConfig config = configOf(text, options).robot;
  scene::ObjectOptions objects;
  objects.resolve = resolverOf(text, options, config);
  objects.meshes.tolerance = config.model.mesh_tolerance;
  objects.meshes.cache = config.model.mesh_cache;
  objects.meshes.time_budget = config.model.mesh_time_budget;
  objects.meshes.progress = options.progress;
  objects.meshes.stop = stop;
  return objects;
}

std::optional<scene::LevelThresholds> thresholdsOf(const RobotText& text, const scene::RobotModel& robot) {
  if (!text.thresholds && !text.config) return std::nullopt;
  const std::string& name = text.thresholds ? text.thresholds_name : text.config_name;
  const scene::ConfigFile file =
      text.thresholds ? scene::thresholdsFrom(*text.thresholds, name) : scene::configFrom(*text.config, name);
  return withNameInErrors(name, [&] { return file.robot.thresholdsOf(robot, {text.srdf}, file.levels); });
}

}  // namespace proximity_server::python
