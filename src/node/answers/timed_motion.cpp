#include "node/answers/timed_motion.h"

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

/// The first known pose of a root link, which no joint moves.
const Eigen::Isometry3d& rootOf(const Robot& robot, const scene::BodyPoses& poses) {
  const std::vector<int> roots = robot.robotModel().roots();
  const auto hit = std::find_if(roots.begin(), roots.end(), [&](int root) { return poses[root].has_value(); });
  return poses[hit == roots.end() ? roots.front() : *hit].value();
}

/// Transforms the poses into the frame of the root link of rootOf().
scene::BodyPoses inRoot(const Robot& robot, const scene::BodyPoses& poses) {
  return inFrame(rootOf(robot, poses).inverse(), poses);
}

/// TimedMotion::reference_T_poses for a motion of joints that starts from these poses.
std::function<Eigen::Isometry3d(const scene::BodyPoses&)> referenceFrom(const Robot& robot,
                                                                        const scene::BodyPoses& poses) {
  return [&robot, reference_T_root = rootOf(robot, poses)](const scene::BodyPoses& poses_in_root) {
    return referenceToRoot(robot, poses_in_root, reference_T_root).value();
  };
}

/// The reference frame in a motion of joints, which is in the frame of the root link of rootOf(). All roots rest.
scene::RobotMotion::Segment worldOf(const Robot& robot, const scene::BodyPoses& poses) {
  using Motion = scene::RobotMotion;
  if (robot.referenceLink() < 0) return Motion::atRest(rootOf(robot, poses).inverse());
  const scene::Link& link = robot.robotModel().links[robot.referenceLink()];
  return Motion::atRest(link.body_T_link, link.body == 0 ? -1 : link.body);
}

/// The frame of a link, which moves with its body.
scene::RobotMotion::Segment segmentOf(const Robot& robot, int index) {
  const scene::Link& link = robot.robotModel().links[index];
  return scene::RobotMotion::atRest(link.body_T_link, link.body);
}

/// The motions of the frames of moving objects: those of links move with the links, all others rest.
std::vector<scene::RobotMotion::Segment> segmentsOf(const Robot& robot, const CarrierFrames& frames,
                                                    const scene::FramePoses& poses) {
  std::vector<scene::RobotMotion::Segment> segments;
  for (std::size_t i = 0; i < frames.names.size(); ++i) {
    const int index = robot.linkOfFrame(frames.names[i]);
    const auto& pose = i < poses.size() ? poses[i] : std::nullopt;
    segments.push_back(index < 0 ? scene::RobotMotion::atRest(pose) : segmentOf(robot, index));
  }
  return segments;
}

Proximity inReference(const RobotAndObjects& model, const scene::BodyPoses& poses,
                      const Eigen::Isometry3d& reference_T_poses, const scene::PairProximity& pair) {
  Proximity message = toMessage(model, inFrame(reference_T_poses, poses), inFrame(reference_T_poses, pair), {});
  message.guaranteed = kNaN;
  return message;
}

/// Tells which inequality is broken at the start, or else by the motion, and when; "" for none.
std::string brokenText(const scene::RobotModel& robot, const scene::BodyPoses& start, const JointValues& stated,
                       const std::optional<scene::InequalityBreak>& broken, double duration) {
  for (const scene::JointInequality& inequality : robot.inequalities) {
    const std::optional<double> excess = excessAt(robot, inequality, start, stated);
    if (excess && *excess > inequality.tolerance()) return inequality.brokenText(*excess) + " at the start";
  }
  if (!broken) return {};
  return "'" + robot.inequalities[broken->inequality].text + "' is broken from " +
         system::secondsText(broken->time * duration) + " on";
}

/// Tells the turns that are assumed; "" for none.
std::string assumedText(const scene::RobotModel& robot, const std::vector<int>& joints) {
  std::string text;
  for (const int joint : joints) text += (text.empty() ? "'" : ", '") + robot.joints[joint].name + "'";
  return text.empty() ? text : "nothing tells the turn of " + text + ": each is taken to stop as late as a turn allows";
}

}  // namespace

