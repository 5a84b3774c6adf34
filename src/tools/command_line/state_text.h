#pragma once

#include <string>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::tools {

/// The positions, as `joint=position`, of the joints that move the pair; all others do not matter.
std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions);

}  // namespace proximity_server::tools
