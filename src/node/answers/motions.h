#pragma once

#include "node/answers/conversions.h"
#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/MotionMinimum.h"
#include "proximity_server/Proximity.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/limited_motion.h"
#include "proximity_server/scene/motion/motion_question.h"

#include <string>
#include <vector>

// Motions that start from poses of tf, and their results as messages. Poses and results are in the reference frame. The
// motions of joints are computed in the frame of a root link; there the reference frame is the world, which may move.

namespace proximity_server::node {

/// Whether the pose of a root link is known; all functions below need one.
bool knowsRoot(const Robot& robot, const scene::BodyPoses& poses);

/// The poses, in the reference frame, transformed into the frame of the first root link with a known pose.
scene::BodyPoses inRoot(const Robot& robot, scene::BodyPoses poses);

/// The motions of the frames of moving objects, which are at these poses in the reference frame at the start. A frame of
/// a link moves with the link. All others rest in the reference frame, because nothing tells their velocity.
std::vector<scene::RobotMotion::Segment> framesOfObjects(const Robot& robot, const CarrierFrames& frames,
                                                         const scene::FramePoses& poses_of_frames);

/// framesOfObjects() with the world, for a motion from inRoot(poses).
scene::RobotMotion::ObjectFrames objectFramesInRoot(const Robot& robot, const scene::BodyPoses& poses,
                                                    const CarrierFrames& frames,
                                                    const scene::FramePoses& poses_of_frames);

/// framesOfObjects() with the world, for a motion whose poses are in the frame in which the reference frame is at the
/// start.
scene::RobotMotion::ObjectFrames objectFramesAtStart(const Robot& robot, const CarrierFrames& frames,
                                                     const scene::FramePoses& poses_of_frames);

/// Moves every joint at constant velocity until it reaches a limit, where it stops, for `duration` [s] from time 0 on.
/// `travel` is the change of each position [rad] or [m] without limits. The positions that the caller states are used as
/// in scene::motionWithinLimits(). An inequality stops no joint.
scene::LimitedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses,
                                        const std::vector<double>& travel, const JointValues& stated, double duration);

/// Tells which inequality is broken at the start, or else by a motion of `duration` [s], and when; and the turns that are
/// assumed. "" for none.
std::string limitsText(const scene::RobotModel& robot, const scene::BodyPoses& start, const JointValues& stated,
                       const scene::MotionLimits& limits, double duration);

/// Tells the turns that are assumed only.
std::string assumedText(const scene::RobotModel& robot, const scene::MotionLimits& limits);

/// Joins two texts, of which either may be empty.
std::string joined(const std::string& a, const std::string& b);

/// Writes into a message which joints stop at a limit during a motion of `duration` [s], and when.
template <class Message>
void assignStops(Message& message, const Robot& robot, const scene::MotionLimits& limits, double duration) {
  message.joints_at_limit.clear();
  message.limit_times.clear();
  for (const scene::JointStop& stop : limits.stops) {
    message.joints_at_limit.push_back(robot.robotModel().joints[stop.joint].name);
    message.limit_times.push_back(duration * stop.time);
  }
}

/// Converts a pair that was found at a parameter of the motion, in this state if it is along a spline.
Proximity toMessage(const RobotAndObjects& model, const scene::Motion& motion, double parameter,
                    const scene::Positions& state, const scene::PairProximity& pair);

/// Converts the bounds, time and pair of a minimum. The pair is UNKNOWN if none was found.
MotionMinimum toMessage(const RobotAndObjects& model, const scene::Motion& motion, const scene::RobotMinimum& minimum);

/// A minimum about which nothing is known: all numbers are NaN.
MotionMinimum unknownMinimum();

}  // namespace proximity_server::node
