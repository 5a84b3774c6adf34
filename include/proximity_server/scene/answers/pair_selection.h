#pragma once

#include "proximity_server/scene/query/scene.h"

#include <vector>

namespace proximity_server::scene {

/// Which pairs are in the answer about a state: all of them, the closest one, all or any at or below the threshold of
/// the question, or the `count` closest ones.
struct PairSelection {
  enum class Kind : unsigned char { All, Minimum, Below, Closest, Any };
  Kind kind = Kind::Minimum;
  int count = 1;  ///< for Closest
};

/// Asks the scene for the selected ones of `pairs`. Failure: throws as its questions do.
std::vector<PairProximity> selectPairs(Scene& scene, const State& state, const Pairs& pairs,
                                       const PairSelection& selection, const Question& question = {});

}  // namespace proximity_server::scene
