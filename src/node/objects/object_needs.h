#pragma once

#include <vector>

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"

// Which poses a question needs.

namespace proximity_server::node {

/// The bodies for all checked pairs of a robot, with objects and without.
std::vector<int> bodiesOfCheckedPairs(const Robot& robot, const scene::Objects& objects);

/// The frames of all moving objects.
AskedFrames framesOf(const scene::Objects& objects);

// The same for the pairs of a list.
std::vector<int> bodiesOf(const Robot& robot, const scene::Objects& objects,
                          const std::vector<scene::ShapeRefPair>& pairs);
AskedFrames framesOf(const scene::Objects& objects, const std::vector<scene::ShapeRefPair>& pairs);

}  // namespace proximity_server::node
