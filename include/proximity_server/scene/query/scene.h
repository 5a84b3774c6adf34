#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/question.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::scene {

class PairRanking;
class Volumes;

/// One robot with its objects in one set of poses, and the working memory of one caller. Not thread-safe; call
/// forAnotherThread() for each further thread.
///
/// After the first question of each kind nothing is allocated. Skipping never changes an answer.
class Scene {
 public:
  /// Throws std::invalid_argument without a model.
  explicit Scene(std::shared_ptr<const SceneModel> model, Skipping skipping = Skipping::On);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Returns another scene of the same model and objects, without poses. The two share all data that never change.
  Scene forAnotherThread() const;

  const SceneModel& model() const { return *model_; }

  /// Takes the next objects of the robot, and keeps what is known of the objects that stay. A fixed object stands in
  /// its place at once. An attached object has the poses of the last update, unless the body of its link has no
  /// geometry; then it has no pose until the next update, and neither has a moving object.
  /// Failure: throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// nullptr before the first use().
  const Objects* objects() const;

  /// Takes one consistent set of poses: one for each body, all in one frame. The answers are in that frame. Moving
  /// objects then have no pose.
  ///
  /// A pose that is not finite, or whose matrix is not a rotation within single precision, counts as missing.
  /// Failure: throws std::invalid_argument if there is not one pose for each body.
  void update(const BodyPoses& poses);

  /// Takes one pose for each body and one for each of Objects::frames(), all in one frame.
  /// Failure: throws std::invalid_argument also if there is not one pose for each frame.
  void update(const BodyPoses& poses, const FramePoses& frames);

  /// The pose with which the scene answers, of a body that carries geometry or of an object that no link holds; nullopt
  /// if it is not known, or if the body has no geometry.
  std::optional<Eigen::Isometry3d> poseOf(int body) const;
  std::optional<Eigen::Isometry3d> poseOfObject(int number) const;

  // Every question throws std::invalid_argument for a link, <collision> or object that does not exist, and for
  // two objects with half-spaces.

  /// The distance of one pair, whether the filter checks it or not. Two shapes of one body are legal.
  PairProximity proximity(const ShapeRefPair& pair, const Question& question = {});

  /// The candidate pairs of the filter. If there are many, groups of links settle most of them, see Pairs.
  const Candidates& candidates() const;

  // Each of the following visits `pairs` and returns a reference that is valid until the next question.
  // A pair is Unknown if a pose is missing, if the deadline passed before it was computed, or if it is too far away for
  // the narrowphase. It is counted, and all() returns it; the other questions leave it out. A distance that did not
  // converge is sorted by its lower bound, because it may be the smallest.

  /// The pair with the smallest signed distance; nullptr if there is none, or none nearer than the threshold.
  const PairProximity* minimum(const Pairs& pairs, const Question& question = {});

  /// Up to k pairs with the smallest signed distances, sorted.
  const std::vector<PairProximity>& closest(const Pairs& pairs, int k, const Question& question = {});

  /// All pairs with a signed distance of at most question.threshold, sorted by distance.
  const std::vector<PairProximity>& below(const Pairs& pairs, const Question& question);

  /// Up to `most` of the closest pairs that below() finds, and the number of all of them. Cheaper than below() for long
  /// lists.
  PairsBelow closestBelow(const Pairs& pairs, int most, const Question& question);

  /// The first pair found at or below question.threshold ("is anything too close?"); nullptr if there is none.
  const PairProximity* first(const Pairs& pairs, const Question& question);

  /// All pairs, in the order given. For the candidates: first the pairs of links, then those with objects.
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
