#include "scene/query/pair_search.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool isLate(const Question& question) {
  using Clock = std::chrono::steady_clock;
  return question.deadline != Clock::time_point::max() && Clock::now() > question.deadline;
}

PairProximity unknown(const ShapeRefPair& pair) {
  PairProximity proximity;
  proximity.asked = pair;
  return proximity;
}

/// [m] the place of a result that is not beyond the threshold among the others.
double rankOf(const narrowphase::SignedDistance& result, const Question& question) {
  if (isFinal(result, question)) return -kInfinity;
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// What is left of a result that proves to be beyond the threshold: the proof.
narrowphase::SignedDistance onlyProof(narrowphase::SignedDistance result) {
  const narrowphase::SignedDistance nothing;
  result.status = narrowphase::Status::Threshold;
  result.distance = result.lower_bound;
  result.point_a = result.point_b = nothing.point_a;
  result.has_points = false;
  return result;
}

/// Fewer candidates than these are quicker looked at one by one.
constexpr std::size_t kManyPairs = 500;

/// Pairs of subjects that are remembered: the candidates, and some that are asked for besides.
std::size_t rememberedPairs(const PairTable& table) {
  return std::clamp<std::size_t>(2 * table.checked.size(), 1u << 8, 1u << 14);
}

}  // namespace

