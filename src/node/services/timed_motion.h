#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "proximity_server/MotionMinimum.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

// The motion of a request on the clock of its answer, and its results as messages.

namespace proximity_server::node {

/// A motion over the time [0, 1] that stands for a span of the answer's clock.
struct TimedMotion {
  scene::PhasedMotion motion;
  double begin;     ///< [s]
  double duration;  ///< [s]
  /// The reference frame at a time, given the poses of that time in the frame of the motion.
  std::function<Eigen::Isometry3d(const scene::BodyPoses&)> reference_T_poses;

  std::vector<scene::JointStop> stops = {};  ///< of joints at their limits, at times of [0, 1]

  double onClock(double time) const { return begin + time * duration; }
};

/// Every joint at constant velocity, from poses in the reference frame on: `travel` [rad] or [m] is for the whole time,
/// see RobotMotion::ofJoints. Beyond limits too.
TimedMotion motionOfJoints(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                           double begin, double duration);

/// The same until each joint reaches a limit, where it stops. `stated` positions tell turns, see
/// scene/limited_motion.h; the clock starts at 0.
TimedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                               const JointValues& stated, double duration);

/// Each body on its own, relative to the reference frame, from poses in it on: twists are for the whole time.
TimedMotion motionOfTwists(const scene::BodyPoses& poses, const std::vector<scene::RobotMotion::Twist>& twists,
                           double duration);

/// Tells in a message which joints stop at a limit, and when.
template <class Message>
void assignStops(Message& message, const Robot& robot, const TimedMotion& motion) {
  message.joints_at_limit.clear();
  message.limit_times.clear();
  for (const scene::JointStop& stop : motion.stops) {
    message.joints_at_limit.push_back(robot.robotModel().joints[stop.joint].name);
    message.limit_times.push_back(motion.onClock(stop.time));
  }
}

/// A pair as found at a time of the motion, in the reference frame of that time.
Proximity toMessage(const Robot& robot, const TimedMotion& motion, double time, const scene::PairProximity& pair);

/// Bounds, time and pair; the pair is UNKNOWN where none was found.
MotionMinimum toMessage(const Robot& robot, const TimedMotion& motion, const scene::RobotMinimum& minimum);

/// A minimum of which nothing is known: all numbers are NaN.
MotionMinimum unknownMinimum();

/// OK, or TF_UNAVAILABLE where something was said of some pairs only.
QueryStatus completeness(const scene::MotionCounts& counts);

/// OK, or OVER_BUDGET where the deadline has passed, else NOT_CONVERGED.
QueryStatus statusOf(narrowphase::Status status, const scene::MotionQuestion& question);

}  // namespace proximity_server::node
