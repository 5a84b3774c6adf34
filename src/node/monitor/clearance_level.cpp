#include "node/monitor/clearance_level.h"

#include "proximity_server/Clearance.h"

namespace proximity_server::node {

std::uint8_t clearanceLevel(double distance, std::uint8_t previous, const MonitorSettings& settings) {
  struct Step {
    std::uint8_t level;
    double threshold;
  };
  const Step steps[] = {{Clearance::COLLISION, 0.0},
                        {Clearance::STOP, settings.stop_distance},
                        {Clearance::WARN, settings.warn_distance}};
  for (const Step& step : steps) {
    const bool kept = previous != Clearance::INVALID && previous >= step.level;
    const double hysteresis = kept ? settings.hysteresis : 0.0;
    // Written so that NaN is the worst level.
    if (!(distance > step.threshold + hysteresis)) return step.level;
  }
  return Clearance::CLEAR;
}

std::string levelName(std::uint8_t level) {
  switch (level) {
    case Clearance::CLEAR:
      return "CLEAR";
    case Clearance::WARN:
      return "WARN";
    case Clearance::STOP:
      return "STOP";
    case Clearance::COLLISION:
      return "COLLISION";
    default:
      return "INVALID";
  }
}

}  // namespace proximity_server::node
