#include "scene/batch/verdicts.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace proximity_server::scene {

using Kind = StateVerdict::Kind;

Verdicts::Verdicts(std::shared_ptr<const BatchModel> batch)
    : batch_(std::move(batch)),
      lanes_(batch_->lanes),
      exact_(batch_),
      objects_(batch_),
      open_(LaneBounds::kBlock),
      near_(LaneBounds::kBlock),
      leftovers_(LaneBounds::kBlock) {
  for (std::vector<int>& pairs : leftovers_) pairs.reserve(batch_->candidates.size());
}

const std::vector<StateVerdict>& Verdicts::anyBelow(const States& states, double distance, const Deadline& deadline) {
  deadline_ = deadline;
  verdicts_.assign(static_cast<std::size_t>(states.rows()), {});
  for (Eigen::Index first = 0; first < states.rows() && !deadline.hasPassed(); first += LaneBounds::kBlock) {
    const States block = states.middleRows(first, std::min<Eigen::Index>(LaneBounds::kBlock, states.rows() - first));
    block_ = verdicts_.data() + first;
    lanes_.place(block);
    decideInLanes(distance);
    decideExactly(block, distance);
    if (objects_.hasPairs()) decideObjects(block, distance);
    if (!deadline.hasPassed()) continue;
    const auto isAbove = [](const StateVerdict& verdict) { return verdict.kind == Kind::Above; };
    std::replace_if(block_, block_ + lanes_.count(), isAbove, StateVerdict());  // a pair may have been left out
  }
  return verdicts_;
}

/// Decides the states in which a pair is below, and collects the leftovers of the other states.
void Verdicts::decideInLanes(double distance) {
  for (std::vector<int>& pairs : leftovers_) pairs.clear();
  int open = 0;
  for (int i = 0; i < lanes_.count(); ++i)
    if (lanes_.isPlaced(i)) open_[open++] = i;
  for (const int pair : batch_->order) {
    std::copy_n(open_.begin(), open, near_.begin());
    const int near = lanes_.keepNear(pair, distance, near_.data(), open);
    if (near == 0) continue;
    const std::vector<LaneBounds::Side>& sides = lanes_.sides(pair, distance, near_.data(), near);
    bool is_finished = false;
    for (int i = 0; i < near; ++i) {
      const int state = near_[i];
      if (sides[i] == LaneBounds::Side::Below) {
        block_[state] = {Kind::Below, pair};
        is_finished = true;
      } else if (sides[i] == LaneBounds::Side::Unknown) {
        leftovers_[state].push_back(pair);
      }
    }
    if (!is_finished) continue;
    const auto end = std::remove_if(open_.begin(), open_.begin() + open,
                                    [&](int state) { return block_[state].kind == Kind::Below; });
    open = static_cast<int>(end - open_.begin());
  }
}

/// Decides the leftovers, and all pairs of the states that the lanes could not place.
void Verdicts::decideExactly(const States& block, double distance) {
  for (int i = 0; i < lanes_.count() && !deadline_.hasPassed(); ++i) {
    StateVerdict& verdict = block_[i];
    if (verdict.kind == Kind::Below) continue;
    const bool is_in_lanes = lanes_.isPlaced(i);
    if (!is_in_lanes && !block.row(i).allFinite()) continue;
    exact_.place(block, i);
    if (!is_in_lanes && !exact_.isPlaced()) continue;
    verdict.kind = Kind::Above;
    for (const int pair : is_in_lanes ? leftovers_[i] : batch_->order) {
      if (deadline_.hasPassed()) break;
      if (!exact_.isBelow(pair, distance)) continue;
      verdict = {Kind::Below, pair};
      break;
    }
  }
}

/// Decides the states in which no pair of links is below.
void Verdicts::decideObjects(const States& block, double distance) {
  objects_.place(lanes_);
  for (int i = 0; i < lanes_.count() && !deadline_.hasPassed(); ++i) {
    if (block_[i].kind != Kind::Above) continue;
    exact_.place(block, i);
    block_[i] = verdictOfObjects(i, distance);
  }
}

/// Above or Below, by the pairs with objects in a state that is placed in exact_.
StateVerdict Verdicts::verdictOfObjects(int state, double distance) {
  queue_.clear();
  for (const Visit& visit : objects_.within(distance + kSettledFor, state, exact_)) queue_.push(visit);
  while (!queue_.empty() && !deadline_.hasPassed()) {
    Visit visit = queue_.pop();
    if (visit.bound == Visit::Bound::Sphere) {
      const std::optional<Visit> bounded = exact_.boundedWithin(visit.number, distance);
      if (!bounded) continue;
      visit = *bounded;
      visit.bound = Visit::Bound::Box;
    }
    if (visit.lower_bound > queue_.lowestBound())
      queue_.push(visit);
    else if (exact_.isBelow(visit, distance))
      return {Kind::Below, visit.number};
  }
  return {Kind::Above};
}

}  // namespace proximity_server::scene
