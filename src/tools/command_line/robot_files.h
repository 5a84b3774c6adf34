#pragma once

#include <memory>
#include <optional>
#include <string>

#include "proximity_server/scene/filter/scene_model.h"

namespace proximity_server::tools {

/// The files of a robot, and how to read them.
struct RobotFiles {
  std::string urdf;
  std::string srdf;                      ///< "": none
  std::optional<double> mesh_tolerance;  ///< [m]; nullopt: the default of the library
};

/// The whole text of a file. Throws std::invalid_argument naming it if it cannot be read.
std::string readTextFile(const std::string& path);

/// Loads the same robot and pairs as the node would. Mesh packages are searched on ROS_PACKAGE_PATH; relative paths
/// start at the folder of the URDF. Throws std::invalid_argument naming file and link.
std::shared_ptr<const scene::SceneModel> loadSceneModel(const RobotFiles& files);

/// Prints every warning about robot and SRDF on standard error, one per line, with the text that the node logs.
void printWarnings(const scene::SceneModel& model);

}  // namespace proximity_server::tools
