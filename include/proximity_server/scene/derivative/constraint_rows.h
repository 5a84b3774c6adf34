#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// How fast two shapes may approach each other: at most gain (d - stop) / (influence - stop) [m/s] at the distance d. So a
/// pair that is above its stop distance comes ever more slowly to it, and one below must move away.
///
/// In steps of the time dt the distance stays above the stop distance only if gain * dt <= influence - stop.
/// Source: Faverjon, Tournassoud, A local based approach for path planning of manipulators with a high number of degrees of
///         freedom, ICRA 1987.
struct VelocityDamper {
  double stop_distance;         ///< [m] of two links
  double object_stop_distance;  ///< [m] of a pair with an object
  double influence_distance;    ///< [m] pairs farther apart are not limited; above both stop distances
  double gain;                  ///< [m/s] how fast a pair at the influence distance may approach; positive
};

/// The linear constraints that keep a robot from approaching itself and its objects too fast: rows of a QP in the
/// velocities of its degrees of freedom. Not thread-safe.
///
/// 1. Ask the scene for the closest pairs within the influence distance, as many as there are rows: of links, and of objects,
///    which may have another stop distance.
/// 2. Order them by their share (d - stop) / (influence - stop), d the proven lower bound: the smallest is the most demanding.
///    A pair that has a row is measured also where it is no longer among them, and its share counts as smaller by
///    kKeepShare.
/// 3. The first ones, as many as there are rows, have one. Those that had a row keep it; the others take the free rows,
///    lowest first.
/// 4. A row is the pair's gradient, and its bound is -gain * share, rounded up.
///
/// Order:   a pair keeps its row from update to update as long as it is among the closest, and gives way only to one whose
///          share is smaller by more than kKeepShare, or beyond the influence distance by that share. So two pairs that are
///          equally close do not take turns, and a controller can start warm. A pair without a row is therefore never closer
///          by more than that share than one with a row.
/// Memory:  size and place never change. Nothing allocates after the first update() of a scene without objects; with objects
///          that is so as soon as the scene has no new ones.
/// Limit:   a row looks at the velocity in this moment. What the distance loses in a step because links turn is of second order
///          in the step.
class ConstraintRows {
 public:
  static constexpr double kKeepShare = 0.05;

  /// Throws std::invalid_argument for a capacity below 1.
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

  /// [m/s]; -infinity for a row that is not used, positive for a pair below its stop distance. Not below the exact value of
  /// the formula for the lower bound of the distance.
  const Eigen::VectorXd& bounds() const { return bounds_; }

  const std::vector<Row>& rows() const { return rows_; }

  /// How many pairs within the influence distance have no row because others were more demanding. The rows say nothing about
  /// them: a controller that sees any has too few rows.
  int leftOut() const { return left_out_; }

  /// How many pairs have no row because their distance or their gradient is not known.
  int unknown() const { return unknown_; }

 private:
  static constexpr int kNone = -1;
  enum class Reach : unsigned char { Within, Open };  // the influence distance, as the scene has counted it
  struct Offer {
    ShapeRefPair pair;
    narrowphase::SignedDistance result;
    double share;
    int row;  // that it has; kNone
    Reach reach;

    double rank() const { return row == kNone ? share : share - kKeepShare; }
  };

  void offerClosest(Scene& scene, PairKind kind, const VelocityDamper& damper);
  void offerKept(Scene& scene, const VelocityDamper& damper);
  void offer(const PairProximity& pair, const VelocityDamper& damper, int row, Reach reach);
  void choose();
  void giveRows();
  int rowOf(const ShapeRefPair& pair) const;
  void free(int row);
  void fill(const Offer& offer, const Derivatives& derivatives, const VelocityDamper& damper);

  std::shared_ptr<const SceneModel> model_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix_;
  Eigen::VectorXd bounds_;
  std::vector<Row> rows_;
  std::vector<Offer> offers_;
  int left_out_ = 0;
  int unknown_ = 0;
};

}  // namespace proximity_server::scene
