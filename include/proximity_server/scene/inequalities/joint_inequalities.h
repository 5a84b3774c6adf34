#pragma once

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/robot_model.h"

#include <string>

namespace proximity_server::scene {

/// Sets RobotModel::inequalities from a list of texts, or of a map with this list as `joint_inequalities`:
///
///     - 2*j1 - j2 <= 1.7
///     - -347 deg <= 1.71*(shoulder_pitch - shoulder_roll) <= 112 deg
///
/// A text has sums of joints and numbers, with brackets, and one comparison (<= or >=), or two in the same direction.
/// Positions are in radians or metres; "deg" behind a number makes radians of it. A mimic joint stands for its leader.
///
/// Failure: throws std::invalid_argument with `source`, the line, the entry and the reason: a joint that does not exist
///          or has not one position, a text that is not linear or cannot be read, one in which no joint is left; and
///          naming the inequalities that contradict each other within the limits of the joints. Then nothing changes.
/// Limit:   joints without limits are taken to be within 1e6 rad or m.
void setJointInequalities(const FileValue& value, const std::string& source, RobotModel& robot);

/// Reads a file of YAML. Failure: as setJointInequalities(), and if the file cannot be read.
void readJointInequalities(const std::string& path, RobotModel& robot);

}  // namespace proximity_server::scene
