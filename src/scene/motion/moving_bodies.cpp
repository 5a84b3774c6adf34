#include "scene/motion/moving_bodies.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

using Way = PosesInTime::Way;

/// The motion of the frame behind a step of a way, in the frame before it.
narrowphase::ScrewMotion motionOf(const PosesInTime& poses, const Way& way, std::size_t step) {
  const narrowphase::ScrewMotion& motion = poses.segment(way.frame(step)).motion;
  return step < way.left.size() ? motion.inverse() : motion;
}

bool isRest(const PosesInTime& poses, int frame) { return poses.segment(frame).motion.isRest(); }

/// Multiplies a chain by one more screw. A screw at rest is merged with its neighbour.
void append(const narrowphase::ScrewMotion& screw, narrowphase::MotionChain& chain) {
  if (chain.empty() || !(screw.isRest() || chain.back().isRest()))
    chain.push_back(screw);
  else
    chain.back() = screw.isRest() ? chain.back() * screw.start : chain.back().start * screw;
}

/// Sets a chain, which is never empty, to the motion of the frame at the begin of a way, seen from the frame after its
/// first `half` steps.
void setToBegin(const PosesInTime& poses, const Way& way, std::size_t half, narrowphase::MotionChain& chain) {
  chain.clear();
  for (std::size_t i = half; i-- > 0;) append(motionOf(poses, way, i).inverse(), chain);
  if (chain.empty()) chain.emplace_back();
}

/// Sets a chain, which is never empty, to the motion of the frame at the end of a way, seen from the same frame.
void setToEnd(const PosesInTime& poses, const Way& way, std::size_t half, narrowphase::MotionChain& chain) {
  chain.clear();
  for (std::size_t i = half; i < way.size(); ++i) append(motionOf(poses, way, i), chain);
  if (chain.empty()) chain.emplace_back();
}

/// The smallest distance of the origin from the points of a segment.
double distanceToSegment(const Vector3d& begin, const Vector3d& end) {
  const Vector3d along = end - begin;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0.0 ? std::clamp(-begin.dot(along) / length2, 0.0, 1.0) : 0.0;
  return (begin + part * along).norm();
}

}  // namespace

// --- poses

void PosesInTime::follow(const RobotMotion& motion) {
  motion_ = &motion;
  world_ = -1;
  others_.clear();
  known_.clear();
  const RobotMotion::ObjectFrames& frames = motion.objectFrames();
  const int bodies = static_cast<int>(motion.segments().size());
  if (!isIdentity(frames.world)) {
    world_ = bodies;
    others_.push_back(frames.world);
  }
  first_moving_ = bodies + static_cast<int>(others_.size());
  for (Segment frame : frames.moving) {
    if (frame.parent < 0) frame.parent = world_;
    others_.push_back(frame);
  }
}

const BodyPoses& PosesInTime::at(double time) {
  const auto place =
      std::lower_bound(known_.begin(), known_.end(), time, [](const Known& known, double t) { return known.time < t; });
  if (place != known_.end() && place->time == time) return poses_[place->poses];
  const std::size_t next = known_.size();
  known_.insert(place, {time, static_cast<int>(next)});
  if (next == poses_.size()) poses_.emplace_back();
  motion_->at(time, poses_[next]);
  return poses_[next];
}

const Way& PosesInTime::wayBetween(int from, int to) const {
  way_.left.clear();
  way_.entered.clear();
  for (; from >= 0; from = segment(from).parent) way_.left.push_back(from);
  for (; to >= 0; to = segment(to).parent) way_.entered.push_back(to);
  while (!way_.left.empty() && !way_.entered.empty() && way_.left.back() == way_.entered.back()) {
    way_.left.pop_back();
    way_.entered.pop_back();
  }
  std::reverse(way_.entered.begin(), way_.entered.end());
  return way_;
}

int PosesInTime::add(const Isometry3d& world_T_frame) {
  others_.push_back({world_, true, {world_T_frame, Vector3d::Zero(), Vector3d::Zero()}});
  return static_cast<int>(motion_->segments().size() + others_.size()) - 1;
}

bool PosesInTime::isKnown(int frame) const {
  for (; frame >= 0; frame = segment(frame).parent)
    if (!segment(frame).is_known) return false;
  return true;
}

Isometry3d PosesInTime::pose(int frame, double time) {
  if (frame < 0) return Isometry3d::Identity();
  if (frame < static_cast<int>(motion_->segments().size())) return *at(time)[frame];
  const Segment& own = segment(frame);
  const Isometry3d parent_T_frame = own.motion.isRest() ? own.motion.start : own.motion.at(time);
  return own.parent < 0 ? parent_T_frame : pose(own.parent, time) * parent_T_frame;
}

// --- two bodies

