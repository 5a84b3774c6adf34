#pragma once

#include "node/monitor/lookahead.h"
#include "node/robot/robot.h"
#include "node/tf/joint_velocities.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <ros/time.h>

namespace proximity_server::node {

/// The poses of a cycle, and the velocities of all that may move until its message is used.
struct AgedPoses {
  const PoseSnapshot& poses;
  const VelocitySnapshot& velocities;
  const CarrierFrames& frames;
  const FrameSnapshot& frame_poses;
  const MotionSources& sources;
};

/// Sets the parts of an uncertainty that grow with the age of the poses to those of the parameters, increased by how
/// far everything may have moved since then:
///
/// * A joint with the velocity v at the time t_v, and at most the acceleration a: |v| T + a (|t_v - t| T + T^2 / 2). Here
///   t is the time of the poses, and T their age plus Config::message_latency. With PoseLatency::Limit, or if v or a is
///   not known, it is the velocity limit of the URDF times T.
/// * The root of a robot that may move relative to what is checked with it, and an object in a frame that may move:
///   their speeds in the parameters times T.
///
/// Failure: the status is NO_VELOCITY, and names the first joint, robot or object of which nothing of that is known.
QueryStatus addAge(const Robot& robot, const AgedPoses& aged, const scene::Objects& objects,
                   scene::Uncertainty& uncertainty);

}  // namespace proximity_server::node
