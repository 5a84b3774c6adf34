#include "python/loading.h"

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
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

scene::ModelOptions modelOptions(const LoadOptions& options) {
  requireLength("mesh_tolerance", options.mesh_tolerance);
  requireLength("padding", options.padding);
  scene::ModelOptions model;
  model.mesh_tolerance = options.mesh_tolerance;
  model.default_padding = options.padding;
  model.allow_missing_meshes = options.allow_missing_meshes;
  model.allow_broken_mimics = options.allow_broken_mimics;
  model.mesh_cache = scene::userMeshCache();
  model.progress = options.progress;
  return model;
}

scene::MeshResolver resolverOf(const RobotText& text, const LoadOptions& options) {
  return scene::packageResolver(options.packages ? *options.packages : scene::rosPackagePath(), text.folder);
}

}  // namespace

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
  scene::ModelOptions model_options = modelOptions(options);
  model_options.stop = stop;
  scene::RobotModel robot = withNameInErrors(
      text.urdf_name, [&] { return scene::loadRobotModel(text.urdf, resolverOf(text, options), model_options); });
  return withNameInErrors(text.srdf_name, [&] {
    return std::make_shared<const scene::SceneModel>(scene::makeSceneModel(std::move(robot), text.srdf, options.pairs));
  });
}

scene::ObjectOptions objectOptions(const RobotText& text, const LoadOptions& options, const std::atomic<bool>* stop) {
  scene::ObjectOptions objects;
  objects.resolve = resolverOf(text, options);
  objects.meshes.tolerance = options.mesh_tolerance;
  objects.meshes.cache = scene::userMeshCache();
  objects.meshes.progress = options.progress;
  objects.meshes.stop = stop;
  return objects;
}

std::optional<scene::LevelThresholds> thresholdsOf(const RobotText& text, const scene::RobotModel& robot) {
  if (!text.thresholds) return std::nullopt;
  const scene::ThresholdFile file = scene::thresholdsFrom(*text.thresholds, text.thresholds_name);
  return withNameInErrors(text.thresholds_name,
                          [&] { return scene::levelThresholds(robot, {text.srdf}, file.rules, file.defaults); });
}

}  // namespace proximity_server::python
