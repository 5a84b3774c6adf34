#include "scene/query/pair_ranking.h"

#include "proximity_server/scene/query/pair_distances.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

/// [m] The value by which the results within the threshold are sorted.
double rankOf(const narrowphase::SignedDistance& result, const Question& question) {
  if (isFinal(result, question)) return -kInfinity;
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// Groups of links are used if there are more candidates than this. Measured on chains of boxes (the minimum in 300
/// states of a slow motion, AMD EPYC, 2026-11): groups are 1.6 times as fast at 528 pairs, 4.1 times at 4,851, and 9.9
/// times at 124,251. Smaller numbers were not measured.
constexpr std::size_t kManyPairs = 500;

/// [m] The most that a pair of a kind adds to the threshold.
double largestThreshold(const Question& question, PairKind kind) {
  return question.thresholds ? question.thresholds->range(kind).largest : 0.0;
}

}  // namespace

PairRanking::Search::Search(const Pairs& of_pairs, std::size_t most, Goal of_search, const Question& asked,
                            const Objects& objects)
    : pairs(of_pairs),
      with_links(pairs.includeLinks()),
      with_objects(pairs.includeObjects(&objects)),
      total((with_links ? pairs.size() : 0) + (with_objects ? static_cast<std::size_t>(objects.pairCount()) : 0)),
      k(std::min(most, total)),
      goal(of_search),
      question(asked),
      of_links(largestThreshold(question, PairKind::OfLinks)),
      with_object(largestThreshold(question, PairKind::WithObject)) {}

PairRanking::PairRanking(const SceneModel& model, Skipping skipping)
    : model_(model), skipping_(skipping), measurement_(model, skipping) {
  for (const int index : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[index];
    candidates_.push_back({{pair.link_a, pair.link_b}, pair.padding});
  }
  if (candidates_.size() > kManyPairs && skipping == Skipping::On) groups_.emplace(model);
}

/// Takes the poses and the objects of a state, unless they are those that were seen last.
void PairRanking::see(const State& state) {
  if (state.revision() == seen_) return;
  state.requireModel(model_);
  measurement_.see(state.placed());
  groups_fit_ = groups_ && groups_->refit(measurement_.robot());
  object_visits_.fit(measurement_.robot());
  seen_ = state.revision();
}

PairProximity PairRanking::one(const State& state, const ShapeRefPair& pair, const Question& question) {
  see(state);
  measurement_.counts() = {};
  return measurement_.settle(pair, question);
}

const std::vector<PairProximity>& PairRanking::all(const State& state, const Pairs& pairs, const Question& question) {
  see(state);
  measurement_.counts() = {};
  results_.clear();
  results_.reserve(pairs.size());
  if (pairs.includeLinks())
    for (const ShapeRefPair& pair : pairs.list()) results_.push_back(measurement_.settle(pair, question));
  if (pairs.includeObjects(&objects()))
    objects().forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) {
      results_.push_back(measurement_.settle({a, b}, question));
    });
  return results_;
}

/// [m] A pair whose distance minus its own threshold is larger than this does not change the answer.
double PairRanking::limit(const Search& search) const {
  if (skipping_ == Skipping::Off || search.goal == Goal::ClosestAndCount || nearest_.size() < search.k)
    return search.question.threshold;
  const bool is_done = search.goal == Goal::Any || nearest_.empty();
  return is_done ? -kInfinity : std::min(search.question.threshold, nearest_.first().rank);
}

// Inline, as visitOf() and enter() are, because a question asks for each of its pairs.
inline PairRanking::QueriedPair PairRanking::inList(int number, const Search& search) const {
  const ShapeRefPair& pair = search.pairs.list()[number];
  return {{measurement_.robot().numberOf(pair.a), measurement_.robot().numberOf(pair.b)}, number};
}

ShapeRefPair PairRanking::refsOf(const QueriedPair& pair, const Search& search) const {
  if (pair.isInList()) return search.pairs.list()[pair.number];
  const PlacedRobot& robot = measurement_.robot();
  return {robot.refOf(std::min(pair.a, pair.b)), robot.refOf(std::max(pair.a, pair.b))};
}

/// The visit of a pair, with the threshold of the pair.
inline std::optional<Visit> PairRanking::visitOf(const QueriedPair& pair, const Search& search) const {
  ShapeRefPair of_parts;
  const ShapeRefPair& refs = pair.isInList() ? search.pairs.list()[pair.number] : (of_parts = refsOf(pair, search));
  std::optional<Visit> visit = measurement_.visitOf(refs, pair, pair.number);
  if (visit && search.question.thresholds) visit->threshold = search.question.thresholds->of(refs);
  return visit;
}

/// Measures a pair, and ranks it if it is one of the nearest so far.
void PairRanking::consider(const Visit& visit, const Search& search) {
  const ShapeRefPair pair = refsOf({visit, visit.number}, search);
  const double limit_of_pair = limit(search) + visit.threshold;
  const PairProximity proximity = measurement_.measure(pair, visit, limit_of_pair, search.question);
  if (proximity.result.status == narrowphase::Status::Unknown || isBeyond(proximity.result, limit_of_pair)) return;
  ++below_;
  nearest_.push({rankOf(proximity.result, search.question) - visit.threshold, visit.number, proximity});
  if (nearest_.size() > search.k) nearest_.pop();
}

