#include "proximity_server/scene/motion/robot_motion.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/body_pose.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A number of things, with their name.
struct Count {
  std::size_t number;
  const char* name;
  std::string text() const { return std::to_string(number) + " " + name; }
};

void require(const Count& given, const Count& expected) {
  if (given.number == expected.number) return;
  throw std::invalid_argument("the robot has " + expected.text() + ", but there are " + given.text());
}

/// [rad] or [m] The travel of a joint, computed from the travel of its leader.
double travelOf(const RobotModel& model, int joint, const std::vector<double>& travel) {
  const Joint::Mimic leader = model.leaderOf(joint);
  const double own = leader.multiplier * travel[leader.joint];
  if (std::isfinite(own)) return own;
  throw std::invalid_argument("the travel of joint " + model.joints[joint].name + " is not finite");
}

/// The motion of a joint, beginning where its child stands in the frame of its parent.
narrowphase::ScrewMotion jointScrew(const Joint& joint, double travel, const Isometry3d& parent_T_child) {
  const Vector3d axis = travel * (parent_T_child.linear() * joint.axis);
  switch (joint.type) {
    case Joint::Type::Revolute:
    case Joint::Type::Continuous:
      return {parent_T_child, Vector3d::Zero(), axis};
    case Joint::Type::Prismatic:
      return {parent_T_child, axis, Vector3d::Zero()};
    case Joint::Type::Floating:
    case Joint::Type::Planar:
      break;
  }
  return {parent_T_child, Vector3d::Zero(), Vector3d::Zero()};
}

void requireCarrier(const RobotMotion::Segment& segment, std::size_t bodies, const std::string& what) {
  if (segment.parent < -1 || segment.parent >= static_cast<int>(bodies))
    throw std::invalid_argument(what + " has the parent " + std::to_string(segment.parent) + ", but there are " +
                                std::to_string(bodies) + " bodies");
  const narrowphase::ScrewMotion& motion = segment.motion;
  if (segment.is_known && !(motion.start.matrix().allFinite() && (motion.linear + motion.angular).allFinite()))
    throw std::invalid_argument("the motion of " + what + " is not finite");
}

}  // namespace

RobotMotion RobotMotion::ofTravel(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel) {
  RobotMotion motion;
  motion.setTravel(model, start, travel);
  return motion;
}

void RobotMotion::setTravel(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel) {
  require({start.size(), "poses"}, {model.bodies.size(), "bodies"});
  require({travel.size(), "travels"}, {model.joints.size(), "movable joints"});
  model_ = &model;
  segments_.clear();
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Body& body = model.bodies[i];
    Segment segment;
    segment.parent = body.parent;
    const std::optional<Isometry3d> pose = usablePose(start[i]);
    const std::optional<Isometry3d> parent = body.parent < 0 ? Isometry3d::Identity() : usablePose(start[body.parent]);
    segment.is_known = pose && parent;
    const double own_travel = body.joint < 0 ? 0.0 : travelOf(model, body.joint, travel);
    if (segment.is_known) {
      segment.motion.start = parent->inverse() * *pose;
      if (body.joint >= 0) segment.motion = jointScrew(model.joints[body.joint], own_travel, segment.motion.start);
    }
    segments_.push_back(segment);
  }
}

RobotMotion RobotMotion::between(const RobotModel& model, const std::vector<double>& from,
                                 const std::vector<double>& to) {
  const BodyPoses start = forwardKinematics(model, from);
  require({to.size(), "positions to go to"}, {from.size(), "movable joints"});
  std::vector<double> travel(to.size());
  std::transform(to.begin(), to.end(), from.begin(), travel.begin(), std::minus<>());
  return ofTravel(model, start, travel);
}

RobotMotion RobotMotion::ofTwists(const BodyPoses& start, const std::vector<Twist>& twists) {
  require({twists.size(), "twists"}, {start.size(), "poses"});
  RobotMotion motion;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const std::optional<Isometry3d> pose = usablePose(start[i]);
    if (!(twists[i].linear + twists[i].angular).allFinite())
      throw std::invalid_argument("twist " + std::to_string(i) + " is not finite");
    Segment segment;
    segment.is_known = pose.has_value();
    if (pose) segment.motion = {*pose, twists[i].linear, twists[i].angular};
    motion.segments_.push_back(segment);
  }
  return motion;
}

