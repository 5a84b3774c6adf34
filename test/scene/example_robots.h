#pragma once

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "sanitized.h"
#include "scene/files.h"

#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// A robot of the package example-robot-data; the files are relative to its folder `robots`.
struct ExampleRobot {
  const char* name;
  const char* urdf;
  const char* srdf;
};

inline constexpr ExampleRobot kExampleRobots[] = {
    {"Panda", "panda_description/urdf/panda.urdf", "panda_description/srdf/panda.srdf"},
    {"Ur5", "ur_description/urdf/ur5_robot.urdf", "ur_description/srdf/ur5.srdf"},
    {"Pr2", "pr2_description/urdf/pr2.urdf", "pr2_description/srdf/pr2.srdf"}};

/// Those that a test goes through: the meshes of the others take minutes under a sanitizer.
inline std::vector<ExampleRobot> robotsToTest() {
#ifdef PROXIMITY_SANITIZED
  return {kExampleRobots[0]};
#else
  return {std::begin(kExampleRobots), std::end(kExampleRobots)};
#endif
}

constexpr char kExampleRobotsMissing[] =
    "The package example-robot-data is neither on ROS_PACKAGE_PATH nor beside this one.";

/// Packages are looked for on ROS_PACKAGE_PATH, then beside this one.
inline MeshResolver exampleRobotsResolver() {
  std::vector<std::string> roots = rosPackagePath();
  roots.push_back(PROXIMITY_SOURCE_DIR "/../shared/robots");
  return packageResolver(roots);
}

inline bool findsExampleRobots(const MeshResolver& resolve) {
  try {
    resolve("package://example-robot-data/package.xml");
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

/// The path of a file of ExampleRobot.
inline std::string exampleRobotFile(const MeshResolver& resolve, const std::string& file) {
  return resolve("package://example-robot-data/robots/" + file);
}

/// For tests that are not about decompositions: each is made once, and all tests share those of the user. They take
/// seconds, and under a sanitizer minutes.
inline ModelOptions cachedLoading() {
  ModelOptions options;
  options.mesh_cache = userMeshCache();
  return options;
}

/// The robot of ./dev demo with the pairs of its SRDF.
inline std::shared_ptr<const SceneModel> demoModel() {
  const std::string files = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  RobotModel robot =
      loadRobotModel(readFile(files + ".urdf"), packageResolver({PROXIMITY_SOURCE_DIR "/.."}), cachedLoading());
  PairTable pairs = filterPairs(robot, readFile(files + ".srdf"));
  return std::make_shared<const SceneModel>(SceneModel{std::move(robot), std::move(pairs)});
}

/// An example robot with the pairs of its SRDF.
inline std::shared_ptr<const SceneModel> modelOf(const ExampleRobot& files, const MeshResolver& resolve,
                                                 const ModelOptions& options = cachedLoading()) {
  RobotModel robot = loadRobotModel(readFile(exampleRobotFile(resolve, files.urdf)), resolve, options);
  PairTable pairs = filterPairs(robot, readFile(exampleRobotFile(resolve, files.srdf)));
  return std::make_shared<const SceneModel>(SceneModel{std::move(robot), std::move(pairs)});
}

/// How a robot is loaded where its pieces do not matter: a sanitized run takes the hulls of its meshes.
inline ModelOptions quickLoading() {
  ModelOptions options = cachedLoading();
  if (kIsSanitized) options.mesh_tolerance = 1.0;
  return options;
}

}  // namespace proximity_server::scene
