#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "tools/pair_audit/level_shares.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// A state for a robot that stands still, and its level.
struct RestState {
  scene::Positions positions;
  scene::ClearanceLevel level;
};

/// The first of levelStates() if a person has chosen it; or the first of its two without random joints that is at most
/// at WARN; or else the first with the best level.
enum class Rest : unsigned char { Chosen, Found };
RestState restState(const std::vector<scene::Positions>& states, const LevelShares& shares, Rest rest);

/// The parts that the files of a folder for a robot are made of.
struct RobotSetup {
  std::string urdf_path;   ///< its text is copied; meshes with relative paths become absolute ones
  std::string srdf;        ///< text
  std::string parameters;  ///< the parameters of the node (YAML)
  RestState rest;
};

/// Throws std::invalid_argument naming a file of the folder if it is not empty, or the folder if it is none. It need
/// not exist.
void requireEmpty(const std::string& folder);

/// Makes the folder: a catkin package with URDF, SRDF, parameters, a launch file that starts the node with them, and a
/// rostest that holds the robot in the state of rest. It has the name of the folder.
/// Failure: throws as requireEmpty() does, and std::invalid_argument naming the file that cannot be written.
void writeSetup(const std::string& folder, const scene::RobotModel& robot, const RobotSetup& setup);

}  // namespace proximity_server::tools
