#include "oracle/motion_oracle.h"

#include "proximity_server/narrowphase/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace proximity_server::narrowphase {
namespace {

/// Far more than any case of the tests needs.
constexpr int kMaxSteps = 2000000;

Matrix3l crossMatrix(const Vector3l& v) {
  Matrix3l m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// How a frame has turned, and how far its origin has come, since time 0.
LongPose travelled(const Vector3l& linear, const Vector3l& angular, long double time) {
  const long double speed = angular.stableNorm();
  if (speed == 0) return {Matrix3l::Identity(), linear * time};
  const Vector3l axis = angular / speed;
  const long double angle = speed * time, half_sine = std::sin(angle / 2);
  const Matrix3l turn = crossMatrix(axis);
  const Vector3l along = axis * axis.dot(linear);
  return {Matrix3l::Identity() + std::sin(angle) * turn + 2 * half_sine * half_sine * turn * turn,
          along * time + (linear - along) * (std::sin(angle) / speed) +
              axis.cross(linear) * (2 * half_sine * half_sine / speed)};
}

// The origin is taken away first: 1e6 m from it, long double has but 1e-13 m.

LongPose poseSeenFrom(const Vector3l& origin, const ScrewMotion& screw, long double time) {
  const LongPose way = travelled(screw.linear.cast<long double>(), screw.angular.cast<long double>(), time);
  return {way.rotation * screw.start.linear().cast<long double>(),
          screw.start.translation().cast<long double>() - origin + way.translation};
}

LongPose poseSeenFrom(const Vector3l& origin, const MotionChain& chain, long double time) {
  if (chain.empty()) return {Matrix3l::Identity(), -origin};
  LongPose pose = poseSeenFrom(origin, chain.front(), time);
  for (std::size_t i = 1; i < chain.size(); ++i) pose = pose * exactPoseAt(chain[i], time);
  return pose;
}

Eigen::Vector3d originOf(const MotionChain& chain) {
  return chain.empty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(chain.front().start.translation());
}

/// How far a frame's origin is from that of the frame before it, at most.
long double stepOf(const ScrewMotion& screw) {
  return static_cast<long double>(screw.start.translation().norm()) + screw.linear.norm();
}

long double reachOf(const Shape& shape) {
  return static_cast<long double>(shape.centre().norm()) + shape.coreRadius() + shape.margin();
}

long double speedLimitOf(const MotionChain& chain, long double reach) {
  long double speed = 0;
  for (auto screw = chain.rbegin(); screw != chain.rend(); ++screw) {
    speed += screw->linear.norm() + screw->angular.norm() * reach;
    reach += stepOf(*screw);
  }
  return speed;
}

/// Returns the rounding [m] of a point in the first frame, moved to `origin` [m].
double roundingOf(const MotionChain& chain, const Eigen::Vector3d& origin, double reach) {
  constexpr double kFewEpsilon = 16.0 * std::numeric_limits<double>::epsilon();
  double rounding = kFewEpsilon * reach;
  for (auto screw = chain.rbegin(); screw != chain.rend(); ++screw) {
    const bool is_first = screw + 1 == chain.rend();
    const Eigen::Vector3d start = screw->start.translation() - (is_first ? origin : Eigen::Vector3d::Zero());
    reach += start.norm() + screw->linear.norm();
    rounding += kFewEpsilon * (1.0 + screw->angular.norm()) * reach;
  }
  return rounding;
}

struct Interval {
  TimeInterval time;
  DistanceBounds at_begin, at_end;
  long double lower_bound;

  bool operator<(const Interval& other) const { return lower_bound > other.lower_bound; }
};

Interval makeInterval(const TimeInterval& time, const DistanceBounds& at_begin, const DistanceBounds& at_end,
                      long double speed_limit) {
  // Two cones of slope speed_limit meet there.
  const long double lowest = (at_begin.low + at_end.low - speed_limit * (time.end - time.begin)) / 2;
  return {time, at_begin, at_end, std::min({lowest, at_begin.low, at_end.low})};
}

/// From `from` on by steps that double: a time at or below the contact distance, if they meet one.
std::optional<long double> contactAfter(const DistanceOverTime& distance, long double contact_distance,
                                        long double from, long double first_step, long double end) {
  for (long double step = first_step;; step *= 2) {
    const long double time = std::min(from + step, end);
    if (distance.at(time).high <= contact_distance) return time;
    if (time >= end) return std::nullopt;
  }
}

}  // namespace

LongPose LongPose::operator*(const LongPose& other) const {
  return {rotation * other.rotation, rotation * other.translation + translation};
}

LongPose LongPose::inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }

Eigen::Isometry3d LongPose::rounded() const {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.cast<double>();
  pose.translation() = translation.cast<double>();
  return pose;
}

/// Newton's method: the product with the transpose becomes 1 within a rounding of long double.
LongPose longPose(const Eigen::Isometry3d& pose) {
  Matrix3l rotation = pose.linear().cast<long double>();
  for (int i = 0; i < 4; ++i)
    rotation = 0.5L * rotation * (3.0L * Matrix3l::Identity() - rotation.transpose() * rotation);
  return {rotation, pose.translation().cast<long double>()};
}

