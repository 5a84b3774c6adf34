#include "proximity_server/narrowphase/motion/motion.h"

#include "narrowphase/motion/screw_path.h"
#include "proximity_server/narrowphase/angle.h"

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The translation along the axis is uniform. Across the axis, a velocity v leads to the displacement
/// 1/x (sin(x) v + (1 - cos(x)) axis x v), see at(); this equation is solved for v.
ScrewMotion ScrewMotion::between(const Isometry3d& start, const Isometry3d& end) {
  const Eigen::Quaterniond turn(Matrix3d(end.linear() * start.linear().transpose()));
  double half_sine = turn.vec().norm();
  if (half_sine < std::numeric_limits<double>::epsilon()) half_sine = turn.vec().stableNorm();
  const double half_cosine = std::abs(turn.w()), half = angleOf(half_sine, half_cosine);
  const Vector3d axis = half > 0.0 ? Vector3d(turn.vec() / std::copysign(half_sine, turn.w())) : Vector3d::UnitX();
  const Vector3d translation = end.translation() - start.translation();
  const double half_cotangent = half > 0.0 ? half * half_cosine / half_sine : 1.0;
  const Vector3d along = axis.dot(translation) * axis;
  return {start, along + half_cotangent * (translation - along) - half * axis.cross(translation), 2.0 * half * axis};
}

Isometry3d ScrewMotion::at(double time) const { return ScrewPath(start, linear, angular).at(time).isometry(); }

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

double roundedLengths(const MotionChain& chain, double reach, const Vector3d& origin) {
  double sum = reach;
  for (std::size_t i = chain.size(); i-- > 0;) {
    const Vector3d start = chain[i].start.translation();
    reach += (i == 0 ? Vector3d(start - origin) : start).norm() + chain[i].linear.norm();
    sum += (1.0 + chain[i].angular.norm()) * reach;
  }
  return sum;
}

}  // namespace proximity_server::narrowphase
