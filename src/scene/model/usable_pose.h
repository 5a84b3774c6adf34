#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace proximity_server::scene {

/// The pose with the rotation nearest to its matrix; nullopt if it is missing, not finite, or no rotation within
/// single precision.
std::optional<Eigen::Isometry3d> usablePose(const std::optional<Eigen::Isometry3d>& pose);

}  // namespace proximity_server::scene
