#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/objects/object.h"

// No Python here but the error of a file.

namespace proximity_server::python {

/// How a robot is read, and which pairs are checked.
struct LoadOptions {
  double mesh_tolerance;                             ///< [m] see scene::ModelOptions
  double padding;                                    ///< [m] see scene::ModelOptions::default_padding
  std::optional<std::vector<std::string>> packages;  ///< folders of packages; nullopt: those of ROS_PACKAGE_PATH
  scene::PairFilterOptions pairs;
  bool allow_missing_meshes;  ///< see scene::ModelOptions, as the next
  bool allow_broken_mimics;
  std::function<void(const std::string&)> progress;  ///< is called in the calling thread
};

/// The whole text of a file. With the GIL: throws Python's OSError of the file, such as FileNotFoundError.
std::string readTextFile(const std::filesystem::path& path);

/// A URDF with its SRDF ("": none) and thresholds, and how errors name them.
struct RobotText {
  std::string urdf, srdf;
  std::string urdf_name, srdf_name;
  std::filesystem::path folder;           ///< where relative paths of meshes begin
  std::optional<std::string> thresholds;  ///< nullopt: none
  std::string thresholds_name;
};

/// Failure: throws std::invalid_argument naming urdf_name or srdf_name, and what the library says is wrong: link, joint, file.
std::shared_ptr<const scene::SceneModel> load(const RobotText& text, const LoadOptions& options);

/// How objects of the robot are made: relative paths, packages and meshes as those of the links.
scene::ObjectOptions objectOptions(const RobotText& text, const LoadOptions& options);

/// The thresholds of the text; nullopt if there are none.
/// Failure: throws std::invalid_argument naming thresholds_name, and the line, link or group that is wrong.
std::optional<scene::LevelThresholds> thresholdsOf(const RobotText& text, const scene::RobotModel& robot);

}  // namespace proximity_server::python
