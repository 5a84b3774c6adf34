#include "scene/batch/nearest_pairs.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

/// For more pairs than this, the k-th smallest upper bound is not computed: it would exclude hardly any pair.
constexpr std::size_t kMostRanked = 16;

/// [m] Along an edge, a pair beyond the limit is computed until it is proven to be so much farther. So the proof
/// outlasts the motion of some states. Evidence: the minimum of PR2 takes 8 % fewer instructions with 5 mm, 12.5 % with
/// 20 mm, and 11.5 % with 50 mm.
constexpr double kSpare = 0.02;

/// Fewer states than this, each near the one before, are no edge: the first one has no limit from the one before.
constexpr Eigen::Index kFewestOnEdge = 8;

}  // namespace

NearestPairs::NearestPairs(std::shared_ptr<const BatchModel> batch)
    : batch_(std::move(batch)),
      times_closest_(batch_->order.size(), 0),
      limits_(LaneBounds::kBlock),
      limits_of_(LaneBounds::kBlock),
      uppers_(LaneBounds::kBlock * kMostRanked),
      near_(LaneBounds::kBlock),
      lower_(LaneBounds::kBlock),
      upper_(LaneBounds::kBlock),
      is_on_edge_(LaneBounds::kBlock),
      kept_of_(LaneBounds::kBlock),
      nearest_(LaneBounds::kBlock),
      limits_of_asked_(LaneBounds::kBlock),
      objects_(batch_) {
  kept_.reserve(pairs() * LaneBounds::kBlock);
  for (std::vector<int>& of_state : kept_of_) of_state.reserve(pairs());
  queue_.reserve(pairs());
  last_found_.reserve(pairs());
  travel_.resize(LaneBounds::kBlock * std::max<std::size_t>(1, batch_->lanes->links.size()));
  for (int pair = 0; pair < static_cast<int>(pairs()); ++pair)
    if (const LaneModel::Pair& shapes = batch_->lanes->pairs[pair]; shapes.hasGeometry())
      on_edge_.push_back({pair, shapes.a, shapes.b, -kInfinity});
  was_found_.assign(batch_->pairs.size(), 0);
  upper_bounds_.resize(batch_->pairs.size());
  measured_.reserve(pairs());
  answers_.reserve(pairs());
  found_.reserve(pairs() + 1);
}

// --- bounds of a block

void NearestPairs::place(const LaneBounds& lanes, const States& states, const Deadline& deadline) {
  lanes_ = &lanes;
  deadline_ = deadline;
  objects_.place(lanes);
  for (Eigen::Index first = 0, end = 0; first < states.rows(); first = end) {
    for (end = first + 1; end < states.rows() && areNear(states, end - 1, end);) ++end;
    std::fill(is_on_edge_.begin() + first, is_on_edge_.begin() + end, end - first >= kFewestOnEdge);
  }
}

void NearestPairs::prepareClosest(std::size_t k) {
  PROXIMITY_ASSERT(k > 0 && lanes_->count() > 0,
                   "Nothing is asked: a block has at least one state, of which at least one pair is wanted.");
  forgetThresholds();
  takeBoundsOfClosest(k, kInfinity);
}

void NearestPairs::prepareWithin(double accuracy) {
  accuracy_ = accuracy;
  prepareClosest(1);
  accuracy_ = 0.0;
}

void NearestPairs::prepareClosest(const PairDistances& thresholds, double limit) {
  takeThresholds(thresholds);
  takeBoundsOfClosest(1, limit + kSettledFor);
}

void NearestPairs::takeThresholds(const PairDistances& thresholds) {
  own_thresholds_ = thresholds;
  thresholds_.clear();
  for (const ShapeRefPair& pair : batch_->candidates) thresholds_.push_back(thresholds.of(pair));
}

void NearestPairs::takeBoundsOfClosest(std::size_t k, double limit) {
  k_ = std::min(k, batch_->pairs.size());
  ranks_bounds_ = k_ > 0 && k_ <= kMostRanked && (k_ < batch_->pairs.size() || accuracy_ > 0.0);
  std::fill(uppers_.begin(), uppers_.end(), kFloatInfinity);
  if (k_ > 0) takeBounds(limit);
}

