#pragma once

#include <optional>

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// How near a robot is, the best first.
enum class ClearanceLevel : unsigned char {
  Clear,
  Warn,      ///< a pair is at or below its warn distance
  Stop,      ///< at or below its stop distance
  Collision  ///< touching or overlapping
};
const char* toString(ClearanceLevel level);  ///< "CLEAR"

/// A level is left only when the distance exceeds its threshold by more than `hysteresis` [m].
struct LevelBefore {
  std::optional<ClearanceLevel> level;  ///< of the state before; nullopt: no level is kept
  double hysteresis = 0.0;
};

/// The level of one distance [m], and the threshold that it is at or below, or, if it is Clear, above.
struct DistanceLevel {
  ClearanceLevel level = ClearanceLevel::Clear;
  double threshold = 0.0;  ///< [m]
};
DistanceLevel levelOf(double distance, double stop, double warn, const LevelBefore& before = {});

/// The level of a pair by its own thresholds, decided by the lower bound: without an answer it is the worst one. If its stop distance is
/// smaller than that of pairs without one of their own, so is the hysteresis, in proportion: a pair that is near by design could else
/// never leave a level.
DistanceLevel levelOf(const PairProximity& pair, const LevelThresholds& thresholds, const LevelBefore& before = {});

/// The pair that sets the level of a state: of the worst level, it is the one with the smallest distance less its threshold (that of
/// WARN if the level is Clear). It need not be the closest one.
struct DecidingPair {
  DistanceLevel level;
  PairProximity pair;
};

/// Decides by the lower bounds of the distances.
///
/// 1. The closest pair tells whether there is a collision.
/// 2. If all pairs of the question have the same thresholds, it tells the level too.
/// 3. Otherwise search for the pair with the smallest distance less its stop distance, no farther than matters, and if it is no Stop, for
///    the one with the smallest distance less its warn distance. The scene has measured most of what is near by then.
///
/// Limit: the hysteresis is of the level, not of each pair. Where pairs have thresholds of their own, a Stop may be left within the
///        hysteresis if another pair, with a smaller hysteresis, is nearer to its stop distance. It is never left at or below a threshold.
///
/// `closest` is what Scene::minimum() answers about the same pairs and question, which has no threshold.
DecidingPair decidingPair(Scene& scene, const Pairs& pairs, const PairProximity& closest,
                          const LevelThresholds& thresholds, const Question& question = {},
                          const LevelBefore& before = {});

}  // namespace proximity_server::scene
