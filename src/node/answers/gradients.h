#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/state/state.h"

#include <string>
#include <vector>

namespace proximity_server::node {

/// The position of a joint at these poses, [rad] in (-pi, pi] or [m]; NaN for planar and floating joints, and if a pose
/// is missing.
double jointPositionAt(const scene::RobotModel& robot, const scene::Joint& joint, const scene::BodyPoses& poses);

// Messages that have held as many numbers before allocate no memory in the following functions.

/// Writes the names of the columns of a gradient.
void assignColumns(std::vector<std::string>& names, const scene::DegreesOfFreedom& columns);

/// Writes the position of each column at these poses, [rad] in (-pi, pi] or [m]. It is NaN if a pose is missing, and
/// for planar and floating joints.
void assignPositions(std::vector<double>& positions, const scene::State& state, const scene::BodyPoses& poses);

}  // namespace proximity_server::node
