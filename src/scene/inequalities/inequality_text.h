#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// The one or two inequalities of a text, see setJointInequalities().
/// Failure: throws std::invalid_argument with the reason.
std::vector<JointInequality> inequalitiesOf(const std::string& text, const RobotModel& robot);

}  // namespace proximity_server::scene
