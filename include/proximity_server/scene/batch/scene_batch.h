#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "proximity_server/scene/batch/state_verdict.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/model/states.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

/// Pairs of many states, state by state.
struct StatePairs {
  std::vector<PairProximity> pairs;    ///< of all states; those of one state are sorted by distance
  std::vector<std::size_t> begins;     ///< those of state i begin here, and end at begins[i + 1]
  std::vector<unsigned char> unknown;  ///< 1 for a state that has no answer, and so no pairs
};

/// The candidate pairs of one robot in many states, each in the frame of the root links: planners, audits and data sets ask
/// for millions. The scratch of one caller. Not thread-safe; make a twin for each thread.
///
/// The answer about a state depends on that state alone, to the last bit: not on the states beside it, the number of them,
/// the threads or the processor. It is what a new Scene answers that has seen no other state, with the default tolerance; but
/// where a Scene chooses between pairs or pieces whose distances differ by less than the tolerance, its choice may depend on
/// the order of its search. Here the closest pairs are always those with the smallest Scene::proximity(), and what is said of
/// them is what that says. Equal distances are in the order of the candidates. A distance that did not converge is ranked by
/// its lower bound.
/// Nothing allocates after the first batch of its size, unless more pairs are listed than ever before.
///
/// A state with a position that is not finite, or so large that the pose of a checked link is not, has no answer: Unknown. A pair
/// that is too far apart for the narrowphase, 1e30 m, is left out.
/// Every question throws std::invalid_argument if there is not one column for each joint, and for a distance that is NaN or a
/// k below 1.
/// References are valid until the next question.
class SceneBatch {
 public:
  /// Throws std::invalid_argument without a model.
  explicit SceneBatch(std::shared_ptr<const SceneModel> model);
  ~SceneBatch();
  SceneBatch(SceneBatch&&) noexcept;
  SceneBatch& operator=(SceneBatch&&) noexcept;

  /// Another one of the same model. The two share what never changes.
  SceneBatch twin() const;

  const SceneModel& model() const;

  /// What StateVerdict::pair counts.
  const Candidates& candidates() const;

  /// For each state: is anything at or below the distance [m]? A pair counts as below unless its lower bound proves otherwise.
  const std::vector<StateVerdict>& anyBelow(const States& states, double distance);

  /// For each state the pair with the smallest signed distance; Unknown also if there is no candidate pair.
  const std::vector<PairProximity>& minimum(const States& states);

  /// For each state the pair that sets its level, see DecidingPair; levelOf() tells the level. Unknown as in minimum().
  const std::vector<PairProximity>& deciding(const States& states, const LevelThresholds& thresholds);

  /// For each state up to k pairs with the smallest signed distances.
  const StatePairs& closest(const States& states, int k);

  /// For each state all pairs with a signed distance of at most `distance` [m].
  const StatePairs& below(const States& states, double distance);

 private:
  class Impl;
  explicit SceneBatch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace proximity_server::scene