LongPose exactPoseAt(const ScrewMotion& screw, long double time) { return poseSeenFrom(Vector3l::Zero(), screw, time); }

LongPose exactPoseAt(const MotionChain& chain, long double time) { return poseSeenFrom(Vector3l::Zero(), chain, time); }

LongPose MovingPair::relativePose(long double time) const {
  const Vector3l origin = originOf(a_motion).cast<long double>();
  return poseSeenFrom(origin, a_motion, time).inverse() * poseSeenFrom(origin, b_motion, time);
}

long double MovingPair::speedLimit() const {
  return speedLimitOf(a_motion, reachOf(a)) + speedLimitOf(b_motion, reachOf(b));
}

double MovingPair::rounding() const {
  const Eigen::Vector3d origin = originOf(a_motion);
  return roundingOf(a_motion, origin, static_cast<double>(reachOf(a))) +
         roundingOf(b_motion, origin, static_cast<double>(reachOf(b)));
}

DistanceBounds exactDistanceAt(const MovingPair& pair, long double time, int max_cells) {
  const Eigen::Isometry3d a_T_b = pair.relativePose(time).rounded();
  const ShapePair at_time{pair.a, pair.b, a_T_b};
  const Truth truth = signedDistanceOracle(at_time, max_cells);
  const long double rounding = 2 * std::numeric_limits<double>::epsilon() * static_cast<long double>(at_time.scale());
  return {truth.distance - rounding, truth.distance + truth.error_bound + rounding};
}

DistanceBounds fastDistanceAt(const MovingPair& pair, long double time, double tolerance) {
  const Eigen::Isometry3d a_T_b = pair.relativePose(time).rounded();
  Options options;
  options.distance_tolerance = tolerance;
  const SignedDistance result = signedDistance(pair.a, pair.b, a_T_b, options);
  // roundingOf of certificate.h, and that of the pose.
  const long double rounding =
      10 * std::numeric_limits<double>::epsilon() * static_cast<long double>(ShapePair{pair.a, pair.b, a_T_b}.scale());
  return {result.lower_bound - rounding, result.upper_bound + rounding};
}

FirstContact firstContact(const DistanceOverTime& distance, long double contact_distance, const TimeInterval& interval,
                          long double resolution, int max_steps) {
  FirstContact found{interval.begin, {}};
  for (int step = 0; step < max_steps && found.free_until < interval.end; ++step) {
    const DistanceBounds now = distance.at(found.free_until);
    if (now.high <= contact_distance) found.contact_by = found.free_until;
    if (now.low - contact_distance <= resolution) break;
    found.free_until += (now.low - contact_distance) / distance.speed_limit;
  }
  if (found.free_until >= interval.end || found.contact_by) return found;
  found.contact_by = contactAfter(distance, contact_distance, found.free_until,
                                  resolution / std::max(distance.speed_limit, 1e-300L), interval.end);
  return found;
}

DistanceBounds smallestDistance(const DistanceOverTime& distance, long double gap, const TimeInterval& interval) {
  const DistanceBounds at_begin = distance.at(interval.begin), at_end = distance.at(interval.end);
  std::priority_queue<Interval> open;
  open.push(makeInterval(interval, at_begin, at_end, distance.speed_limit));
  long double smallest = std::min(at_begin.high, at_end.high);
  for (int step = 0; step < kMaxSteps && open.top().lower_bound < smallest - gap; ++step) {
    const Interval widest = open.top();
    open.pop();
    const long double middle = (widest.time.begin + widest.time.end) / 2;
    const DistanceBounds at_middle = distance.at(middle);
    smallest = std::min(smallest, at_middle.high);
    open.push(makeInterval({widest.time.begin, middle}, widest.at_begin, at_middle, distance.speed_limit));
    open.push(makeInterval({middle, widest.time.end}, at_middle, widest.at_end, distance.speed_limit));
  }
  return {std::min(open.top().lower_bound, smallest), smallest};
}

long double timeOfLocalMinimum(const DistanceOverTime& distance, const TimeInterval& interval, int sections) {
  const long double golden = (std::sqrt(5.0L) - 1) / 2;
  TimeInterval bracket = interval;
  long double left = bracket.end - golden * (bracket.end - bracket.begin);
  long double right = bracket.begin + golden * (bracket.end - bracket.begin);
  long double at_left = distance.at(left).high, at_right = distance.at(right).high;
  for (int i = 0; i < sections; ++i) {
    if (at_left <= at_right) {
      bracket.end = right;
      right = left;
      at_right = at_left;
      left = bracket.end - golden * (bracket.end - bracket.begin);
      at_left = distance.at(left).high;
    } else {
      bracket.begin = left;
      left = right;
      at_left = at_right;
      right = bracket.begin + golden * (bracket.end - bracket.begin);
      at_right = distance.at(right).high;
    }
  }
  return at_left <= at_right ? left : right;
}

}  // namespace proximity_server::narrowphase
