#include "node/answers/motions.h"

#include "node/answers/conversions.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

scene::BodyPoses inFrame(const Eigen::Isometry3d& frame_T_poses, scene::BodyPoses poses) {
  for (std::optional<Eigen::Isometry3d>& pose : poses) {
    if (pose) pose = frame_T_poses * *pose;
  }
  return poses;
}

scene::PairProximity inFrame(const Eigen::Isometry3d& frame_T_poses, scene::PairProximity pair) {
  pair.result.point_a = frame_T_poses * pair.result.point_a;
  pair.result.point_b = frame_T_poses * pair.result.point_b;
  pair.result.normal = frame_T_poses.linear() * pair.result.normal;
  return pair;
}

/// The first known pose of a root link, which no joint moves; nullopt if none is known.
const std::optional<Eigen::Isometry3d>& rootOf(const Robot& robot, const scene::BodyPoses& poses) {
  static const std::optional<Eigen::Isometry3d> kNone;
  for (std::size_t body = 0; body < poses.size(); ++body)
    if (poses[body] && robot.robotModel().bodies[body].parent < 0) return poses[body];
  return kNone;
}

/// The reference frame in a motion of joints, which is in the frame of the root link of rootOf(). All roots rest.
scene::RobotMotion::Segment worldOf(const Robot& robot, const scene::BodyPoses& poses) {
  using Motion = scene::RobotMotion;
  if (robot.referenceLink() < 0) return Motion::atRest(rootOf(robot, poses).value().inverse());
  const scene::Link& link = robot.robotModel().links[robot.referenceLink()];
  return Motion::atRest(link.body_T_link, link.body == 0 ? -1 : link.body);
}

/// The frame of a link, which moves with its body.
scene::RobotMotion::Segment segmentOf(const Robot& robot, int index) {
  const scene::Link& link = robot.robotModel().links[index];
  return scene::RobotMotion::atRest(link.body_T_link, link.body);
}

std::string brokenText(const scene::RobotModel& robot, const scene::BodyPoses& start, const JointValues& stated,
                       const scene::MotionLimits& limits, double duration) {
  for (const scene::JointInequality& inequality : robot.inequalities) {
    const std::optional<double> excess = excessAt(robot, inequality, start, stated);
    if (excess && *excess > inequality.tolerance()) return inequality.brokenText(*excess) + " at the start";
  }
  if (!limits.broken) return {};
  return "'" + robot.inequalities[limits.broken->inequality].text + "' is broken from " +
         system::secondsText(duration * limits.broken->time) + " on";
}

}  // namespace

bool knowsRoot(const Robot& robot, const scene::BodyPoses& poses) { return rootOf(robot, poses).has_value(); }

scene::BodyPoses inRoot(const Robot& robot, scene::BodyPoses poses) {
  const Eigen::Isometry3d root_T_poses = rootOf(robot, poses).value().inverse();
  return inFrame(root_T_poses, std::move(poses));
}

std::vector<scene::RobotMotion::Segment> framesOfObjects(const Robot& robot, const CarrierFrames& frames,
                                                         const scene::FramePoses& poses_of_frames) {
  std::vector<scene::RobotMotion::Segment> segments;
  for (std::size_t i = 0; i < frames.names.size(); ++i) {
    const int index = robot.linkOfFrame(frames.names[i]);
    const auto& pose = i < poses_of_frames.size() ? poses_of_frames[i] : std::nullopt;
    segments.push_back(index < 0 ? scene::RobotMotion::atRest(pose) : segmentOf(robot, index));
  }
  return segments;
}

scene::RobotMotion::ObjectFrames objectFramesInRoot(const Robot& robot, const scene::BodyPoses& poses,
                                                    const CarrierFrames& frames,
                                                    const scene::FramePoses& poses_of_frames) {
  return {worldOf(robot, poses), framesOfObjects(robot, frames, poses_of_frames)};
}

scene::RobotMotion::ObjectFrames objectFramesAtStart(const Robot& robot, const CarrierFrames& frames,
                                                     const scene::FramePoses& poses_of_frames) {
  const int index = robot.referenceLink();
  const bool is_moved = index >= 0 && robot.robotModel().bodies[robot.robotModel().links[index].body].joint >= 0;
  return {is_moved ? segmentOf(robot, index) : scene::RobotMotion::ObjectFrames().world,
          framesOfObjects(robot, frames, poses_of_frames)};
}

scene::LimitedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses,
                                        const std::vector<double>& travel, const JointValues& stated, double duration) {
  scene::LimitedMotion limited = scene::motionWithinLimits(robot.robotModel(), inRoot(robot, poses), travel, stated);
  limited.motion.setTime(0.0, duration);
  return limited;
}

std::string limitsText(const scene::RobotModel& robot, const scene::BodyPoses& start, const JointValues& stated,
                       const scene::MotionLimits& limits, double duration) {
  return joined(brokenText(robot, start, stated, limits, duration), assumedText(robot, limits));
}

std::string assumedText(const scene::RobotModel& robot, const scene::MotionLimits& limits) {
  std::string text;
  for (const int joint : limits.assumed) text += (text.empty() ? "'" : ", '") + robot.joints[joint].name + "'";
  return text.empty() ? text : "nothing tells the turn of " + text + ": each is taken to stop as late as a turn allows";
}

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + "; " + b; }

Proximity toMessage(const RobotAndObjects& model, const scene::Motion& motion, double parameter,
                    const scene::Positions& state, const scene::PairProximity& pair) {
  const scene::BodyPoses poses = motion.at(parameter, state);
  const Eigen::Isometry3d reference_T_poses = motion.worldAt(parameter, poses).value().inverse();
  Proximity message = toMessage(model, inFrame(reference_T_poses, poses), inFrame(reference_T_poses, pair), {});
  message.guaranteed = kNaN;
  return message;
}

MotionMinimum toMessage(const RobotAndObjects& model, const scene::Motion& motion, const scene::RobotMinimum& minimum) {
  MotionMinimum message = unknownMinimum();
  message.lower_bound = minimum.lower_bound;
  message.upper_bound = minimum.upper_bound;
  if (!(minimum.time >= 0.0)) return message;
  message.time = motion.timeAt(minimum.time);
  message.pair = toMessage(model, motion, minimum.time, minimum.state, minimum.pair);
  return message;
}

MotionMinimum unknownMinimum() {
  MotionMinimum message;
  message.lower_bound = message.upper_bound = message.time = kNaN;
  message.pair = unknownProximity();
  return message;
}

}  // namespace proximity_server::node
