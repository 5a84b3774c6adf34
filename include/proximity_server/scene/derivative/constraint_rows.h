#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// How fast two shapes may approach each other: at most gain (d - stop) / (influence - stop) [m/s] at the distance d. So a
/// pair that is above its stop distance comes ever more slowly to it, and one below must move away.
///
/// In steps of the time dt the distance stays above the stop distance only if gain * dt <= influence - stop.
/// Source: Faverjon, Tournassoud, A local based approach for path planning of manipulators with a high number of degrees of
///         freedom, ICRA 1987.
struct VelocityDamper {
  PairDistances stop;
  double influence_distance;  ///< [m] pairs farther apart are not limited; above all stop distances
  double gain;                ///< [m/s] how fast a pair at the influence distance may approach; positive
};

/// The linear constraints that keep a robot from approaching itself and its objects too fast: rows of a QP in the
/// velocities of its degrees of freedom. Not thread-safe.
///
/// 1. Ask the scene for all pairs within the influence distance, and for those that have a row.
/// 2. Order them by their share (d - stop) / (influence - stop), d the proven lower bound: the smallest is the most demanding.
///    The share of a pair that has a row counts as smaller by kKeepShare.
/// 3. Leave out the pairs that need no row. With the gradient g, and the velocities v that the joints have by the URDF, no motion
///    changes the distance by more than r = sum |g_j| v_j [m/s], over the |g_j| above kNoChange. If r is 0 there is nothing to limit.
///    If the approach at r is slower than what the damper allows, by kSpareShare of the gain, a row would never bind.
/// 4. The first ones of the others, as many as there are rows, have one. Those that had a row keep it; the others take the free rows,
///    lowest first.
/// 5. A row is the pair's gradient, and its bound b = -gain * share, rounded up. A pair that must part does so only as well as the
///    joints can do it: its bound is b |g|^2 / (|g|^2 + kDamping^2), at most r / 2. With b itself the velocity b / |g| would be
///    ever larger where the joints hardly part the two, and beyond them where |g| vanishes, as where a pair is as far apart
///    as it can be; there it would be of the one sign and of the other in turn. Such a row still forbids to approach.
///
/// Order:   a pair keeps its row from update to update as long as it is among the most demanding, and gives way only to one whose
///          share is smaller by more than kKeepShare, or beyond the influence distance by that share. So two pairs that are
///          equally close do not take turns, and a controller can start warm. A pair that needs a row and has none is therefore never
///          closer by more than that share than one with a row.
/// Memory:  size and place never change. Nothing allocates after the first update() of a scene without objects; with objects
///          that is so as soon as the scene has no new ones, and not more of them are near.
/// Limit:   a row looks at the velocity in this moment. What the distance loses in a step because links turn, or as others of
///          their points come closest, is not seen; the latter is of first order in the step, but not in the time.
///          The velocities of the URDF have to be true: a joint that states none counts as of any velocity.
/// Source of the damping in 5: Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped
///          least-squares methods, IEEE Transactions on Systems, Man, and Cybernetics, 1986.
class ConstraintRows {
 public:
  static constexpr double kKeepShare = 0.05;
  static constexpr double kSpareShare =
      0.1;  ///< that a controller may add to a bound, without binding a row that is left out
  static constexpr double kNoChange =
      1e-6;  ///< [m/rad, m/m] more than what the errors of normals make of a gradient of 0
  static constexpr double kDamping = 0.02;  ///< [m/rad, m/m]

  /// `moving` are the columns of the degrees of freedom that the controller moves; all others count as at rest, and their columns of
  /// the matrix are 0.
  /// Throws std::invalid_argument without a model, for a capacity below 1, and for a column that does not exist.
  ConstraintRows(std::shared_ptr<const SceneModel> model, int capacity, const std::vector<int>& moving);

  /// The same with all of them.
  ConstraintRows(std::shared_ptr<const SceneModel> model, int capacity);

