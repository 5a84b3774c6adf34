#pragma once

#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

// Reading robots. Only the errors of files use Python.

namespace proximity_server::python {

/// The options of reading a robot and of its pairs. If one is not set, RobotText::config or the default decides.
struct LoadOptions {
  std::optional<double> mesh_tolerance;              ///< [m] see scene::ModelOptions
  std::optional<double> padding;                     ///< [m] see scene::ModelOptions::default_padding
  std::optional<std::vector<std::string>> packages;  ///< folders of packages; nullopt: by ROS_PACKAGE_PATH
  scene::PairFilterOptions pairs;
  bool allow_missing_meshes;                         ///< see scene::ModelOptions
  bool allow_broken_mimics;                          ///< see scene::ModelOptions
  std::function<void(const std::string&)> progress;  ///< is called in the thread that loads
};

/// Returns the result of `act`. Puts `name`, unless it is "", in front of its errors.
template <typename Act>
auto withNameInErrors(const std::string& name, const Act& act) {
  try {
    return act();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(name + (name.empty() ? "" : ": ") + error.what());
  }
}

/// Reads the whole text of a file. Needs the GIL. Throws Python's OSError of the file, such as FileNotFoundError.
std::string readTextFile(const std::filesystem::path& path);

/// The texts of a robot, and the names that errors have for them.
struct RobotText {
  std::string urdf;
  std::string srdf;  ///< "" if there is none
  std::string urdf_name, srdf_name;
  std::filesystem::path folder;           ///< relative paths of meshes begin here
  std::optional<std::string> thresholds;  ///< nullopt if there are none
  std::string thresholds_name;
  std::optional<std::string> config;  ///< the node's parameters, see scene::configFrom(); nullopt if there are none
  std::string config_name;
  std::filesystem::path config_folder;  ///< relative paths of its objects' meshes begin here
};

/// The configuration of a robot, with the options, which replace it.
/// Failure: throws std::invalid_argument naming config_name, the line and what is wrong.
scene::ConfigFile configOf(const RobotText& text, const LoadOptions& options);

/// Makes the model of a robot from its texts.
/// Failure: throws std::invalid_argument naming urdf_name or srdf_name, and the link, joint or file that is wrong;
///          std::runtime_error once `stop` is set.
std::shared_ptr<const scene::SceneModel> load(const RobotText& text, const LoadOptions& options,
                                              const std::atomic<bool>* stop);

/// The options for objects of the robot. Relative paths, packages and meshes are treated as for links;
/// `stop` must outlive the use of the options.
scene::ObjectOptions objectOptions(const RobotText& text, const LoadOptions& options, const std::atomic<bool>* stop);

/// The thresholds of the text, or else of the configuration; nullopt if there are none.
/// Failure: throws std::invalid_argument naming thresholds_name, and the line, link or group that is wrong.
std::optional<scene::LevelThresholds> thresholdsOf(const RobotText& text, const scene::RobotModel& robot);

}  // namespace proximity_server::python
