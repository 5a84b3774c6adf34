#include "proximity_server/scene/scene.h"

#include <algorithm>

#include <optional>

#include "placed_robot.h"
#include "visit_queue.h"

namespace proximity_server {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool isBeyond(const SignedDistance& result, double limit) { return result.lower_bound > limit; }

/// An overlap, which is as close as it gets where nobody asked for its depth.
bool isFinal(const SignedDistance& result, const Question& question) {
  return question.depth == Question::Depth::NotWanted && (result.distance <= 0.0 || result.status == Status::Threshold);
}

/// [m] the place of a result that is not beyond the threshold among the others.
double rankOf(const SignedDistance& result, const Question& question) {
  if (isFinal(result, question)) return -kInfinity;
  return result.status == Status::Converged ? result.distance : result.lower_bound;
}

Options optionsFor(const Question& question, double limit, double padding) {
  Options options;
  options.distance_tolerance = question.tolerance;
  options.stop_above = limit + padding;
  if (question.depth == Question::Depth::NotWanted) options.stop_below = std::min(0.0, question.threshold) + padding;
  return options;
}

/// Both surfaces moved outwards by half of the padding.
SignedDistance padded(SignedDistance result, double padding) {
  result.distance -= padding;
  result.lower_bound -= padding;
  result.upper_bound -= padding;
  result.point_a += 0.5 * padding * result.normal;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

/// What is left of a result that proves to be beyond the threshold: the proof.
SignedDistance onlyProof(SignedDistance result) {
  const SignedDistance nothing;
  result.status = Status::Threshold;
  result.distance = result.lower_bound;
  result.point_a = result.point_b = nothing.point_a;
  result.has_points = false;
  return result;
}

/// The closest of the pairs of pieces that were computed, and what all of them prove together.
struct ClosestPieces {
  int piece_a = -1, piece_b = -1;
  SignedDistance result;
  bool is_beyond = true;                                    ///< the limit
  double lower_bound = kInfinity, upper_bound = kInfinity;  ///< of the closest, whichever it is
  Status lower_bound_status = Status::Threshold;

  bool empty() const { return piece_a < 0; }

  void offer(int a, int b, const SignedDistance& other, double limit) {
    if (other.lower_bound < lower_bound) {
      lower_bound = other.lower_bound;
      lower_bound_status = other.status;
    }
    upper_bound = std::min(upper_bound, other.upper_bound);
    const bool other_is_beyond = isBeyond(other, limit);
    const bool closer = is_beyond == other_is_beyond ? other.distance < result.distance : is_beyond;
    if (!empty() && !closer) return;
    piece_a = a;
    piece_b = b;
    result = other;
    is_beyond = other_is_beyond;
  }

  /// [m] a pair of pieces farther than that changes nothing.
  double limit(double outer_limit, const Question& question) const {
    if (is_beyond) return outer_limit;
    return isFinal(result, question) ? -kInfinity : std::min(outer_limit, result.distance);
  }
};

struct PairPadding {
  int link_a, link_b;  ///< link_a < link_b
  double padding;      ///< [m]
};

/// The pairs of links whose padding is not zero, sorted.
std::vector<PairPadding> pairPaddings(const PairTable& table) {
  std::vector<PairPadding> paddings;
  for (const LinkPair& pair : table.pairs)
    if (pair.padding != 0.0) paddings.push_back({pair.link_a, pair.link_b, pair.padding});
  return paddings;
}

/// The largest number of pairs of pieces that two subjects can have.
std::size_t mostPiecePairs(const PlacedRobot& robot, const RobotModel& model) {
  std::size_t most = 0;
  for (std::size_t link = 0; link < model.links.size(); ++link)
    most = std::max(most, robot.piecesOf(robot.volumeOf({static_cast<int>(link), 0})).size());
  for (const Collision& collision : model.collisions) most = std::max(most, collision.pieces.size());
  return most * most;
}

Visit withBoxes(Visit visit, const PlacedRobot& robot) {
  if (robot.boxesPay(visit.a, visit.b))
    visit.lower_bound = std::max(visit.lower_bound, robot.boxGap(visit.a, visit.b) - visit.padding);
  visit.bound = Visit::Bound::Box;
  return visit;
}

/// Calls measure(visit) for all that are not beyond limit(), the closest first: by spheres, then by boxes.
template <typename Limit, typename Measure>
void visitBestFirst(VisitQueue& queue, const PlacedRobot& robot, const Limit& limit, const Measure& measure) {
  while (!queue.empty() && !(queue.lowestBound() > limit())) {
    const Visit visit = queue.pop();
    const Visit bounded = visit.bound == Visit::Bound::Sphere ? withBoxes(visit, robot) : visit;
    if (bounded.lower_bound > std::min(queue.lowestBound(), limit()))
      queue.push(bounded);
    else
      measure(bounded);
  }
}

}  // namespace

/// The scratch behind a Scene.
class Scene::Search {
 public:
  enum class Goal : unsigned char { Nearest, Any };