void NearestPairs::prepareBelow(double distance) {
  forgetThresholds();
  distance_ = distance;
  k_ = 0;
  ranks_bounds_ = false;
  takeBounds(distance + kSettledFor);
}

void NearestPairs::takeBounds(double limit) {
  kept_.clear();
  for (std::vector<int>& of_state : kept_of_) of_state.clear();
  std::fill(limits_.begin(), limits_.end(), limit);
  const bool has_limit = ranks_bounds_ || limit < kInfinity;
  int in_lanes = 0, on_edge = 0;
  for (int state = 0; state < lanes_->count(); ++state) {
    const bool has_bounds = has_limit && lanes_->isPlaced(state);
    if (!(has_bounds && k_ > 0 && accuracy_ == 0.0)) is_on_edge_[state] = 0;
    in_lanes += has_bounds && !is_on_edge_[state];
    on_edge += is_on_edge_[state];
    if (has_bounds && !is_on_edge_[state]) continue;
    limits_[state] = -kInfinity;  // so that the lanes find no pair near in this state
    for (int pair = 0; !has_bounds && pair < static_cast<int>(pairs()); ++pair) keep({pair, state});
  }
  if (on_edge > 0) beginEdges();
  order_ = batch_->order;
  // Which overlap gives bounds within an accuracy depends on the order.
  if (!(accuracy_ > 0.0)) putLikelyFirst();
  if (in_lanes > 0)
    for (const int pair : order_) keepNear(pair);
  if (accuracy_ > 0.0) boundPieces();
  for (double& of_state : limits_)
    if (of_state == -kInfinity) of_state = limit;
}

/// Forgets the bounds of the last block, whose travel is not known any more.
void NearestPairs::beginEdges() {
  for (OnEdge& pair : on_edge_) pair.lower_bound = -kInfinity;
  lanes_->travel(travel_.data());
}

/// Puts the pairs that were often among the closest in the last block first in the order. Mostly they are close again,
/// and give all others a small limit.
void NearestPairs::putLikelyFirst() {
  std::size_t sorted = 0;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const int times = times_closest_[order_[i]];
    if (times == 0) continue;
    const auto begin = order_.begin(), end = begin + static_cast<std::ptrdiff_t>(sorted++);
    const auto place = std::find_if(begin, end, [&](int other) { return times_closest_[other] < times; });
    std::rotate(place, begin + static_cast<std::ptrdiff_t>(i), begin + static_cast<std::ptrdiff_t>(i) + 1);
  }
  std::fill(times_closest_.begin(), times_closest_.end(), 0);
}

/// [m] For each state the limit of the distance of a pair.
const double* NearestPairs::limitsOf(int pair) {
  const double threshold = thresholdOf(pair);
  if (threshold == 0.0) return limits_.data();
  std::transform(limits_.begin(), limits_.end(), limits_of_.begin(), [&](double limit) { return limit + threshold; });
  return limits_of_.data();
}

/// Keeps a pair in the states in which it may be within the limit.
void NearestPairs::keepNear(int pair) {
  const double* const limits = limitsOf(pair);
  const int near = lanes_->findNear(pair, limits, near_.data());
  if (near == 0) return;
  if (ranks_bounds_)
    lanes_->bounds(pair, near_.data(), near, lower_.data(), upper_.data());
  else  // all limits are the same
    lanes_->lowerBounds(pair, near_.data(), near, limits[near_.front()], lower_.data());
  for (std::size_t i = 0; i < static_cast<std::size_t>(near); ++i) {
    const int state = near_[i];
    if (lower_[i] > limits[state]) continue;
    keep({pair, state, lower_[i], upper_[i]});
    if (ranks_bounds_) lowerLimit(kept_.back());
  }
}

void NearestPairs::keep(const Kept& kept) {
  kept_of_[kept.state].push_back(static_cast<int>(kept_.size()));
  kept_.push_back(kept);
}

