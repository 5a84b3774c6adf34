#include "scene/batch/nearest_pairs.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

/// For more pairs than this, the k-th smallest upper bound is not computed: it would exclude hardly any pair.
constexpr std::size_t kMostRanked = 16;

}  // namespace

NearestPairs::NearestPairs(std::shared_ptr<const BatchModel> batch)
    : batch_(std::move(batch)),
      limits_(LaneBounds::kBlock),
      limits_of_(LaneBounds::kBlock),
      uppers_(LaneBounds::kBlock * kMostRanked),
      near_(LaneBounds::kBlock),
      lower_(LaneBounds::kBlock),
      upper_(LaneBounds::kBlock),
      first_(LaneBounds::kBlock) {
  kept_.reserve(pairs() * LaneBounds::kBlock);
  queue_.reserve(pairs());
  measured_.reserve(pairs());
  answers_.reserve(pairs());
  found_.reserve(pairs() + 1);
}

// --- bounds of a block

void NearestPairs::prepareClosest(const LaneBounds& lanes, std::size_t k) {
  PROXIMITY_ASSERT(k > 0 && lanes.count() > 0,
                   "Nothing is asked: a block has at least one state, of which at least one pair is wanted.");
  forgetThresholds();
  takeBoundsOfClosest(lanes, k, kInfinity);
}

void NearestPairs::prepareClosest(const LaneBounds& lanes, const PairDistances& thresholds, double limit) {
  thresholds_.clear();
  for (const ShapeRefPair& pair : batch_->candidates) thresholds_.push_back(thresholds.of(pair));
  takeBoundsOfClosest(lanes, 1, limit + kSettledFor);
}

void NearestPairs::takeBoundsOfClosest(const LaneBounds& lanes, std::size_t k, double limit) {
  k_ = std::min(k, pairs());
  ranks_bounds_ = k_ > 0 && k_ <= kMostRanked && k_ < pairs();
  std::fill(uppers_.begin(), uppers_.end(), kNothing);
  if (k_ > 0) takeBounds(lanes, limit);
}

void NearestPairs::prepareBelow(const LaneBounds& lanes, double distance) {
  forgetThresholds();
  distance_ = distance;
  ranks_bounds_ = false;
  takeBounds(lanes, distance + kSettledFor);
}

void NearestPairs::takeBounds(const LaneBounds& lanes, double limit) {
  kept_.clear();
  std::fill(first_.begin(), first_.end(), -1);
  std::fill(limits_.begin(), limits_.end(), limit);
  const bool has_limit = ranks_bounds_ || limit < kInfinity;
  for (int state = 0; state < lanes.count(); ++state) {
    if (has_limit && lanes.isPlaced(state)) continue;
    for (int pair = 0; pair < static_cast<int>(pairs()); ++pair) keep(state, {pair, -kNothing});
    limits_[state] = -kInfinity;  // so that the lanes find no pair near in this state
  }
  if (has_limit)
    for (const int pair : batch_->order) keepNear(lanes, pair);
  for (double& of_state : limits_)
    if (of_state == -kInfinity) of_state = limit;
}

/// [m] For each state the limit of the distance of a pair.
const double* NearestPairs::limitsOf(int pair) {
  const double threshold = thresholdOf(pair);
  if (threshold == 0.0) return limits_.data();
  std::transform(limits_.begin(), limits_.end(), limits_of_.begin(), [&](double limit) { return limit + threshold; });
  return limits_of_.data();
}

/// Keeps a pair in the states in which it may be within the limit.
void NearestPairs::keepNear(const LaneBounds& lanes, int pair) {
  const double* const limits = limitsOf(pair);
  const int near = lanes.findNear(pair, limits, near_.data());
  lanes.bounds(pair, near_.data(), near, lower_.data(), upper_.data());
  for (std::size_t i = 0; i < static_cast<std::size_t>(near); ++i) {
    const int state = near_[i];
    if (lower_[i] > limits[state]) continue;
    keep(state, {pair, lower_[i]});
    if (ranks_bounds_) lowerLimit(state, roundedUp(static_cast<double>(upper_[i]) - thresholdOf(pair)));
  }
}