/// Step 1 of PairRanking: measures the pairs that were closest the last time, if they still exist and the question is
/// about them.
void PairRanking::considerLikely(const Search& search) {
  const bool is_useless = skipping_ == Skipping::Off || search.k == search.total;
  const auto isForgotten = [&](const QueriedPair& pair) {
    if (!isQueried(pair, search)) return pair.isInList();
    const bool is_there = pair.isInList() ? pair.number < static_cast<int>(search.pairs.size())
                                          : isCheckedPair(measurement_.robot(), pair.a, pair.b);
    return is_useless || !is_there;
  };
  last_nearest_.erase(std::remove_if(last_nearest_.begin(), last_nearest_.end(), isForgotten), last_nearest_.end());
  for (QueriedPair& pair : last_nearest_) {
    if (!isQueried(pair, search)) continue;
    if (pair.isInList()) pair = inList(pair.number, search);  // the list may be a different one now
    const std::optional<Visit> visit = visitOf(pair, search);
    if (!visit)
      measurement_.counts().unknown += pair.isInList();  // enterObjects() counts the others
    else if (visit->excess() > limit(search))
      ++countOf(visit->bound, measurement_.counts());
    else
      consider(*visit, search);
  }
}

/// Step 2 of PairRanking: puts all other pairs that may be close enough into the queue.
void PairRanking::enterOthers(const Search& search) {
  queue_.clear();
  if (search.pairs.areCandidates() && search.pairs.size() != candidates_.size())
    throw std::invalid_argument("the candidates are those of another robot: " + std::to_string(search.pairs.size()) +
                                " pairs, not " + std::to_string(candidates_.size()));
  if (search.pairs.areCandidates() && limit(search) == -kInfinity) return countUnknown(search);
  if (search.with_objects) enterObjects(search);
  if (!search.with_links) return;
  if (groups_fit_ && search.pairs.areCandidates()) return enterBetween(0, 0, search);
  if (skipping_ == Skipping::On && search.pairs.areCandidates()) return enterCandidates(search);
  for (int number = 0; number < static_cast<int>(search.pairs.size()); ++number) enter(inList(number, search), search);
}

/// Puts the candidates into the queue whose spheres are within the limit. Most are not, and no visit is made of them.
void PairRanking::enterCandidates(const Search& search) {
  const PlacedRobot& robot = measurement_.robot();
  const double largest_limit = limit(search) + search.of_links;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate& pair = candidates_[i];
    if (!robot.areFar(pair.a, pair.b, largest_limit + pair.padding)) enter(inList(static_cast<int>(i), search), search);
  }
}

/// Counts the candidates without a distance, as enterOthers() does, where the answer is known already.
void PairRanking::countUnknown(const Search& search) {
  const PlacedRobot& robot = measurement_.robot();
  if (search.with_objects) measurement_.counts().unknown += static_cast<int>(object_visits_.unknownPairs());
  if (!search.with_links || groups_fit_) return;
  for (int number = 0; number < static_cast<int>(search.pairs.size()); ++number) {
    const QueriedPair pair = inList(number, search);
    const bool is_placed = robot.isPlaced(pair.a) && robot.isPlaced(pair.b);
    measurement_.counts().unknown +=
        !is_placed && !std::binary_search(last_nearest_.begin(), last_nearest_.end(), pair);
  }
}

/// Puts the pairs with objects that are in no hierarchy into the queue, and begins the search of the hierarchies.
void PairRanking::enterObjects(const Search& search) {
  const PlacedRobot& robot = measurement_.robot();
  measurement_.counts().unknown += static_cast<int>(object_visits_.unknownPairs());
  const auto enter_pair = [&](int a, int b) { enter({{a, b}, kNotInList}, search); };
  if (skipping_ == Skipping::Off)
    return objects().forEachCheckedPair(
        [&](const ShapeRef& a, const ShapeRef& b) { enter_pair(robot.numberOf(a), robot.numberOf(b)); });
  const bool asks_for_all = search.goal == Goal::ClosestAndCount || search.k == search.total;
  if (asks_for_all && search.question.threshold < kInfinity)
    object_visits_.enterAllWithin(robot, search.question.threshold + search.with_object, enter_pair);
  else
    object_visits_.begin(robot, enter_pair);
}

/// Opens the hierarchy of objects while it may hold the pair with the smallest bound.
void PairRanking::openNearby(const Search& search) {
  while (!object_visits_.empty() &&
         !(object_visits_.lowestBound() > std::min(queue_.lowestBound(), limit(search)) + search.with_object))
    object_visits_.open(measurement_.robot(), limit(search) + search.with_object, [&](int a, int b) {
      enter({{a, b}, kNotInList}, search);
    });
}

