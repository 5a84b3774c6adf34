#include "proximity_server/narrowphase/motion.h"

#include <algorithm>
#include <cmath>

namespace proximity_server {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A turn about a unit axis, by an angle x: sin x and 1 - cos x without cancellation.
///
/// Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 2.2 (Rodrigues' formula) and
///         2.4 (exponential of a twist).
struct Turn {
  Turn(const Vector3d& unit_axis, double angle) : axis(unit_axis) {
    const double half_sine = std::sin(0.5 * angle), half_cosine = std::cos(0.5 * angle);
    sine = 2.0 * half_sine * half_cosine;
    versine = 2.0 * half_sine * half_sine;
  }

  Vector3d operator*(const Vector3d& v) const {
    const Vector3d across = axis.cross(v);
    return v + sine * across + versine * axis.cross(across);
  }

  Vector3d axis;
  double sine, versine;
};

}  // namespace

/// Of the way between the poses, the part along the axis is gone straight. Across it, what a velocity v comes to is
/// 1/x (sin x v + (1 - cos x) axis x v), see at(); solved for v.
ScrewMotion ScrewMotion::between(const Isometry3d& start, const Isometry3d& end) {
  const Eigen::AngleAxisd turn(Matrix3d(end.linear() * start.linear().transpose()));
  const Vector3d& axis = turn.axis();
  const Vector3d way = end.translation() - start.translation();
  const double half = 0.5 * turn.angle();
  const double half_cotangent = half > 0.0 ? half / std::tan(half) : 1.0;
  const Vector3d along = axis.dot(way) * axis;
  return {start, along + half_cotangent * (way - along) - half * axis.cross(way), turn.angle() * axis};
}

Isometry3d ScrewMotion::at(double time) const {
  Isometry3d pose = start;
  const double speed = angular.norm();
  if (speed == 0.0) {
    pose.translation() += time * linear;
    return pose;
  }
  const Turn turn(angular / speed, speed * time);
  for (int column = 0; column < 3; ++column) pose.linear().col(column) = turn * start.linear().col(column);
  if (linear.isZero(0.0)) return pose;
  const Vector3d along = turn.axis.dot(linear) * turn.axis;
  pose.translation() += time * along + (turn.sine * (linear - along) + turn.versine * turn.axis.cross(linear)) / speed;
  return pose;
}

ScrewMotion ScrewMotion::inverse() const {
  const Isometry3d back = start.inverse();
  return {back, back.linear() * (angular.cross(start.translation()) - linear), -(back.linear() * angular)};
}

ScrewMotion operator*(const Isometry3d& pose, const ScrewMotion& screw) {
  return {pose * screw.start, pose.linear() * screw.linear, pose.linear() * screw.angular};
}

ScrewMotion operator*(const ScrewMotion& screw, const Isometry3d& pose) {
  const Vector3d offset = screw.start.linear() * pose.translation();
  return {screw.start * pose, screw.linear + screw.angular.cross(offset), screw.angular};
}

Isometry3d poseAt(const MotionChain& chain, double time) {
  Isometry3d pose = Isometry3d::Identity();
  for (const ScrewMotion& screw : chain) pose = pose * screw.at(time);
  return pose;
}

double roundedLengths(const MotionChain& chain, double reach, const Vector3d& origin) {
  double sum = reach;
  for (std::size_t i = chain.size(); i-- > 0;) {
    const Vector3d start = chain[i].start.translation();
    reach += (i == 0 ? Vector3d(start - origin) : start).norm() + chain[i].linear.norm();
    sum += (1.0 + chain[i].angular.norm()) * reach;
  }
  return sum;
}

/// From the last frame to the first, the ball is seen to move in each; `centre` and `radius` become those of a ball
/// that holds it all the time. A point that moves at a speed s in a frame that turns at w gains an acceleration of 2 w
/// s.
MotionBound motionBound(const MotionChain& chain, const Vector3d& ball_centre, double ball_radius, double begin,
                        double end) {
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  Vector3d centre = ball_centre;
  double radius = ball_radius, all_turning = 0.0, speed = 0.0;
  MotionBound bound{Vector3d::Zero(), 0.0, 0.0};
  for (std::size_t i = chain.size(); i-- > 0;) {
    const ScrewMotion& screw = chain[i];
    const Isometry3d pose = screw.at(middle);
    centre = pose * centre;
    const double turning = screw.angular.norm();
    // A twist has one field of velocities at all times.
    const Vector3d velocity = screw.linear + screw.angular.cross(centre - screw.start.translation());
    const double centripetal = screw.angular.cross(velocity).norm();
    bound.acceleration += centripetal + turning * (turning * radius + 2.0 * speed);
    bound.velocity = pose.linear() * bound.velocity + velocity;
    all_turning += turning;
    speed += velocity.norm() + turning * radius;
    radius += half * velocity.norm();
  }
  bound.deviation = all_turning * ball_radius + half * bound.acceleration;
  return bound;
}

Shape sweptShape(const Shape& shape, const ScrewMotion& motion, double begin, double end) {
  const double duration = end - begin;
  const Isometry3d begin_T_end = motion.at(begin).inverse() * motion.at(end);
  const double acceleration = motionBound({motion}, shape.centre(), shape.coreRadius(), begin, end).acceleration;
  return shape.sweptTo(begin_T_end).padded(acceleration * duration * duration / 8.0);
}

}  // namespace proximity_server
