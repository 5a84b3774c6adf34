#pragma once

#include "proximity_server/scene/query/deadline.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "scene/batch/exact_state.h"
#include "scene/batch/near_objects.h"
#include "scene/bounds/heap.h"
#include "scene/lanes/lane_bounds.h"
#include "scene/state/visit_queue.h"

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Finds the closest candidate pairs in each state of a block.
///
/// 1. Each state has a limit: the distance of the question, or the k-th smallest upper bound so far, because the k
///    closest pairs are not farther.
/// 2. Go through the pairs; those that were among the closest most often in the last block come first, then those that
///    are near most often. Keep the states in which the balls of the pair are within the limit, and bound the distance
///    in these states in lanes. This may lower the limit.
/// 3. For each state: put the kept pairs whose lower bound is within the limit into a queue, the smallest bound first.
/// 4. Take the first pair of the queue and compute it. The k-th smallest distance so far is the next limit. A pair
///    without a bound of the lanes gets one from an earlier state or from its boxes first. Pieces beyond the upper
///    bound of the lanes are left out.
/// 5. End when the smallest bound in the queue is above the limit.
///
/// Along an edge, the pairs that were the closest in the last state mostly are again. They are computed first, and give
/// all others a small limit. Then few pairs are left, and lanes do not pay: step 2 leaves these states out, and step 3
/// takes the pairs that no lower bound excludes. From the cheapest to the most expensive, it is the bound of an earlier
/// state minus the travel of both links since then, the bound of the balls, the bound of an earlier state minus the
/// motion of the links relative to each other, and the bound of the boxes.
///
/// If only bounds of the smallest distance are asked for, the lanes bound the pieces of the kept pairs after step 2. What
/// they leave open is computed, until the bounds are as near as asked.
///
/// The pairs with objects within the limit come from NearObjects, and enter the queue with the pairs of links.
///
/// If pairs have thresholds of their own, these are subtracted from bounds and distances before they are compared.
///
/// No other answer depends on the bounds, on the order of the visits or on the limits; they decide only which pairs are
/// computed. The reason: a pair among the closest is nearer than every limit by more than the tolerance, so its search
/// leaves out no piece that could be its closest one. If it did not converge, it is computed again without limit.
class NearestPairs {
 public:
  explicit NearestPairs(std::shared_ptr<const BatchModel> batch);

  /// Takes a block of states, which `lanes` has placed. `lanes` must keep them until the last question about them. After
  /// the deadline, answers are not complete.
  void place(const LaneBounds& lanes, const States& states, const Deadline& deadline = {});

  /// Bounds the pairs in the states of the block, for the k closest pairs of each.
  void prepareClosest(std::size_t k);

  /// Prepares for bounds of the smallest distance that are `accuracy` [m] apart.
  void prepareWithin(double accuracy);

  /// Prepares for the pair with the smallest distance minus its own threshold, if this is at most `limit` [m].
  void prepareClosest(const PairDistances& thresholds, double limit);

  /// Prepares for all pairs at or below the distance [m].
  void prepareBelow(double distance);

  /// Finds the prepared pairs in one state of the block. The state is placed in `exact`. The result is sorted, and
  /// valid until the next call.
  const std::vector<PairProximity>& closest(ExactState& exact, int state);
  const std::vector<PairProximity>& below(ExactState& exact, int state);

  /// Returns bounds of the smallest distance of all pairs, see SceneBatch::minimumWithin().
  PairProximity within(ExactState& exact, int state, double accuracy);

 private:
  /// A pair that may be within the limit of a state.
  struct Kept {
    int pair, state;
    float lower_bound = -std::numeric_limits<float>::infinity();  ///< [m]
    float upper_bound = std::numeric_limits<float>::infinity();   ///< [m]
  };
  struct Found {
    /// [m] the distance minus the threshold; the lower bound minus the threshold if the search did not converge
    double rank;
    int pair;           ///< decides between equal ranks
    std::size_t index;  ///< index into measured_
    bool operator<(const Found& other) const { return rank != other.rank ? rank < other.rank : pair < other.pair; }
  };

