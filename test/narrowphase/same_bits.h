#pragma once

#include "proximity_server/narrowphase/signed_distance.h"

#include <Eigen/Core>

#include <cmath>
#include <cstring>

namespace proximity_server::narrowphase {

/// Equal to the last bit, where -0 does not equal 0, and any NaN equals any other.
inline bool areSameBits(double x, double y) {
  return std::memcmp(&x, &y, sizeof x) == 0 || (std::isnan(x) && std::isnan(y));
}

inline bool areSameBits(const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  return areSameBits(x.x(), y.x()) && areSameBits(x.y(), y.y()) && areSameBits(x.z(), y.z());
}

/// Whether two answers are the same to the last bit. Their iterations are left out: they tell how an answer was found,
/// which a warm start changes.
inline bool areSameBits(const SignedDistance& x, const SignedDistance& y) {
  return x.status == y.status && x.has_points == y.has_points && x.unique == y.unique &&
         areSameBits(x.distance, y.distance) && areSameBits(x.lower_bound, y.lower_bound) &&
         areSameBits(x.upper_bound, y.upper_bound) && areSameBits(x.point_a, y.point_a) &&
         areSameBits(x.point_b, y.point_b) && areSameBits(x.normal, y.normal);
}

}  // namespace proximity_server::narrowphase
