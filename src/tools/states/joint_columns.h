#pragma once

#include <string>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::tools {

/// A name in double quotes, for messages.
std::string inQuotes(const std::string& name);

/// What a column of a table of states is about.
struct JointColumn {
  static constexpr int kTime = -1;
  std::string name;
  int joint;  ///< index into RobotModel::joints, or kTime
};

/// The columns of these names. A column "time" is the time of the state, unless a joint has that name.
/// Failure: throws std::invalid_argument naming the column: an unknown, repeated, fixed, floating or planar joint.
std::vector<JointColumn> jointColumns(const std::vector<std::string>& names, const scene::RobotModel& robot);

/// Whether one of them is the time.
bool hasTime(const std::vector<JointColumn>& columns);

/// A sentence about each column that is not used, because its joint follows another one.
std::vector<std::string> unusedColumns(const std::vector<JointColumn>& columns, const scene::RobotModel& robot);

/// "column "elbow": " and what is wrong with a number in it, for messages.
std::string notFinite(const std::string& column, const std::string& number);

/// Index of the joint, which has one position.
/// Failure: throws std::invalid_argument with the reason, without the name: an unknown, fixed, floating or planar joint.
int jointWithPosition(const std::string& name, const scene::RobotModel& robot);

/// What follows "... is not used: " in a warning about a joint; "" if it follows no other one.
std::string whyNotUsed(const scene::RobotModel& robot, int joint);

}  // namespace proximity_server::tools
