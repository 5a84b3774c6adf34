#include "proximity_server/scene/uncertainty/guaranteed_level.h"

namespace proximity_server::scene {

GuaranteedDecidingPair decidingPair(Scene& scene, GuaranteedDistances& distances, const State& state,
                                    const Pairs& pairs, const PairProximity& closest, const ListedPairs& listed,
                                    const LevelThresholds& thresholds, const Question& question,
                                    const LevelBefore& before) {
  const auto withLevel = [&](const PairProximity& pair, double guaranteed) {
    return GuaranteedDecidingPair{{levelOf(pair, guaranteed, thresholds, before), pair}, guaranteed};
  };
  const auto nearest = [&](const PairDistances& own, double enough) {
    const GuaranteedMinimum found = distances.find(scene, state, pairs, own, listed, question, enough);
    return withLevel(found.pair, found.guaranteed);
  };
  if (levelOf(closest, thresholds, before).level == ClearanceLevel::Collision)
    return withLevel(closest, distances.of(state, closest));
  const PairKind kind = pairs.areCandidates() ? pairs.kind() : PairKind::Any;
  const bool are_equal = thresholds.stop.areEqual(kind) && thresholds.warn.areEqual(kind);
  const double between = are_equal ? thresholds.warn.range(kind).largest - thresholds.stop.range(kind).largest : 0.0;
  const GuaranteedDecidingPair by_stop = nearest(thresholds.stop, between + before.hysteresis);
  return are_equal || by_stop.level.level == ClearanceLevel::Stop ? by_stop
                                                                  : nearest(thresholds.warn, before.hysteresis);
}

}  // namespace proximity_server::scene
