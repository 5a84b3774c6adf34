#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "scene/guaranteed/pieces_bound.h"
#include "scene/guaranteed/reached.h"

#include <cstddef>
#include <vector>

namespace proximity_server::scene {

/// Divides the positions of the joints between the two of a pair into parts, and bounds the pair in each of them: two
/// states may need different directions. The part with the lowest bound is divided next (Land, Doig, An Automatic Method
/// of Solving Discrete Programming Problems, 1960).
class DividedBound {
 public:
  DividedBound(const UncertainPlaces& places, DisplacedPair& pair, PiecesBound& pieces, ReachedStates& reached,
               LimitedWork& work);

  /// 0: nothing is divided.
  void divideInto(int most_parts) { most_parts_ = most_parts; }

  /// Returns a bound [m] of all states that is at least `whole`, and not improved above `enough`. The pieces that decide
  /// the pair in the present state stay the deciding ones of `pieces`. It ends when the bound loses at most kMuch times
  /// as much as a state that was found, or when such a state is in contact, or with the work of the pair. `lower_bound`
  /// [m]: the lower bound of the pair in the present state.
  double improved(double whole, double lower_bound, double enough);

  /// By joint, the positions of the leaders relative to the present ones in the nearest state that the last division
  /// found; empty: the middle of no part is nearer than the states that ReachedStates finds.
  const std::vector<double>& nearestState() const { return nearest_state_; }
  void forgetNearest() { nearest_state_.clear(); }

 private:
  /// A part: an interval for each of the joints between the two.
  struct Box {
    std::size_t intervals;  ///< the place of the first one
    double bound;           ///< [m] of the pair
    LeafPair leaves;        ///< those that decide it
  };
  bool findLeadersBetween();
  std::vector<JointRange>::const_iterator findInterval(std::size_t begin, int joint) const;
  Box halve(const Box& box);
  void boundPart(Box& box, double enough, double& nearest);
  double displaceSide(const DisplacedShape& whole, const Box& box, DisplacedShape& side) const;

  static constexpr int kUsualParts = 64;
  static constexpr double kNegligible = 1e-6;  ///< [m] a loss that is not worth a part; links are known to 1e-4 at best

  const UncertainPlaces& places_;
  DisplacedPair& pair_;
  PiecesBound& pieces_;
  ReachedStates& reached_;
  LimitedWork& work_;
  int most_parts_ = kUsualParts;
  DisplacedShape whole_a_, whole_b_;  ///< the two in the present state
  std::vector<double> lever_arms_;    ///< [m/rad] or [m/m] by joint, an upper bound of the ways of all points
  std::vector<JointRange> intervals_;
  std::size_t leaders_between_ = 0;  ///< the number of intervals of each part
  std::vector<Box> boxes_;           ///< a heap: the lowest bound first
  std::vector<double> nearest_state_;
};

}  // namespace proximity_server::scene