  explicit Search(const SceneModel& model)
      : model_(model.robot),
        robot_(model.robot),
        warm_starts_(model.robot.pieces.size()),
        paddings_(pairPaddings(model.pairs)) {
    pieces_.reserve(mostPiecePairs(robot_, model.robot));
  }

  void update(const BodyPoses& poses) { robot_.update(poses); }
  const PairCounts& counts() const { return counts_; }

  PairProximity one(const SubjectPair& pair, const Question& question);
  const std::vector<PairProximity>& all(const std::vector<SubjectPair>& pairs, const Question& question);
  const std::vector<PairProximity>& closest(const std::vector<SubjectPair>& pairs, std::size_t k, Goal goal,
                                            const Question& question);

 private:
  struct Kept {
    double rank;
    int number;
    PairProximity proximity;
    bool operator<(const Kept& other) const { return rank != other.rank ? rank < other.rank : number < other.number; }
  };

  double paddingOf(const SubjectPair& pair) const;
  std::optional<Visit> enter(const SubjectPair& pair, int number) const;
  PairProximity blank(const SubjectPair& pair, const Visit& visit) const;
  PairProximity settle(const SubjectPair& pair, const Question& question);
  PairProximity measure(const SubjectPair& pair, const Visit& visit, double limit, const Question& question);
  ClosestPieces closestPieces(const Visit& visit, double limit, const Question& question);
  void enqueuePieces(const Visit& visit);
  void keep(int number, const PairProximity& proximity, std::size_t k, const Question& question);
  const Collision& collisionOf(int piece) const;

  const RobotModel& model_;
  PlacedRobot robot_;
  WarmStarts warm_starts_;
  std::vector<PairPadding> paddings_;

