#pragma once

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Motions of the degrees of freedom that keep a pair above a threshold: all dq with sum weights_j |dq_j| <= free.
struct Bubble {
  ShapeRefPair pair;        ///< if it names no links or objects: all pairs farther apart than the influence distance
  double free = 0.0;        ///< [m] lower bound of the distance minus the threshold, at least 0
  Eigen::VectorXd weights;  ///< [m/rad] and [m/m], one for each of DegreesOfFreedom
};

struct FreeMotionQuestion {
  PairDistances thresholds;  ///< [m]
  /// [m] Each pair that is nearer has a bubble of its own; all others share one. The larger it is, the larger is the
  /// shared bubble.
  double influence_distance = 0.2;
  Deadline deadline{};
};

/// Motions of a robot from one state that are certainly free, found without a search; and the working memory of
/// one caller. Not thread-safe. Nothing is allocated unless more pairs are near than ever before.
///
/// 1. The change of the relative pose of two bodies does not depend on the order in which the joints between them move.
///    The paths from the two bodies to their root meet at a common body. On each path, let the joint next to the common
///    body move first, by |dq_j|, while all others keep their present positions. Each point of the geometry at the end
///    of the path moves by at most r_j |dq_j|, where r_j is its present distance from the axis. Then let the next joint
///    move. The first joint has moved the axis of this joint together with all that this joint carries, so r_j is the
///    present distance for this joint, too.
/// 2. So no point moves by more than the sum of w_j |dq_j|, where w_j is the largest distance of any point from the
///    axis, or 1 for a translation. That holds for motions of any length, because nothing is linearised.
/// 3. The signed distance of two convex pieces, which includes the depth of an overlap, is the largest distance of the
///    pieces along any direction. It changes by no more than the points move, and so does the smallest distance of
///    several pieces. A half-space has no farthest point: seen from it, the points of the other shape move, also by the
///    joints that carry the half-space.
/// 4. A mimic joint adds its own radius, times the multiplier, to the weight of its leader. A planar joint has the
///    weights 1, 1 and the radius about its normal; a floating joint has 1 and the distance from its origin.
/// 5. If the set contains dq, it contains s dq for all s in [0, 1]. So the straight motion to dq is free, and so is
///    each motion that is part of it because joints stop earlier.
///
/// To find how far one straight motion is free at all, ask MotionSearch::timeOfContact() with RobotMotion::ofTravel():
/// `t_free` is the largest s that is proven for s dq. That is a search, and as exact as its tolerance. scale() costs a
/// few products, and finds less: a random motion to the
/// border of the bubble of a pair is free for at least 4 times that way in the median (./dev stress free-motions).
///
/// Source: Quinlan, Real-Time Modification of Collision-Free Paths, 1994 (bubbles of free configurations).
/// Differs: the radii are taken from the present configuration and the two bodies of the pair, not from the arm when
///          it is stretched out.
class FreeMotion {
 public:
  /// Throws std::invalid_argument without a model.
  explicit FreeMotion(std::shared_ptr<const SceneModel> model);

  /// The weights of a pair. Its distance changes by at most sum weights_j |dq_j|, whatever the distance is.
  ///
  /// Units:   [m/rad] and [m/m]; 0 for joints that are not between the two.
  /// Error:   rounded up. Bounding volumes stand for the geometry, so a weight may be larger than needed.
  /// Failure: returns false, with NaN, if a pose between the two or the pose of one of them is missing. Throws
  ///          std::invalid_argument for a state of another robot, for a wrong size of `weights`, and for a link,
  ///          <collision> or object that does not exist.
  bool weights(const State& state, const ShapeRefPair& pair, Eigen::Ref<Eigen::VectorXd> weights) const;

  /// Makes the bubbles of all checked pairs in a state. It asks the scene for the pairs below the influence distance.
  /// Failure: if a pair is unknown, because a pose is missing or the deadline has passed, no motion is known to be
  ///          free.
  ///          Throws std::invalid_argument for an influence distance or a threshold that is not finite, and for a
  ///          state of another robot; then no motion is known to be free.
  void find(Scene& scene, const State& state, const FreeMotionQuestion& question);

  /// Makes the bubbles from pairs that were found before in this state: all checked pairs that are at or below the
  /// influence distance, see SceneBatch::below(). The deadline is ignored.
  /// Failure: throws std::invalid_argument for an influence distance or a threshold that is not finite, and for a state of
  ///          another robot.
  void find(const State& state, const PairProximity* begin, const PairProximity* end,
            const FreeMotionQuestion& question);

  /// True if the last find() has made bubbles of all pairs, for its state. Otherwise contains() is false, and scale() and
  /// alone() are 0.
  bool isKnown() const { return is_known_; }

  /// The bubbles: first the bubbles of the near pairs, the closest first, then the one of all other pairs.
  int size() const { return size_; }
  const Bubble& operator[](int bubble) const { return bubbles_[bubble]; }

  // Motions have one entry [rad] or [m] for each degree of freedom. Throws std::invalid_argument for another size.

  /// True if all pairs are certain to stay above their thresholds during a straight motion; false for a motion that is
  /// not finite. A motion that moves no pair is free, even if a pair is at or below its threshold.
  bool contains(const Eigen::Ref<const Eigen::VectorXd>& motion) const { return scale(motion) == 1.0; }

  /// The largest s in [0, 1] for which all bubbles contain s times the motion, rounded down.
  double scale(const Eigen::Ref<const Eigen::VectorXd>& motion) const;

  /// [rad] or [m] How far one degree of freedom can move in each direction while all others are at rest; infinity if it
  /// moves no pair.
  double alone(int column) const;

 private:
  bool addWeights(const State& state, const ShapeRef& moved, int body, int other_body,
                  Eigen::Ref<Eigen::VectorXd> weights) const;
  Bubble& next();
  bool findLargestWeights(const State& state, Eigen::VectorXd& weights);
  template <class Visit>
  void forEachBounded(const State& state, const Visit& visit) const;

  std::shared_ptr<const SceneModel> model_;
  bool is_known_ = false;
  int size_ = 0;
  std::vector<Bubble> bubbles_;   ///< only the first size_ are used
  std::vector<bool> is_checked_;  ///< for each link: true if it is in a checked pair of links
  Eigen::VectorXd sides_;  ///< how many shapes of a pair a degree of freedom can move: 1, or 2 if it has mimic joints
  Eigen::VectorXd scratch_;
};

}  // namespace proximity_server::scene
