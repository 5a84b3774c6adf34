#pragma once

#include "system/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {

inline constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// roundedUp(): the nearest float that is not below a number. roundedDown(): the nearest float that is not above it.
inline float roundedUp(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                              : nearest;
}
inline float roundedDown(double value) { return -roundedUp(-value); }

/// Half the width of an interval, from its middle, which is computed, to either end; rounded up.
inline double halfWidth(double lower, double upper) {
  const double middle = 0.5 * (lower + upper);
  return std::nextafter(std::max(upper - middle, middle - lower), kInfinity);
}

}  // namespace proximity_server::scene
