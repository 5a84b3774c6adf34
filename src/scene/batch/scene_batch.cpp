#include "proximity_server/scene/batch/scene_batch.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "scene/batch/batch_model.h"
#include "scene/batch/exact_state.h"
#include "scene/batch/nearest_pairs.h"
#include "scene/batch/verdicts.h"
#include "scene/lanes/lane_bounds.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {

class SceneBatch::Impl {
 public:
  explicit Impl(std::shared_ptr<const BatchModel> shared)
      : batch(std::move(shared)), lanes(batch->lanes), exact(batch), nearest(batch), verdicts(batch) {}

  /// Goes through the states in blocks: prepare(), then for each state in order answer(state in the block), or skip()
  /// if it has no answer. An answer that was not complete before the deadline is none.
  template <typename Prepare, typename Answer, typename Skip>
  void forEach(const States& states, const Prepare& prepare, const Answer& answer, const Skip& skip) {
    for (Eigen::Index first = 0; first < states.rows(); first += LaneBounds::kBlock) {
      const States block = states.middleRows(first, std::min<Eigen::Index>(LaneBounds::kBlock, states.rows() - first));
      const bool is_late = deadline.hasPassed();
      for (Eigen::Index i = 0; is_late && i < block.rows(); ++i) skip();
      if (is_late) continue;
      lanes.place(block);
      nearest.place(lanes, block, deadline);
      prepare();
      for (int state = 0; state < lanes.count(); ++state) {
        if (!deadline.hasPassed() && takeState(block, state))
          answer(state);
        else
          skip();
      }
    }
  }

  /// Places a state of the block. False if it has no answer: a position or the pose of a pair is not finite.
  bool takeState(const States& block, int state) {
    if (!block.row(state).allFinite()) return false;
    exact.place(block, state);
    return lanes.isPlaced(state) || exact.isPlaced();  // the poses of a state that the lanes place are finite
  }

  /// Fills `closest` with the first pair that is found in each state after prepare().
  template <typename Prepare>
  const std::vector<PairProximity>& closestOfEach(const States& states, const Prepare& prepare,
                                                  std::vector<PairProximity>& closest) {
    closest.clear();
    closest.reserve(states.rows());
    forEach(
        states, prepare,
        [&](int state) {
          const std::vector<PairProximity>& found = nearest.closest(exact, state);
          closest.push_back(found.empty() || deadline.hasPassed() ? PairProximity() : found.front());
        },
        [&] { closest.emplace_back(); });
    return closest;
  }

  /// Examines the `open` states. If some pair is at or below its threshold, and its level by `thresholds` is not better
  /// than `level`, the pair with the smallest distance minus its threshold replaces the one in `minima`. All other
  /// states are removed from `open`.
  void decide(const States& states, const LevelThresholds& thresholds, const PairDistances& threshold,
              ClearanceLevel level) {
    const auto count_of_open = static_cast<Eigen::Index>(open.size());
    if (open_states.rows() < count_of_open) open_states.resize(states.rows(), states.cols());
    for (Eigen::Index i = 0; i < count_of_open; ++i)
      open_states.row(i) = states.row(static_cast<Eigen::Index>(open[i]));
    closestOfEach(
        open_states.topRows(count_of_open), [&] { nearest.prepareClosest(threshold, 0.0); }, found_in_open);
    if (deadline.hasPassed()) {  // nobody knows what the search has missed
      for (const std::size_t state : open) minima[state] = {};
      return open.clear();
    }
    std::size_t still_open = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      const PairProximity& found = found_in_open[i];
      if (found.result.status == narrowphase::Status::Unknown || levelOf(found, thresholds).level < level) continue;
      minima[open[i]] = found;
      open[still_open++] = open[i];
    }
    open.resize(still_open);
  }

  /// Fills the lists with the pairs that pairsOf(state in the block) returns.
  template <typename Prepare, typename PairsOf>
  const StatePairs& listed(const States& states, const Prepare& prepare, const PairsOf& pairsOf) {
    lists.pairs.clear();
    lists.begins.assign(1, 0);
    lists.unknown.clear();
    const auto end = [&](unsigned char unknown) {
      lists.unknown.push_back(unknown);
      lists.begins.push_back(lists.pairs.size());
    };
    forEach(
        states, prepare,
        [&](int state) {
          const std::vector<PairProximity>& found = pairsOf(state);
          if (deadline.hasPassed()) return end(1);
          lists.pairs.insert(lists.pairs.end(), found.begin(), found.end());
          end(0);
        },
        [&] { end(1); });
    return lists;
  }

  std::shared_ptr<const BatchModel> batch;
  Deadline deadline;  ///< of the question
  LaneBounds lanes;
  ExactState exact;
  NearestPairs nearest;
  Verdicts verdicts;
  std::vector<PairProximity> minima;
  std::vector<std::size_t> open;  ///< the states whose level is not known yet
  Eigen::MatrixXd open_states;
  std::vector<PairProximity> found_in_open;
  StatePairs lists;
};

namespace {

void requireColumns(const States& states, const RobotModel& robot) {
  if (states.cols() != static_cast<Eigen::Index>(robot.joints.size()))
    throw std::invalid_argument("the robot has " + std::to_string(robot.joints.size()) +
                                " movable joints, but a state has " + std::to_string(states.cols()) + " positions");
}

void requireNumber(double distance) {
  if (std::isnan(distance)) throw std::invalid_argument("the distance is not a number");
}

}  // namespace

