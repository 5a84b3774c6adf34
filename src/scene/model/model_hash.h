#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <string>

namespace proximity_server::scene {

/// A hash of all that decides the distances of links in a state of the joints: the tree of bodies and joints with their
/// limits, and the pieces with their paddings. Two models with the same hash have the same proofs. Names of links and
/// joints are a part of it, as files name them; pairs that are checked are not.
std::string modelHash(const RobotModel& robot);

}  // namespace proximity_server::scene
