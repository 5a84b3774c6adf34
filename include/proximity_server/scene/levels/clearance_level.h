#pragma once

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/query/scene.h"

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
};

/// The level of one distance [m]. `threshold` is the threshold of the level, or, for Clear, that of Warn.
struct DistanceLevel {
  ClearanceLevel level = ClearanceLevel::Clear;
  double threshold = 0.0;  ///< [m]
};
DistanceLevel levelOf(double distance, double stop, double warn, const LevelBefore& before = {});

/// The level of a pair by its own thresholds, decided by the lower bound; a pair without an answer has the worst level.
/// If the stop distance of the pair is smaller than the default, the hysteresis is smaller in the same proportion:
/// otherwise a pair that is near by design could never leave a level.
DistanceLevel levelOf(const PairProximity& pair, const LevelThresholds& thresholds, const LevelBefore& before = {});

/// The same where only a lower bound of the distance is guaranteed [m], because the state is not known exactly. The
/// level is Collision only if the pair touches or overlaps in the state of the answer.
DistanceLevel levelOf(const PairProximity& pair, double guaranteed, const LevelThresholds& thresholds,
                      const LevelBefore& before = {});

/// The pair that decides the level of a state. Among the pairs of the worst level, it is the one with the smallest
/// distance minus its threshold (that of WARN if the level is Clear). It need not be the closest pair.
struct DecidingPair {
  DistanceLevel level;
  PairProximity pair;
};

/// Finds the deciding pair by the lower bounds of the distances.
///
/// 1. The closest pair tells whether there is a collision.
/// 2. If all pairs of the question have the same thresholds, the closest pair also tells the level.
/// 3. Otherwise search for the pair with the smallest distance minus its stop distance, up to the distance that
///    matters. If it is not at Stop, search for the pair with the smallest distance minus its warn distance. By then
///    the scene has measured most of the near pairs.
///
/// Limit: the hysteresis belongs to the level, not to each pair. If pairs have thresholds of their own, a Stop may be
///        left within the hysteresis if another pair, with a smaller hysteresis, is nearer to its stop distance. It is
///        never left at or below a threshold.
///
/// `closest` must be the answer of Scene::minimum() about the same state, pairs and question, and that question has no
/// threshold.
DecidingPair decidingPair(Scene& scene, const State& state, const Pairs& pairs, const PairProximity& closest,
                          const LevelThresholds& thresholds, const Question& question = {},
                          const LevelBefore& before = {});

}  // namespace proximity_server::scene
