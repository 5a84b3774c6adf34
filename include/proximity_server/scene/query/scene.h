#pragma once

#include <memory>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

class PairRanking;
class Volumes;

/// One robot in one set of poses: the scratch of one caller. Not thread-safe; make a twin for each thread.
///
/// Nothing allocates after the first question of a kind. Skipping never changes an answer.
class Scene {
 public:
  explicit Scene(std::shared_ptr<const SceneModel> model, Skipping skipping = Skipping::On);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Returns another scene of the same model, without poses. The two share what never changes.
  Scene twin() const;

  const SceneModel& model() const { return *model_; }

  /// Takes one consistent set of poses, one for each body and all in one frame; the answers are in that frame.
  ///
  /// A pose that is not finite, or whose matrix is no rotation within single precision, counts as missing.
  /// Failure: throws std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  // Every question throws std::invalid_argument for a link or <collision> that does not exist.

  /// The distance of one pair, whether the filter checks it or not. Two shapes of one body are legal.
  PairProximity proximity(const ShapeRefPair& pair, const Question& question = {});

  /// The candidate pairs of the filter. If there are many, groups of links settle most of them, see Pairs.
  const Candidates& candidates() const;

  // Each of the following visits `pairs` and returns a reference that is valid until the next question.
  // A pair is Unknown if a pose is missing or if the deadline passed before it was computed: it is counted, all()
  // returns it, and the other questions leave it out. A distance that did not converge is sorted by its lower bound, as
  // it may be the smallest.

  /// The pair with the smallest signed distance; nullptr if there is none (or none nearer than the threshold).
  const PairProximity* minimum(const Pairs& pairs, const Question& question = {});

  /// Up to k pairs with the smallest signed distances, sorted.
  const std::vector<PairProximity>& closest(const Pairs& pairs, int k, const Question& question = {});

  /// All pairs with a signed distance of at most question.threshold, sorted by distance.
  const std::vector<PairProximity>& below(const Pairs& pairs, const Question& question);

  /// The `most` closest of the pairs that below() finds, and the number of all: cheaper than below() for long lists.
  PairsBelow closestBelow(const Pairs& pairs, int most, const Question& question);

  /// The first pair found at or below question.threshold ("is anything too close?"); nullptr if there is none.
  const PairProximity* first(const Pairs& pairs, const Question& question);

  /// Every pair, in the order given.
  const std::vector<PairProximity>& all(const Pairs& pairs, const Question& question = {});

  /// How the pairs of the last question were settled.
  const PairCounts& counts() const;

 private:
  Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Candidates> candidates,
        std::shared_ptr<const Volumes> volumes, Skipping skipping);

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Candidates> candidates_;
  std::shared_ptr<const Volumes> volumes_;
  Skipping skipping_;
  std::unique_ptr<PairRanking> ranking_;
};

}  // namespace proximity_server::scene