void NearestPairs::lowerLimit(const Kept& kept) {
  const int state = kept.state;
  const float upper_bound = roundedUp(static_cast<double>(kept.upper_bound) - thresholdOf(kept.pair));
  float* const smallest = &uppers_[static_cast<std::size_t>(state) * kMostRanked];
  std::size_t place = k_;
  for (; place > 0 && upper_bound < smallest[place - 1]; --place)
    if (place < k_) smallest[place] = smallest[place - 1];
  if (place < k_) smallest[place] = upper_bound;
  double& limit = limits_[state];
  limit = std::min(limit, static_cast<double>(smallest[k_ - 1]) + kSettledFor);
  // Bounds within an accuracy need no other pair than one that overlaps.
  if (accuracy_ > 0.0 && smallest[0] <= 0.0F) limit = -kInfinity;
}

/// Bounds the pieces of the pairs that decide bounds within the accuracy: the nearest pair of each state first, which
/// lowers its limit.
void NearestPairs::boundPieces() {
  const auto isWithin = [&](const Kept& kept) {
    return lanes_->isPlaced(kept.state) && kept.lower_bound <= limits_[kept.state] - accuracy_;
  };
  findNearestOfStates();
  const auto isNearest = [&](const Kept& kept) { return &kept == &kept_[nearest_[kept.state]]; };
  boundPieces([&](const Kept& kept) { return isNearest(kept) && isWithin(kept); });
  boundPieces([&](const Kept& kept) { return !isNearest(kept) && isWithin(kept); });
}

void NearestPairs::findNearestOfStates() {
  std::fill(nearest_.begin(), nearest_.end(), -1);
  for (int i = 0; i < static_cast<int>(kept_.size()); ++i) {
    int& nearest = nearest_[kept_[i].state];
    if (nearest < 0 || kept_[i].lower_bound < kept_[nearest].lower_bound) nearest = i;
  }
}

/// Bounds the pieces of the kept pairs for which isWanted() is true.
template <typename IsWanted>
void NearestPairs::boundPieces(const IsWanted& isWanted) {
  asked_.clear();
  for (int i = 0; i < static_cast<int>(kept_.size()); ++i) {
    if (!asked_.empty() && kept_[i].pair != kept_[asked_.front()].pair) boundAsked();
    if (isWanted(kept_[i])) asked_.push_back(i);
  }
  boundAsked();
}

/// Bounds the pieces of asked_, which are of the same pair, and forgets them.
void NearestPairs::boundAsked() {
  if (asked_.empty()) return;
  const int pair = kept_[asked_.front()].pair;
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const Kept& kept = kept_[asked_[i]];
    near_[i] = kept.state;
    lower_[i] = kept.lower_bound;
    upper_[i] = kept.upper_bound;
    limits_of_asked_[i] = limits_[kept.state] - accuracy_;
  }
  lanes_->boundPieces(pair, near_.data(), static_cast<int>(asked_.size()), limits_of_asked_.data(), accuracy_,
                      lower_.data(), upper_.data());
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    Kept& kept = kept_[asked_[i]];
    kept.lower_bound = lower_[i];
    kept.upper_bound = upper_[i];
    lowerLimit(kept);
  }
  asked_.clear();
}

// --- one state

/// [m] A pair that is proven to be farther than this is not among the closest, and not in the answer of a new Scene.
double NearestPairs::limit() const {
  const double kth = found_.size() < k_ ? kInfinity : found_.first().rank + kSettledFor;
  return std::min(first_limit_, kth);
}

/// Computes the pairs that were found in the last state. Mostly they are again, and give all others a small limit.
void NearestPairs::measureLikely(ExactState& exact) {
  for (const int pair : last_found_) {
    Visit visit = batch_->visits[pair];
    visit.threshold = thresholdOf(pair);
    if (exact.isPlaced(visit)) measure(exact, visit);
  }
}

