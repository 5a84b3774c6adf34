#include "scene/query/pair_ranking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// [m] the place of a result that is not beyond the threshold among the others.
double rankOf(const narrowphase::SignedDistance& result, const Question& question) {
  if (isFinal(result, question)) return -kInfinity;
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// From this many candidates on, groups of links are used. Measured on chains of boxes (the minimum in 300 states of a
/// slow motion, AMD EPYC, 2026-11): with groups 1.6 times as fast at 528 pairs, 4.1 times at 4,851, 9.9 times at 124,251.
/// Smaller numbers were not measured.
constexpr std::size_t kManyPairs = 500;

}  // namespace

PairRanking::PairRanking(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping)
    : skipping_(skipping),
      candidate_count_(model.pairs.checked.size()),
      measurement_(model, std::move(volumes), skipping) {
  if (candidate_count_ > kManyPairs && skipping == Skipping::On) groups_.emplace(model);
}

void PairRanking::update(const BodyPoses& poses) {
  measurement_.update(poses);
  groups_fit_ = groups_ && groups_->refit(measurement_.robot());
}

PairProximity PairRanking::one(const ShapeRefPair& pair, const Question& question) {
  measurement_.counts() = {};
  return measurement_.settle(pair, question);
}

const std::vector<PairProximity>& PairRanking::all(const Pairs& pairs, const Question& question) {
  measurement_.counts() = {};
  results_.clear();
  results_.reserve(pairs.size());
  for (const ShapeRefPair& pair : pairs.list()) results_.push_back(measurement_.settle(pair, question));
  return results_;
}

/// [m] a pair farther than that changes nothing.
double PairRanking::limit(const Search& search) const {
  if (skipping_ == Skipping::Off || search.goal == Goal::ClosestAndCount || nearest_.size() < search.k)
    return search.question.threshold;
  const bool is_done = search.goal == Goal::Any || nearest_.empty();
  return is_done ? -kInfinity : std::min(search.question.threshold, nearest_.front().rank);
}

/// Measures a pair, and ranks it if it is among the nearest so far.
void PairRanking::consider(const Visit& visit, const Search& search) {
  const ShapeRefPair& pair = search.pairs.list()[visit.number];
  const PairProximity proximity = measurement_.measure(pair, visit, limit(search), search.question);
  if (proximity.result.status == narrowphase::Status::Unknown || isBeyond(proximity.result, limit(search))) return;
  ++below_;
  nearest_.push_back({rankOf(proximity.result, search.question), visit.number, proximity});
  std::push_heap(nearest_.begin(), nearest_.end());
  if (nearest_.size() <= search.k) return;
  std::pop_heap(nearest_.begin(), nearest_.end());
  nearest_.pop_back();
}

/// The pairs that were nearest the last time come first: where little has moved, their distances leave little to do.
void PairRanking::considerLikely(const Search& search) {
  if (skipping_ == Skipping::Off || search.k == search.pairs.size()) likely_.clear();
  const auto known = [&](int number) { return number < static_cast<int>(search.pairs.size()); };
  likely_.erase(std::find_if_not(likely_.begin(), likely_.end(), known), likely_.end());
  for (const int number : likely_) {
    const std::optional<Visit> visit = measurement_.visitOf(search.pairs.list()[number], number);
    if (!visit)
      ++measurement_.counts().unknown;
    else if (visit->lower_bound > limit(search))
      ++countOf(visit->bound, measurement_.counts());
    else
      consider(*visit, search);
  }
}

/// Queues all that may be near.
void PairRanking::enterOthers(const Search& search) {
  queue_.clear();
  if (search.pairs.areCandidates() && search.pairs.size() != candidate_count_)
    throw std::invalid_argument("the candidates are those of another robot: " + std::to_string(search.pairs.size()) +
                                " pairs, not " + std::to_string(candidate_count_));
  if (groups_fit_ && search.pairs.areCandidates()) return enterBetween(0, 0, search);
  for (int number = 0; number < static_cast<int>(search.pairs.size()); ++number) enter(number, search);
}