  struct Row {
    ShapeRefPair pair;                                           ///< in the order of the scene's answer
    double distance = std::numeric_limits<double>::quiet_NaN();  ///< [m] the lower bound used
    bool is_used = false;
    /// False: the closest points, or the normal, are one choice of many (parallel faces, concentric shapes), and the row is
    /// for this choice: it does not limit other points of the contact feature, which a rotation may bring closer. See
    /// Derivatives::rate() for the slowest rate of the feature at one velocity.
    bool unique = true;
  };

  /// A pair that must part, by its distance, but no motion of the joints makes it part so fast.
  struct Stuck {
    ShapeRefPair pair;
    double distance;  ///< [m] the lower bound used
    double rate;      ///< [m/s] how fast it can part, at most. 0: no joint changes the distance, and it has no row
  };

  /// Takes what the scene says of its candidate pairs, those with objects too. `scene` and `derivatives` have the same poses
  /// and the same objects.
  /// Failure: throws std::invalid_argument for a scene or derivatives of another robot, and naming the field of the damper that
  ///          is not finite or out of range; then nothing changes. It throws also for an object of the scene that the
  ///          derivatives do not have; the rows are not valid then.
  void update(Scene& scene, const Derivatives& derivatives, const VelocityDamper& damper);

  int capacity() const { return static_cast<int>(rows_.size()); }

  /// A row for each of rows(), a column for each of Derivatives::degreesOfFreedom() [m/rad, m/m]. A velocity [rad/s, m/s]
  /// keeps to the damper if matrix * velocity >= bounds. A row that is not used is 0.
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& matrix() const { return matrix_; }

  /// [m/s]; -infinity for a row that is not used, positive for a pair below its stop distance. One that is not positive is not below
  /// the exact value of the formula for the lower bound of the distance.
  const Eigen::VectorXd& bounds() const { return bounds_; }

  const std::vector<Row>& rows() const { return rows_; }

  /// How many pairs within the influence distance have no row because others were more demanding. The rows say nothing about
  /// them: a controller that sees any has too few rows.
  int leftOut() const { return left_out_; }

  /// How many pairs within the influence distance have no row because they need none.
  int unneeded() const { return unneeded_; }

  /// The most demanding of the pairs that are stuck, as many as there are rows, and the number of all.
  const std::vector<Stuck>& stuck() const { return stuck_; }
  int stuckCount() const { return stuck_count_; }

  /// How many pairs have no row because their distance or their gradient is not known.
  int unknown() const { return unknown_; }

 private:
  static constexpr int kNone = -1;
  enum class Need : unsigned char { Row, None, Unknown };
  struct Offer {
    ShapeRefPair pair;
    narrowphase::SignedDistance result;
    double share;
    int row;             // that it has; kNone
    bool is_within;      // the influence distance
    double bound = 0.0;  // of its row

    double rank() const { return row == kNone ? share : share - kKeepShare; }
  };

  void offerNear(Scene& scene, const VelocityDamper& damper);
  void offerKept(Scene& scene, const VelocityDamper& damper);
  void offer(const PairProximity& pair, const VelocityDamper& damper, int row);
  void choose(const Derivatives& derivatives, const VelocityDamper& damper);
  Need judge(Offer& offer, const Derivatives& derivatives, const VelocityDamper& damper);
  bool findGradient(const Offer& offer, const Derivatives& derivatives);
  void giveRows();
  int rowOf(const ShapeRefPair& pair) const;
  void free(int row);
  void fill(const Offer& offer, const Derivatives& derivatives);

  std::shared_ptr<const SceneModel> model_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix_;
  Eigen::VectorXd bounds_;
  std::vector<Row> rows_;
  std::vector<Offer> offers_;
  std::vector<Stuck> stuck_;
  Eigen::VectorXd speeds_;    // of each column, at most; 0 if it does not move
  Eigen::VectorXd gradient_;  // of one offer
  int left_out_ = 0, unneeded_ = 0, stuck_count_ = 0;
  int unknown_ = 0;
};

}  // namespace proximity_server::scene
