#include "tools/robot/robot_files.h"

#include "proximity_server/scene/filter/links_of_groups.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/readable_file.h"
#include "system/number_text.h"
#include "system/whole_file.h"
#include "tools/program/options.h"
#include "tools/text/naming.h"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

std::string folderOf(const std::string& file) { return std::filesystem::absolute(file).parent_path(); }

}  // namespace

void addRobotOptions(ProgramOptions& program, RobotFiles& files, const std::string& needs) {
  program
      .addText("--config", "FILE", files.config,
               "the node's parameters, YAML or a dump of rosparam: what they say about geometry, pairs, levels, "
               "uncertainty and objects counts; an option that says otherwise is stronger")
      .needs = needs;
  addLength(program, "--mesh-tolerance", files.mesh_tolerance, 0.0,
            "how far pieces may lie from their mesh (default: 0.005; 0: triangles)")
      .needs = needs;
  program
      .addFlag("--allow-missing-meshes", files.allow_missing_meshes, true,
               "a mesh that cannot be read is a warning, and that geometry is NOT checked")
      .needs = needs;
  program
      .addFlag("--allow-broken-mimics", files.allow_broken_mimics, true,
               "a mimic that makes no sense, as of a joint that does not exist, is a warning, and the joint has "
               "a position of its own")
      .needs = needs;
}

void addJointInequalities(ProgramOptions& program, RobotFiles& files) {
  program.addText(
      "--joint-inequalities", "FILE", files.joint_inequalities,
      "limits that couple joints: YAML, a list like \"2*j1 - j2 <= 1.7\", in radians, metres or 90deg. Random "
      "states are within them, and a warning names the other states that break one");
}

void addQuiet(ProgramOptions& program, Warnings& warnings) {
  program.addFlag("--quiet", warnings, Warnings::Hidden, "no warnings and no steps of loading on standard error");
}

std::string readTextFile(const std::string& path) {
  scene::requireReadable(path);
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string srdfOf(const RobotFiles& files) { return files.srdf.empty() ? "" : readTextFile(files.srdf); }

scene::ConfigFile configOf(const RobotFiles& files) {
  scene::ConfigFile config;
  if (!files.config.empty())
    config = scene::configFrom(readTextFile(files.config), files.config, folderOf(files.config));
  scene::RobotConfig& robot = config.robot;
  if (files.mesh_tolerance) robot.model.mesh_tolerance = *files.mesh_tolerance;
  robot.model.allow_missing_meshes |= files.allow_missing_meshes;
  robot.model.allow_broken_mimics |= files.allow_broken_mimics;
  robot.useMeshCache();
  return config;
}

scene::MeshResolver meshResolver(const scene::RobotConfig& config, const std::string& folder) {
  return [find = config.meshResolver(folder)](const std::string& uri) {
    const std::string path = find(uri);
    system::FileRoles::ofProcess().addInput("the mesh", path);
    return path;
  };
}

std::shared_ptr<const scene::SceneModel> loadSceneModel(const RobotFiles& files) {
  const scene::ConfigFile config = configOf(files);
  printWarnings(config.warnings, files.warnings);
  scene::ModelOptions options = config.robot.model;
  if (files.warnings == Warnings::Shown) options.progress = [](const std::string& what) { std::cerr << what << '\n'; };
  const std::string srdf = srdfOf(files);
  if (!files.srdf.empty() && srdf.find_first_not_of(" \t\r\n") == std::string::npos)
    printWarnings({files.srdf + ": the file is empty, so only neighbours are not checked."}, files.warnings);
  scene::RobotModel robot = naming(files.urdf, [&] {
    const std::string urdf = readTextFile(files.urdf);
    return scene::loadRobotModel(urdf, meshResolver(config.robot, folderOf(files.urdf)),
                                 withLinksOfGroups(options, {{"", urdf}}, {srdf}));
  });
  if (files.joint_inequalities.empty())
    naming(files.config, [&] { config.robot.setInequalities(robot); });
  else
    scene::readJointInequalities(files.joint_inequalities, robot);
  return naming(files.srdf.empty() ? files.urdf : files.srdf, [&] {
    return std::make_shared<const scene::SceneModel>(
        scene::makeSceneModel(std::move(robot), srdf, config.robot.filter));
  });
}

scene::RobotModel loadJoints(const RobotFiles& files) {
  scene::ModelOptions options;
  options.allow_missing_meshes = true;
  options.allow_broken_mimics = configOf(files).robot.model.allow_broken_mimics;
  const scene::MeshResolver no_mesh = [](const std::string& uri) -> std::string { throw std::invalid_argument(uri); };
  return naming(files.urdf, [&] { return scene::loadRobotModel(readTextFile(files.urdf), no_mesh, options); });
}

void printWarnings(const std::vector<std::string>& sentences, Warnings warnings) {
  if (warnings == Warnings::Hidden) return;
  for (const std::string& sentence : sentences)
    if (!sentence.empty()) std::cerr << "warning: " << system::readable(sentence) << '\n';
}

void printWarningsOf(const scene::SceneModel& model, Warnings warnings) {
  printWarnings(model.robot.warnings, warnings);
  printWarnings(model.pairs.warnings, warnings);
}

}  // namespace proximity_server::tools
