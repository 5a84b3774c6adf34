#include "scene/motion/motion_search.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxLevels = 6;  // of halved intervals; the narrowphase divides shorter ones itself

// The same where nothing divides shorter ones: of a motion of a metre the shortest are 1e-7 m. Each keeps the poses of the
// robot, about 10 kB, for a time of its own.
constexpr int kMaxInteriorLevels = 23;
constexpr int kMaxInteriorIntervals = 1000;

using Clock = std::chrono::steady_clock;

bool isOver(const MotionQuestion& question) {
  return question.deadline != Clock::time_point::max() && Clock::now() > question.deadline;
}

/// The less complete of two statuses: the one that stands later in the enumeration.
narrowphase::Status lessComplete(narrowphase::Status p, narrowphase::Status q) { return std::max(p, q); }

}  // namespace

void MotionSearch::FirstContactBounds::leaveOpen(double time, narrowphase::Status why) {
  undecided = std::min(undecided, time);
  status = lessComplete(status, why);
}

MotionSearch::MotionSearch(std::shared_ptr<const SceneModel> model, std::shared_ptr<const Volumes> volumes)
    : model_(std::move(model)),
      volumes_(std::move(volumes)),
      paddings_(model_->pairs),
      states_(*model_, volumes_, Skipping::On) {}

const Piece& MotionSearch::pieceOf(int leaf) const { return model_->robot.pieces[at(leaf).piece]; }

void MotionSearch::begin(const Pairs& pairs, const RobotMotion& motion, Order order, MotionCounts& counts) {
  if (motion.segments().size() != model_->robot.bodies.size())
    throw std::invalid_argument("the robot has " + std::to_string(model_->robot.bodies.size()) +
                                " bodies, but the motion is of " + std::to_string(motion.segments().size()));
  order_ = order;
  queue_.clear();
  moving_pairs_.clear();
  poses_.emplace(motion);
  for (const ShapeRefPair& pair : pairs.list()) {
    const int a = volumes_->of(pair.a), b = volumes_->of(pair.b);
    MovingBodies bodies(motion, at(a).body, at(a).bounds, at(b).body, at(b).bounds);
    if (at(a).isEmpty() || at(b).isEmpty() || !bodies.isKnown()) continue;
    moving_pairs_.push_back({pair, paddings_.of(pair), a, b, std::move(bodies)});
  }
  counts.pairs = static_cast<int>(pairs.size());
  counts.unknown = counts.pairs - static_cast<int>(moving_pairs_.size());
}

/// Queues what one bound for the whole motion does not settle, and returns how many pairs it does.
int MotionSearch::enterAll(double limit) {
  for (int i = 0; i < static_cast<int>(moving_pairs_.size()); ++i) {
    const MovingPair& moving = moving_pairs_[i];
    const IntervalVisit visit = withSpheres({-kInfinity, i, moving.a, moving.b, 1, 0.0});
    if (!(visit.lower_bound > limit)) push(visit);
  }
  return static_cast<int>(moving_pairs_.size() - queue_.size());
}

bool MotionSearch::goesLater(const IntervalVisit& p, const IntervalVisit& q) const {
  if (order_ == Order::Earliest) {
    const double of_p = MovingBodies::Interval(p.interval).begin, of_q = MovingBodies::Interval(q.interval).begin;
    if (of_p != of_q) return of_p > of_q;
  }
  return p.lower_bound > q.lower_bound;
}

void MotionSearch::push(const IntervalVisit& visit) {
  queue_.push_back(visit);
  std::push_heap(queue_.begin(), queue_.end(),
                 [this](const IntervalVisit& p, const IntervalVisit& q) { return goesLater(p, q); });
}

MotionSearch::IntervalVisit MotionSearch::pop() {
  std::pop_heap(queue_.begin(), queue_.end(),
                [this](const IntervalVisit& p, const IntervalVisit& q) { return goesLater(p, q); });
  const IntervalVisit first = queue_.back();
  queue_.pop_back();
  return first;
}