inline void PairRanking::enter(const QueriedPair& pair, const Search& search) {
  if (std::binary_search(last_nearest_.begin(), last_nearest_.end(), pair)) return;
  const std::optional<Visit> visit = visitOf(pair, search);
  if (!visit)
    measurement_.counts().unknown += pair.isInList();  // enterObjects() counts the others
  else if (!(visit->excess() > limit(search)))
    queue_.push(*visit);
}

/// Puts the candidate pairs between the links of two groups into the queue, unless the bound of the groups excludes
/// them. Divides the larger group until both are single links.
void PairRanking::enterBetween(int group_a, int group_b, const Search& search) {
  const BoxTree::Node &a = groups_->tree()[group_a], &b = groups_->tree()[group_b];
  if (group_a == group_b) {
    if (a.isLeaf()) return;
    enterBetween(a.parts[0], a.parts[0], search);
    enterBetween(a.parts[1], a.parts[1], search);
    enterBetween(a.parts[0], a.parts[1], search);
  } else if (groups_->gap(group_a, group_b) > limit(search) + search.of_links) {
    return;
  } else if (a.isLeaf() && b.isLeaf()) {
    const int number = groups_->candidate(a.item, b.item);
    if (number >= 0) enter(inList(number, search), search);
  } else if (b.isLeaf() || (!a.isLeaf() && a.box.volume() >= b.box.volume())) {
    for (const int part : a.parts) enterBetween(part, group_b, search);
  } else {
    for (const int part : b.parts) enterBetween(group_a, part, search);
  }
}

/// True if a pair is farther apart than the wanted pairs, and its kept answer proves that it is not beyond the
/// threshold. Then the pair is counted without being measured.
bool PairRanking::needsOnlyCounting(const Visit& visit, const Search& search) const {
  if (search.goal != Goal::ClosestAndCount || nearest_.size() < search.k) return false;
  // If the depth is not wanted, all overlaps count as equally close.
  if (!nearest_.empty() && !(std::isfinite(nearest_.first().rank) && visit.excess() > nearest_.first().rank))
    return false;
  return measurement_.isStillWithin(visit, search.question.threshold + visit.threshold);
}

void PairRanking::visitBestFirst(const Search& search) {
  while (true) {
    if (search.with_objects) openNearby(search);
    if (queue_.empty() || queue_.lowestBound() > limit(search)) return;
    Visit visit = queue_.pop();
    if (visit.bound == Visit::Bound::Sphere) visit = measurement_.refined(visit, limit(search) + visit.threshold);
    if (visit.excess() > std::min(queue_.lowestBound(), limit(search))) {
      queue_.push(visit);
    } else if (needsOnlyCounting(visit, search)) {
      ++countOf(visit.bound, measurement_.counts());
      ++below_;
    } else {
      consider(visit, search);
    }
  }
}

/// Completes the counts: bounds settled the pairs that are still in the queue, and the pairs that never entered it.
void PairRanking::countTheRest(const Search& search) {
  PairCounts& counts = measurement_.counts();
  counts.total = static_cast<int>(search.total);
  for (const Visit& visit : queue_.all()) {
    counts.at_rest += visit.bound == Visit::Bound::Rest;
    counts.by_motion += visit.bound == Visit::Bound::Motion;
  }
  counts.by_bounds = counts.total - counts.unknown - counts.at_rest - counts.by_motion - counts.computed;
}

/// Keeps the nearest pairs for the next question. After a question about links alone, the pairs with objects of the
/// question before are kept too.
void PairRanking::keepLikely(const Search& search) {
  const auto isReplaced = [&](const QueriedPair& pair) { return isQueried(pair, search); };
  last_nearest_.erase(std::remove_if(last_nearest_.begin(), last_nearest_.end(), isReplaced), last_nearest_.end());
  const PlacedRobot& robot = measurement_.robot();
  for (const Ranked& ranked : nearest_.all()) {
    const ShapeRefPair& refs = ranked.proximity.asked;
    last_nearest_.push_back({{robot.numberOf(refs.a), robot.numberOf(refs.b)}, ranked.number});
  }
  std::sort(last_nearest_.begin(), last_nearest_.end());
}

const std::vector<PairProximity>& PairRanking::closest(const State& state, const Pairs& pairs, std::size_t k, Goal goal,
                                                       const Question& question) {
  see(state);
  const Search search(pairs, k, goal, question, objects());
  measurement_.counts() = {};
  below_ = 0;
  nearest_.clear();
  queue_.reserve(pairs.size());
  // It is not known how many pairs with objects will be near.
  const std::size_t expected = std::min(search.k, pairs.size());
  nearest_.reserve(expected + 1);
  last_nearest_.reserve(2 * expected);
  results_.reserve(expected);
  considerLikely(search);
  enterOthers(search);
  visitBestFirst(search);
  countTheRest(search);

  keepLikely(search);
  results_.clear();
  for (const Ranked& ranked : nearest_.sorted()) results_.push_back(ranked.proximity);
  return results_;
}

}  // namespace proximity_server::scene