TimedMotion motionOfJoints(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                           double begin, double duration) {
  return {scene::RobotMotion::ofTravel(robot.robotModel(), inRoot(robot, poses), travel), begin, duration,
          referenceFrom(robot, poses), worldOf(robot, poses)};
}

TimedMotion motionWithinLimits(const Robot& robot, const scene::BodyPoses& poses, const std::vector<double>& travel,
                               const JointValues& stated, double duration) {
  scene::LimitedMotion limited = motionWithinLimits(robot.robotModel(), inRoot(robot, poses), travel, stated);
  std::string broken = brokenText(robot.robotModel(), poses, stated, limited.broken, duration);
  return {std::move(limited.motion),
          0.0,
          duration,
          referenceFrom(robot, poses),
          worldOf(robot, poses),
          std::move(limited.stops),
          std::move(broken),
          assumedText(robot.robotModel(), limited.assumed)};
}

TimedMotion motionOfTwists(const scene::BodyPoses& poses, const std::vector<scene::RobotMotion::Twist>& twists,
                           double duration) {
  return {scene::RobotMotion::ofTwists(poses, twists), 0.0, duration,
          [](const scene::BodyPoses&) { return Eigen::Isometry3d::Identity(); },
          scene::RobotMotion::ObjectFrames().world};
}

void carryObjects(const Robot& robot, const CarrierFrames& frames, const scene::FramePoses& poses,
                  TimedMotion& motion) {
  motion.motion.carryObjects({motion.world, segmentsOf(robot, frames, poses)});
}

SplineMotion splineMotion(const Robot& robot, std::function<scene::BodyPoses(const scene::Positions&)> posesAt,
                          const scene::Positions& start, const CarrierFrames& frames,
                          const scene::FramePoses& poses_of_frames) {
  const scene::BodyPoses at_start = posesAt(start);
  return {[&robot, posesAt = std::move(posesAt)](const scene::Positions& positions) {
            return inRoot(robot, posesAt(positions));
          },
          referenceFrom(robot, at_start),
          {worldOf(robot, at_start), segmentsOf(robot, frames, poses_of_frames)}};
}

scene::RobotMotion::ObjectFrames objectFramesAtStart(const Robot& robot, const CarrierFrames& frames,
                                                     const scene::FramePoses& poses) {
  using Motion = scene::RobotMotion;
  const int index = robot.referenceLink();
  const bool is_moved = index >= 0 && robot.robotModel().bodies[robot.robotModel().links[index].body].joint >= 0;
  return {is_moved ? segmentOf(robot, index) : Motion::atRest(Eigen::Isometry3d::Identity()),
          segmentsOf(robot, frames, poses)};
}

Proximity toMessage(const RobotAndObjects& model, const TimedMotion& motion, double parameter,
                    const scene::PairProximity& pair) {
  const scene::BodyPoses poses = motion.motion.at(parameter);
  return inReference(model, poses, motion.reference_T_poses(poses), pair);
}

Proximity toMessage(const RobotAndObjects& model, const SplineMotion& motion, const scene::Positions& positions,
                    const scene::PairProximity& pair) {
  const scene::BodyPoses poses = motion.poses(positions);
  return inReference(model, poses, motion.reference_T_poses(poses), pair);
}

MotionMinimum toMessage(const RobotAndObjects& model, const TimedMotion& motion, const scene::RobotMinimum& minimum) {
  MotionMinimum message = unknownMinimum();
  message.lower_bound = minimum.lower_bound;
  message.upper_bound = minimum.upper_bound;
  if (!(minimum.time >= 0.0)) return message;
  message.time = motion.timeAt(minimum.time);
  message.pair = toMessage(model, motion, minimum.time, minimum.pair);
  return message;
}

MotionMinimum unknownMinimum() {
  MotionMinimum message;
  message.lower_bound = message.upper_bound = message.time = kNaN;
  message.pair = unknownProximity();
  return message;
}

}  // namespace proximity_server::node
