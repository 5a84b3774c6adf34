#pragma once

#include "proximity_server/scene/model/states.h"
#include "scene/kernels/lane_kernels.h"
#include "scene/lanes/lane_model.h"
#include "scene/lanes/piece_bounds.h"
#include "scene/query/closest_pieces.h"

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Bounds of the signed distances of the candidate pairs in a block of states. Each lane of a vector has one state.
///
/// 1. place() computes the frames of all bodies in double and the frames of the links in float, with a bound of their
///    errors (LaneError).
/// 2. Enclosing balls, then boxes give lower bounds.
/// 3. A search in the Minkowski difference of the outlines of two links moves a point towards the origin, step by step.
///    The support plane at each point gives a lower bound, and the point itself gives an upper bound if the links are
///    convex. It is run first with few corners, then with all.
/// 4. Inner balls near the last point give upper bounds.
/// 5. GJK for the pieces, see PieceBounds.
///
/// All bounds hold for the whole links and include the paddings of pairs, the interiors of closed meshes, and rounding.
/// Each bound is a function of the state and the pair alone, with the same bits on every processor.
///
/// Source: Frank, Wolfe, An Algorithm for Quadratic Programming, 1956 (the step of the search); Gilbert, Johnson,
///         Keerthi, 1988 (the lower bound). Unlike GJK, it keeps no simplex, so all lanes take the same steps.
class LaneBounds {
 public:
  static constexpr int kBlock = lanes::kBlock;  ///< the largest number of states at once

  explicit LaneBounds(const SceneModel& model);
  explicit LaneBounds(std::shared_ptr<const LaneModel> model, const lanes::Kernels& kernels = lanes::kernels());

  /// Takes up to kBlock states.
  void place(const States& states);

  /// How many these are.
  int count() const { return count_; }

  /// False if a position is not finite, or beyond the range in which the errors hold. Then the state has no bounds.
  bool isPlaced(int state) const { return is_placed_[state] != 0; }

  /// Bounds a candidate pair in each of the listed, placed states: lower[i] <= signed distance <= upper[i] [m].
  void bounds(int pair, const int* states, int count, float* lower, float* upper) const;

  /// The lower bounds alone. A bound that is above the limit [m] need not be the best one.
  void lowerBounds(int pair, const int* states, int count, double limit, float* lower) const;

  /// Narrows bounds of a pair in each of the listed, placed states to the bounds of its pieces, by GJK, until they are
  /// at most `accuracy` [m] apart where float allows it. States whose lower bound is above limits[i] [m] need no more.
  /// An upper bound is found for pieces that are hulls of points, with any margin. `upper` is at most 0 if the pair is
  /// proven to overlap; the depth is only bounded.
  void boundPieces(int pair, const int* states, int count, const double* limits, double accuracy, float* lower,
                   float* upper) const;

  // The following functions find bounds in steps, for a question with a threshold.

  /// Keeps the states in which the balls of the pair do not prove a distance above the threshold [m]. Returns their
  /// number.
  int keepNear(int pair, double threshold, int* states, int count) const;

  /// The states whose balls do not prove a distance above the threshold [m] of the state. Writes their numbers to
  /// `states`, ascending, and returns how many they are. Both arrays have kBlock entries.
  int findNear(int pair, const double* thresholds, int* states) const;

  /// [m] A lower bound of the distance of a pair with geometry in one placed state, by its balls.
  double ballGap(int pair, int state) const;

  /// Upper bounds [m] of how far any point of each link has moved from the first state to each other one, if it went
  /// from state to state: travel[state * links + link], with the links of LaneModel.
  void travel(double* travel) const;

  /// The side of the threshold on which a pair is proven to be in one state.
  enum class Side : unsigned char { Unknown, Above, Below };

  /// Returns the side for each of the listed states. The result is valid until the next question.
  const std::vector<Side>& sides(int pair, double threshold, const int* states, int count) const;

  /// Writes where a point of a body is in each state, see LaneModel::body_errors for its error. The arrays have kBlock
  /// entries.
  void placePoint(int body, const Eigen::Vector3d& point, float* x, float* y, float* z) const;

  /// The frames of all bodies, as the lanes have them. For tests.
  std::vector<Eigen::Isometry3d> bodyPoses(int state) const;

 private:
  using Row = lanes::Row;
  struct alignas(64) AlignedRow {
    lanes::WideRow row;
  };
  using Rows = std::vector<AlignedRow>;
  static const lanes::WideRow* rowsOf(const Rows& rows) { return rows.empty() ? nullptr : &rows.front().row; }
  template <typename Tile>
  struct alignas(64) Aligned {
    Tile tile;
  };
  template <typename Tile>
  static Tile* tilesOf(std::vector<Aligned<Tile>>& tiles) {
    return tiles.empty() ? nullptr : &tiles.front().tile;
  }
  const LaneModel::Pair& pairAt(int pair) const { return model_->pairs[pair]; }
  lanes::PairPoses posesOf(const LaneModel::Pair& pair) const;
  void takePositions(const States& states, const LaneModel::Column& column);
  int keepUndecided(const lanes::SearchLimits& limits, int count) const;

  std::shared_ptr<const LaneModel> model_;
  const lanes::Kernels* kernels_;
  int count_ = 0;
  std::vector<unsigned char> is_placed_;
  Rows sines_, cosines_, positions_;
  std::vector<Aligned<lanes::WideTile>> body_poses_;
  std::vector<Aligned<lanes::Tile>> link_poses_;
  std::vector<double> column_;
  std::unique_ptr<lanes::Items> items_;
  mutable std::vector<unsigned char> near_;
  mutable std::vector<Side> sides_;
  mutable std::vector<int> places_;
  mutable PieceBounds pieces_;
};

}  // namespace proximity_server::scene