MotionSearch::IntervalVisit MotionSearch::withSpheres(IntervalVisit visit) {
  MovingPair& moving = movingPairOf(visit);
  const MovingBodies::SphereGap spheres =
      moving.bodies.sphereGap(at(visit.a).bounds, at(visit.b).bounds, visit.interval, *poses_);
  visit.lower_bound = std::max(visit.lower_bound, spheres.gap - moving.padding);
  visit.travel = spheres.travel;
  return visit;
}

MotionSearch::IntervalVisit MotionSearch::withBoxes(IntervalVisit visit) {
  MovingPair& moving = movingPairOf(visit);
  const double gap = moving.bodies.boxGap(at(visit.a).bounds, at(visit.b).bounds, visit.interval, *poses_);
  visit.lower_bound = std::max(visit.lower_bound, gap - moving.padding);
  return visit;
}

/// Splits the interval if the volumes move farther than they are large, else one of the volumes, see splitsFirst().
void MotionSearch::split(const IntervalVisit& visit, double limit) {
  const Volume &a = at(visit.a), &b = at(visit.b);
  const auto enter = [&](IntervalVisit part) {
    part = withSpheres(part);
    if (!(part.lower_bound > limit)) part = withBoxes(part);
    if (!(part.lower_bound > limit)) push(part);
  };
  const bool split_a = splitsFirst(a, b);
  IntervalVisit part = visit;
  if (visit.travel > (split_a ? a : b).bounds.radius && visit.interval < 1 << kMaxLevels) {
    for (const int half : {2 * visit.interval, 2 * visit.interval + 1}) {
      part.interval = half;
      enter(part);
    }
  } else {
    for (const int volume : split_a ? a.parts : b.parts) {
      (split_a ? part.a : part.b) = volume;
      enter(part);
    }
  }
}

narrowphase::TimeOfContact MotionSearch::contactOf(const IntervalVisit& visit, const MotionQuestion& question,
                                                   double latest) {
  const MovingPair& moving = movingPairOf(visit);
  const MovingBodies::Interval interval(visit.interval);
  const Piece &a = pieceOf(visit.a), &b = pieceOf(visit.b);
  narrowphase::ContactOptions options;
  options.contact_distance = question.contact_distance + moving.padding;
  options.tolerance = question.tolerance;
  options.begin = interval.begin;
  options.end = std::min(interval.end, latest);
  // About a millisecond: longer than that no two pieces hold up a question that has a deadline.
  constexpr int kQueriesBetweenLooksAtTheClock = 256;
  if (question.deadline != Clock::time_point::max()) options.max_queries = kQueriesBetweenLooksAtTheClock;
  return timeOfContact(a.shape, moving.bodies.chainOfA(a.body_T_piece), b.shape, moving.bodies.chainOfB(b.body_T_piece),
                       options);
}

narrowphase::MinimumOverMotion MotionSearch::minimumOf(const IntervalVisit& visit, const MotionQuestion& question,
                                                       double upper_bound) {
  const MovingPair& moving = movingPairOf(visit);
  const MovingBodies::Interval interval(visit.interval);
  const Piece &a = pieceOf(visit.a), &b = pieceOf(visit.b);
  narrowphase::MinimumOptions options;
  options.tolerance = question.tolerance;
  options.begin = interval.begin;
  options.end = interval.end;
  options.stop_above = upper_bound - question.tolerance + moving.padding;
  narrowphase::MinimumOverMotion minimum = minimumDistance(a.shape, moving.bodies.chainOfA(a.body_T_piece), b.shape,
                                                           moving.bodies.chainOfB(b.body_T_piece), options);
  minimum.lower_bound -= moving.padding;
  minimum.upper_bound -= moving.padding;
  return minimum;
}

