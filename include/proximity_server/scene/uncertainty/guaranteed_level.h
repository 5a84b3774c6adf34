#pragma once

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/uncertainty/guaranteed_distances.h"

namespace proximity_server::scene {

/// The pair that decides the level of a state that is not known exactly.
struct GuaranteedDecidingPair : DecidingPair {
  double guaranteed = 0.0;  ///< [m] of the pair
};

/// Finds the pair that decides by guaranteed distances: among the pairs of the worst level it is the one with the
/// smallest guaranteed distance minus its threshold. A level of Collision is that of the state itself.
///
/// `closest`, thresholds, question and `before` are those of decidingPair(). `listed` are pairs that the scene has listed
/// for this state. All poses must be known.
GuaranteedDecidingPair decidingPair(Scene& scene, GuaranteedDistances& distances, const State& state,
                                    const Pairs& pairs, const PairProximity& closest, const ListedPairs& listed,
                                    const LevelThresholds& thresholds, const Question& question = {},
                                    const LevelBefore& before = {});

}  // namespace proximity_server::scene
