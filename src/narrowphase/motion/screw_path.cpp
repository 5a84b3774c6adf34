#include "narrowphase/motion/screw_path.h"

#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"

namespace proximity_server::narrowphase {

using Eigen::Vector3d;

namespace {

Eigen::Matrix3d axesOf(const Eigen::Isometry3d& pose) {
  const bool is_usable = isRotation(departure2FromRotation(pose));
  return (is_usable ? pose : rigidPose(pose).value_or(pose)).linear();
}

}  // namespace

Eigen::Isometry3d ScrewPath::Pose::isometry() const {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = rotation;
  result.translation() = origin;
  return result;
}

ScrewPath::ScrewPath(const Eigen::Isometry3d& start, const Vector3d& linear, const Vector3d& angular,
                     const Vector3d& from)
    : start_{axesOf(start), start.translation() - from},
      linear_(linear),
      angular_(angular),
      turning_(angular.norm()),
      straight_(linear) {
  if (turning_ == 0.0) return;
  const Vector3d axis = angular_ / turning_;
  for (int column = 0; column < 3; ++column) {
    rotation_by_sine_.col(column) = axis.cross(start_.rotation.col(column));
    rotation_by_versine_.col(column) = axis.cross(rotation_by_sine_.col(column));
  }
  straight_ = axis.dot(linear_) * axis;
  origin_by_sine_ = (linear_ - straight_) / turning_;
  origin_by_versine_ = axis.cross(linear_) / turning_;
}

ScrewPath::Pose ScrewPath::at(double time) const {
  Pose pose{start_.rotation, start_.origin + time * straight_};
  if (turning_ == 0.0) return pose;
  // 1 - cosine is computed from half of the angle, which avoids cancellation.
  const double half = 0.5 * turning_ * time;
  const auto [half_sine, half_cosine] = sineAndCosine(half);
  const double sine = 2.0 * half_sine * half_cosine, versine = 2.0 * half_sine * half_sine;
  pose.rotation += sine * rotation_by_sine_ + versine * rotation_by_versine_;
  pose.origin += sine * origin_by_sine_ + versine * origin_by_versine_;
  return pose;
}

}  // namespace proximity_server::narrowphase
