#include "proximity_server/scene/answers/deciding_pair.h"

#include "scene/model/numbers.h"

#include <optional>

namespace proximity_server::scene {

DecidingPair decidingPair(Scene& scene, const State& state, const Pairs& pairs, const PairProximity& closest,
                          const LevelQuestion& asked) {
  const PairDistances &stop = asked.thresholds.stop, &warn = asked.thresholds.warn;
  const auto withLevel = [&](const PairProximity& pair, double guaranteed) {
    return DecidingPair{levelOf(pair, guaranteed, asked.thresholds, asked.before), pair, guaranteed};
  };
  const PairKind kind = pairs.areCandidates() ? pairs.kind() : PairKind::Any;
  const bool are_equal = stop.areEqual(kind) && warn.areEqual(kind);
  const DecidingPair of_closest = withLevel(closest, closest.result.lower_bound);
  if (of_closest.level.level == ClearanceLevel::Collision)
    return asked.guaranteed ? withLevel(closest, asked.guaranteed->of(state, closest)) : of_closest;
  if (are_equal && !asked.guaranteed) return of_closest;

  // The pair with the smallest distance minus its own. Nothing is to be known exactly that is above it by `enough`.
  const auto nearest = [&](const PairDistances& own, double threshold, double enough) -> std::optional<DecidingPair> {
    if (asked.guaranteed) {
      const GuaranteedMinimum found =
          asked.guaranteed->find(scene, state, pairs, own, asked.listed, asked.question, enough);
      return withLevel(found.pair, found.guaranteed);
    }
    Question near = asked.question;
    near.thresholds = &own;
    near.threshold = threshold;
    const PairProximity* found = scene.minimum(state, pairs, near);
    if (!found) return std::nullopt;
    return withLevel(*found, found->result.lower_bound);
  };
  const double between = are_equal ? warn.range(kind).largest - stop.range(kind).largest : 0.0;
  const std::optional<DecidingPair> by_stop =
      nearest(stop, asked.before.keptAbove(ClearanceLevel::Stop), between + asked.before.hysteresis);
  if (by_stop && (are_equal || by_stop->level.level == ClearanceLevel::Stop)) return *by_stop;
  return nearest(warn, kInfinity, asked.before.hysteresis).value_or(of_closest);
}

}  // namespace proximity_server::scene
