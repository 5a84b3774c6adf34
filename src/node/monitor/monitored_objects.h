#pragma once

#include "node/objects/object_needs.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/state/object_carriers.h"

#include <cstddef>
#include <vector>

namespace proximity_server::node {

/// The joints and roots that can move the two parts of a checked pair relative to each other, and the joints of
/// RobotModel::inequalities. The parts are links and objects; an object moves with the link or frame that carries it.
struct MotionSources {
  std::vector<int> joints;  ///< indices into RobotModel::joints, ascending; a mimic joint is replaced by its leader
  std::vector<int> roots;   ///< an argument for TfPoses::standingStill(); only tf tells how roots move
};
MotionSources motionSourcesOf(const Robot& robot, const scene::Objects& objects);

/// Objects with the data that the monitor needs about them. The data are computed before the monitor gets the objects,
/// so that no cycle waits for that.
struct MonitoredObjects {
  MonitoredObjects() = default;
  MonitoredObjects(const Robot& robot, const RobotObjects& present);

  RobotObjects objects;
  std::vector<int> bodies;       ///< the bodies whose poses a cycle needs
  MotionSources motion_sources;  ///< the joints and roots whose velocities the lookahead needs
  CarrierFrames frames;          ///< the frames that carry moving objects
  scene::ObjectCarriers carriers;
  std::size_t longest_name = 0;  ///< [characters] of the longest name of a robot, link, <collision> element or object
};

}  // namespace proximity_server::node
