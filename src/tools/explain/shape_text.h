#pragma once

#include "tools/explain/explained_pair.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The numbers of a text, separated by blanks. Throws std::invalid_argument, beginning with `what`, unless there are
/// `count` finite ones. If they are angles, [rad], one may also be like "90deg".
std::vector<double> numbersOf(const std::string& what, const std::string& text, std::size_t count,
                              bool are_angles = false);

/// Reads a shape, sizes in metres:
///   box x y z | sphere radius | capsule radius length | cylinder radius length | cone radius length |
///   ellipsoid rx ry rz | hull n x y z ... (n points),
/// and behind it, where wanted, `pad m` and `sweep <rotation, row by row> <translation>` (Shape::sweptTo).
/// Throws std::invalid_argument, beginning with `what`, and naming the word that is wrong.
ExplainedShape readShape(const std::string& what, const std::string& text);

/// The pose of xyz and rpy as in a URDF [m], [rad].
Eigen::Isometry3d poseOf(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy);

/// The pose of a rotation matrix, row by row, and a translation: 12 numbers. Throws std::invalid_argument, beginning
/// with `what`, if the matrix is no rotation within 1e-6.
Eigen::Isometry3d readPose(const std::string& what, const std::string& text);

}  // namespace proximity_server::tools
