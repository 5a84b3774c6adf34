#pragma once

#include <string>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::tools {

/// CSV with a row for each joint that moves: joint, type, lower, upper, unit, mimic. The limits are inf where there are none, the
/// unit is that of a position (rad, m), and mimic is the joint that it follows.
std::string jointList(const scene::RobotModel& robot);

}  // namespace proximity_server::tools
