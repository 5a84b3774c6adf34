#include "scene/query/pair_ranking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "proximity_server/scene/query/pair_distances.h"
#include "scene/model/infinity.h"

namespace proximity_server::scene {
namespace {

/// [m] The value by which results that are not beyond the threshold are sorted.
double rankOf(const narrowphase::SignedDistance& result, const Question& question) {
  if (isFinal(result, question)) return -kInfinity;
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// Groups of links are used for more candidates than this. Measured on chains of boxes (the minimum in 300 states of a
/// slow motion, AMD EPYC, 2026-11): groups are 1.6 times as fast at 528 pairs, 4.1 times at 4,851, and 9.9 times at
/// 124,251. Smaller numbers were not measured.
constexpr std::size_t kManyPairs = 500;

}  // namespace

PairRanking::PairRanking(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping)
    : skipping_(skipping),
      candidate_count_(model.pairs.checked.size()),
      measurement_(model, std::move(volumes), skipping) {
  if (candidate_count_ > kManyPairs && skipping == Skipping::On) groups_.emplace(model);
}

void PairRanking::use(std::shared_ptr<const Objects> objects) {
  measurement_.use(objects);
  objects_ = std::move(objects);
  object_visits_.fit(measurement_.robot());
}

void PairRanking::update(const BodyPoses& poses) {
  measurement_.update(poses);
  groups_fit_ = groups_ && groups_->refit(measurement_.robot());
  if (!objects_) return;
  measurement_.forgetFrames();
  object_visits_.fit(measurement_.robot());
}

void PairRanking::update(const BodyPoses& poses, const std::vector<std::optional<Eigen::Isometry3d>>& frames) {
  measurement_.robot().requireFrames(frames.size());
  measurement_.update(poses);
  groups_fit_ = groups_ && groups_->refit(measurement_.robot());
  measurement_.updateFrames(frames);
  object_visits_.fit(measurement_.robot());
}

PairProximity PairRanking::one(const ShapeRefPair& pair, const Question& question) {
  measurement_.counts() = {};
  return measurement_.settle(pair, question);
}

const std::vector<PairProximity>& PairRanking::all(const Pairs& pairs, const Question& question) {
  measurement_.counts() = {};
  results_.clear();
  results_.reserve(pairs.size());
  if (asksForLinks(pairs))
    for (const ShapeRefPair& pair : pairs.list()) results_.push_back(measurement_.settle(pair, question));
  if (asksForObjects(pairs)) {
    forEachObjectPair(measurement_.robot(),
                      [&](int a, int b) { results_.push_back(measurement_.settle(pairOf(a, b), question)); });
  }
  return results_;
}

ShapeRefPair PairRanking::pairOf(int root_a, int root_b) const {
  const auto refOf = [first = measurement_.robot().firstObject()](int root) {
    return root < first ? ShapeRef{root} : ShapeRef::ofObject(root - first);
  };
  return {refOf(std::min(root_a, root_b)), refOf(std::max(root_a, root_b))};
}

/// [m] A pair whose distance less its own threshold is larger does not change the answer.
double PairRanking::limit(const Search& search) const {
  if (skipping_ == Skipping::Off || search.goal == Goal::ClosestAndCount || nearest_.size() < search.k)
    return search.question.threshold;
  const bool is_done = search.goal == Goal::Any || nearest_.empty();
  return is_done ? -kInfinity : std::min(search.question.threshold, nearest_.front().rank);
}

/// A pair of the list, with its threshold.
std::optional<Visit> PairRanking::visitOf(int number, const Search& search) const {
  const ShapeRefPair& pair = search.pairs.list()[static_cast<std::size_t>(number)];
  std::optional<Visit> visit = measurement_.visitOf(pair, number);
  if (visit && search.question.thresholds) visit->threshold = search.question.thresholds->of(pair);
  return visit;
}

/// The same of a pair with an object.
std::optional<Visit> PairRanking::objectVisitOf(int a, int b, const Search& search) const {
  std::optional<Visit> visit = measurement_.objectVisitOf(a, b, kObjectPair);
  if (visit && search.question.thresholds) visit->threshold = search.question.thresholds->of(pairOf(a, b));
  return visit;
}

/// Measures a pair, and ranks it if it is among the nearest so far.
void PairRanking::consider(const Visit& visit, const Search& search) {
  const ShapeRefPair pair = visit.number == kObjectPair ? pairOf(visit.a, visit.b)
                                                        : search.pairs.list()[static_cast<std::size_t>(visit.number)];
  const double limit_of_pair = limit(search) + visit.threshold;
  const PairProximity proximity = measurement_.measure(pair, visit, limit_of_pair, search.question);
  if (proximity.result.status == narrowphase::Status::Unknown || isBeyond(proximity.result, limit_of_pair)) return;
  ++below_;
  nearest_.push_back({rankOf(proximity.result, search.question) - visit.threshold, visit.number, proximity});
  std::push_heap(nearest_.begin(), nearest_.end());
  if (nearest_.size() <= search.k) return;
  std::pop_heap(nearest_.begin(), nearest_.end());
  nearest_.pop_back();
}

/// Measures the pairs that were closest the last time, see step 1 of PairRanking.
void PairRanking::considerLikely(const Search& search) {
  if (skipping_ == Skipping::Off || search.k == search.total || !search.with_links) likely_.clear();
  const auto known = [&](int number) { return number < static_cast<int>(search.pairs.size()); };
  likely_.erase(std::find_if_not(likely_.begin(), likely_.end(), known), likely_.end());
  for (const int number : likely_) {
    const std::optional<Visit> visit = visitOf(number, search);
    if (!visit)
      ++measurement_.counts().unknown;
    else if (visit->excess() > limit(search))
      ++countOf(visit->bound, measurement_.counts());
    else
      consider(*visit, search);
  }
}

/// The same of the pairs with objects, as far as they are still checked.
void PairRanking::considerLikelyObjects(const Search& search) {
  const PlacedRobot& robot = measurement_.robot();
  const auto isOther = [&](const std::pair<int, int>& roots) {
    return !isCheckedPair(robot, roots.first, roots.second);
  };
  likely_objects_.erase(std::remove_if(likely_objects_.begin(), likely_objects_.end(), isOther), likely_objects_.end());
  if (skipping_ == Skipping::Off || search.k == search.total) likely_objects_.clear();
  for (const auto& [a, b] : likely_objects_) {
    const std::optional<Visit> visit = objectVisitOf(a, b, search);
    if (!visit) continue;  // counted by enterObjects()
    if (visit->excess() > limit(search))
      ++countOf(visit->bound, measurement_.counts());
    else
      consider(*visit, search);
  }
}

/// Puts all other pairs that may be close enough into the queue.
void PairRanking::enterOthers(const Search& search) {
  queue_.clear();
  if (search.pairs.areCandidates() && search.pairs.size() != candidate_count_)
    throw std::invalid_argument("the candidates are those of another robot: " + std::to_string(search.pairs.size()) +
                                " pairs, not " + std::to_string(candidate_count_));
  if (search.with_objects) enterObjects(search);
  if (!search.with_links) return;
  if (groups_fit_ && search.pairs.areCandidates()) return enterBetween(0, 0, search);
  for (int number = 0; number < static_cast<int>(search.pairs.size()); ++number) enter(number, search);
}

/// Puts the pairs with objects into the queue that are in no hierarchy, and begins the walk of the others.
void PairRanking::enterObjects(const Search& search) {
  const PlacedRobot& robot = measurement_.robot();
  measurement_.counts().unknown += static_cast<int>(object_visits_.unknownPairs());
  const auto enter = [&](int a, int b) { enterObject(a, b, search); };
  if (skipping_ == Skipping::Off) return forEachObjectPair(robot, enter);
  const bool asks_for_all = search.goal == Goal::ClosestAndCount || search.k == search.total;
  if (asks_for_all && search.question.threshold < kInfinity)
    object_visits_.enterAllWithin(robot, search.question.threshold + search.with_object, enter);
  else
    object_visits_.begin(robot, limit(search) + search.with_object, enter);
}

/// Opens the hierarchy of objects where it may hold the pair with the smallest bound.
void PairRanking::openNearby(const Search& search) {
  while (!object_visits_.empty() &&
         !(object_visits_.lowestBound() > std::min(queue_.lowestBound(), limit(search)) + search.with_object))
    object_visits_.open(measurement_.robot(), limit(search) + search.with_object,
                        [&](int a, int b) { enterObject(a, b, search); });
}

void PairRanking::enterObject(int a, int b, const Search& search) {
  if (std::binary_search(likely_objects_.begin(), likely_objects_.end(), std::make_pair(a, b))) return;
  const std::optional<Visit> visit = objectVisitOf(a, b, search);
  if (visit && !(visit->excess() > limit(search))) queue_.push(*visit);
}

void PairRanking::enter(int number, const Search& search) {
  if (std::binary_search(likely_.begin(), likely_.end(), number)) return;
  const std::optional<Visit> visit = visitOf(number, search);
  if (!visit)
    ++measurement_.counts().unknown;
  else if (!(visit->excess() > limit(search)))
    queue_.push(*visit);
}

/// Puts the candidate pairs between the links of two groups into the queue, unless the bound of the groups excludes
/// them. Divides the larger group until both are single links.
void PairRanking::enterBetween(int group_a, int group_b, const Search& search) {
  const LinkGroups::Group &a = (*groups_)[group_a], &b = (*groups_)[group_b];
  if (group_a == group_b) {
    if (a.isLink()) return;
    enterBetween(a.parts[0], a.parts[0], search);
    enterBetween(a.parts[1], a.parts[1], search);
    enterBetween(a.parts[0], a.parts[1], search);
  } else if (groups_->gap(group_a, group_b) > limit(search) + search.of_links) {
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

/// Whether a pair is farther apart than the wanted ones, and its kept answer proves that it is not beyond the
/// threshold: then it need only be counted.
bool PairRanking::needsOnlyCounting(const Visit& visit, const Search& search) const {
  if (search.goal != Goal::ClosestAndCount || nearest_.size() < search.k) return false;
  // If the depth is not wanted, all overlaps are equally close.
  if (!nearest_.empty() && !(std::isfinite(nearest_.front().rank) && visit.excess() > nearest_.front().rank))
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

/// Completes the counts: bounds settled the pairs that are left in the queue, and those that never entered it.
void PairRanking::countTheRest(const Search& search) {
  PairCounts& counts = measurement_.counts();
  counts.total = static_cast<int>(search.total);
  for (const Visit& visit : queue_.remaining()) {
    counts.at_rest += visit.bound == Visit::Bound::Rest;
    counts.by_motion += visit.bound == Visit::Bound::Motion;
  }
  counts.by_bounds = counts.total - counts.unknown - counts.at_rest - counts.by_motion - counts.computed;
}

/// Keeps for the next question which of the nearest pairs are with objects.
void PairRanking::keepLikelyObjects() {
  const Volumes& volumes = measurement_.robot().volumes();
  likely_objects_.clear();
  for (const Ranked& ranked : nearest_) {
    const ShapeRefPair& asked = ranked.proximity.asked;
    if (ranked.number == kObjectPair) likely_objects_.emplace_back(volumes.of(asked.a), volumes.of(asked.b));
  }
  std::sort(likely_objects_.begin(), likely_objects_.end());
}

const std::vector<PairProximity>& PairRanking::closest(const Pairs& pairs, std::size_t k, Goal goal,
                                                       const Question& question) {
  const bool with_links = asksForLinks(pairs), with_objects = asksForObjects(pairs);
  std::size_t total = with_links ? pairs.size() : 0;
  if (with_objects) total += static_cast<std::size_t>(objects_->pairCount());
  const PairDistances* const thresholds = question.thresholds;
  const Search search{pairs,
                      with_links,
                      with_objects,
                      total,
                      std::min(k, total),
                      goal,
                      question,
                      thresholds ? thresholds->range(PairKind::OfLinks).largest : 0.0,
                      thresholds ? thresholds->range(PairKind::WithObject).largest : 0.0};
  measurement_.counts() = {};
  below_ = 0;
  nearest_.clear();
  queue_.reserve(pairs.size());
  // Of pairs with objects nobody knows how many will be near.
  const std::size_t expected = std::min(search.k, pairs.size());
  nearest_.reserve(expected + 1);
  likely_.reserve(expected);
  results_.reserve(expected);
  considerLikely(search);
  if (search.with_objects) considerLikelyObjects(search);
  enterOthers(search);
  visitBestFirst(search);
  countTheRest(search);

  likely_.clear();
  for (const Ranked& ranked : nearest_)
    if (ranked.number != kObjectPair) likely_.push_back(ranked.number);
  std::sort(likely_.begin(), likely_.end());
  if (search.with_objects) keepLikelyObjects();
  std::sort_heap(nearest_.begin(), nearest_.end());
  results_.clear();
  for (const Ranked& ranked : nearest_) results_.push_back(ranked.proximity);
  return results_;
}

}  // namespace proximity_server::scene
