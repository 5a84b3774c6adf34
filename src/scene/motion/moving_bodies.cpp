#include "scene/motion/moving_bodies.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Segments = std::vector<RobotMotion::Segment>;

const RobotMotion::Segment& at(const Segments& segments, int body) { return segments[body]; }

/// The bodies from one up to the root of the motion, which is -1.
std::vector<int> ancestry(const Segments& segments, int body) {
  std::vector<int> bodies{body};
  while (bodies.back() >= 0) bodies.push_back(at(segments, bodies.back()).parent);
  return bodies;
}

/// The joints on the way from body a to body b, each as the motion of the frame behind it in the one before it.
struct Step {
  int body;  ///< behind it
  narrowphase::ScrewMotion motion;
};
std::vector<Step> wayBetween(const Segments& segments, int body_a, int body_b) {
  std::vector<int> up = ancestry(segments, body_a), down = ancestry(segments, body_b);
  while (up.size() > 1 && down.size() > 1 && up[up.size() - 2] == down[down.size() - 2]) {
    up.pop_back();
    down.pop_back();
  }
  std::vector<Step> way;
  for (std::size_t i = 0; i + 1 < up.size(); ++i) way.push_back({up[i + 1], at(segments, up[i]).motion.inverse()});
  for (std::size_t i = down.size() - 1; i-- > 0;) way.push_back({down[i], at(segments, down[i]).motion});
  return way;
}

/// The product of a chain and one more screw; what rests becomes a part of its neighbour.
void append(const narrowphase::ScrewMotion& screw, narrowphase::MotionChain& chain) {
  if (chain.empty() || !(screw.isRest() || chain.back().isRest()))
    chain.push_back(screw);
  else
    chain.back() = screw.isRest() ? chain.back() * screw.start : chain.back().start * screw;
}

/// The smallest distance of the origin from the points between two.
double distanceToSegment(const Vector3d& begin, const Vector3d& end) {
  const Vector3d along = end - begin;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0.0 ? std::clamp(-begin.dot(along) / length2, 0.0, 1.0) : 0.0;
  return (begin + part * along).norm();
}

}  // namespace

MovingBodies::MovingBodies(const RobotMotion& motion, int body_a, const Bounds& a, int body_b, const Bounds& b)
    : body_a_(body_a), body_b_(body_b), a_(a), b_(b) {
  const Segments& segments = motion.segments();
  for (const int end : {body_a, body_b})
    for (int body = end; body >= 0; body = at(segments, body).parent) is_known_ &= at(segments, body).is_known;
  if (!is_known_) return;

  const std::vector<Step> way = wayBetween(segments, body_a, body_b);
  const auto moving = std::count_if(way.begin(), way.end(), [](const Step& step) { return !step.motion.isRest(); });
  std::size_t half = 0;
  for (std::ptrdiff_t seen = 0; half < way.size() && seen < moving / 2; ++half) seen += !way[half].motion.isRest();

  middle_ = half == 0 ? body_a : way[half - 1].body;
  for (std::size_t i = half; i-- > 0;) append(way[i].motion.inverse(), chain_a_);
  for (std::size_t i = half; i < way.size(); ++i) append(way[i].motion, chain_b_);
  for (narrowphase::MotionChain* chain : {&chain_a_, &chain_b_})
    if (chain->empty()) chain->push_back({});
  length_ = roundedLengths(chain_a_, a_.reach) + roundedLengths(chain_b_, b_.reach);
}

narrowphase::MotionChain MovingBodies::fixedTo(narrowphase::MotionChain chain, const Isometry3d& pose) {
  chain.back() = chain.back() * pose;
  return chain;
}

MovingBodies::Interval::Interval(int number) {
  const int level = std::ilogb(number);
  const double length = std::ldexp(1.0, -level);
  begin = (number - (1 << level)) * length;
  end = begin + length;
}

const BodyPoses& PosesInTime::at(double time) {
  const auto known = known_.find(time);
  return known != known_.end() ? known->second : known_.emplace(time, motion_.at(time)).first->second;
}

const MovingBodies::IntervalMotion& MovingBodies::motionIn(int number, PosesInTime& poses) {
  if (const auto known = interval_motions_.find(number); known != interval_motions_.end()) return known->second;
  const auto [begin, end] = Interval(number);
  const double middle = 0.5 * (begin + end), duration = end - begin;
  double far = 0.0;
  const auto seen = [&](int body, double time) -> Isometry3d {
    const BodyPoses& all = poses.at(time);
    const Isometry3d& pose = *all[body];
    far = std::max(far, pose.translation().norm());
    return middle_ < 0 ? pose : all[middle_]->inverse() * pose;
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
  return interval_motions_.emplace(number, motion).first->second;
}

MovingBodies::SphereGap MovingBodies::sphereGap(const Bounds& a, const Bounds& b, int interval, PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  const Vector3d begin = here.b_begin * b.centre - here.a_begin * a.centre;
  const Vector3d end = here.b_end * b.centre - here.a_end * a.centre;
  return {distanceToSegment(begin, end) - here.bulge - a.radius - b.radius - here.rounding,
          (end - begin).norm() + here.bulge};
}

double MovingBodies::driftIn(int interval, PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  return here.drift + here.rounding;
}

double MovingBodies::boxGap(const Bounds& a, const Bounds& b, int interval, PosesInTime& poses) {
  const IntervalMotion& here = motionIn(interval, poses);
  const Vector3d between = here.b_middle * b.centre - here.a_middle * a.centre;
  return scene::boxGap(between, a, here.a_middle.linear() * a.axes, b, here.b_middle.linear() * b.axes) - here.drift -
         here.rounding;
}

}  // namespace proximity_server::scene
