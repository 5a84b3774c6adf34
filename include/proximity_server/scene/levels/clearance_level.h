#pragma once

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/query/question.h"

#include <optional>

namespace proximity_server::scene {

/// How near a robot is to contact. The best level comes first.
enum class ClearanceLevel : unsigned char {
  Clear,
  Warn,      ///< a pair is at or below its warn distance
  Stop,      ///< a pair is at or below its stop distance
  Collision  ///< a pair touches or overlaps
};
const char* toString(ClearanceLevel level);  ///< "CLEAR"

/// The level of the state before. A level is left only when the distance exceeds its threshold by more than
/// `hysteresis` [m].
struct LevelBefore {
  std::optional<ClearanceLevel> level;  ///< nullopt: no level is kept
  double hysteresis = 0.0;

  /// [m] A distance that exceeds the threshold of a level by less than this is still at that level.
  double keptAbove(ClearanceLevel of) const { return level && *level >= of ? hysteresis : 0.0; }
};

/// The level of one distance [m]. `threshold` is the threshold of the level, or, for Clear, the threshold of Warn.
struct DistanceLevel {
  ClearanceLevel level = ClearanceLevel::Clear;
  double threshold = 0.0;  ///< [m]
};
DistanceLevel levelOf(double distance, double stop, double warn, const LevelBefore& before = {});

/// The level of a pair by its own thresholds, decided by the lower bound; a pair without an answer has the worst level.
/// If the stop distance of the pair is smaller than the default, the hysteresis is smaller in the same proportion:
/// otherwise a pair that is near by design could never leave a level.
DistanceLevel levelOf(const PairProximity& pair, const LevelThresholds& thresholds, const LevelBefore& before = {});

/// The level if only the lower bound `guaranteed` [m] is known, because the state is not known exactly. It is
/// Collision only if the pair touches or overlaps in the state of the answer.
DistanceLevel levelOf(const PairProximity& pair, double guaranteed, const LevelThresholds& thresholds,
                      const LevelBefore& before = {});

}  // namespace proximity_server::scene
