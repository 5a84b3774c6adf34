#pragma once

#include <limits>

namespace proximity_server::scene {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace proximity_server::scene
