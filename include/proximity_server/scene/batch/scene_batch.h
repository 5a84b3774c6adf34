#pragma once

#include "proximity_server/scene/batch/state_verdict.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/model/states.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/deadline.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Pairs of many states, listed state by state.
struct StatePairs {
  std::vector<PairProximity> pairs;    ///< the pairs of all states; within one state sorted by distance
  std::vector<std::size_t> begins;     ///< the pairs of state i begin at begins[i] and end at begins[i + 1]
  std::vector<unsigned char> unknown;  ///< 1 for a state that has no answer, and so has no pairs
};

/// Answers questions about one robot in many states, each in the frame of the root links: about its candidate pairs, and
/// the checked pairs with its objects. Planners, audits and data sets ask about millions of states. It has the working
/// memory of one caller. Not thread-safe; call forAnotherThread() for each further thread.
///
/// The answer about a state depends on that state alone, to the last bit: not on other states, their number, the
/// threads or the processor. It is the answer of a new Scene that has seen no other state, with the default tolerance.
/// There is one exception: if the distances of pairs or pieces differ by less than the tolerance, the choice of a Scene
/// may depend on the order of its search. Here the closest pairs are always those with the smallest Scene::proximity(),
/// and all facts about them are as in Scene::proximity(). Equal distances are in the order of the candidates. A
/// distance that did not converge is ranked by its lower bound.
/// After the first batch of a size nothing is allocated, unless more pairs are listed than ever before.
///
/// A state has no answer (Unknown) if a position is not finite, or so large that the pose of a checked link is not
/// finite. A pair that is too far apart for the narrowphase, 1e30 m, is left out. The states that are not answered before
/// the deadline have no answer either.
/// Every question throws std::invalid_argument if there is not one column for each joint, if a distance is NaN, or if k
/// is below 1.
/// References are valid until the next question.
class SceneBatch {
 public:
  /// Throws std::invalid_argument without a model.
  explicit SceneBatch(std::shared_ptr<const SceneModel> model);
  ~SceneBatch();
  SceneBatch(SceneBatch&&) noexcept;
  SceneBatch& operator=(SceneBatch&&) noexcept;

  /// Returns another batch of the same model and objects. The two share all data that never change.
  SceneBatch forAnotherThread() const;

  const SceneModel& model() const;

  /// Takes the objects that all following questions are about, too. A moving object moves with the link that its frame
  /// names, see setPoses().
  /// Failure: throws std::invalid_argument for the objects of another model, and naming a moving object whose frame is
  ///          not a link. Then the batch keeps the objects that it had.
  void use(std::shared_ptr<const Objects> objects);

  /// nullptr before the first use().
  const Objects* objects() const;

  const Candidates& candidates() const;

  /// The candidate pairs, then the pairs with objects in the order of Objects::forEachCheckedPair(). StateVerdict::pair
  /// is an index into them.
  const std::vector<ShapeRefPair>& pairs() const;

  /// Tells for each state whether any pair is at or below the distance [m]. A pair counts as below unless its lower
  /// bound proves otherwise.
  const std::vector<StateVerdict>& anyBelow(const States& states, double distance, const Deadline& deadline = {});

  /// Finds for each state the pair with the smallest signed distance; Unknown also if there is no pair.
  const std::vector<PairProximity>& minimum(const States& states, const Deadline& deadline = {});

  /// Bounds for each state the smallest signed distance of all pairs, so that the bounds are at most `accuracy` [m]
  /// apart. They are proven, rounding included. It costs a fraction of minimum() for 1e-4 m, with which no distance is
  /// wrong by more than the robot is built to; spheres in place of the links are wrong by centimetres.
  ///
  /// `asked` is the pair of the upper bound. The answer has Status::Threshold, its distance is its lower bound, and it
  /// has no points and no <collision>. If the upper bound is 0 or less, the pair overlaps, and another pair may overlap
  /// more. Then the distance is the upper bound, and the lower bound only says how deep any pair of links can overlap;
  /// with objects it is minus infinity. Unknown as in minimum().
  /// Bounds are wider apart where the narrowphase does not converge, and where `accuracy` is below its tolerance.
  /// Throws std::invalid_argument also if `accuracy` is not positive.
  const std::vector<PairProximity>& minimumWithin(const States& states, double accuracy, const Deadline& deadline = {});

  /// Finds for each state the pair that decides its level, see DecidingPair; levelOf() returns the level. Unknown as in
  /// minimum().
  const std::vector<PairProximity>& deciding(const States& states, const LevelThresholds& thresholds,
                                             const Deadline& deadline = {});

  /// Finds for each state up to k pairs with the smallest signed distances.
  const StatePairs& closest(const States& states, int k, const Deadline& deadline = {});

  /// Finds for each state all pairs with a signed distance of at most `distance` [m].
  const StatePairs& below(const States& states, double distance, const Deadline& deadline = {});

 private:
  class Impl;
  explicit SceneBatch(std::unique_ptr<Impl> impl);
  Impl& asked(const States& states, const Deadline& deadline);
  std::unique_ptr<Impl> impl_;
};

}  // namespace proximity_server::scene
