#include "proximity_server/narrowphase/motion.h"

#include <algorithm>
#include <cmath>

namespace proximity_server {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d crossProduct(const Vector3d& v) {
  Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

/// A turn by the vector `angle` [rad], and the mean of all turns on the way there.
///
/// Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 2.4 (exponential of a twist).
class Turn {
 public:
  explicit Turn(const Vector3d& angle)
      : cross_(crossProduct(angle)), square_(angle * angle.transpose()), x2_(angle.squaredNorm()) {
    const double x = std::sqrt(x2_), half_sine = std::sin(0.5 * x), half_cosine = std::cos(0.5 * x);
    const double per_half = x > 0.0 ? 2.0 * half_sine / x : 1.0;
    square_.diagonal().array() -= x2_;
    sine_ = per_half * half_cosine;
    versine_ = 0.5 * per_half * per_half;
  }

  Matrix3d rotation() const { return Matrix3d::Identity() + sine_ * cross_ + versine_ * square_; }

  Matrix3d mean() const {
    // (x - sin x) / x^3 loses its digits to the difference where x is small; the next term of the series is 2e-17.
    const bool is_small = x2_ < 0.01;
    const double rest =
        is_small ? 1.0 / 6.0 - x2_ * (1.0 / 120.0 - x2_ * (1.0 / 5040.0 - x2_ / 362880.0)) : (1.0 - sine_) / x2_;
    return Matrix3d::Identity() + versine_ * cross_ + rest * square_;
  }

 private:
  Matrix3d cross_, square_;     ///< of the angle: its cross product, once and twice
  double x2_, sine_, versine_;  ///< x^2, sin x / x, (1 - cos x) / x^2 of the angle x
};

}  // namespace

ScrewMotion ScrewMotion::between(const Isometry3d& start, const Isometry3d& end) {
  const Eigen::AngleAxisd turn(Matrix3d(end.linear() * start.linear().transpose()));
  ScrewMotion motion{start, end.translation() - start.translation(), turn.angle() * turn.axis()};
  motion.linear = Turn(motion.angular).mean().inverse() * motion.linear;
  return motion;
}

Isometry3d ScrewMotion::at(double time) const {
  Isometry3d pose = start;
  if (angular.isZero(0.0)) {
    pose.translation() += time * linear;
    return pose;
  }
  const Turn turn(time * angular);
  pose.linear() = turn.rotation() * start.linear();
  if (!linear.isZero(0.0)) pose.translation() += time * (turn.mean() * linear);
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
