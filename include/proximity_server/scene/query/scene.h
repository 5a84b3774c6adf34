#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <vector>

#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// What never changes: shared by every Scene, so that requests run in parallel.
struct SceneModel {
  RobotModel robot;
  PairTable pairs;
};

/// The robot with its pairs, see filterPairs(), and one more warning: the checked pairs that one joint moves against
/// each other, but that are in contact all over its range. That is nearly always an overlap of the model itself.
///
/// Failure: throws as filterPairs() does.
SceneModel makeSceneModel(RobotModel robot, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// A link, or one of its <collision> elements.
struct Subject {
  int link = -1;
  int collision = 0;  ///< n-th <collision> of the link, counted from 1; 0 = the whole link
};
struct SubjectPair {
  Subject a, b;
};

/// What is known about two subjects, in the order asked: the signed distance of their closest (or deepest) pieces,
/// less the padding of the pair of links. The bounds are those of the whole subjects, the normal that of these pieces.
struct PairProximity {
  SubjectPair asked;
  int collision_a = 0;  ///< the <collision> of a that is closest, counted from 1; 0 where nothing was computed
  int collision_b = 0;
  narrowphase::SignedDistance
      result;  ///< in the frame of the poses; Status::Unknown where a pose or all geometry is missing
  Representation representation = Representation::Exact;  ///< the less exact of the two
  /// Two that overlap, of which one has several pieces: the whole may be deeper than its deepest pieces are.
  bool depth_is_lower_bound = false;
};

/// How the pairs of a question were settled: total is the sum of the others, in the order in which they are tried.
struct PairCounts {
  int total = 0;
  int unknown = 0;    ///< a pose or all geometry is missing, or the deadline came first
  int at_rest = 0;    ///< the two bodies stand to each other as they did when their answer was computed
  int by_motion = 0;  ///< a bound of before, less the motion since, was enough
  int by_bounds = 0;  ///< bounds about bodies and pieces were enough, or `first` had its answer before
  int computed = 0;   ///< at least one pair of pieces went to the narrowphase
};

/// Pairs at or below a threshold.
struct PairsBelow {
  const std::vector<PairProximity>& closest;  ///< sorted by distance
  int count;                                  ///< of all, listed or not
};

/// How exactly to answer.
struct Question {
  double tolerance = 1e-9;  ///< [m] accepted gap between upper and lower bound
  /// [m] beyond this signed distance only the proof is wanted (Status::Threshold, distance = lower bound, no points,
  /// and no normal either where bounds were enough). A pair counts as nearer unless its lower bound proves otherwise.
  double threshold = std::numeric_limits<double>::infinity();
  enum class Depth : unsigned char { Wanted, NotWanted };
  Depth depth = Depth::Wanted;  ///< NotWanted: an overlap is reported (Status::Threshold) without its depth, any of
                                ///< them is the minimum, and points and normal may be missing
  /// A pair that would have to be computed after it is Unknown.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// Off is for tests and measurements: every pair of pieces is computed anew, with the same answers.
enum class Skipping : unsigned char { On, Off };

class PairSearch;
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

  /// Another one of the same model, without poses yet: what never changes is shared.
  Scene twin() const;

  const SceneModel& model() const { return *model_; }

  /// Takes one consistent set of poses, one for each body and all in one frame; the answers are in that frame.
  ///
  /// A pose that is not finite, or whose matrix is no rotation within single precision, counts as missing.
  /// Failure: throws std::invalid_argument where the number of poses is not that of the bodies.
  void update(const BodyPoses& poses);

  // Every question throws std::invalid_argument for a link or <collision> that does not exist.

  /// One pair, filtered or not. Subjects of one body are legal: their distance never changes.
  PairProximity proximity(const SubjectPair& pair, const Question& question = {});

  /// The candidate pairs of the filter, ready to be asked about: by this very reference many are settled at once.
  const std::vector<SubjectPair>& candidates() const;

  // Each of the following visits `pairs` and returns a reference that is valid until the next question.
  // A pair with a missing pose, or left over at the deadline, is Unknown: it is counted, `all` returns it, the others
  // leave it out. Where a distance did not converge its lower bound takes its place among the others, as it may be the
  // smallest.

  /// The pair with the smallest signed distance; nullptr where there is none (or none nearer than the threshold).
  const PairProximity* minimum(const std::vector<SubjectPair>& pairs, const Question& question = {});

  /// Up to k pairs with the smallest signed distances, sorted.
  const std::vector<PairProximity>& closest(const std::vector<SubjectPair>& pairs, int k,
                                            const Question& question = {});

  /// All pairs with a signed distance of at most question.threshold, sorted by distance.
  const std::vector<PairProximity>& below(const std::vector<SubjectPair>& pairs, const Question& question);

  /// Of these only the `most` closest, and how many there are: cheaper where few of many are wanted.
  PairsBelow closestBelow(const std::vector<SubjectPair>& pairs, int most, const Question& question);

  /// The first pair found at or below question.threshold ("is anything too close?"); nullptr where there is none.
  const PairProximity* first(const std::vector<SubjectPair>& pairs, const Question& question);

  /// Every pair, in the order given.
  const std::vector<PairProximity>& all(const std::vector<SubjectPair>& pairs, const Question& question = {});

  /// How the pairs of the last question were settled.
  const PairCounts& counts() const;

 private:
  Scene(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes, Skipping skipping);

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const Volumes> volumes_;
  Skipping skipping_;
  std::unique_ptr<PairSearch> search_;
};

}  // namespace proximity_server::scene
