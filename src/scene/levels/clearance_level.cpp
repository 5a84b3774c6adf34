#include "proximity_server/scene/levels/clearance_level.h"

namespace proximity_server::scene {

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
    if (!(distance > at.threshold + before.keptAbove(at.level))) return at;
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

}  // namespace proximity_server::scene
