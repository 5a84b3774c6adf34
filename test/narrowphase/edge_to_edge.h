#pragma once

#include <Eigen/Geometry>

#include <cmath>

namespace proximity_server::narrowphase {

/// Pose of a box of 2 m beside another (at the identity) whose edge x = y = 1 it faces with an edge across: the normal
/// is n = (1, 1, 0) / sqrt(2), and the edges are nearest in (1, 1, 0.3) and in (1, 1, 0.3) + gap n. A negative gap is
/// minus a depth.
///
/// The axes of b are e1 = (1, -1, 0) / sqrt(2), e2 = (n + z) / sqrt(2), e3 = (z - n) / sqrt(2). Towards -n its edge
/// along e1 lies at -e2 + e3 = -sqrt(2) n.
inline Eigen::Isometry3d edgeToEdge(double gap) {
  const Eigen::Vector3d n = Eigen::Vector3d(1, 1, 0).normalized(), z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d e1 = Eigen::Vector3d(1, -1, 0).normalized();
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  a_T_b.linear() << e1, (n + z).normalized(), (z - n).normalized();
  a_T_b.translation() = (2.0 * std::sqrt(2.0) + gap) * n + 0.3 * z + 0.2 * e1;
  return a_T_b;
}

}  // namespace proximity_server::narrowphase
