#pragma once

#include "narrowphase/same_bits.h"
#include "proximity_server/scene/query/pair_distances.h"

namespace proximity_server::scene {

/// Whether two answers about a pair are the same to the last bit, but for their iterations.
inline bool areSame(const PairProximity& p, const PairProximity& q) {
  return p.asked.a == q.asked.a && p.asked.b == q.asked.b && p.collision_a == q.collision_a &&
         p.collision_b == q.collision_b && p.representation == q.representation &&
         p.depth_is_lower_bound == q.depth_is_lower_bound && narrowphase::areSameBits(p.result, q.result);
}

}  // namespace proximity_server::scene