void MovingBodies::follow(const PosesInTime& poses, int body_a, const Bounds& a, int body_b, const Bounds& b,
                          SeenFrom seen_from) {
  body_a_ = body_a;
  body_b_ = body_b;
  a_ = a;
  b_ = b;
  intervals_.clear();
  is_known_ = poses.isKnown(body_a) && poses.isKnown(body_b);
  if (!is_known_) return;

  const Way& way = poses.wayBetween(body_a, body_b);
  std::size_t moving = 0;
  for (std::size_t i = 0; i < way.size(); ++i) moving += !isRest(poses, way.frame(i));
  std::size_t half = seen_from == SeenFrom::B ? way.size() : 0;
  if (seen_from == SeenFrom::Middle)
    for (std::size_t seen = 0; half < way.size() && seen < moving / 2; ++half) seen += !isRest(poses, way.frame(half));

  if (seen_from == SeenFrom::Middle && moving == 1) {
    // Only one joint moves, and either body may be seen as the moving one. The body whose centre is nearer to the axis
    // moves less.
    const auto accelerated = [](const narrowphase::MotionChain& chain, const Bounds& of) {
      return motionBound(chain, of.centre, of.radius, 0.0, 0.0).acceleration;
    };
    setToBegin(poses, way, way.size(), chain_a_);
    setToEnd(poses, way, half, chain_b_);
    if (accelerated(chain_a_, a) < accelerated(chain_b_, b)) half = way.size();
  }
  setToBegin(poses, way, half, chain_a_);
  setToEnd(poses, way, half, chain_b_);
  const auto after = [&](std::size_t step) {
    return step < way.left.size() ? poses.segment(way.left[step]).parent : way.frame(step);
  };
  middle_ = half == 0 ? body_a : after(half - 1);
  const int robot_end = static_cast<int>(poses.motion().segments().size());
  bool leaves_the_robot = false;
  path_length_ = 0.0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    path_length_ += motionOf(poses, way, i).start.translation().norm();
    leaves_the_robot |= after(i) < 0 || way.frame(i) >= robot_end;
  }
  if (!leaves_the_robot) path_length_ = 0.0;
  length_ = roundedLengths(chain_a_, a_.reach) + roundedLengths(chain_b_, b_.reach) + path_length_;
}

double MovingBodies::roundingAt(double time, PosesInTime& poses) const {
  double far = 0.0;
  for (const int frame : {body_a_, body_b_, poses.world()})
    if (poses.isKnown(frame)) far += poses.pose(frame, time).translation().norm();
  return kPoseRounding * (length_ + 4.0 * far);
}

/// The origin of a screw moves at a constant speed. So a frame of a chain is never farther from the frame before it
/// than its start plus its linear velocity; roundedLengths() counts each of these at least once.
double MovingBodies::reach() const {
  return std::max(narrowphase::roundedLengths(chain_a_, a_.reach), narrowphase::roundedLengths(chain_b_, b_.reach));
}

MovingBodies::Interval::Interval(int its_number) : number(its_number) {
  PROXIMITY_ASSERT(number >= 1,
                   "Intervals are numbered from 1, the whole motion, and the halves of n are 2 n and 2 n + 1.");
  const int level = std::ilogb(number);
  const double length = std::ldexp(1.0, -level);
  begin = (number - (1 << level)) * length;
  end = begin + length;
}

const MovingBodies::IntervalMotion& MovingBodies::motionIn(const Interval& interval, PosesInTime& poses) {
  for (std::size_t i = intervals_.size(); i-- > 0;)
    if (intervals_[i].number == interval.number) return intervals_[i].motion;
  const double begin = interval.begin, end = interval.end;
  const double middle = 0.5 * (begin + end), duration = end - begin;
  double far = 0.0;
  const auto seen = [&](int body, double time) -> Isometry3d {
    const Isometry3d pose = poses.pose(body, time);
    far = std::max(far, pose.translation().norm());
    return middle_ < 0 ? pose : poses.pose(middle_, time).inverse() * pose;
  };
  const narrowphase::MotionBound of_a = motionBound(chain_a_, a_.centre, a_.radius, begin, end);
  const narrowphase::MotionBound of_b = motionBound(chain_b_, b_.centre, b_.radius, begin, end);
  const double speed = (of_b.velocity - of_a.velocity).norm() + of_a.deviation + of_b.deviation;
  IntervalMotion motion{seen(body_a_, begin),
                        seen(body_b_, begin),
                        seen(body_a_, middle),
                        seen(body_b_, middle),
                        seen(body_a_, end),
                        seen(body_b_, end),
                        (of_a.acceleration + of_b.acceleration) * duration * duration / 8.0,
                        0.5 * duration * speed,
                        0.0};
  motion.rounding = kPoseRounding * (length_ + 4.0 * far);
  intervals_.push_back({interval.number, motion});
  return intervals_.back().motion;
}

MovingBodies::SphereGap MovingBodies::sphereGap(const Bounds& a, const Bounds& b, const Interval& interval,
                                                PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  const Vector3d begin = here.b_begin * b.centre - here.a_begin * a.centre;
  const Vector3d end = here.b_end * b.centre - here.a_end * a.centre;
  return {distanceToSegment(begin, end) - here.bulge - a.radius - b.radius - here.rounding,
          (end - begin).norm() + here.bulge};
}

MovingBodies::Drift MovingBodies::driftIn(const Interval& interval, PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  return {here.drift, here.rounding};
}

double MovingBodies::boxGap(const Bounds& a, const Bounds& b, const Interval& interval, PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  const Vector3d between = here.b_middle * b.centre - here.a_middle * a.centre;
  return scene::boxGap(between, a, here.a_middle.linear() * a.axes, b, here.b_middle.linear() * b.axes) - here.drift -
         here.rounding;
}

}  // namespace proximity_server::scene
