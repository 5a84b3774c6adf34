#pragma once

#include <cmath>
#include <limits>

namespace proximity_server::scene {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// roundedUp(): the nearest float that is not below a number. roundedDown(): the nearest float that is not above it.
inline float roundedUp(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                              : nearest;
}
inline float roundedDown(double value) { return -roundedUp(-value); }

}  // namespace proximity_server::scene