/// Puts it before those that are kept for the state.
void NearestPairs::keep(int state, Kept kept) {
  int& first = first_[state];
  kept.next = first;
  kept_.push_back(kept);
  first = static_cast<int>(kept_.size()) - 1;
}

void NearestPairs::lowerLimit(int state, float upper_bound) {
  float* const smallest = &uppers_[static_cast<std::size_t>(state) * kMostRanked];
  std::size_t place = k_;
  for (; place > 0 && upper_bound < smallest[place - 1]; --place)
    if (place < k_) smallest[place] = smallest[place - 1];
  if (place < k_) smallest[place] = upper_bound;
  double& limit = limits_[state];
  limit = std::min(limit, static_cast<double>(smallest[k_ - 1]) + kSettledFor);
}

// --- one state

/// [m] A pair that is proven to be farther than this is not among the closest, and not in the answer of a new Scene.
double NearestPairs::limit() const {
  const double kth = found_.size() < k_ ? kInfinity : found_.first().rank + kSettledFor;
  return std::min(first_limit_, kth);
}

void NearestPairs::enter(int state) {
  queue_.clear();
  for (int i = first_[state]; i >= 0; i = kept_[i].next) {
    const Kept& kept = kept_[i];
    Visit visit = batch_->visits[kept.pair];
    visit.lower_bound = kept.lower_bound;
    visit.threshold = thresholdOf(kept.pair);
    if (visit.excess() > first_limit_) continue;
    // The boxes of whole links hardly ever improve a bound of the lanes.
    if (kept.lower_bound > -kNothing) visit.bound = Visit::Bound::Box;
    queue_.push(visit);
  }
}

const std::vector<PairProximity>& NearestPairs::closest(ExactState& exact, int state) {
  measured_.clear();
  found_.clear();
  if (k_ == 0) return sorted();
  first_limit_ = limits_[state];
  enter(state);
  while (!queue_.empty() && !(queue_.lowestBound() > limit())) {
    Visit visit = queue_.pop();
    if (!exact.isPlaced(visit)) continue;
    if (visit.bound == Visit::Bound::Sphere) visit = exact.withBoxes(visit, limit() + visit.threshold);
    if (visit.excess() > std::min(queue_.lowestBound(), limit()))
      queue_.push(visit);
    else
      measure(exact, visit);
  }
  return sorted();
}

void NearestPairs::measure(ExactState& exact, const Visit& visit) {
  const double limit_of_pair = limit() + visit.threshold;
  PairProximity proximity = exact.measure(visit, limit_of_pair);
  if (proximity.result.lower_bound > limit_of_pair) return;
  if (proximity.result.status != narrowphase::Status::Converged) proximity = exact.measure(visit, kInfinity);
  rank(visit.number, proximity);
  if (found_.size() > k_) found_.pop();
}

void NearestPairs::rank(int pair, const PairProximity& proximity) {
  const narrowphase::SignedDistance& result = proximity.result;
  if (result.status == narrowphase::Status::Unknown) return;
  const double by = result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
  found_.push({by - thresholdOf(pair), pair, measured_.size()});
  measured_.push_back(proximity);
}

const std::vector<PairProximity>& NearestPairs::below(ExactState& exact, int state) {
  measured_.clear();
  found_.clear();
  for (int i = first_[state]; i >= 0; i = kept_[i].next) {
    const int pair = kept_[i].pair;
    const PairProximity proximity = exact.proximity(pair, distance_);
    if (!(proximity.result.lower_bound > distance_)) rank(pair, proximity);
  }
  return sorted();
}

const std::vector<PairProximity>& NearestPairs::sorted() {
  answers_.clear();
  for (const Found& found : found_.sorted()) answers_.push_back(measured_[found.index]);
  return answers_;
}

}  // namespace proximity_server::scene