PairSearch::PairSearch(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping)
    : model_(model),
      skipping_(skipping),
      robot_(model.robot, std::move(volumes)),
      pieces_(robot_, model.robot.pieces.size(), skipping),
      kept_(rememberedPairs(model.pairs)) {
  for (const LinkPair& pair : model.pairs.pairs)
    if (pair.padding != 0.0) paddings_.push_back({pair.link_a, pair.link_b, pair.padding});
  for (const int index : model.pairs.checked) {
    const LinkPair& pair = model.pairs.pairs[static_cast<std::size_t>(index)];
    candidates_.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
  if (candidates_.size() > kManyPairs && skipping == Skipping::On) groups_.emplace(model);
}

void PairSearch::update(const BodyPoses& poses) {
  robot_.update(poses);
  groups_fit_ = groups_ && groups_->refit(robot_);
}

double PairSearch::paddingOf(const ShapeRefPair& pair) const {
  if (paddings_.empty()) return 0.0;
  const auto [a, b] = std::minmax(pair.a.link, pair.b.link);
  const auto found = std::lower_bound(paddings_.begin(), paddings_.end(), std::make_pair(a, b),
                                      [](const PairPadding& padding, const std::pair<int, int>& links) {
                                        return std::make_pair(padding.link_a, padding.link_b) < links;
                                      });
  return found != paddings_.end() && found->link_a == a && found->link_b == b ? found->padding : 0.0;
}

/// Nothing where a pose or all geometry is missing. The same numbers come out for a pair asked in the other order.
std::optional<Visit> PairSearch::visitOf(const ShapeRefPair& pair, int number) const {
  const auto [a, b] = std::minmax({robot_.volumes().of(pair.a), robot_.volumes().of(pair.b)});
  if (!robot_.isPlaced(a) || !robot_.isPlaced(b)) return std::nullopt;
  Visit visit{-kInfinity, number, a, b, paddingOf(pair)};
  if (skipping_ == Skipping::On) visit.lower_bound = robot_.sphereGap(a, b) - visit.padding;
  return visit;
}

/// The best bound that costs less than computing, or any that is above the limit.
Visit PairSearch::refined(Visit visit, double limit) {
  visit.bound = Visit::Bound::Box;
  if (skipping_ == Skipping::Off) return visit;
  const RelativePose a_T_b = robot_.relative(visit.a, visit.b);
  if (const KeptAnswer* kept = kept_.find(visit.a, visit.b)) {
    const RelativeMotionBound motion = robot_.relativeMotion(visit.a, visit.b, kept->a_T_b, a_T_b);
    const double bound = kept->proximity.result.lower_bound - motion.distance_change;
    if (bound > visit.lower_bound) {
      visit.lower_bound = bound;
      visit.bound = motion.is_rest ? Visit::Bound::Rest : Visit::Bound::Motion;
    }
  }
  if (!(visit.lower_bound > limit) && robot_.boxesPay(visit.a, visit.b)) {
    const double bound = robot_.boxGap(visit.a, visit.b, a_T_b) - visit.padding;
    if (bound > visit.lower_bound) {
      visit.lower_bound = bound;
      visit.bound = Visit::Bound::Box;
    }
  }
  return visit;
}

/// The answer before anything is computed, where the bound is enough.
PairProximity PairSearch::proof(const Visit& visit) const {
  PairProximity proximity;
  proximity.representation =
      std::max(robot_.volumes()[visit.a].representation, robot_.volumes()[visit.b].representation);
  proximity.result.lower_bound = visit.lower_bound;
  proximity.result = onlyProof(proximity.result);
  return proximity;
}

/// The kept answer, with bounds that allow for the rounding of the poses since.
std::optional<PairProximity> PairSearch::answerAtRest(const Visit& visit, const RelativePose& a_T_b,
                                                      const Question& question) {
  const KeptAnswer* kept = skipping_ == Skipping::On ? kept_.find(visit.a, visit.b) : nullptr;
  if (!kept || kept->proximity.result.status != narrowphase::Status::Converged) return std::nullopt;
  const RelativeMotionBound motion = robot_.relativeMotion(visit.a, visit.b, kept->a_T_b, a_T_b);
  if (!motion.is_rest) return std::nullopt;
  PairProximity proximity = kept->proximity;
  proximity.result.lower_bound -= motion.distance_change;
  proximity.result.upper_bound += motion.distance_change;
  if (proximity.result.upper_bound - proximity.result.lower_bound > question.tolerance) return std::nullopt;
  return proximity;
}

/// Only the proof where all is beyond the limit.
PairProximity PairSearch::compute(const Visit& visit, const RelativePose& a_T_b, double limit,
                                  const Question& question) {
  const KeptAnswer* kept = skipping_ == Skipping::On ? kept_.find(visit.a, visit.b) : nullptr;
  const ClosestPieces closest = pieces_.between(visit, a_T_b, kept ? kept->leaves : LeafPair(), limit, question);
  PairProximity proximity = proof(visit);
  proximity.result = closest.result;
  proximity.result.lower_bound = closest.lower_bound;
  proximity.result.upper_bound = closest.upper_bound;
  if (!closest.empty()) {
    const Volume &a = robot_.volumes()[closest.leaves.a], &b = robot_.volumes()[closest.leaves.b];
    proximity.collision_a = collisionOf(model_.robot, a.piece).number;
    proximity.collision_b = collisionOf(model_.robot, b.piece).number;
    proximity.representation = std::max(a.representation, b.representation);
    const bool too_wide = closest.upper_bound - closest.lower_bound > question.tolerance;
    if (closest.result.status == narrowphase::Status::Converged && too_wide)
      proximity.result.status = closest.lower_bound_status;
  }
  proximity.depth_is_lower_bound =
      closest.result.distance < 0.0 && !(robot_.volumes()[visit.a].isLeaf() && robot_.volumes()[visit.b].isLeaf());
  if (isBeyond(proximity.result, limit)) proximity.result = onlyProof(proximity.result);
  if (skipping_ == Skipping::On) kept_.of(visit.a, visit.b) = {a_T_b, proximity, closest.leaves};
  return proximity;
}

PairProximity PairSearch::asAsked(const ShapeRefPair& pair, const Visit& visit, PairProximity proximity) const {
  proximity.asked = pair;
  proximity.result = robot_.inPosesFrame(visit.a, proximity.result);
  if (robot_.volumes().of(pair.a) == visit.a) return proximity;
  std::swap(proximity.collision_a, proximity.collision_b);
  std::swap(proximity.result.point_a, proximity.result.point_b);
  proximity.result.normal = -proximity.result.normal;
  return proximity;
}

PairProximity PairSearch::measure(const ShapeRefPair& pair, const Visit& visit, double limit,
                                  const Question& question) {
  const RelativePose a_T_b = robot_.relative(visit.a, visit.b);
  if (const auto kept = answerAtRest(visit, a_T_b, question)) {
    ++counts_.at_rest;
    return asAsked(pair, visit, *kept);
  }
  if (isLate(question)) {
    ++counts_.unknown;
    return unknown(pair);
  }
  const PairProximity proximity = compute(visit, a_T_b, limit, question);
  ++(proximity.collision_a > 0 ? counts_.computed : counts_.by_bounds);
  return asAsked(pair, visit, proximity);
}

PairProximity PairSearch::settle(const ShapeRefPair& pair, const Question& question) {
  ++counts_.total;
  std::optional<Visit> visit = visitOf(pair, 0);
  if (!visit) {
    ++counts_.unknown;
    return unknown(pair);
  }
  if (question.threshold < kInfinity && !(visit->lower_bound > question.threshold))
    visit = refined(*visit, question.threshold);
  if (!(visit->lower_bound > question.threshold)) return measure(pair, *visit, question.threshold, question);
  ++countOf(visit->bound);
  return asAsked(pair, *visit, proof(*visit));
}

PairProximity PairSearch::one(const ShapeRefPair& pair, const Question& question) {
  counts_ = {};
  return settle(pair, question);
}

const std::vector<PairProximity>& PairSearch::all(const std::vector<ShapeRefPair>& pairs, const Question& question) {
  counts_ = {};
  results_.clear();
  results_.reserve(pairs.size());
  for (const ShapeRefPair& pair : pairs) results_.push_back(settle(pair, question));
  return results_;
}

int& PairSearch::countOf(Visit::Bound bound) {
  switch (bound) {
    case Visit::Bound::Rest:
      return counts_.at_rest;
    case Visit::Bound::Motion:
      return counts_.by_motion;
    case Visit::Bound::Sphere:
    case Visit::Bound::Box:
      break;
  }
  return counts_.by_bounds;
}

/// [m] a pair farther than that changes nothing.
double PairSearch::limit(const Search& search) const {
  if (skipping_ == Skipping::Off || search.goal == Goal::NearestOfAll || nearest_.size() < search.k)
    return search.question.threshold;
  const bool is_done = search.goal == Goal::Any || nearest_.empty();
  return is_done ? -kInfinity : std::min(search.question.threshold, nearest_.front().rank);
}

/// Measures a pair, and ranks it if it is among the nearest so far.
void PairSearch::consider(const Visit& visit, const Search& search) {
  const ShapeRefPair& pair = search.pairs[static_cast<std::size_t>(visit.number)];
  const PairProximity proximity = measure(pair, visit, limit(search), search.question);
  if (proximity.result.status == narrowphase::Status::Unknown || isBeyond(proximity.result, limit(search))) return;
  ++below_;
  nearest_.push_back({rankOf(proximity.result, search.question), visit.number, proximity});
  std::push_heap(nearest_.begin(), nearest_.end());
  if (nearest_.size() <= search.k) return;
  std::pop_heap(nearest_.begin(), nearest_.end());
  nearest_.pop_back();
}

/// The pairs that were nearest the last time come first: where little has moved, their distances leave little to do.
void PairSearch::considerLikely(const Search& search) {
  if (skipping_ == Skipping::Off || search.k == search.pairs.size()) likely_.clear();
  const auto known = [&](int number) { return number < static_cast<int>(search.pairs.size()); };
  likely_.erase(std::find_if_not(likely_.begin(), likely_.end(), known), likely_.end());
  for (const int number : likely_) {
    const std::optional<Visit> visit = visitOf(search.pairs[static_cast<std::size_t>(number)], number);
    if (!visit)
      ++counts_.unknown;
    else if (visit->lower_bound > limit(search))
      ++countOf(visit->bound);
    else
      consider(*visit, search);
  }
}

/// Queues all that may be near.
void PairSearch::enterOthers(const Search& search) {
  queue_.clear();
  counts_.total = static_cast<int>(search.pairs.size());
  if (groups_fit_ && &search.pairs == &candidates_) return enterBetween(0, 0, search);
  for (int number = 0; number < counts_.total; ++number) enter(number, search);
}

void PairSearch::enter(int number, const Search& search) {
  if (std::binary_search(likely_.begin(), likely_.end(), number)) return;
  const std::optional<Visit> visit = visitOf(search.pairs[static_cast<std::size_t>(number)], number);
  if (!visit)
    ++counts_.unknown;
  else if (!(visit->lower_bound > limit(search)))
    queue_.push(*visit);
}

/// All pairs of a link of one group and a link of the other: the larger group is divided; two links are a pair.
void PairSearch::enterBetween(int group_a, int group_b, const Search& search) {
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
bool PairSearch::needsOnlyCounting(const Visit& visit, const Search& search) const {
  if (search.goal != Goal::NearestOfAll || nearest_.size() < search.k) return false;
  // Overlaps whose depth nobody wants to know are all as near.
  if (!nearest_.empty() && !(std::isfinite(nearest_.front().rank) && visit.lower_bound > nearest_.front().rank))
    return false;
  const KeptAnswer* kept = kept_.find(visit.a, visit.b);
  if (!kept) return false;
  const RelativeMotionBound motion =
      robot_.relativeMotion(visit.a, visit.b, kept->a_T_b, robot_.relative(visit.a, visit.b));
  return kept->proximity.result.upper_bound + motion.distance_change <= search.question.threshold;
}

void PairSearch::visitBestFirst(const Search& search) {
  while (!queue_.empty() && !(queue_.lowestBound() > limit(search))) {
    Visit visit = queue_.pop();
    if (visit.bound == Visit::Bound::Sphere) visit = refined(visit, limit(search));
    if (visit.lower_bound > std::min(queue_.lowestBound(), limit(search))) {
      queue_.push(visit);
    } else if (needsOnlyCounting(visit, search)) {
      ++countOf(visit.bound);
      ++below_;
    } else {
      consider(visit, search);
    }
  }
  for (const Visit& visit : queue_.remaining()) {
    counts_.at_rest += visit.bound == Visit::Bound::Rest;
    counts_.by_motion += visit.bound == Visit::Bound::Motion;
  }
  counts_.by_bounds = counts_.total - counts_.unknown - counts_.at_rest - counts_.by_motion - counts_.computed;
}

const std::vector<PairProximity>& PairSearch::closest(const std::vector<ShapeRefPair>& pairs, std::size_t k, Goal goal,
                                                      const Question& question) {
  const Search search{pairs, std::min(k, pairs.size()), goal, question};
  counts_ = {};
  below_ = 0;
  nearest_.clear();
  queue_.reserve(pairs.size());
  nearest_.reserve(search.k + 1);
  likely_.reserve(search.k);
  results_.reserve(search.k);
  considerLikely(search);
  enterOthers(search);
  visitBestFirst(search);

  likely_.clear();
  for (const Ranked& ranked : nearest_) likely_.push_back(ranked.number);
  std::sort(likely_.begin(), likely_.end());
  std::sort_heap(nearest_.begin(), nearest_.end());
  results_.clear();
  for (const Ranked& ranked : nearest_) results_.push_back(ranked.proximity);
  return results_;
}

}  // namespace proximity_server::scene
