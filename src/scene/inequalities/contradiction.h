#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <vector>

namespace proximity_server::scene {

/// Inequalities of a robot that no positions within the limits of the joints obey together, as indices; empty if some
/// positions obey all of them. Joints without limits are taken to be within 1e6 rad or m.
///
/// 1. Scale each inequality so that its weight is 1, and ask for the smallest t with which positions within the limits
///    exist whose excesses are at most t.
/// 2. That is a linear program in the positions and t. Move the lower limits to 0 and solve it by the simplex method,
///    beginning where all joints are at their lower limits and t is the largest excess.
/// 3. If t is above the tolerance, inequalities with a multiplier in the optimum contradict each other.
/// Error:   the error of t is about 1e-15 times the largest limit, far below the tolerance.
/// Source:  Chvatal, Linear Programming, 1983, chapter 3. Bland's rule keeps the method from cycling.
std::vector<int> contradiction(const RobotModel& robot);

}  // namespace proximity_server::scene
