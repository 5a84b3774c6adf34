#include "node/monitor/clearance_level.h"

#include "proximity_server/Clearance.h"

namespace proximity_server::node {

std::uint8_t clearanceLevel(double distance, std::uint8_t previous, const MonitorSettings& settings) {
  struct LevelThreshold {
    std::uint8_t level;
    double threshold;
  };
  const LevelThreshold levels[] = {{Clearance::COLLISION, 0.0},
                                   {Clearance::STOP, settings.stop_distance},
                                   {Clearance::WARN, settings.warn_distance}};
  for (const LevelThreshold& at : levels) {
    const bool kept = previous != Clearance::INVALID && previous >= at.level;
    const double hysteresis = kept ? settings.hysteresis : 0.0;
    // Written as !(distance > ...) so that NaN gives the worst level.
    if (!(distance > at.threshold + hysteresis)) return at.level;
  }
  return Clearance::CLEAR;
}

MonitorSettings ofObjects(MonitorSettings settings) {
  settings.warn_distance = settings.object_warn_distance;
  settings.stop_distance = settings.object_stop_distance;
  return settings;
}

}  // namespace proximity_server::node
