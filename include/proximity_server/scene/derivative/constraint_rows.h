#pragma once

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/posed_position.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <Eigen/Core>

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// Limits how fast two shapes may approach each other: at most gain (d - stop) / (influence - stop) [m/s] at the
/// distance d. So a pair above its stop distance approaches it ever more slowly, and a pair below it must move away.
///
/// In steps of the time dt, the distance stays above the stop distance only if gain * dt <= influence - stop.
/// Source: Faverjon, Tournassoud, A local based approach for path planning of manipulators with a high number of
///         degrees of freedom, ICRA 1987.
struct VelocityDamper {
  PairDistances stop;
  double influence_distance;  ///< [m] must be above all stop distances; pairs that are farther apart are not limited
  double gain;                ///< [m/s] how fast a pair at the influence distance may approach; must be positive
  /// If the state is not known exactly: a lower bound [m] of the distance of a pair over all states, which takes the
  /// place of the distance of the scene, see GuaranteedDistances::of(). It is smaller by at most `largest_loss` [m].
  std::function<double(const PairProximity&)> guaranteed{};
  double largest_loss = 0.0;
};

/// The linear constraints that keep a robot from approaching itself and its objects too fast: rows of a QP in the
/// velocities of its degrees of freedom. Not thread-safe.
///
/// 1. Ask the scene for all pairs within the influence distance, and for the pairs that have a row.
/// 2. Order the pairs by their share (d - stop) / (influence - stop), where d is the proven lower bound: the pair with
///    the smallest share is the most demanding. The share of a pair that has a row counts as smaller by kKeepShare.
/// 3. Leave out the pairs that need no row. Let g be the gradient and v the largest velocities of the joints in the
///    URDF. Then no motion changes the distance faster than r = sum |g_j| v_j [m/s], over all |g_j| above kNoChange. If
///    r is 0, there is nothing to limit. If an approach at r is slower than the damper allows, by kSpareShare of the
///    gain, a row would never bind.
/// 4. The first of the other pairs get rows, as many as there are rows. Pairs that had a row keep it; the others get
///    the free rows, the lowest first.
/// 5. A row is the gradient of its pair, and its bound is b = -gain * share, rounded up. If b is positive, the pair
///    must move apart, and the bound is b |g|^2 / (|g|^2 + kDamping^2), at most r / 2. With b itself, the velocity b /
///    |g| would become very large where the joints hardly change the distance, and impossible where |g| vanishes, for
///    example where the pair is as far apart as it can be; its sign would alternate there. The damped row still forbids
///    an approach.
///
/// Order:   a pair keeps its row from update to update as long as it is among the most demanding. It loses the row only
///          to a pair whose share is smaller by more than kKeepShare, or if it is beyond the influence distance by that
///          share. So two pairs that are equally close do not alternate, and a controller can start warm. A pair that
///          needs a row and has none is therefore never closer than a pair with a row by more than that share.
/// Memory:  size and address never change. After the first update() of a scene without objects nothing is allocated;
///          with objects, nothing is allocated after the first update unless the scene has new objects, or more of them
///          are near.
/// Limit:   a row describes the velocity at this moment. It does not see how the distance shrinks in a step because
///          links turn, or because other points of them become the closest ones. The latter is of first order in the
///          step, but not in the time. The velocities of the URDF must be true: a joint that states none may have any
///          velocity.
/// Source of the damping in 5: Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped
///          least-squares methods, IEEE Transactions on Systems, Man, and Cybernetics, 1986.
class ConstraintRows {
 public:
  static constexpr double kKeepShare = 0.05;
  /// the share of the gain that a controller may add to a bound without making a missing row bind
  static constexpr double kSpareShare = 0.1;
  /// [m/rad, m/m] larger than the error that the errors of normals cause in a gradient of 0
  static constexpr double kNoChange = 1e-6;
  static constexpr double kDamping = 0.02;  ///< [m/rad, m/m]

  /// `moving` are the columns of the degrees of freedom that the controller moves. All others count as at rest, and
  /// their columns of the matrix are 0.
  /// Throws std::invalid_argument without a model, for a capacity below 1, and for a column that does not exist.
  ConstraintRows(std::shared_ptr<const SceneModel> model, int capacity, const std::vector<int>& moving);

  /// All degrees of freedom move.
  ConstraintRows(const std::shared_ptr<const SceneModel>& model, int capacity);

  struct Row {
    ShapeRefPair pair;                                           ///< in the order of the scene's answer
    double distance = std::numeric_limits<double>::quiet_NaN();  ///< [m] the lower bound that was used
    bool is_used = false;
    /// False: the closest points, or the normal, are one choice of many (parallel faces, concentric shapes). The row is
    /// for this choice: it does not limit other points of the contact feature, which a rotation may bring closer.
    /// Derivatives::rate() gives the slowest rate of the feature at one velocity.
    bool unique = true;
  };

