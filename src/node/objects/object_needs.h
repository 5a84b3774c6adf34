#pragma once

#include <vector>

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/derivative/object_carriers.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"

// Which poses a question needs, and with what objects move.

namespace proximity_server::node {

/// The bodies for all checked pairs of a robot, with objects and without.
std::vector<int> bodiesOfCheckedPairs(const Robot& robot, const scene::Objects& objects);

/// The frames of all moving objects.
AskedFrames framesOf(const scene::Objects& objects);

// The same for the pairs of a list.
std::vector<int> bodiesOf(const Robot& robot, const scene::Objects& objects,
                          const std::vector<scene::ShapeRefPair>& pairs);
AskedFrames framesOf(const scene::Objects& objects, const std::vector<scene::ShapeRefPair>& pairs);

/// The body with which an object moves: that of its link, of the link whose frame carries it, or of the reference frame if that
/// is a link; -1 if it rests in a reference frame that is none.
int carrierOf(const Robot& robot, const scene::Object& object);

/// The same of all objects that no link holds.
scene::ObjectCarriers carriersOf(const Robot& robot, const scene::Objects& objects);

}  // namespace proximity_server::node