void NearestPairs::enter(int state) {
  for (const int i : kept_of_[state]) {
    const Kept& kept = kept_[i];
    Visit visit = batch_->visits[kept.pair];
    visit.lower_bound = kept.lower_bound;
    visit.threshold = thresholdOf(kept.pair);
    if (was_found_[kept.pair] || visit.excess() > limit()) continue;
    upper_bounds_[kept.pair] = kept.upper_bound;
    // The boxes of whole links hardly ever improve a bound of the lanes.
    if (kept.lower_bound > -kFloatInfinity) visit.bound = Visit::Bound::Box;
    queue_.push(visit);
  }
}

/// Enters the pairs of a state that the lanes have not bounded.
void NearestPairs::enterOnEdge(ExactState& exact, int state) {
  const double limit_of_all = limit();
  const double* const travel = &travel_[static_cast<std::size_t>(state) * batch_->lanes->links.size()];
  for (OnEdge& on_edge : on_edge_) {
    const double travel_of_both = travel[on_edge.a] + travel[on_edge.b];
    const double limit_of_pair = limit_of_all + thresholds_[on_edge.pair];
    if (on_edge.lower_bound - travel_of_both > limit_of_pair || was_found_[on_edge.pair]) continue;
    Visit visit = batch_->visits[on_edge.pair];
    visit.threshold = thresholds_[on_edge.pair];
    visit.lower_bound = lanes_->ballGap(on_edge.pair, state);
    if (!(visit.lower_bound > limit_of_pair)) {
      if (!exact.isPlaced(visit)) continue;
      visit = exact.refined(visit, limit_of_pair);
      if (!(visit.lower_bound > limit_of_pair)) queue_.push(visit);
    }
    on_edge.lower_bound = visit.lower_bound + travel_of_both;
  }
}

void NearestPairs::enterObjects(ExactState& exact, int state) {
  if (limit() == kInfinity) first_limit_ = objects_.limitOfClosest(k_, own_thresholds_, state, exact) + kSettledFor;
  const double largest_threshold = own_thresholds_.range(PairKind::WithObject).largest;
  for (Visit visit : objects_.within(limit() + largest_threshold, state, exact)) {
    visit.threshold = thresholdOf(visit.number);
    if (!was_found_[visit.number] && !(visit.excess() > limit())) queue_.push(visit);
  }
}

const std::vector<PairProximity>& NearestPairs::closest(ExactState& exact, int state) {
  measured_.clear();
  found_.clear();
  if (k_ == 0) return sorted();
  first_limit_ = limits_[state];
  queue_.clear();
  std::fill(upper_bounds_.begin(), upper_bounds_.end(), kFloatInfinity);
  if (!exact.isNearLast()) forgetFound();
  measureLikely(exact);
  if (is_on_edge_[state])
    enterOnEdge(exact, state);
  else
    enter(state);
  if (objects_.hasPairs()) enterObjects(exact, state);
  while (!queue_.empty() && !(queue_.lowestBound() > limit()) && !deadline_.hasPassed()) {
    Visit visit = queue_.pop();
    if (!exact.isPlaced(visit)) continue;
    if (visit.bound == Visit::Bound::Sphere) visit = exact.refined(visit, limit() + visit.threshold);
    if (visit.excess() > std::min(queue_.lowestBound(), limit()))
      queue_.push(visit);
    else
      measure(exact, visit);
  }
  keepFound();
  return sorted();
}

void NearestPairs::forgetFound() {
  for (const int pair : last_found_) was_found_[pair] = 0;
  last_found_.clear();
}

/// Keeps the pairs that were found in this state.
void NearestPairs::keepFound() {
  forgetFound();
  for (const Found& found : found_.all()) {
    was_found_[found.pair] = 1;
    last_found_.push_back(found.pair);
    if (found.pair < static_cast<int>(pairs())) ++times_closest_[found.pair];
  }
}

