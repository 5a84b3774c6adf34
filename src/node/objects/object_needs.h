#pragma once

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/state/object_carriers.h"

#include <vector>

// The poses that a question needs, and the bodies with which objects move.

namespace proximity_server::node {

/// The bodies whose poses are needed for all checked pairs: those of links, and those with objects.
std::vector<int> bodiesOfCheckedPairs(const Robot& robot, const scene::Objects& objects);

/// Adds the bodies of the joints of RobotModel::inequalities.
std::vector<int> withInequalities(const Robot& robot, const std::vector<int>& bodies);

/// The frames of moving objects, all of which are needed.
CarrierFrames framesOf(const scene::Objects& objects);

/// The bodies whose poses are needed for the pairs of a list.
std::vector<int> bodiesOf(const Robot& robot, const scene::Objects& objects,
                          const std::vector<scene::ShapeRefPair>& pairs);

/// The frames of moving objects; those of objects in the pairs of a list are needed.
CarrierFrames framesOf(const scene::Objects& objects, const std::vector<scene::ShapeRefPair>& pairs);

/// The body with which an object moves: the body of the link that holds it, or of the link whose frame carries it, or
/// otherwise of the reference link. It is -1 if the object rests in a reference frame that is not that of a link.
int carrierOf(const Robot& robot, const scene::Object& object);

/// The bodies with which all objects move that no link holds. A root carries only the objects in frames of links: all
/// others stand beside it, and how exactly it stands there is its uncertainty.
scene::ObjectCarriers carriersOf(const Robot& robot, const scene::Objects& objects);

}  // namespace proximity_server::node
