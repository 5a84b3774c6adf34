#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Core>

namespace proximity_server::scene {

/// [m] An upper bound of the distance of any point of a piece from a point in the frame of its body.
double reachFrom(const Eigen::Vector3d& point, const Piece& piece);

/// Failure: throws std::invalid_argument if a point of a piece may be farther than kFarthest from its frame, `frame` in
/// the message.
void requireNear(const Piece& piece, const char* frame);

}  // namespace proximity_server::scene
