#include "scene/motion/moving_bodies.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A body and all its ancestors up to the root of the motion, which is -1.
std::vector<int> ancestry(const PosesInTime& poses, int body) {
  std::vector<int> bodies{body};
  while (bodies.back() >= 0) bodies.push_back(poses.segment(bodies.back()).parent);
  return bodies;
}

/// One step on the path from body a to body b: the motion of the frame after the step, in the frame before it.
struct Step {
  int body;  ///< behind it
  bool leaves_the_robot;
  narrowphase::ScrewMotion motion;
};
std::vector<Step> pathBetween(const PosesInTime& poses, int body_a, int body_b) {
  std::vector<int> up = ancestry(poses, body_a), down = ancestry(poses, body_b);
  while (up.size() > 1 && down.size() > 1 && up[up.size() - 2] == down[down.size() - 2]) {
    up.pop_back();
    down.pop_back();
  }
  const int robot_end = static_cast<int>(poses.motion().segments().size());
  std::vector<Step> path;
  for (std::size_t i = 0; i + 1 < up.size(); ++i)
    path.push_back({up[i + 1], up[i + 1] < 0 || up[i] >= robot_end, poses.segment(up[i]).motion.inverse()});
  for (std::size_t i = down.size() - 1; i-- > 0;)
    path.push_back({down[i], down[i] >= robot_end, poses.segment(down[i]).motion});
  return path;
}

/// Multiplies a chain by one more screw. A screw at rest is merged with its neighbour.
void append(const narrowphase::ScrewMotion& screw, narrowphase::MotionChain& chain) {
  if (chain.empty() || !(screw.isRest() || chain.back().isRest()))
    chain.push_back(screw);
  else
    chain.back() = screw.isRest() ? chain.back() * screw.start : chain.back().start * screw;
}

/// The motions of the frames at both ends of a path, seen from the frame after its first `half` steps. Neither chain is
/// empty.
struct Chains {
  narrowphase::MotionChain a, b;
};
Chains chainsOf(const std::vector<Step>& path, std::size_t half) {
  Chains chains;
  for (std::size_t i = half; i-- > 0;) append(path[i].motion.inverse(), chains.a);
  for (std::size_t i = half; i < path.size(); ++i) append(path[i].motion, chains.b);
  for (narrowphase::MotionChain* chain : {&chains.a, &chains.b})
    if (chain->empty()) chain->push_back({});
  return chains;
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

PosesInTime::PosesInTime(const RobotMotion& motion) : motion_(motion) {
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
  const auto known = known_.find(time);
  return known != known_.end() ? known->second : known_.emplace(time, motion_.at(time)).first->second;
}

int PosesInTime::add(const Isometry3d& world_T_frame) {
  others_.push_back({world_, true, {world_T_frame, Vector3d::Zero(), Vector3d::Zero()}});
  return static_cast<int>(motion_.segments().size() + others_.size()) - 1;
}

bool PosesInTime::isKnown(int frame) const {
  for (; frame >= 0; frame = segment(frame).parent)
    if (!segment(frame).is_known) return false;
  return true;
}

Isometry3d PosesInTime::pose(int frame, double time) {
  if (frame < 0) return Isometry3d::Identity();
  if (frame < static_cast<int>(motion_.segments().size())) return *at(time)[frame];
  const Segment& own = segment(frame);
  const Isometry3d parent_T_frame = own.motion.isRest() ? own.motion.start : own.motion.at(time);
  return own.parent < 0 ? parent_T_frame : pose(own.parent, time) * parent_T_frame;
}

// --- two bodies

MovingBodies::MovingBodies(const PosesInTime& poses, int body_a, const Bounds& a, int body_b, const Bounds& b,
                           SeenFrom seen_from)
    : body_a_(body_a), body_b_(body_b), is_known_(poses.isKnown(body_a) && poses.isKnown(body_b)), a_(a), b_(b) {
  if (!is_known_) return;

  const std::vector<Step> path = pathBetween(poses, body_a, body_b);
  const auto moving = std::count_if(path.begin(), path.end(), [](const Step& step) { return !step.motion.isRest(); });
  std::size_t half = seen_from == SeenFrom::B ? path.size() : 0;
  if (seen_from == SeenFrom::Middle)
    for (std::ptrdiff_t seen = 0; half < path.size() && seen < moving / 2; ++half) seen += !path[half].motion.isRest();

  Chains chains = chainsOf(path, half);
  if (seen_from == SeenFrom::Middle && moving == 1) {
    // Only one joint moves, and either body may be seen as the moving one. The body whose centre is nearer to the axis
    // moves less.
    Chains other = chainsOf(path, path.size());
    const auto accelerated = [](const narrowphase::MotionChain& chain, const Bounds& of) {
      return motionBound(chain, of.centre, of.radius, 0.0, 0.0).acceleration;
    };
    if (accelerated(other.a, a) < accelerated(chains.b, b)) {
      half = path.size();
      chains = std::move(other);
    }
  }
  chain_a_ = std::move(chains.a);
  chain_b_ = std::move(chains.b);
  middle_ = half == 0 ? body_a : path[half - 1].body;
  bool leaves_the_robot = false;
  for (const Step& step : path) {
    path_length_ += step.motion.start.translation().norm();
    leaves_the_robot |= step.leaves_the_robot;
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

narrowphase::MotionChain MovingBodies::fixedTo(narrowphase::MotionChain chain, const Isometry3d& pose) {
  chain.back() = chain.back() * pose;
  return chain;
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
  if (const auto known = interval_motions_.find(interval.number); known != interval_motions_.end())
    return known->second;
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
  return interval_motions_.emplace(interval.number, motion).first->second;
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
