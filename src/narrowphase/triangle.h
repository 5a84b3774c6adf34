#pragma once

#include <Eigen/Geometry>

namespace proximity_server {

/// Area vector (twice the area, counter-clockwise normal) of a triangle from its edges a to b, b to c, c to a: the
/// cross product of the two shortest, which loses least to rounding.
inline Eigen::Vector3d areaVector(const Eigen::Vector3d& ab, const Eigen::Vector3d& bc, const Eigen::Vector3d& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return bc.cross(ca);
  if (bc2 >= ca2) return ca.cross(ab);
  return ab.cross(bc);
}

}  // namespace proximity_server
