#pragma once

#include <string>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::tools {

/// The state as `joint=position` for the joints that move the pair; the others do not matter.
std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions);

}  // namespace proximity_server::tools
