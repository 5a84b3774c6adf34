#pragma once

#include <Eigen/Core>
#include <chrono>
#include <memory>
#include <vector>

#include "proximity_server/scene/derivative/degrees_of_freedom.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

class PlacedJoints;
class Volumes;

/// Motions of the degrees of freedom that keep a pair above a threshold: all dq with sum weights_j |dq_j| <= free.
struct Bubble {
  ShapeRefPair pair;        ///< without links and objects: all pairs that are farther than the influence distance
  double free = 0.0;        ///< [m] lower bound of the distance less the threshold, at least 0
  Eigen::VectorXd weights;  ///< [m/rad] and [m/m], one for each of DegreesOfFreedom
};

struct FreeMotionQuestion {
  PairDistances thresholds;  ///< [m]
  /// [m] Pairs that are nearer have a bubble each, all others share one. The farther, the more room that one has.
  double influence_distance = 0.2;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// How far a robot can move from one set of poses and is certain to be free, without a search: the scratch of one caller. Not
/// thread-safe. Nothing allocates unless there are more near pairs than ever before.
///
/// 1. The change of the relative pose of two bodies does not depend on the order in which the joints between them move. Take
///    the body where the ways from the two to their root meet; on each way let the joint next to it move first, by |dq_j|, while
///    all others are where they are at present. Each point of the geometry at the end of the way moves by at most r_j |dq_j|,
///    where r_j is its present distance from the axis. Then comes the next joint. The first one has carried its axis
///    together with all that it carries itself, so r_j is the present distance for this one too.
/// 2. So no point moves by more than the sum of w_j |dq_j|, where w_j is the largest distance of any point from the axis, or 1 for
///    a translation. That holds for motions of any length, as nothing is linearised.
/// 3. A signed distance of two convex pieces, and the depth of an overlap too, is the largest over all directions of how far
///    the pieces are apart along it. It changes by no more than the points move, and so does the smallest of several pieces.
/// 4. What follows another joint adds its own radius, times the multiplier, to the weight of its leader. A planar joint has the
///    weights 1, 1 and the radius about its normal, a floating one 1 and the distance from its origin.
/// 5. The set holds s dq with each dq, for s in [0, 1], so the straight motion to dq is free, and so is each part of
///    it where joints stop earlier.
///
/// It takes the same poses as the Scene that gave the answers. The roots of the robots rest, and so do objects that are not
/// attached to a link. For the way that one straight motion is free at all ask MovingScene::timeOfContact() with
/// RobotMotion::ofTravel(): `t_free` is the largest s that is proven for s dq. That is a search, and as good as its tolerance.
/// scale() costs a few products, and tells less: a random motion to the border of the bubble of a pair is free for at least 4 times
/// that way in the median (./dev stress free-motions).
///
/// Source: Quinlan, Real-Time Modification of Collision-Free Paths, 1994 (bubbles of free configurations).
/// Differs: the radii are those of the present configuration and of the two bodies that are asked about, not those of the arm
///          when it is stretched out.
class FreeMotion {
 public:
  /// Throws std::invalid_argument without a model.
  explicit FreeMotion(std::shared_ptr<const SceneModel> model);
  ~FreeMotion();
  FreeMotion(FreeMotion&&) noexcept;
  FreeMotion& operator=(FreeMotion&&) noexcept;

  const DegreesOfFreedom& degreesOfFreedom() const;

  /// Takes the objects of the scene.
  /// Throws std::invalid_argument for the objects of another model.
  void use(std::shared_ptr<const Objects> objects);

  /// Throws std::invalid_argument if there is not one pose for each body. What find() found is forgotten.
  void update(const BodyPoses& poses);

  /// The weights of a pair: whatever its distance is, it changes by at most sum weights_j |dq_j|.
  ///
  /// Units:   [m/rad] and [m/m]; 0 for joints that are not between the two.
  /// Error:   rounded up. Bounding volumes stand for the geometry, so a weight may be larger than needed.
  /// Failure: returns false, with NaN, if a pose between the two or of one of them is missing. Throws std::invalid_argument for
  ///          another size of `weights`, and for a link, <collision> or object that does not exist.
  bool weights(const ShapeRefPair& pair, Eigen::Ref<Eigen::VectorXd> weights) const;

  /// Makes the bubbles of all checked pairs of a scene that has the same poses and objects. It asks the scene for the pairs
  /// below the influence distance.
  /// Failure: if a pair is unknown, as a pose is missing or the deadline has passed, nothing is known to be free. Throws
  ///          std::invalid_argument for an influence distance or a threshold that is no number, and for a scene of another robot
  ///          or with other objects; nothing is known to be free then.
  void find(Scene& scene, const FreeMotionQuestion& question);

  /// Whether the last update has bubbles of all pairs. If not, contains() is false, and scale() and alone() are 0.
  bool isKnown() const { return is_known_; }

  /// The bubbles: those of the near pairs, the closest first, then that of all others.
  int size() const { return size_; }
  const Bubble& operator[](int bubble) const { return bubbles_[static_cast<std::size_t>(bubble)]; }

  // Motions have one entry [rad] or [m] for each degree of freedom. Throws std::invalid_argument for another size.

  /// Whether all pairs are certain to stay above their thresholds during a straight motion; false for what is not finite.
  /// What moves no pair is free, even if a pair is at or below its threshold.
  bool contains(const Eigen::Ref<const Eigen::VectorXd>& motion) const { return scale(motion) == 1.0; }

  /// The largest s in [0, 1] for which all bubbles have s times the motion, rounded down.
  double scale(const Eigen::Ref<const Eigen::VectorXd>& motion) const;

  /// [rad] or [m] How far one degree of freedom can move in each direction while all others rest; infinity if that moves no
  /// pair.
  double alone(int column) const;

 private:
  bool addWeights(const ShapeRef& ref, int body, int other_body, Eigen::Ref<Eigen::VectorXd> weights) const;
  Bubble& next();
  bool findLargestWeights(Eigen::VectorXd& weights);

  std::unique_ptr<PlacedJoints> joints_;
  std::unique_ptr<const Volumes> volumes_;
  bool is_known_ = false;
  int size_ = 0;
  std::vector<Bubble> bubbles_;  ///< of which the first size_ are used
  Eigen::VectorXd sides_;        ///< how many of a pair a degree of freedom can move: 1, or 2 if other joints follow it
  Eigen::VectorXd scratch_;
};

}  // namespace proximity_server::scene
