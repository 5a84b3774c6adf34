#pragma once

#include <memory>
#include <vector>

#include "proximity_server/scene/batch/state_verdict.h"
#include "proximity_server/scene/model/states.h"
#include "scene/batch/exact_state.h"
#include "scene/lanes/lane_bounds.h"

namespace proximity_server::scene {

/// Whether anything is at or below a distance, for many states: SceneBatch::anyBelow.
///
/// 1. Place a block of states in lanes.
/// 2. Go through the pairs in an order that is the same for all states, those that are near most often first. Keep the states
///    in which the balls of the pair are near, and let LaneBounds find the side of the distance. A state in which a pair is
///    proven to be below is finished.
/// 3. What is left over, pairs that the lanes can prove neither above nor below in states that are not finished, is decided
///    exactly, in the same order of pairs, up to the first that is below.
///
/// So the pair of a verdict is the first in the order that the lanes prove to be below, or else the first that is so exactly:
/// a function of the state and the distance.
class Verdicts {
 public:
  explicit Verdicts(std::shared_ptr<const BatchModel> batch);

  /// For each state; valid until the next question. Unknown where a position or a pose is not finite. There is one column for
  /// each joint, and the distance [m] is a number.
  const std::vector<StateVerdict>& anyBelow(const States& states, double distance);

  /// How many states or pairs of states reached which step in the last question.
  struct Counts {
    long states = 0;
    long near_pairs = 0;       ///< pairs that the balls left
    long exact_pairs = 0;      ///< pairs that were decided exactly
    long exact_states = 0;     ///< states with such pairs
    long unplaced_states = 0;  ///< beyond the range of the lanes
  };
  const Counts& counts() const { return counts_; }

 private:
  void decideInLanes(int count, double distance);
  void decideExactly(const States& states, Eigen::Index first, int count, double distance);

  std::shared_ptr<const BatchModel> batch_;
  LaneBounds lanes_;
  ExactState exact_;
  std::vector<StateVerdict> verdicts_;
  StateVerdict* block_ = nullptr;
  std::vector<int> open_, near_;  ///< states of the block
  struct Leftover {
    int pair, next;  ///< the next one of the state; -1: none
  };
  std::vector<Leftover> leftovers_;
  std::vector<int> first_leftover_, last_leftover_;  ///< of each state; -1: none
  Counts counts_;
};

}  // namespace proximity_server::scene
