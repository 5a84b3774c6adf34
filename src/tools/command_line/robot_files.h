#pragma once

#include <memory>
#include <optional>
#include <string>

#include "proximity_server/scene/filter/scene_model.h"

namespace proximity_server::tools {

/// Where a robot is on disk.
struct RobotFiles {
  std::string urdf;
  std::string srdf;                      ///< "": none
  std::optional<double> mesh_tolerance;  ///< [m]; nothing: the default of the library
};

/// The whole text of a file. Throws std::invalid_argument naming it where it cannot be read.
std::string readTextFile(const std::string& path);

/// Robot and pairs as the node would have them. Mesh packages are found on ROS_PACKAGE_PATH, relative paths beside the
/// URDF. Throws std::invalid_argument naming file and link.
std::shared_ptr<const scene::SceneModel> loadSceneModel(const RobotFiles& files);

/// Every warning of robot and SRDF on standard error, one a line, as the node logs them.
void printWarnings(const scene::SceneModel& model);

}  // namespace proximity_server::tools