RobotContact MotionSearch::firstContact(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question) {
  RobotContact answer;
  begin(pairs, motion, Order::Earliest, answer.counts);
  if (moving_pairs_.empty()) return answer;
  answer.counts.by_one_bound = enterAll(question.contact_distance);
  FirstContactBounds bounds;
  considerStart(question, bounds, answer);
  while (!queue_.empty()) {
    const IntervalVisit visit = pop();
    const double time = MovingBodies::Interval(visit.interval).begin;
    if (answer.contact && !(time < bounds.latest)) break;
    ++answer.counts.intervals;
    if (isOver(question)) {
      bounds.leaveOpen(time, narrowphase::Status::IterationLimit);
      break;
    }
    if (isLeaf(visit))
      measure(visit, question, bounds, answer);
    else
      split(visit, question.contact_distance);
  }
  answer.t_free = std::min(bounds.undecided, bounds.latest);
  answer.status = bounds.undecided < bounds.latest ? bounds.status : narrowphase::Status::Converged;
  return answer;
}

/// Finds what is inside a closed mesh at the start. Depths that are reached later are left open.
void MotionSearch::considerStart(const MotionQuestion& question, FirstContactBounds& bounds, RobotContact& answer) {
  bool is_placed = false;
  for (int i = 0; i < static_cast<int>(moving_pairs_.size()) && !answer.contact; ++i) {
    const MovingPair& moving = moving_pairs_[i];
    if (!hasInterior(moving)) continue;
    if (!is_placed) states_.update(poses_->at(0.0));
    is_placed = true;
    const DistanceBounds inside = states_.interiorOf(moving.asked, 0.0);
    const bool may_get_inside = !(withSpheres({-kInfinity, i, moving.a, moving.b, 1, 0.0}).lower_bound > 0.0);
    if (inside.upper <= question.contact_distance + question.tolerance) {
      answer.contact = true;
      answer.t_contact = bounds.latest = 0.0;
      answer.pair = states_.one(moving.asked, {});
    } else if (inside.lower <= question.contact_distance || (question.contact_distance < 0.0 && may_get_inside)) {
      bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
    }
  }
}

/// Measures two pieces: they may be in contact earlier than those before, or leave a contact undecided.
void MotionSearch::measure(const IntervalVisit& visit, const MotionQuestion& question, FirstContactBounds& bounds,
                           RobotContact& answer) {
  const narrowphase::TimeOfContact contact = contactOf(visit, question, bounds.latest);
  answer.counts.queries += contact.queries;
  if (contact.status != narrowphase::Status::Converged) return bounds.leaveOpen(contact.t_free, contact.status);
  if (!contact.contact || (answer.contact && !(contact.t_contact < bounds.latest))) return;
  answer.contact = true;
  answer.t_contact = bounds.latest = contact.t_contact;
  answer.pair = found(visit, contact.at_contact, contact.t_contact);
}

/// Measures a few states of the motion first: their smallest distance is an upper bound, which leaves little to search.
void MotionSearch::considerStates(const Pairs& pairs, RobotMinimum& answer) {
  for (const double time : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    states_.update(poses_->at(time));
    const std::vector<PairProximity>& closest = states_.closest(pairs, 1, PairRanking::Goal::Closest, {});
    if (closest.empty() || !(closest.front().result.upper_bound < answer.upper_bound)) continue;
    answer.upper_bound = closest.front().result.upper_bound;
    answer.time = time;
    answer.pair = closest.front();
  }
}

RobotMinimum MotionSearch::minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question) {
  RobotMinimum answer;
  begin(pairs, motion, Order::Nearest, answer.counts);
  if (moving_pairs_.empty()) return answer;
  considerStates(pairs, answer);
  answer.counts.by_one_bound = enterAll(answer.upper_bound);
  answer.status = narrowphase::Status::Converged;
  double proven = kInfinity;  // [m] the smallest bound of all pieces that were measured
  while (!queue_.empty() && answer.upper_bound - queue_.front().lower_bound > question.tolerance) {
    ++answer.counts.intervals;
    if (isOver(question)) {
      answer.status = narrowphase::Status::IterationLimit;
      break;
    }
    const IntervalVisit visit = pop();
    if (!isLeaf(visit)) {
      split(visit, answer.upper_bound);
      continue;
    }
    const narrowphase::MinimumOverMotion pieces = minimumOf(visit, question, answer.upper_bound);
    answer.counts.queries += pieces.queries;
    proven = std::min(proven, pieces.lower_bound);
    if (pieces.status != narrowphase::Status::Threshold) answer.status = lessComplete(answer.status, pieces.status);
    if (!(pieces.upper_bound < answer.upper_bound)) continue;
    answer.upper_bound = pieces.upper_bound;
    answer.time = pieces.time;
    answer.pair = found(visit, pieces.at_minimum, pieces.time);
  }
  const double open = queue_.empty() ? kInfinity : queue_.front().lower_bound;
  answer.lower_bound = std::min({proven, open, answer.upper_bound});
  if (!(answer.lower_bound > 0.0)) searchInteriors(question, answer);
  return answer;
}

