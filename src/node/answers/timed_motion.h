#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "node/answers/conversions.h"
#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/MotionMinimum.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

// A motion in the time of its answer, and its results as messages.

namespace proximity_server::node {

/// A motion over the parameter [0, 1], which stands for an interval of the answer's time.
struct TimedMotion {
  scene::PhasedMotion motion;
  double begin;     ///< [s]
  double duration;  ///< [s]
  /// The transform into the reference frame at a time, given the poses of that time in the frame of the motion.
  std::function<Eigen::Isometry3d(const scene::BodyPoses&)> reference_T_poses;
  /// The reference frame as the motion has it: fixed objects stand there, and moving ones rest there.
  scene::RobotMotion::Segment world;

  std::vector<scene::JointStop> stops = {};  ///< of joints at their limits, with times in [0, 1]

  double onClock(double time) const { return begin + time * duration; }
};

/// Moves every joint at constant velocity, also beyond its limits. `poses` are the start, in the reference frame. For
/// `travel` [rad] or [m] during the whole motion see RobotMotion::ofTravel.
TimedMotion motionOfJoints(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                           double begin, double duration);

/// The same, but each joint stops when it reaches a limit. For `stated` positions see scene::motionWithinLimits. The
/// time begins at 0.
TimedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                               const JointValues& stated, double duration);

/// Moves each body by its own twist, relative to the reference frame. `poses` are the start, in that frame; the twists
/// are per duration of the whole motion.
TimedMotion motionOfTwists(const scene::BodyPoses& poses, const std::vector<scene::RobotMotion::Twist>& twists,
                           double duration);

/// Lets the frames of moving objects take part, which have these poses in the reference frame at the start. A frame of a
/// link of the robot moves with the link; all others rest in the reference frame, as nothing tells their velocity.
void carryObjects(const Robot& robot, const AskedFrames& frames, const scene::FramePoses& poses, TimedMotion& motion);

/// What carries objects in a motion whose poses are in the reference frame, as it stands at the start, with the same `frames`.
scene::RobotMotion::ObjectFrames objectFramesAtStart(const Robot& robot, const AskedFrames& frames,
                                                     const scene::FramePoses& poses);

/// Writes into a message which joints stop at a limit, and when.
template <class Message>
void assignStops(Message& message, const Robot& robot, const TimedMotion& motion) {
  message.joints_at_limit.clear();
  message.limit_times.clear();
  for (const scene::JointStop& stop : motion.stops) {
    message.joints_at_limit.push_back(robot.robotModel().joints[stop.joint].name);
    message.limit_times.push_back(motion.onClock(stop.time));
  }
}

/// A pair that was found at a time of the motion, in the reference frame at that time.
Proximity toMessage(const Named& named, const TimedMotion& motion, double time, const scene::PairProximity& pair);

/// Bounds, time and pair; the pair is UNKNOWN if none was found.
MotionMinimum toMessage(const Named& named, const TimedMotion& motion, const scene::RobotMinimum& minimum);

/// A minimum of which nothing is known: all numbers are NaN.
MotionMinimum unknownMinimum();

}  // namespace proximity_server::node
