#pragma once

#include "node/robot/robot.h"
#include "proximity_server/scene/objects/objects.h"

#include <visualization_msgs/MarkerArray.h>

namespace proximity_server::node {

/// Draws the shapes of all objects as they were sent, each fixed in the frame that carries its object, with the
/// object's id as namespace. The first marker deletes all earlier ones. Half-spaces are drawn as squares of 10 m.
/// Paddings are not drawn.
visualization_msgs::MarkerArray objectMarkers(const Robot& robot, const scene::Objects& objects);

}  // namespace proximity_server::node
