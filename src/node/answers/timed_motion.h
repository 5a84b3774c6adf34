#pragma once

#include "node/answers/conversions.h"
#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/MotionMinimum.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

#include <Eigen/Geometry>

#include <functional>
#include <optional>
#include <string>
#include <vector>

// Motions whose parameter stands for a time [s], and their results as messages.

namespace proximity_server::node {

/// A motion over a parameter in [0, 1], which stands for an interval of time.
struct TimedMotion {
  scene::PhasedMotion motion;
  double begin;     ///< [s]
  double duration;  ///< [s]
  /// Returns the transform from the frame of the motion into the reference frame at a time, given the poses at that
  /// time.
  std::function<Eigen::Isometry3d(const scene::BodyPoses&)> reference_T_poses;
  /// The motion of the reference frame in the frame of the motion. Fixed objects stand in it, and so do objects that
  /// move with frames of tf which are not those of links.
  scene::RobotMotion::Segment world;

  std::vector<scene::JointStop> stops = {};  ///< stops of joints at their limits, with parameters in [0, 1]
  std::string broken = {};                   ///< a text about the inequality that it breaks first; "": none
  std::string assumed = {};                  ///< a text about the joints of LimitedMotion::assumed; "": none

  /// The time [s] for which the parameter stands.
  double timeAt(double parameter) const { return begin + parameter * duration; }
};

/// Moves every joint at constant velocity, also beyond its limits, for `duration` [s] from the time `begin` [s] on.
/// `poses` are those at the start, in the reference frame. `travel` is the change of each position [rad] or [m] during
/// the whole motion, see RobotMotion::ofTravel().
TimedMotion motionOfJoints(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                           double begin, double duration);

/// Moves every joint at constant velocity until it reaches a limit, where it stops. The time begins at 0. The positions
/// that the caller states are used as in scene::motionWithinLimits(). An inequality stops no joint.
TimedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                               const JointValues& stated, double duration);

/// Moves each body by its own twist relative to the reference frame. `poses` are those at the start, in that frame. A
/// twist is the motion during the whole duration.
TimedMotion motionOfTwists(const scene::BodyPoses& poses, const std::vector<scene::RobotMotion::Twist>& twists,
                           double duration);

/// Adds the frames of moving objects to a motion; `poses` are their poses in the reference frame at the start. A frame
/// of a link moves with the link. All others rest in the reference frame, because nothing tells their velocity.
void carryObjects(const Robot& robot, const CarrierFrames& frames, const scene::FramePoses& poses, TimedMotion& motion);

/// Motions along splines, for a scene.
struct SplineMotion {
  /// The poses of all bodies in the frame of the motion, see scene::SplineQuestion::poses.
  std::function<scene::BodyPoses(const scene::Positions&)> poses;
  std::function<Eigen::Isometry3d(const scene::BodyPoses&)> reference_T_poses;  ///< as in TimedMotion
  scene::RobotMotion::ObjectFrames frames;
};

/// `posesAt` returns the poses of all bodies in the reference frame; `start` are some positions of the motion. Objects
/// are carried as by carryObjects().
SplineMotion splineMotion(const Robot& robot, std::function<scene::BodyPoses(const scene::Positions&)> posesAt,
                          const scene::Positions& start, const CarrierFrames& frames,
                          const scene::FramePoses& poses_of_frames);

/// The frames that carry objects, for a motion whose poses are in the frame in which the reference frame is at the
/// start.
scene::RobotMotion::ObjectFrames objectFramesAtStart(const Robot& robot, const CarrierFrames& frames,
                                                     const scene::FramePoses& poses);

/// Writes into a message which joints stop at a limit, and when.
template <class Message>
void assignStops(Message& message, const Robot& robot, const TimedMotion& motion) {
  message.joints_at_limit.clear();
  message.limit_times.clear();
  for (const scene::JointStop& stop : motion.stops) {
    message.joints_at_limit.push_back(robot.robotModel().joints[stop.joint].name);
    message.limit_times.push_back(motion.timeAt(stop.time));
  }
}

/// Converts a pair that was found at a parameter of the motion. Its points are in the reference frame at that time.
Proximity toMessage(const RobotAndObjects& model, const TimedMotion& motion, double parameter,
                    const scene::PairProximity& pair);

/// Converts a pair that was found at some positions. Its points are in the reference frame there.
Proximity toMessage(const RobotAndObjects& model, const SplineMotion& motion, const scene::Positions& positions,
                    const scene::PairProximity& pair);

/// Converts the bounds, time and pair of a minimum. The pair is UNKNOWN if none was found.
MotionMinimum toMessage(const RobotAndObjects& model, const TimedMotion& motion, const scene::RobotMinimum& minimum);

/// A minimum about which nothing is known: all numbers are NaN.
MotionMinimum unknownMinimum();

}  // namespace proximity_server::node