  VisitQueue pairs_, pieces_;
  std::vector<Kept> kept_;  // a heap, the farthest in front
  std::vector<PairProximity> results_;
  PairCounts counts_;
};

double Scene::Search::paddingOf(const SubjectPair& pair) const {
  const auto [a, b] = std::minmax(pair.a.link, pair.b.link);
  const auto found = std::lower_bound(paddings_.begin(), paddings_.end(), std::make_pair(a, b),
                                      [](const PairPadding& padding, const std::pair<int, int>& links) {
                                        return std::make_pair(padding.link_a, padding.link_b) < links;
                                      });
  return found != paddings_.end() && found->link_a == a && found->link_b == b ? found->padding : 0.0;
}

/// Nothing where a pose or all geometry is missing.
std::optional<Visit> Scene::Search::enter(const SubjectPair& pair, int number) const {
  const int a = robot_.volumeOf(pair.a), b = robot_.volumeOf(pair.b);
  if (!robot_.isPlaced(a) || !robot_.isPlaced(b)) return std::nullopt;
  const double padding = paddingOf(pair);
  return Visit{robot_.sphereGap(a, b) - padding, number, a, b, padding, Visit::Bound::Sphere};
}

const Collision& Scene::Search::collisionOf(int piece) const {
  const int collision = model_.pieces[static_cast<std::size_t>(piece)].collision;
  return model_.collisions[static_cast<std::size_t>(collision)];
}

void Scene::Search::enqueuePieces(const Visit& visit) {
  const std::vector<int>&a = robot_.piecesOf(visit.a), &b = robot_.piecesOf(visit.b);
  pieces_.clear();
  if (a.size() == 1 && b.size() == 1) {
    // The same bounds again would tell nothing new.
    pieces_.push({visit.lower_bound, 0, a.front(), b.front(), visit.padding, Visit::Bound::Box});
    return;
  }
  int number = 0;
  for (const int piece_a : a)
    for (const int piece_b : b)
      pieces_.push({robot_.sphereGap(piece_a, piece_b) - visit.padding, number++, piece_a, piece_b, visit.padding,
                    Visit::Bound::Sphere});
}

ClosestPieces Scene::Search::closestPieces(const Visit& visit, double limit, const Question& question) {
  ClosestPieces closest;
  const auto current_limit = [&] { return closest.limit(limit, question); };
  enqueuePieces(visit);
  visitBestFirst(pieces_, robot_, current_limit, [&](const Visit& pieces) {
    const Options options = optionsFor(question, current_limit(), visit.padding);
    const SignedDistance result = robot_.distance(pieces.a, pieces.b, options, warm_starts_);
    closest.offer(pieces.a, pieces.b, padded(result, visit.padding), limit);
  });
  closest.lower_bound = std::min(closest.lower_bound, pieces_.lowestBound());
  return closest;
}

/// The answer before anything is computed.
PairProximity Scene::Search::blank(const SubjectPair& pair, const Visit& visit) const {
  PairProximity proximity;
  proximity.asked = pair;
  proximity.representation = std::max(robot_.representationOf(visit.a), robot_.representationOf(visit.b));
  return proximity;
}

/// Only the proof where all is beyond the limit.
PairProximity Scene::Search::measure(const SubjectPair& pair, const Visit& visit, double limit,
                                     const Question& question) {
  const ClosestPieces closest = closestPieces(visit, limit, question);
  PairProximity proximity = blank(pair, visit);
  SignedDistance& result = proximity.result = closest.result;
  result.lower_bound = closest.lower_bound;
  result.upper_bound = closest.upper_bound;
  if (!closest.empty()) {
    ++counts_.computed;
    const Collision &a = collisionOf(closest.piece_a), &b = collisionOf(closest.piece_b);
    proximity.collision_a = a.number;
    proximity.collision_b = b.number;
    proximity.representation = std::max(a.representation, b.representation);
    const bool too_wide = result.upper_bound - result.lower_bound > question.tolerance;
    if (result.status == Status::Converged && too_wide) result.status = closest.lower_bound_status;
  }
  if (isBeyond(result, limit)) result = onlyProof(result);
  return proximity;
}

PairProximity Scene::Search::settle(const SubjectPair& pair, const Question& question) {
  ++counts_.total;
  const std::optional<Visit> visit = enter(pair, 0);
  if (!visit) {
    ++counts_.unknown;
    PairProximity unknown;
    unknown.asked = pair;
    return unknown;
  }
  const Visit bounded = question.threshold < kInfinity ? withBoxes(*visit, robot_) : *visit;
  if (!(bounded.lower_bound > question.threshold)) return measure(pair, bounded, question.threshold, question);
  PairProximity beyond = blank(pair, bounded);
  beyond.result.lower_bound = bounded.lower_bound;
  beyond.result = onlyProof(beyond.result);
  return beyond;
}

PairProximity Scene::Search::one(const SubjectPair& pair, const Question& question) {
  counts_ = {};
  const PairProximity proximity = settle(pair, question);
  counts_.by_bounds = counts_.total - counts_.unknown - counts_.computed;
  return proximity;
}

const std::vector<PairProximity>& Scene::Search::all(const std::vector<SubjectPair>& pairs, const Question& question) {
  counts_ = {};
  results_.clear();
  results_.reserve(pairs.size());
  for (const SubjectPair& pair : pairs) results_.push_back(settle(pair, question));
  counts_.by_bounds = counts_.total - counts_.unknown - counts_.computed;
  return results_;
}

void Scene::Search::keep(int number, const PairProximity& proximity, std::size_t k, const Question& question) {
  kept_.push_back({rankOf(proximity.result, question), number, proximity});
  std::push_heap(kept_.begin(), kept_.end());
  if (kept_.size() <= k) return;
  std::pop_heap(kept_.begin(), kept_.end());
  kept_.pop_back();
}

const std::vector<PairProximity>& Scene::Search::closest(const std::vector<SubjectPair>& pairs, std::size_t k,
                                                         Goal goal, const Question& question) {
  counts_ = {};
  pairs_.clear();
  kept_.clear();
  results_.clear();
  k = std::min(k, pairs.size());
  pairs_.reserve(pairs.size());
  kept_.reserve(k + 1);
  results_.reserve(k);

  for (const SubjectPair& pair : pairs) {
    const std::optional<Visit> visit = enter(pair, counts_.total++);
    if (!visit) ++counts_.unknown;
    if (visit && !(visit->lower_bound > question.threshold)) pairs_.push(*visit);
  }
  const auto limit = [&] {
    if (kept_.size() < k) return question.threshold;
    return goal == Goal::Any || kept_.empty() ? -kInfinity : std::min(question.threshold, kept_.front().rank);
  };
  visitBestFirst(pairs_, robot_, limit, [&](const Visit& visit) {
    const PairProximity proximity = measure(pairs[static_cast<std::size_t>(visit.number)], visit, limit(), question);
    if (!isBeyond(proximity.result, limit())) keep(visit.number, proximity, k, question);
  });
  counts_.by_bounds = counts_.total - counts_.unknown - counts_.computed;

  std::sort_heap(kept_.begin(), kept_.end());
  for (const Kept& kept : kept_) results_.push_back(kept.proximity);
  return results_;
}

Scene::Scene(std::shared_ptr<const SceneModel> model, Skipping)
    : model_(std::move(model)), search_(std::make_unique<Search>(*model_)) {
  for (const int index : model_->pairs.checked) {
    const LinkPair& pair = model_->pairs.pairs[static_cast<std::size_t>(index)];
    candidates_.push_back({{pair.link_a, 0}, {pair.link_b, 0}});
  }
}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

void Scene::update(const BodyPoses& poses) { search_->update(poses); }

const PairCounts& Scene::counts() const { return search_->counts(); }

PairProximity Scene::proximity(const SubjectPair& pair, const Question& question) {
  return search_->one(pair, question);
}

const PairProximity* Scene::minimum(const std::vector<SubjectPair>& pairs, const Question& question) {
  const auto& found = search_->closest(pairs, 1, Search::Goal::Nearest, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::closest(const std::vector<SubjectPair>& pairs, int k,
                                                 const Question& question) {
  return search_->closest(pairs, static_cast<std::size_t>(std::max(k, 0)), Search::Goal::Nearest, question);
}

const std::vector<PairProximity>& Scene::below(const std::vector<SubjectPair>& pairs, const Question& question) {
  return search_->closest(pairs, pairs.size(), Search::Goal::Nearest, question);
}

const PairProximity* Scene::first(const std::vector<SubjectPair>& pairs, const Question& question) {
  const auto& found = search_->closest(pairs, 1, Search::Goal::Any, question);
  return found.empty() ? nullptr : &found.front();
}

const std::vector<PairProximity>& Scene::all(const std::vector<SubjectPair>& pairs, const Question& question) {
  return search_->all(pairs, question);
}

}  // namespace proximity_server
