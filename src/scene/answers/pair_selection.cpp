#include "proximity_server/scene/answers/pair_selection.h"

namespace proximity_server::scene {

std::vector<PairProximity> selectPairs(Scene& scene, const State& state, const Pairs& pairs,
                                       const PairSelection& selection, const Question& question) {
  const PairProximity* one = nullptr;
  switch (selection.kind) {
    case PairSelection::Kind::All:
      return scene.all(state, pairs, question);
    case PairSelection::Kind::Below:
      return scene.below(state, pairs, question);
    case PairSelection::Kind::Closest:
      return scene.closest(state, pairs, selection.count, question);
    case PairSelection::Kind::Minimum:
      one = scene.minimum(state, pairs, question);
      break;
    case PairSelection::Kind::Any:
      one = scene.first(state, pairs, question);
      break;
  }
  return {one, one + (one ? 1 : 0)};
}

}  // namespace proximity_server::scene
