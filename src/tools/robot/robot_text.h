#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "proximity_server/scene/query/question.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace proximity_server::tools {

using scene::kContactDistance;

/// CSV with a row for each joint that moves: joint, type, lower, upper, unit, mimic. The limits are inf where there are
/// none, the unit is the unit of a position (rad, m), and mimic is the joint that it follows.
std::string jointList(const scene::RobotModel& robot);

/// The positions of the joints that lead, by their names.
nlohmann::ordered_json positionsJson(const scene::RobotModel& robot, const scene::Positions& positions);

/// The positions, as `joint=position`, of the joints that move the pair; all others do not matter.
std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions);

/// A length with three significant digits, "0.0499 m".
std::string lengthText(double length);

}  // namespace proximity_server::tools
