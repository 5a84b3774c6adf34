#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <limits>
#include <optional>

namespace proximity_server::narrowphase {

/// Returns the pose with the rotation nearest to its linear part. Returns nullopt if the pose is not finite, or if the
/// linear part is not a rotation within single precision, 2e-6 in each product of two columns; so mirrored, scaled and
/// zero matrices give nullopt.
///
/// Source: Higham, Computing the Polar Decomposition, SIAM J. Sci. Stat. Comput. 1986.
std::optional<Eigen::Isometry3d> rigidPose(const Eigen::Isometry3d& pose);

/// The square of a measure of how far the linear part of a pose is from a rotation: the columns x, y, z of a rotation,
/// and only of a rotation, have x times y = z, y times z = x and |x| = 1. The root is at least a third of the distance
/// to the nearest rotation, to first order. NaN if an entry is not finite.
inline double departure2FromRotation(const Eigen::Isometry3d& pose) {
  const auto axes = pose.linear();
  const Eigen::Vector3d x = axes.col(0), y = axes.col(1), z = axes.col(2);
  const double length = x.squaredNorm() - 1.0;
  return (x.cross(y) - z).squaredNorm() + (y.cross(z) - x).squaredNorm() + length * length;
}

/// True if a pose with this distance from a rotation is used unchanged: a product of many rotation matrices has a
/// smaller one. False for NaN.
inline bool isRotation(double departure2) {
  constexpr double kDeparture = 32.0 * std::numeric_limits<double>::epsilon();
  return departure2 <= kDeparture * kDeparture;
}

}  // namespace proximity_server::narrowphase
