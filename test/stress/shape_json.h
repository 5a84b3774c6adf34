#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

// Shapes and poses as the recorded cases write them, every double with all of its digits; see recorded_pairs.h.

/// JSON has no word for what is not finite: that stands in quotes.
nlohmann::json toJson(double number);
nlohmann::json toJson(const Eigen::Vector3d& v);
nlohmann::json toJson(const Eigen::Isometry3d& pose);  ///< rows of [R | t]
nlohmann::json toJson(const Shape& shape);

/// Throws std::runtime_error for a kind that it does not know.
Shape shapeFrom(const nlohmann::json& j);

}  // namespace proximity_server::narrowphase
