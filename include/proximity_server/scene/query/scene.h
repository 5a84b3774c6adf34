#pragma once

#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"

#include <memory>
#include <vector>

namespace proximity_server::scene {

class PairRanking;

/// Answers questions about states of one robot with its objects; with the working memory of one caller, which makes the
/// answers about successive states cheaper. Not thread-safe; call forAnotherThread() for each further thread.
///
/// After the first question of each kind nothing is allocated. Skipping never changes an answer.
class Scene {
 public:
  /// Throws std::invalid_argument without a model.
  explicit Scene(std::shared_ptr<const SceneModel> model, Skipping skipping = Skipping::On);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Returns another scene of the same model. The two share all data that never change.
  Scene forAnotherThread() const;

  const SceneModel& model() const { return *model_; }

  // Every question throws std::invalid_argument for a state of another robot, for a link, <collision> or object that
  // does not exist, and for two objects with half-spaces. Its answer is in the frame of the state.

  /// The distance of one pair, whether the filter checks it or not. Two shapes of one body are legal.
  PairProximity proximity(const State& state, const ShapeRefPair& pair, const Question& question = {});

  /// The candidate pairs of the filter. If there are many, groups of links settle most of them, see Pairs.
  const Candidates& candidates() const;

  // Each of the following visits `pairs` and returns a reference that is valid until the next question.
  // A pair is Unknown if a pose is missing, if the deadline passed before it was computed, or if it is too far away for
  // the narrowphase. It is counted, and all() returns it; the other questions leave it out. A distance that did not
  // converge is sorted by its lower bound, because it may be the smallest.

  /// The pair with the smallest signed distance; nullptr if there is none, or none nearer than the threshold.
  const PairProximity* minimum(const State& state, const Pairs& pairs, const Question& question = {});

  /// Up to k pairs with the smallest signed distances, sorted.
  const std::vector<PairProximity>& closest(const State& state, const Pairs& pairs, int k,
                                            const Question& question = {});

  /// All pairs with a signed distance of at most question.threshold, sorted by distance.
  const std::vector<PairProximity>& below(const State& state, const Pairs& pairs, const Question& question);

  /// Up to `most` of the closest pairs that below() finds, and the number of all of them. Cheaper than below() for long
  /// lists.
  PairsBelow closestBelow(const State& state, const Pairs& pairs, int most, const Question& question);

  /// The first pair found at or below question.threshold ("is anything too close?"); nullptr if there is none.
  const PairProximity* first(const State& state, const Pairs& pairs, const Question& question);

  /// All pairs, in the order given. For the candidates: first the pairs of links, then those with objects.
  const std::vector<PairProximity>& all(const State& state, const Pairs& pairs, const Question& question = {});

  /// How the pairs of the last question were settled.
  const PairCounts& counts() const;

 private:
  Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Candidates> candidates, Skipping skipping);

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Candidates> candidates_;
  Skipping skipping_;
  std::unique_ptr<PairRanking> ranking_;
};

}  // namespace proximity_server::scene
