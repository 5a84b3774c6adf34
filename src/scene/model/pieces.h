#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Core>

namespace proximity_server::scene {

/// [m] An upper bound of the distance of any point of a piece from a point in the frame of its body.
double reachFrom(const Eigen::Vector3d& point, const Piece& piece);

}  // namespace proximity_server::scene
