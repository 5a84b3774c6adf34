#pragma once

#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

/// The part of the area vector of a needle along its longest edge is rounding, at the end of a long lever.
inline Eigen::Vector3d withoutRoundingAlong(const Eigen::Vector3d& edge, double length2, const Eigen::Vector3d& area) {
  constexpr double kNeedle = 1e-4;  // of (width / length)^2: a wider one loses at most 100 eps of its length
  if (area.squaredNorm() > kNeedle * length2 * length2) return area;
  return area - (area.dot(edge) / length2) * edge;
}

/// Area vector (twice the area, counter-clockwise normal) of a triangle from its edges a to b, b to c, c to a: the
/// cross product of the two shortest, which loses least to rounding.
inline Eigen::Vector3d areaVector(const Eigen::Vector3d& ab, const Eigen::Vector3d& bc, const Eigen::Vector3d& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return withoutRoundingAlong(ab, ab2, bc.cross(ca));
  if (bc2 >= ca2) return withoutRoundingAlong(bc, bc2, ca.cross(ab));
  return withoutRoundingAlong(ca, ca2, ab.cross(bc));
}

}  // namespace proximity_server::narrowphase