/// Bounds by the interiors of a pair during an interval: by how deep something is in its middle, less the way from there.
MotionSearch::IntervalVisit MotionSearch::withInterior(IntervalVisit visit, RobotMinimum& answer) {
  MovingPair& moving = movingPairOf(visit);
  const MovingBodies::Interval interval(visit.interval);
  const double middle = 0.5 * (interval.begin + interval.end), drift = moving.bodies.driftIn(visit.interval, *poses_);
  states_.update(poses_->at(middle));
  const DistanceBounds inside = states_.interiorOf(moving.asked, drift);
  visit.lower_bound = inside.lower - drift;
  if (inside.upper < answer.upper_bound) {
    answer.pair = states_.one(moving.asked, {});
    answer.upper_bound = std::min(inside.upper, answer.pair.result.upper_bound);
    answer.time = middle;
  }
  return visit;
}

/// Looks for what is deeper in a closed mesh than pieces tell, the deepest first.
void MotionSearch::searchInteriors(const MotionQuestion& question, RobotMinimum& answer) {
  queue_.clear();
  for (int i = 0; i < static_cast<int>(moving_pairs_.size()); ++i)
    if (const MovingPair& moving = moving_pairs_[i]; hasInterior(moving))
      push(withInterior({-kInfinity, i, moving.a, moving.b, 1, 0.0}, answer));
  double proven = kInfinity;  // [m] the smallest bound of the intervals that are not divided further
  for (int i = 0; i < kMaxInteriorIntervals && !queue_.empty() && !isOver(question); ++i) {
    if (!(answer.upper_bound - queue_.front().lower_bound > question.tolerance)) break;
    const IntervalVisit visit = pop();
    ++answer.counts.intervals;
    if (visit.interval >= 1 << kMaxInteriorLevels) {
      proven = std::min(proven, visit.lower_bound);
      continue;
    }
    IntervalVisit half = visit;
    for (half.interval = 2 * visit.interval; half.interval <= 2 * visit.interval + 1; ++half.interval)
      push(withInterior(half, answer));
  }
  const double open = queue_.empty() ? kInfinity : queue_.front().lower_bound;
  answer.lower_bound = std::min({answer.lower_bound, proven, open, answer.upper_bound});
  if (answer.upper_bound - answer.lower_bound > question.tolerance)
    answer.status = lessComplete(answer.status, narrowphase::Status::IterationLimit);
}

/// A result of the narrowphase as an answer about links, in the frame of the poses.
PairProximity MotionSearch::found(const IntervalVisit& visit, narrowphase::SignedDistance result, double time) {
  const MovingPair& moving = movingPairOf(visit);
  const Volume &a = at(visit.a), &b = at(visit.b);
  if (const int middle = moving.bodies.middle(); middle >= 0) {
    const Eigen::Isometry3d& pose = *poses_->at(time)[middle];
    result.normal = (pose.linear() * result.normal).normalized();
    result.point_a = pose * result.point_a;
  }
  PairProximity proximity;
  proximity.asked = moving.asked;
  proximity.collision_a = collisionOf(model_->robot, a.piece).number;
  proximity.collision_b = collisionOf(model_->robot, b.piece).number;
  proximity.result = padded(result, moving.padding);
  proximity.representation = std::max(a.representation, b.representation);
  const bool is_compound = !at(moving.a).isLeaf() || !at(moving.b).isLeaf();
  proximity.depth_is_lower_bound = proximity.result.distance < 0.0 && is_compound;
  return proximity;
}

}  // namespace proximity_server::scene
