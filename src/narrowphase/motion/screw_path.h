#pragma once

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

/// A screw motion with everything precomputed that does not depend on the time, so that a pose costs one sine, one
/// cosine and some sums.
///
/// With the unit axis e and the angle x, a rotated vector is v + sin(x) e x v + (1 - cos(x)) e x (e x v).
///
/// Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 2.2 (Rodrigues' formula) and
///         2.4 (exponential of a twist).
class ScrewPath {
 public:
  struct Pose {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d origin;
    Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + origin; }
    Eigen::Isometry3d isometry() const;
  };

  ScrewPath() = default;
  /// See ScrewMotion. Positions are relative to `from`.
  ScrewPath(const Eigen::Isometry3d& start, const Eigen::Vector3d& linear, const Eigen::Vector3d& angular,
            const Eigen::Vector3d& from = Eigen::Vector3d::Zero());

  Pose at(double time) const;

  /// [rad] per unit of time: the angular speed.
  double turning() const { return turning_; }

  /// [rad] per unit of time: the parts of the angular velocity along the z axis of the moving frame and perpendicular
  /// to it. Both are constant; the second one allows for the rounding of the products.
  struct Spin {
    double along, across;
  };
  Spin aboutOwnAxis() const {
    const Eigen::Vector3d z = start_.rotation.col(2);
    constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
    return {std::abs(angular_.dot(z)), angular_.cross(z).norm() + kRounding * turning_};
  }

  /// [m] per unit of time: the velocity of the moving body at a point.
  Eigen::Vector3d velocity(const Eigen::Vector3d& point) const {
    return linear_ + angular_.cross(point - start_.origin);
  }
  const Eigen::Vector3d& angular() const { return angular_; }

 private:
  Pose start_;
  Eigen::Vector3d linear_, angular_;
  double turning_;
  // The factors of the sine and of 1 - cosine; they are not set if there is no rotation. straight_ is the velocity of
  // the origin along the axis.
  Eigen::Matrix3d rotation_by_sine_, rotation_by_versine_;
  Eigen::Vector3d straight_, origin_by_sine_, origin_by_versine_;
};

}  // namespace proximity_server::narrowphase
