#pragma once

#include "proximity_server/scene/batch/state_verdict.h"
#include "proximity_server/scene/model/states.h"
#include "proximity_server/scene/query/deadline.h"
#include "scene/batch/exact_state.h"
#include "scene/batch/near_objects.h"
#include "scene/lanes/lane_bounds.h"
#include "scene/state/visit_queue.h"

#include <memory>
#include <vector>

namespace proximity_server::scene {

/// Tells for many states whether any pair is at or below a distance, see SceneBatch::anyBelow.
///
/// 1. Place a block of states in lanes.
/// 2. Go through the pairs in an order that is the same for all states; those that are near most often come first. Keep
///    the states in which the balls of the pair are near, and let LaneBounds find the side of the distance. A state in
///    which a pair is proven to be below is decided.
/// 3. The leftovers are pairs that the lanes prove neither above nor below, in states that are not decided. Decide them
///    exactly, in the same order of pairs, up to the first one that is below.
///
/// 4. In the states in which no pair of links is below, decide the pairs with objects that NearObjects finds, the one
///    with the smallest lower bound first.
///
/// So the pair of a verdict is the first one in the order that the lanes prove to be below; if there is none, the first
/// one that is exactly below. It depends on the state and the distance alone.
class Verdicts {
 public:
  explicit Verdicts(std::shared_ptr<const BatchModel> batch);

  /// Returns a verdict for each state; valid until the next question. Unknown if a position or a pose is not finite.
  /// There must be one column for each joint, and the distance [m] must be a number. Unknown also if the state is not
  /// decided before the deadline.
  const std::vector<StateVerdict>& anyBelow(const States& states, double distance, const Deadline& deadline = {});

 private:
  void decideInLanes(double distance);
  void decideExactly(const States& block, double distance);
  void decideObjects(const States& block, double distance);
  StateVerdict verdictOfObjects(int state, double distance);

  std::shared_ptr<const BatchModel> batch_;
  LaneBounds lanes_;
  ExactState exact_;
  NearObjects objects_;
  VisitQueue queue_;  ///< of pairs with objects
  std::vector<StateVerdict> verdicts_;
  Deadline deadline_;
  StateVerdict* block_ = nullptr;
  std::vector<int> open_, near_;             ///< states of the block
  std::vector<std::vector<int>> leftovers_;  ///< for each state: pairs, in their order
};

}  // namespace proximity_server::scene