SceneBatch::SceneBatch(std::shared_ptr<const SceneModel> model)
    : impl_(std::make_unique<Impl>(std::make_shared<const BatchModel>(std::move(model)))) {}
SceneBatch::SceneBatch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SceneBatch::~SceneBatch() = default;
SceneBatch::SceneBatch(SceneBatch&&) noexcept = default;
SceneBatch& SceneBatch::operator=(SceneBatch&&) noexcept = default;

SceneBatch SceneBatch::forAnotherThread() const { return SceneBatch(std::make_unique<Impl>(impl_->batch)); }

const SceneModel& SceneBatch::model() const { return *impl_->batch->model; }
const Candidates& SceneBatch::candidates() const { return impl_->batch->candidates; }
const std::vector<ShapeRefPair>& SceneBatch::pairs() const { return impl_->batch->pairs; }

void SceneBatch::use(std::shared_ptr<const Objects> objects) {
  impl_ = std::make_unique<Impl>(std::make_shared<const BatchModel>(*impl_->batch, std::move(objects)));
}

const Objects* SceneBatch::objects() const {
  return impl_->batch->objects ? impl_->batch->objects->objects.get() : nullptr;
}

/// The implementation, for a question with this deadline. Throws std::invalid_argument for a wrong number of columns.
SceneBatch::Impl& SceneBatch::asked(const States& states, const Deadline& deadline) {
  requireColumns(states, model().robot);
  impl_->deadline = deadline;
  return *impl_;
}

const std::vector<StateVerdict>& SceneBatch::anyBelow(const States& states, double distance, const Deadline& deadline) {
  requireColumns(states, model().robot);
  requireNumber(distance);
  return impl_->verdicts.anyBelow(states, distance, deadline);
}

const std::vector<PairProximity>& SceneBatch::minimum(const States& states, const Deadline& deadline) {
  Impl& impl = asked(states, deadline);
  return impl.closestOfEach(
      states, [&] { impl.nearest.prepareClosest(1); }, impl.minima);
}

const std::vector<PairProximity>& SceneBatch::minimumWithin(const States& states, double accuracy,
                                                            const Deadline& deadline) {
  Impl& impl = asked(states, deadline);
  if (!(accuracy > 0.0))
    throw std::invalid_argument("the accuracy is " + std::to_string(accuracy) + ", but must be positive");
  impl.minima.clear();
  impl.minima.reserve(states.rows());
  impl.forEach(
      states, [&] { impl.nearest.prepareWithin(accuracy); },
      [&](int state) {
        const PairProximity bounded = impl.nearest.within(impl.exact, state, accuracy);
        impl.minima.push_back(deadline.hasPassed() ? PairProximity() : bounded);
      },
      [&] { impl.minima.emplace_back(); });
  return impl.minima;
}

// If the pair with the smallest distance minus its warn distance is Clear, the state is Clear, and this pair decides.
// Otherwise search for a pair at Stop, and if there is one, for a pair in Collision. Pairs beyond these thresholds are
// left out, so these searches cost little.
const std::vector<PairProximity>& SceneBatch::deciding(const States& states, const LevelThresholds& thresholds,
                                                       const Deadline& deadline) {
  const PairKind kind = objects() && !objects()->empty() ? PairKind::Any : PairKind::OfLinks;
  if (thresholds.stop.areEqual(kind) && thresholds.warn.areEqual(kind)) return minimum(states, deadline);
  Impl& impl = asked(states, deadline);
  impl.closestOfEach(
      states, [&] { impl.nearest.prepareClosest(thresholds.warn, kInfinity); }, impl.minima);
  impl.open.clear();
  for (std::size_t state = 0; state < impl.minima.size(); ++state) {
    const PairProximity& pair = impl.minima[state];
    if (pair.result.status != narrowphase::Status::Unknown && levelOf(pair, thresholds).level != ClearanceLevel::Clear)
      impl.open.push_back(state);
  }
  impl.decide(states, thresholds, thresholds.stop, ClearanceLevel::Stop);
  impl.decide(states, thresholds, {}, ClearanceLevel::Collision);
  return impl.minima;
}

const StatePairs& SceneBatch::closest(const States& states, int k, const Deadline& deadline) {
  Impl& impl = asked(states, deadline);
  if (k <= 0) throw std::invalid_argument("k is " + std::to_string(k) + ", but must be positive");
  const auto most = static_cast<std::size_t>(k);
  return impl.listed(
      states, [&] { impl.nearest.prepareClosest(most); },
      [&](int state) -> const std::vector<PairProximity>& { return impl.nearest.closest(impl.exact, state); });
}

const StatePairs& SceneBatch::below(const States& states, double distance, const Deadline& deadline) {
  Impl& impl = asked(states, deadline);
  requireNumber(distance);
  return impl.listed(
      states, [&] { impl.nearest.prepareBelow(distance); },
      [&](int state) -> const std::vector<PairProximity>& { return impl.nearest.below(impl.exact, state); });
}

}  // namespace proximity_server::scene
