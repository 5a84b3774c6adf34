#pragma once

#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// The pair that decides the level of a state. Among the pairs of the worst level, it is the one with the smallest
/// distance minus its threshold (the threshold of Warn if the level is Clear). It need not be the closest pair.
struct DecidingPair {
  DistanceLevel level;
  PairProximity pair;
  double guaranteed = 0.0;  ///< [m] of the pair; its lower bound if the state is known exactly
};

/// The thresholds of a level, the level before, and what is known about the state.
struct LevelQuestion {
  const LevelThresholds& thresholds;
  LevelBefore before{};
  Question question{};                        ///< of the scene; without thresholds
  GuaranteedDistances* guaranteed = nullptr;  ///< nullptr: the state is known exactly
  ListedPairs listed{};                       ///< pairs that the scene has listed for this state; for `guaranteed`
};

/// Finds the deciding pair by the lower bounds of the distances.
///
/// 1. The closest pair tells whether there is a collision.
/// 2. If all pairs of the question have the same thresholds, the closest pair also tells the level.
/// 3. Otherwise search for the pair with the smallest distance minus its stop distance, up to the distance that
///    matters. If it is not at Stop, search for the pair with the smallest distance minus its warn distance. By then
///    the scene has measured most of the near pairs.
///
/// With LevelQuestion::guaranteed the guaranteed distances decide, in which case all poses must be known. A level of
/// Collision is about the state itself.
///
/// Limit: the hysteresis belongs to the level, not to each pair. If pairs have thresholds of their own, a Stop may be
///        left within the hysteresis if another pair, with a smaller hysteresis, is nearer to its stop distance. It is
///        never left at or below a threshold.
///
/// `closest` must be the answer of Scene::minimum() about the same state, pairs and question, and that question has no
/// threshold.
DecidingPair decidingPair(Scene& scene, const State& state, const Pairs& pairs, const PairProximity& closest,
                          const LevelQuestion& asked);

}  // namespace proximity_server::scene
