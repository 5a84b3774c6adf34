#pragma once

#include "proximity_server/scene/guaranteed/guarantee_limits.h"
#include "proximity_server/scene/guaranteed/reached_state.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <array>
#include <limits>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// The pair of a scene with the smallest guaranteed distance minus its threshold.
struct GuaranteedMinimum {
  PairProximity pair;  ///< the answer of the scene; it asks for nothing if there is no pair
  /// [m] of the pair. If the work has ended before all pairs were considered, it is lowered with `excess`.
  double guaranteed = std::numeric_limits<double>::infinity();
  /// [m] In no state is the distance of a pair whose pose is known minus its threshold below this.
  double excess = std::numeric_limits<double>::infinity();
  int unknown = 0;  ///< the number of pairs without a distance: nothing is guaranteed of them
};

/// Checked pairs, among them the closest ones.
struct ListedPairs {
  const PairProximity *begin, *end;
  double others;  ///< [m] no other checked pair is closer
};

/// Lower bounds of the distances of pairs over all states that an Uncertainty allows, and the working memory of one
/// caller. Not thread-safe. Nothing is allocated after the first questions, unless reached() finds a state.
///
/// 1. The distance is at least the present one minus a bound of the way of all points (FreeMotion, points 1 to 4); the
///    uncertainty of a frame adds its translation and its angle times the distance from its origin. It holds for
///    uncertainties of any size, and is enough for most pairs.
/// 2. The direction in which the two are apart now bounds the distance also in other states: see Displacements, to first
///    order with a bounded remainder. So displacements count only as far as they bring the two closer, and each pair of
///    pieces has its own direction.
/// 3. If that loses much more than the closest points do, other frames and other directions are tried: those that
///    separate the displaced points best.
/// 4. If even that loses much more than a state that was found, and the two are apart, the positions of the joints
///    between them are divided, and each part has its own directions.
/// 5. The result is the better one of the two, for the pair of pieces for which it is the smallest. Depths in interiors
///    of meshes change by no more than the way of all points, either, and are bounded along the direction like pieces.
///
/// Without uncertainty, guaranteed distances are the lower bounds of the scene, with the same bits.
class GuaranteedDistances {
 public:
  /// Without uncertainty, until assume() is called. Throws std::invalid_argument without a model.
  explicit GuaranteedDistances(const std::shared_ptr<const SceneModel>& model);
  ~GuaranteedDistances();
  GuaranteedDistances(GuaranteedDistances&&) noexcept;
  GuaranteedDistances& operator=(GuaranteedDistances&&) noexcept;

  /// Throws std::invalid_argument as Uncertainty::requireValidFor() does; then nothing changes.
  void assume(const Uncertainty& uncertainty);
  const Uncertainty& uncertainty() const;

  /// Into how many parts the uncertainty of a pair may be divided, see point 4; 0 for a caller that divides it itself.
  /// 64 until this is called.
  void divideInto(int most_parts);

  /// Limits the work of all questions until the next call; none are limited before the first one. Each pair may take
  /// half of the steps that are left. When steps or time end, bounds that are not found yet are replaced by coarser
  /// ones, which hold as well; so no distance is ever too large. Scenes that are asked have limits of their own.
  void limit(const GuaranteeLimits& limits);

  /// The steps since the last limit(), and whether a bound is coarser because they, or the time, have ended.
  std::int64_t steps() const;
  GuaranteeEnd end() const;

  // Each question is about the states around the present one, and throws std::invalid_argument for a state of another
  // robot.

  /// [m] A lower bound of the signed distance of a pair over all states; never above the lower bound of the answer.
  /// `enough` [m]: once the bound is above this, it is not improved. The bound of a pair in these poses is kept.
  ///
  /// Failure: NaN if the pair is Unknown, or if a pose between the two is missing. Throws std::invalid_argument for a
  ///          link, <collision> or object that does not exist.
  double of(const State& state, const PairProximity& pair, double enough = std::numeric_limits<double>::infinity());

  /// A state in which the pair is certainly closer than the threshold [m]; nullptr if none was found, though there may
  /// be one. It tries states at the border of the uncertainty that bring the closest pieces together, and the middles of
  /// the parts of point 4. Valid until the next call.
  /// Limit:   the limits of joints are not considered.
  /// Failure: as of().
  const ReachedState* reached(const State& state, const PairProximity& pair, double threshold);

  /// The pair of `pairs` with the smallest guaranteed distance minus its threshold. It asks the scene for the closest of
  /// them, as many as are needed. The question's thresholds and threshold are not used.
  /// `enough` [m]: the bound of a pair is not improved once it is above its threshold by more than this. If all pairs
  /// are, the minimum is taken of bounds that may be coarse.
  GuaranteedMinimum find(Scene& scene, const State& state, const Pairs& pairs, const PairDistances& thresholds,
                         Question question = {}, double enough = std::numeric_limits<double>::infinity());

  /// find() for all checked pairs.
  GuaranteedMinimum find(Scene& scene, const State& state, const PairDistances& thresholds);

  /// Finds it among pairs that the scene has listed for this state; it asks the scene only if they do not
  /// decide. A cycle that has asked Scene::closestBelow() anyway so pays for few bounds. All poses must be known.
  GuaranteedMinimum find(Scene& scene, const State& state, const Pairs& pairs, const PairDistances& thresholds,
                         const ListedPairs& listed, const Question& question = {},
                         double enough = std::numeric_limits<double>::infinity());

  /// Finds it among the listed pairs alone, if these are all that can decide: every pair that is not farther apart than
  /// the closest one by more than largestLoss().
  /// Failure: `unknown` is 1 if they do not decide.
  GuaranteedMinimum find(const State& state, const ListedPairs& listed, const PairDistances& thresholds = {});

  /// Forgets what makes the next bounds cheaper. After that they are as in a new object, to the last bit; otherwise
  /// they may be tighter or coarser where so many pieces are near that the budget of a bound, or the limits, end.
  void forget();

  /// [m] In no state is a checked pair closer than its present lower bound minus this, and no other pair of a link or of
  /// a held object either. Infinity if that is not known. It bounds the true distances. The bounds of of() may be
  /// lower, because it takes boxes and balls for the shapes where pieces decide nothing.
  double largestLoss(const State& state);

  /// [m] The same in each state of a motion from these poses, in which each joint moves by at most `travel` [rad] or [m]:
  /// one number for each of RobotModel::joints, of which mimic joints are ignored. It does not cover two objects that
  /// no link holds: no joint moves them.
  double largestLoss(const State& state, const std::vector<double>& travel);

 private:
  double largestLossOf(const State& state, const Pairs& pairs);
  bool settle(const State& state, const ListedPairs& listed, PairKind kind, const PairDistances& thresholds,
              double enough, double loss, GuaranteedMinimum& minimum);

  void see(const State& state);

  struct Parts;
  std::unique_ptr<Parts> parts_;
  int closest_ = 2;                      ///< how many pairs find() asks for
  std::array<ShapeRefPair, 3> found_{};  ///< the pair of the last minimum of each PairKind
};

}  // namespace proximity_server::scene