void RobotMotion::after(const std::vector<double>& before, const std::vector<double>& travel,
                        RobotMotion& motion) const {
  PROXIMITY_ASSERT(model_, "Only a motion of joints goes on as one.");
  motion = *this;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const int index = model_->bodies[i].joint;
    if (index < 0 || !segments_[i].is_known) continue;
    const Joint& joint = model_->joints[index];
    const Isometry3d start = jointScrew(joint, travelOf(*model_, index, before), segments_[i].motion.start).at(1.0);
    motion.segments_[i].motion = jointScrew(joint, travelOf(*model_, index, travel), start);
  }
}

BodyPoses RobotMotion::at(double time) const {
  BodyPoses poses;
  at(time, poses);
  return poses;
}

void RobotMotion::at(double time, BodyPoses& poses) const {
  poses.assign(segments_.size(), std::nullopt);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const Segment& segment = segments_[i];
    if (!segment.is_known) continue;
    if (segment.parent < 0)
      poses[i] = segment.motion.at(time);
    else if (const auto& parent = poses[segment.parent])
      poses[i] = *parent * segment.motion.at(time);
  }
}

// --- frames that carry objects

RobotMotion::Segment RobotMotion::atRest(const std::optional<Isometry3d>& parent_T_frame, int parent) {
  const std::optional<Isometry3d> pose = usablePose(parent_T_frame);
  return {parent, pose.has_value(), {pose.value_or(Isometry3d::Identity()), Vector3d::Zero(), Vector3d::Zero()}};
}

RobotMotion::Segment RobotMotion::withTwist(const std::optional<Isometry3d>& world_T_frame, const Twist& twist) {
  Segment segment = atRest(world_T_frame);
  segment.motion.linear = twist.linear;
  segment.motion.angular = twist.angular;
  return segment;
}

void RobotMotion::carryObjects(const ObjectFrames& frames) {
  requireCarrier(frames.world, segments_.size(), "the world");
  for (std::size_t i = 0; i < frames.moving.size(); ++i)
    requireCarrier(frames.moving[i], segments_.size(), "frame " + std::to_string(i) + " of the objects");
  object_frames_ = frames;
}

RobotMotion::State RobotMotion::inWorld(double time) const {
  State state{at(time), std::vector<std::optional<Isometry3d>>(object_frames_.moving.size())};
  if (!isIdentity(object_frames_.world)) {
    const std::optional<Isometry3d> world = worldAt(time, state.bodies);
    if (!world) return {BodyPoses(segments_.size()), std::move(state.frames)};
    const Isometry3d world_T_poses = world->inverse();
    for (std::optional<Isometry3d>& pose : state.bodies)
      if (pose) pose = world_T_poses * *pose;
  }
  for (std::size_t i = 0; i < state.frames.size(); ++i) {
    const Segment& frame = object_frames_.moving[i];
    const std::optional<Isometry3d> parent = frame.parent < 0 ? Isometry3d::Identity() : state.bodies[frame.parent];
    if (frame.is_known && parent) state.frames[i] = *parent * frame.motion.at(time);
  }
  return state;
}

std::optional<Isometry3d> RobotMotion::worldAt(double time, const BodyPoses& bodies) const {
  const Segment& world = object_frames_.world;
  const std::optional<Isometry3d> parent = world.parent < 0 ? Isometry3d::Identity() : bodies[world.parent];
  if (!parent || !world.is_known) return std::nullopt;
  return *parent * world.motion.at(time);
}

bool isIdentity(const RobotMotion::Segment& segment) {
  return segment.is_known && segment.parent < 0 && segment.motion.isRest() &&
         segment.motion.start.matrix() == Isometry3d::Identity().matrix();
}

}  // namespace proximity_server::scene
