#pragma once

#include <cmath>
#include <limits>

namespace proximity_server::scene {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The float that is nearest to a number and not below it, or not above it.
inline float roundedUp(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                              : nearest;
}
inline float roundedDown(double value) { return -roundedUp(-value); }

}  // namespace proximity_server::scene
