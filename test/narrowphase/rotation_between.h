#pragma once

#include <Eigen/Core>

namespace proximity_server {

/// The shortest rotation that turns one direction into another one. Compiled once: its templates take seven seconds.
Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace proximity_server