void PairRanking::enter(int number, const Search& search) {
  if (std::binary_search(likely_.begin(), likely_.end(), number)) return;
  const std::optional<Visit> visit = measurement_.visitOf(search.pairs.list()[number], number);
  if (!visit)
    ++measurement_.counts().unknown;
  else if (!(visit->lower_bound > limit(search)))
    queue_.push(*visit);
}

/// All pairs of a link of one group and a link of the other: the larger group is divided; two links are a pair.
void PairRanking::enterBetween(int group_a, int group_b, const Search& search) {
  const LinkGroups::Group &a = (*groups_)[group_a], &b = (*groups_)[group_b];
  if (group_a == group_b) {
    if (a.isLink()) return;
    enterBetween(a.parts[0], a.parts[0], search);
    enterBetween(a.parts[1], a.parts[1], search);
    enterBetween(a.parts[0], a.parts[1], search);
  } else if (groups_->gap(group_a, group_b) > limit(search)) {
    return;
  } else if (a.isLink() && b.isLink()) {
    const int number = groups_->candidate(a.link, b.link);
    if (number >= 0) enter(number, search);
  } else if (b.isLink() || (!a.isLink() && a.box.volume() >= b.box.volume())) {
    for (const int part : a.parts) enterBetween(part, group_b, search);
  } else {
    for (const int part : b.parts) enterBetween(group_a, part, search);
  }
}

/// Whether a pair is farther than all that are wanted, and by its answer of before, plus the motion since, not beyond
/// the threshold.
bool PairRanking::needsOnlyCounting(const Visit& visit, const Search& search) const {
  if (search.goal != Goal::ClosestAndCount || nearest_.size() < search.k) return false;
  // Overlaps whose depth nobody wants to know are all as near.
  if (!nearest_.empty() && !(std::isfinite(nearest_.front().rank) && visit.lower_bound > nearest_.front().rank))
    return false;
  return measurement_.isStillWithin(visit, search.question.threshold);
}

void PairRanking::visitBestFirst(const Search& search) {
  while (!queue_.empty() && !(queue_.lowestBound() > limit(search))) {
    Visit visit = queue_.pop();
    if (visit.bound == Visit::Bound::Sphere) visit = measurement_.refined(visit, limit(search));
    if (visit.lower_bound > std::min(queue_.lowestBound(), limit(search))) {
      queue_.push(visit);
    } else if (needsOnlyCounting(visit, search)) {
      ++countOf(visit.bound, measurement_.counts());
      ++below_;
    } else {
      consider(visit, search);
    }
  }
}

/// All pairs that were not counted one by one were settled by bounds.
void PairRanking::countTheRest(const Search& search) {
  PairCounts& counts = measurement_.counts();
  counts.total = static_cast<int>(search.pairs.size());
  for (const Visit& visit : queue_.remaining()) {
    counts.at_rest += visit.bound == Visit::Bound::Rest;
    counts.by_motion += visit.bound == Visit::Bound::Motion;
  }
  counts.by_bounds = counts.total - counts.unknown - counts.at_rest - counts.by_motion - counts.computed;
}

const std::vector<PairProximity>& PairRanking::closest(const Pairs& pairs, std::size_t k, Goal goal,
                                                       const Question& question) {
  const Search search{pairs, std::min(k, pairs.size()), goal, question};
  measurement_.counts() = {};
  below_ = 0;
  nearest_.clear();
  queue_.reserve(pairs.size());
  nearest_.reserve(search.k + 1);
  likely_.reserve(search.k);
  results_.reserve(search.k);
  considerLikely(search);
  enterOthers(search);
  visitBestFirst(search);
  countTheRest(search);

  likely_.clear();
  for (const Ranked& ranked : nearest_) likely_.push_back(ranked.number);
  std::sort(likely_.begin(), likely_.end());
  std::sort_heap(nearest_.begin(), nearest_.end());
  results_.clear();
  for (const Ranked& ranked : nearest_) results_.push_back(ranked.proximity);
  return results_;
}

}  // namespace proximity_server::scene
