#pragma once

#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

/// True if a triangle is so narrow that rounding makes its area vector useless, and the barycentric weights that follow
/// from it. `length2` [m^2]: the square of the longest edge.
inline bool isNeedle(const Eigen::Vector3d& area, double length2) {
  constexpr double kNeedle = 1e-4;  // limit of (width / length)^2; above it, the loss is at most 100 eps of the length
  return area.squaredNorm() <= kNeedle * length2 * length2;
}

/// The area vector without its component along the longest edge, if the triangle is a needle: the true area vector is
/// perpendicular to the edge, and this component is rounding.
inline Eigen::Vector3d withoutRoundingAlong(const Eigen::Vector3d& edge, double length2, const Eigen::Vector3d& area) {
  if (!isNeedle(area, length2)) return area;
  return area - (area.dot(edge) / length2) * edge;
}

/// Area vector (twice the area, counter-clockwise normal) of a triangle from its edges a to b, b to c and c to a. It is
/// the cross product of the two shortest edges, which has the smallest rounding error.
inline Eigen::Vector3d areaVector(const Eigen::Vector3d& ab, const Eigen::Vector3d& bc, const Eigen::Vector3d& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return withoutRoundingAlong(ab, ab2, bc.cross(ca));
  if (bc2 >= ca2) return withoutRoundingAlong(bc, bc2, ca.cross(ab));
  return withoutRoundingAlong(ca, ca2, ab.cross(bc));
}

}  // namespace proximity_server::narrowphase
