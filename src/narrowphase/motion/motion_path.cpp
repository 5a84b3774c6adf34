#include "narrowphase/motion/motion_path.h"

#include <algorithm>

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Vector3d;

MotionPath::MotionPath(const MotionChain& chain, const Vector3d& from)
    : screws_(few_.data()), size_(std::max<std::size_t>(1, chain.size())) {
  if (size_ > few_.size()) {
    many_.resize(size_);
    screws_ = many_.data();
  }
  const ScrewMotion rest, &first = chain.empty() ? rest : chain.front();
  screws_[0] = ScrewPath(first.start, first.linear, first.angular, from);
  for (std::size_t i = 1; i < size_; ++i) screws_[i] = ScrewPath(chain[i].start, chain[i].linear, chain[i].angular);
}

ScrewPath::Pose MotionPath::at(double time) const {
  ScrewPath::Pose pose = screws_[0].at(time);
  for (std::size_t i = 1; i < size_; ++i) {
    const ScrewPath::Pose next = screws_[i].at(time);
    pose.origin += pose.rotation * next.origin;
    pose.rotation = (pose.rotation * next.rotation).eval();
  }
  return pose;
}

namespace {

/// The effect of the turn of a frame on the points of a ball that is fixed to it, besides moving its centre.
struct Turning {
  double speed;         ///< [1] per unit of time: velocities differ by this times the distance from the centre
  double acceleration;  ///< [1] per unit of time squared
};

/// Without the spin about its own axis z, a body turns at w' = w - (w . z) z. The angle between w and z is constant
/// while z turns at w. So |w'| is constant, and w' changes at |(w . z) w x z| = |w . z| |w'|. A point at r from the
/// centre then has the velocity w' x r and the acceleration dw'/dt x r + w' x (w' x r).
Turning turningOf(const ScrewPath& screw, Symmetry symmetry) {
  const double turning = screw.turning();
  if (symmetry == Symmetry::AboutZ) {
    const ScrewPath::Spin spin = screw.aboutOwnAxis();
    if (spin.across < spin.along) return {spin.across, spin.across * (spin.along + spin.across)};
  }
  return {turning, turning * turning};
}

}  // namespace

/// The loop runs from the last frame to the first. In each frame `centre` and `radius` describe a ball that
/// contains the given ball at all times. A point with speed s in a frame that rotates at w has a Coriolis acceleration
/// of 2 w s.
MotionBound MotionPath::bound(const Vector3d& ball_centre, double ball_radius, double begin, double end,
                              Symmetry symmetry) const {
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  Vector3d centre = ball_centre;
  double radius = ball_radius, all_turning = 0.0, speed = 0.0;
  MotionBound bound{Vector3d::Zero(), 0.0, 0.0};
  for (std::size_t i = size_; i-- > 0; symmetry = Symmetry::None) {
    const ScrewPath& screw = screws_[i];
    const Turning turning = turningOf(screw, symmetry);
    const ScrewPath::Pose pose = screw.at(middle);
    centre = pose * centre;
    // The field of velocities of a screw does not change with time.
    const Vector3d velocity = screw.velocity(centre);
    const double centripetal = screw.angular().cross(velocity).norm();
    bound.acceleration += centripetal + turning.acceleration * radius + 2.0 * screw.turning() * speed;
    bound.velocity = pose.rotation * bound.velocity + velocity;
    all_turning += turning.speed;
    speed += velocity.norm() + turning.speed * radius;
    radius += half * velocity.norm();
  }
  bound.deviation = all_turning * ball_radius + half * bound.acceleration;
  return bound;
}

Isometry3d poseAt(const MotionChain& chain, double time) { return MotionPath(chain).at(time).isometry(); }

MotionBound motionBound(const MotionChain& chain, const Vector3d& centre, double radius, double begin, double end) {
  return MotionPath(chain).bound(centre, radius, begin, end);
}

Shape sweptShape(const Shape& shape, const ScrewMotion& motion, double begin, double end) {
  const double duration = end - begin;
  const Isometry3d begin_T_end = motion.at(begin).inverse() * motion.at(end);
  const double acceleration = motionBound({motion}, shape.centre(), shape.coreRadius(), begin, end).acceleration;
  return shape.sweptTo(begin_T_end).padded(acceleration * duration * duration / 8.0);
}

}  // namespace proximity_server::narrowphase
