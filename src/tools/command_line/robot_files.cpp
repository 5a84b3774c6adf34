#include "tools/command_line/robot_files.h"
#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "proximity_server/scene/query/make_scene_model.h"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>

namespace proximity_server::tools {

std::string readTextFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path)) throw std::invalid_argument(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::shared_ptr<const scene::SceneModel> loadSceneModel(const RobotFiles& files) {
  scene::ModelOptions options;
  if (files.mesh_tolerance) options.mesh_tolerance = *files.mesh_tolerance;
  options.mesh_cache = scene::userMeshCache();
  options.progress = [](const std::string& what) { std::cerr << what << '\n'; };
  const std::string folder = std::filesystem::absolute(files.urdf).parent_path();
  const std::string srdf = files.srdf.empty() ? "" : readTextFile(files.srdf);
  try {
    scene::RobotModel robot = scene::loadRobotModel(readTextFile(files.urdf),
                                                    scene::packageResolver(scene::rosPackagePath(), folder), options);
    return std::make_shared<const scene::SceneModel>(scene::makeSceneModel(std::move(robot), srdf));
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    if (what.compare(0, files.urdf.size(), files.urdf) == 0) throw;
    const bool from_srdf = what.compare(0, 4, "SRDF") == 0;
    throw std::invalid_argument((from_srdf ? files.srdf : files.urdf) + ": " + what);
  }
}

void printWarnings(const scene::SceneModel& model) {
  for (const auto* warnings : {&model.robot.warnings, &model.pairs.warnings}) {
    for (const std::string& warning : *warnings) std::cerr << "warning: " << warning << '\n';
  }
}

}  // namespace proximity_server::tools