  std::size_t pairs() const { return batch_->candidates.size(); }  ///< of links
  void takeBoundsOfClosest(std::size_t k, double limit);
  void takeBounds(double limit);
  double thresholdOf(int pair) const {
    const auto place = static_cast<std::size_t>(pair);
    return place < pairs() ? thresholds_[place] : own_thresholds_.of(batch_->pairs[place]);
  }
  void forgetThresholds() { takeThresholds({}); }
  void takeThresholds(const PairDistances& thresholds);
  const double* limitsOf(int pair);
  void beginEdges();
  void putLikelyFirst();
  void keepNear(int pair);
  void keep(const Kept& kept);
  void lowerLimit(const Kept& kept);
  void findNearestOfStates();
  void boundPieces();
  template <typename IsWanted>
  void boundPieces(const IsWanted& isWanted);
  void boundAsked();
  void measureLikely(ExactState& exact);
  void enter(int state);
  void enterOnEdge(ExactState& exact, int state);
  void enterObjects(ExactState& exact, int state);
  void measure(ExactState& exact, const Visit& visit);
  void listIfBelow(ExactState& exact, int pair);
  void forgetFound();
  void keepFound();
  void rank(int pair, const PairProximity& proximity);
  double limit() const;
  const std::vector<PairProximity>& sorted();

  std::shared_ptr<const BatchModel> batch_;
  std::size_t k_ = 0;
  bool ranks_bounds_ = false;         ///< true if upper bounds lower the limits
  double distance_ = 0.0;             ///< [m] for below()
  double accuracy_ = 0.0;             ///< [m] for within(); 0: pieces are not bounded in lanes
  std::vector<double> thresholds_;    ///< [m] for each pair of links: subtracted from its distance
  PairDistances own_thresholds_;      ///< [m] the same of all pairs
  std::vector<int> times_closest_;    ///< for each pair of links: in how many states of the last block
  std::vector<int> order_;            ///< the pairs of links, as they are bounded
  std::vector<double> limits_;        ///< [m] for each state, with kSettledFor
  std::vector<double> limits_of_;     ///< [m] for each state: the limit plus the threshold of a pair
  std::vector<float> uppers_;         ///< [m] for each state: the k smallest upper bounds, ascending
  std::vector<int> near_;             ///< the states in which a pair is near
  std::vector<float> lower_, upper_;  ///< [m] for each of these states
  /// A pair of links in the states of an edge.
  struct OnEdge {
    int pair;
    int a, b;            ///< the links, as in LaneModel
    double lower_bound;  ///< [m] in an earlier state of the block, plus the travel of both links up to there
  };
  std::vector<OnEdge> on_edge_;            ///< all that have geometry
  std::vector<double> travel_;             ///< see LaneBounds::travel()
  std::vector<unsigned char> is_on_edge_;  ///< for each state: 1 if the lanes need not bound its pairs
  std::vector<Kept> kept_;                 ///< the entries of one pair lie side by side
  std::vector<std::vector<int>> kept_of_;  ///< for each state: indices of its kept pairs
  std::vector<int> nearest_;               ///< for each state: index of the kept pair with the smallest lower bound
  std::vector<int> asked_;                 ///< indices of the kept pairs whose pieces are bounded
  std::vector<double> limits_of_asked_;

  const LaneBounds* lanes_ = nullptr;
  Deadline deadline_;
  NearObjects objects_;

  double first_limit_ = 0.0;  ///< [m] for the current state
  VisitQueue queue_;
  std::vector<float> upper_bounds_;       ///< [m] for each pair: by the lanes in the current state
  std::vector<int> last_found_;           ///< the pairs found in the last state
  std::vector<unsigned char> was_found_;  ///< for each pair: 1 if it is one of these
  std::vector<PairProximity> measured_, answers_;
  Heap<Found> found_;  ///< the closest pairs so far, the farthest first
};

}  // namespace proximity_server::scene
