#include "proximity_server/scene/batch/scene_batch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "proximity_server/scene/levels/clearance_level.h"
#include "scene/batch/batch_model.h"
#include "scene/batch/exact_state.h"
#include "scene/batch/nearest_pairs.h"
#include "scene/batch/verdicts.h"
#include "scene/lanes/lane_bounds.h"
#include "scene/model/numbers.h"

namespace proximity_server::scene {

class SceneBatch::Impl {
 public:
  explicit Impl(std::shared_ptr<const BatchModel> shared)
      : batch(std::move(shared)), lanes(batch->lanes), exact(batch), nearest(batch), verdicts(batch) {}

  /// Goes through the states block by block. Calls prepare(number of states in the block) first. Then calls
  /// answer(state, state in the block) for each state that has an answer, and skip(state) for each other state.
  template <typename Prepare, typename Answer, typename Skip>
  void forEach(const States& states, const Prepare& prepare, const Answer& answer, const Skip& skip) {
    for (Eigen::Index first = 0; first < states.rows(); first += LaneBounds::kBlock) {
      const int count = static_cast<int>(std::min<Eigen::Index>(LaneBounds::kBlock, states.rows() - first));
      lanes.place(states, first, count);
      prepare(count);
      for (int i = 0; i < count; ++i) {
        const Eigen::Index state = first + i;
        if (!takeState(states, state, i)) {
          skip(static_cast<std::size_t>(state));
          continue;
        }
        answer(static_cast<std::size_t>(state), i);
      }
    }
  }

  /// Places a state, which is the i-th of the block. Returns false if it has no answer: a position or the pose of a
  /// pair is not finite.
  bool takeState(const States& states, Eigen::Index state, int i) {
    if (!states.row(state).allFinite()) return false;
    exact.place(states, state);
    return lanes.isPlaced(i) || exact.isPlaced();  // the poses of a state that the lanes place are finite
  }

  /// Fills `closest` with the first pair that is found in each state after prepare().
  template <typename Prepare>
  const std::vector<PairProximity>& closestOfEach(const States& states, const Prepare& prepare,
                                                  std::vector<PairProximity>& closest) {
    closest.assign(static_cast<std::size_t>(states.rows()), {});
    forEach(
        states, prepare,
        [&](std::size_t state, int i) {
          const std::vector<PairProximity>& found = nearest.closest(exact, i);
          if (!found.empty()) closest[state] = found.front();
        },
        [](std::size_t) {});
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
      open_states.row(i) = states.row(static_cast<Eigen::Index>(open[static_cast<std::size_t>(i)]));
    closestOfEach(
        open_states.topRows(count_of_open), [&](int count) { nearest.prepareClosest(lanes, count, threshold, 0.0); },
        found_in_open);
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
        [&](std::size_t, int i) {
          const std::vector<PairProximity>& found = pairsOf(i);
          lists.pairs.insert(lists.pairs.end(), found.begin(), found.end());
          end(0);
        },
        [&](std::size_t) { end(1); });
    return lists;
  }

  std::shared_ptr<const BatchModel> batch;
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

SceneBatch SceneBatch::twin() const { return SceneBatch(std::make_unique<Impl>(impl_->batch)); }

const SceneModel& SceneBatch::model() const { return *impl_->batch->model; }
const Candidates& SceneBatch::candidates() const { return impl_->batch->candidates; }

const std::vector<StateVerdict>& SceneBatch::anyBelow(const States& states, double distance) {
  requireColumns(states, model().robot);
  requireNumber(distance);
  return impl_->verdicts.anyBelow(states, distance);
}

const std::vector<PairProximity>& SceneBatch::minimum(const States& states) {
  requireColumns(states, model().robot);
  Impl& impl = *impl_;
  return impl.closestOfEach(
      states, [&](int count) { impl.nearest.prepareClosest(impl.lanes, count, 1); }, impl.minima);
}

// If the pair with the smallest distance minus its warn distance is Clear, the state is Clear, and this pair decides.
// Otherwise search for a pair at Stop, and if there is one, for a pair in Collision. Pairs beyond these thresholds are
// left out, so these searches cost little.
const std::vector<PairProximity>& SceneBatch::deciding(const States& states, const LevelThresholds& thresholds) {
  if (thresholds.stop.areEqual(PairKind::OfLinks) && thresholds.warn.areEqual(PairKind::OfLinks))
    return minimum(states);
  requireColumns(states, model().robot);
  Impl& impl = *impl_;
  impl.closestOfEach(
      states, [&](int count) { impl.nearest.prepareClosest(impl.lanes, count, thresholds.warn, kInfinity); },
      impl.minima);
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

const StatePairs& SceneBatch::closest(const States& states, int k) {
  requireColumns(states, model().robot);
  if (k <= 0) throw std::invalid_argument("k is " + std::to_string(k) + ", but must be positive");
  Impl& impl = *impl_;
  const auto most = static_cast<std::size_t>(k);
  return impl.listed(
      states, [&](int count) { impl.nearest.prepareClosest(impl.lanes, count, most); },
      [&](int i) -> const std::vector<PairProximity>& { return impl.nearest.closest(impl.exact, i); });
}

const StatePairs& SceneBatch::below(const States& states, double distance) {
  requireColumns(states, model().robot);
  requireNumber(distance);
  Impl& impl = *impl_;
  return impl.listed(
      states, [&](int count) { impl.nearest.prepareBelow(impl.lanes, count, distance); },
      [&](int i) -> const std::vector<PairProximity>& { return impl.nearest.below(impl.exact, i); });
}

}  // namespace proximity_server::scene
