#pragma once

#include "proximity_server/scene/query/question.h"

#include <cstring>

namespace proximity_server::scene {

/// Equal to the last bit, where NaN equals NaN.
inline bool areSameBits(double x, double y) { return std::memcmp(&x, &y, sizeof x) == 0; }
inline bool areSameBits(const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  return areSameBits(x[0], y[0]) && areSameBits(x[1], y[1]) && areSameBits(x[2], y[2]);
}

/// Whether all that is written about a pair is the same to the last bit.
inline bool areSame(const PairProximity& p, const PairProximity& q) {
  const narrowphase::SignedDistance &x = p.result, &y = q.result;
  return p.asked.a == q.asked.a && p.asked.b == q.asked.b && p.collision_a == q.collision_a &&
         p.collision_b == q.collision_b && p.representation == q.representation &&
         p.depth_is_lower_bound == q.depth_is_lower_bound && x.status == y.status && x.has_points == y.has_points &&
         x.unique == y.unique && x.iterations == y.iterations && areSameBits(x.distance, y.distance) &&
         areSameBits(x.lower_bound, y.lower_bound) && areSameBits(x.upper_bound, y.upper_bound) &&
         areSameBits(x.point_a, y.point_a) && areSameBits(x.point_b, y.point_b) && areSameBits(x.normal, y.normal);
}

}  // namespace proximity_server::scene