  /// A pair that must move apart by its distance, but that no motion of the joints moves apart fast enough.
  struct Stuck {
    ShapeRefPair pair;
    double distance;  ///< [m] the lower bound that was used
    double rate;      ///< [m/s] how fast it can move apart at most. 0: no joint changes the distance, and it has no row
  };

  /// Makes the rows of the candidate pairs in a state, including those with objects. It asks the scene.
  /// Failure: throws std::invalid_argument for a scene or a state of another robot, and for a field of the damper that
  ///          is not finite or out of range, with its name; then nothing changes.
  void find(Scene& scene, const State& state, const VelocityDamper& damper);

  int capacity() const { return static_cast<int>(rows_.size()); }

  /// A row for each of rows(), and a column for each of State::degreesOfFreedom() [m/rad, m/m]. A velocity
  /// [rad/s, m/s] obeys the damper if matrix * velocity >= bounds. An unused row is 0.
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& matrix() const { return matrix_; }

  /// [m/s] -infinity for an unused row, positive for a pair below its stop distance. A bound that is not positive is
  /// not below the exact value of the formula for the lower bound of the distance.
  const Eigen::VectorXd& bounds() const { return bounds_; }

  const std::vector<Row>& rows() const { return rows_; }

  /// The number of pairs within the influence distance that have no row because others were more demanding. The rows do
  /// not limit these pairs: if the number is not 0, the controller has too few rows.
  int leftOut() const { return left_out_; }

  /// The number of pairs within the influence distance that have no row because they need none.
  int unneeded() const { return unneeded_; }

  /// stuck(): the most demanding of the pairs that cannot move apart fast enough, at most as many as there are rows.
  /// stuckCount(): the number of all of them.
  const std::vector<Stuck>& stuck() const { return stuck_; }
  int stuckCount() const { return stuck_count_; }

  /// The number of pairs that have no row because their distance or their gradient is not known.
  int unknown() const { return unknown_; }

 private:
  static constexpr int kNone = -1;
  enum class Need : unsigned char { Row, None, Unknown };
  struct Offer {
    ShapeRefPair pair;
    narrowphase::SignedDistance result;
    double distance;  // [m] the lower bound that counts
    double share;
    int row;             // the row that it has; kNone if it has none
    bool is_within;      // true if it is within the influence distance
    double bound = 0.0;  // the bound of its row

    double rank() const { return row == kNone ? share : share - kKeepShare; }
  };

  void offerNear(Scene& scene, const State& state, const VelocityDamper& damper);
  void offerKept(Scene& scene, const State& state, const VelocityDamper& damper);
  void offer(const PairProximity& pair, double distance, const VelocityDamper& damper, int row);
  void choose(const State& state, const VelocityDamper& damper);
  Need decideNeed(Offer& offer, const State& state, const VelocityDamper& damper);
  bool findGradient(const Offer& offer, const State& state);
  void assignRows();
  int rowOf(const ShapeRefPair& pair) const;
  void free(int row);
  void fill(const Offer& offer, const State& state);

  std::shared_ptr<const SceneModel> model_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix_;
  Eigen::VectorXd bounds_;
  std::vector<Row> rows_;
  std::vector<Offer> offers_;
  std::vector<Stuck> stuck_;
  Eigen::VectorXd speeds_;    // the largest speed of each column; 0 if it does not move
  Eigen::VectorXd gradient_;  // the gradient of one offer
  int left_out_ = 0, unneeded_ = 0, stuck_count_ = 0;
  int unknown_ = 0;
};

/// The rows of RobotModel::inequalities, for the same QP: matrix * velocity >= bounds, a row for each. The excess e of
/// an inequality may grow at most by -rate * e each second, and where it is positive it has to fall that fast. So a
/// robot approaches a bound at most exponentially, and does not pass it in steps of the time dt with rate * dt <= 1. A
/// row of which no column moves is 0, with the bound -infinity.
///
/// A bound that is positive is at most what the largest velocities of the joints in the URDF can do.
/// Memory: nothing is allocated after construction.
class InequalityRows {
 public:
  /// As ConstraintRows.
  InequalityRows(std::shared_ptr<const SceneModel> model, const std::vector<int>& moving);

  /// Sets the bounds, with positions as excessAt(). `rate` [1/s] is positive. Returns false if a pose is missing of an
  /// inequality of which a column moves; then the rows are not valid.
  bool update(const BodyPoses& poses, const std::vector<std::optional<double>>& stated, double rate);

  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& matrix() const { return matrix_; }
  const Eigen::VectorXd& bounds() const { return bounds_; }

 private:
  std::shared_ptr<const SceneModel> model_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix_;
  Eigen::VectorXd bounds_;
  Eigen::VectorXd largest_;  // the largest rate of change of each sum
};

}  // namespace proximity_server::scene