void NearestPairs::measure(ExactState& exact, const Visit& visit) {
  const double upper_bound = static_cast<double>(upper_bounds_[visit.number]) + kSettledFor;
  const double limit_of_pair = std::min(limit() + visit.threshold, upper_bound);
  PairProximity proximity = exact.measure(visit, limit_of_pair + (exact.isNearLast() ? kSpare : 0.0));
  if (proximity.result.lower_bound > limit_of_pair) return exact.keepBound(visit, proximity.result.lower_bound);
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

PairProximity NearestPairs::within(ExactState& exact, int state, double accuracy) {
  if (k_ == 0) return {};
  narrowphase::SignedDistance bounds;
  bounds.lower_bound = kInfinity;
  int pair = -1;
  const auto take = [&](int number, double lower_bound, double upper_bound) {
    bounds.lower_bound = std::min(bounds.lower_bound, lower_bound);
    if (pair >= 0 && !(upper_bound < bounds.upper_bound)) return;
    pair = number;
    bounds.upper_bound = upper_bound;
  };
  const auto isSettled = [&](double lower_bound) {
    return bounds.upper_bound <= 0.0 || lower_bound >= bounds.upper_bound - accuracy;
  };
  const std::vector<int>& of_state = kept_of_[state];
  for (auto i = of_state.rbegin(); i != of_state.rend(); ++i)
    take(kept_[*i].pair, static_cast<double>(kept_[*i].lower_bound), static_cast<double>(kept_[*i].upper_bound));
  if (bounds.upper_bound > 0.0 && (objects_.hasPairs() || !isSettled(bounds.lower_bound))) {
    Question question;
    question.tolerance = accuracy;
    question.depth = Question::Depth::NotWanted;
    first_limit_ = bounds.lower_bound = kInfinity;
    queue_.clear();
    found_.clear();
    forgetFound();
    enter(state);
    first_limit_ = bounds.upper_bound;
    if (objects_.hasPairs()) enterObjects(exact, state);
    while (!queue_.empty() && !isSettled(queue_.lowestBound()) && !deadline_.hasPassed()) {
      const Visit visit = queue_.pop();
      if (!exact.isPlaced(visit)) continue;
      const narrowphase::SignedDistance result = exact.measure(visit, bounds.upper_bound, question).result;
      if (result.status != narrowphase::Status::Unknown) take(visit.number, result.lower_bound, result.upper_bound);
    }
    bounds.lower_bound = std::min(bounds.lower_bound, queue_.lowestBound());
  }
  PairProximity closest;
  if (!(bounds.upper_bound < kInfinity)) return closest;
  // Other pairs may have been left out.
  if (bounds.upper_bound <= 0.0) bounds.lower_bound = objects_.hasPairs() ? -kInfinity : -batch_->deepest;
  bounds.status = narrowphase::Status::Threshold;
  bounds.distance = bounds.upper_bound > 0.0 ? bounds.lower_bound : bounds.upper_bound;
  closest.asked = batch_->pairs[pair];
  closest.result = bounds;
  closest.representation = exact.representationOf(batch_->visits[pair]);
  return closest;
}

const std::vector<PairProximity>& NearestPairs::below(ExactState& exact, int state) {
  measured_.clear();
  found_.clear();
  for (const int i : kept_of_[state]) listIfBelow(exact, kept_[i].pair);
  if (objects_.hasPairs())
    for (const Visit& visit : objects_.within(distance_ + kSettledFor, state, exact)) listIfBelow(exact, visit.number);
  return sorted();
}

void NearestPairs::listIfBelow(ExactState& exact, int pair) {
  Visit visit = batch_->visits[pair];
  if (deadline_.hasPassed() || !exact.isPlaced(visit)) return;
  visit = exact.refined(visit, distance_);
  if (visit.lower_bound > distance_) return;
  const PairProximity proximity = exact.measure(visit, distance_);
  if (proximity.result.lower_bound > distance_)
    exact.keepBound(visit, proximity.result.lower_bound);
  else
    rank(pair, proximity);
}

const std::vector<PairProximity>& NearestPairs::sorted() {
  answers_.clear();
  for (const Found& found : found_.sorted()) answers_.push_back(measured_[found.index]);
  return answers_;
}

}  // namespace proximity_server::scene
