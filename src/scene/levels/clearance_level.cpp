#include "proximity_server/scene/levels/clearance_level.h"

#include "scene/model/numbers.h"

namespace proximity_server::scene {
namespace {

/// [m] A distance that exceeds the threshold of a level by less than this is still at that level.
double keptAbove(ClearanceLevel level, const LevelBefore& before) {
  return before.level && *before.level >= level ? before.hysteresis : 0.0;
}

}  // namespace

const char* toString(ClearanceLevel level) {
  switch (level) {
    case ClearanceLevel::Clear:
      return "CLEAR";
    case ClearanceLevel::Warn:
      return "WARN";
    case ClearanceLevel::Stop:
      return "STOP";
    case ClearanceLevel::Collision:
      return "COLLISION";
  }
  return "unknown";
}

DistanceLevel levelOf(double distance, double stop, double warn, const LevelBefore& before) {
  for (const DistanceLevel& at :
       {DistanceLevel{ClearanceLevel::Collision, 0.0}, DistanceLevel{ClearanceLevel::Stop, stop},
        DistanceLevel{ClearanceLevel::Warn, warn}}) {
    // Written as !(distance > ...) so that NaN gives the worst level.
    if (!(distance > at.threshold + keptAbove(at.level, before))) return at;
  }
  return {ClearanceLevel::Clear, warn};
}

DistanceLevel levelOf(const PairProximity& pair, const LevelThresholds& thresholds, const LevelBefore& before) {
  return levelOf(pair, pair.result.lower_bound, thresholds, before);
}

DistanceLevel levelOf(const PairProximity& pair, double guaranteed, const LevelThresholds& thresholds,
                      const LevelBefore& before) {
  const bool has_object = !pair.asked.areLinks();
  const double stop = thresholds.stop.of(pair.asked), warn = thresholds.warn.of(pair.asked),
               usual = has_object ? thresholds.stop.objects : thresholds.stop.links;
  const double scale = stop < usual ? stop / usual : 1.0;
  const LevelBefore own{before.level, scale * before.hysteresis};
  const DistanceLevel of_state = levelOf(pair.result.lower_bound, stop, warn, own);
  if (of_state.level == ClearanceLevel::Collision || guaranteed == pair.result.lower_bound) return of_state;
  const DistanceLevel level = levelOf(guaranteed, stop, warn, own);
  return level.level == ClearanceLevel::Collision ? DistanceLevel{ClearanceLevel::Stop, stop} : level;
}

DecidingPair decidingPair(Scene& scene, const State& state, const Pairs& pairs, const PairProximity& closest,
                          const LevelThresholds& thresholds, const Question& question, const LevelBefore& before) {
  const auto withLevel = [&](const PairProximity& pair) {
    return DecidingPair{levelOf(pair, thresholds, before), pair};
  };
  const PairKind kind = pairs.areCandidates() ? pairs.kind() : PairKind::Any;
  const DecidingPair of_closest = withLevel(closest);
  if (of_closest.level.level == ClearanceLevel::Collision) return of_closest;
  if (thresholds.stop.areEqual(kind) && thresholds.warn.areEqual(kind)) return of_closest;

  Question near = question;
  near.thresholds = &thresholds.stop;
  near.threshold = keptAbove(ClearanceLevel::Stop, before);
  if (const PairProximity* nearest = scene.minimum(state, pairs, near)) {
    const DecidingPair decided = withLevel(*nearest);
    if (decided.level.level == ClearanceLevel::Stop) return decided;
  }
  near.thresholds = &thresholds.warn;
  near.threshold = kInfinity;
  const PairProximity* nearest = scene.minimum(state, pairs, near);
  return nearest ? withLevel(*nearest) : of_closest;
}

}  // namespace proximity_server::scene
