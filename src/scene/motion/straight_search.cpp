#include "scene/motion/straight_search.h"

#include "scene/model/numbers.h"
#include "scene/query/closest_pieces.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr int kMaxLevels = 6;  // levels of halved intervals; the narrowphase divides shorter intervals itself

// Levels of halved intervals in the search of interiors. No other step divides shorter intervals: for a motion of one
// metre the shortest are 1e-7 m long. Each interval keeps the poses of the robot at one time, about 10 kB.
constexpr int kMaxInteriorLevels = 23;
constexpr int kMaxInteriorIntervals = 1000;

// So many pairs with the fixed objects below one node of the tree are listed one by one.
constexpr std::size_t kMaxOpenObjects = 64;

/// Two upper bounds [m] of the distance of the pair are known. The smaller one is also an upper bound of the minimum.
void takeUpperBound(double of_pair, RobotMinimum& answer) {
  double& upper_bound = answer.pair.result.upper_bound;
  answer.upper_bound = upper_bound = std::min(of_pair, upper_bound);
}

/// A pair whose bounds are wider than the tolerance, because of the rounding of its poses, has not converged: marks it
/// as Degenerate.
void leaveOpenIfWide(PairProximity& pair, const MotionQuestion& question) {
  narrowphase::SignedDistance& result = pair.result;
  const double tolerance = narrowphase::usableTolerance(question.tolerance);
  if (result.status == narrowphase::Status::Converged && !(result.upper_bound - result.lower_bound <= tolerance))
    result.status = narrowphase::Status::Degenerate;
}

/// The poses at one time, in the frame of the poses, for a motion in which the pose of the world is not known. Frames
/// in the world have no pose.
RobotMotion::State withoutWorld(const RobotMotion& motion, double time) {
  RobotMotion::State state{motion.at(time), {}};
  for (const RobotMotion::Segment& frame : motion.objectFrames().moving) {
    const bool is_carried = frame.is_known && frame.parent >= 0 && state.bodies[frame.parent];
    state.frames.emplace_back();
    if (is_carried) state.frames.back() = *state.bodies[frame.parent] * frame.motion.at(time);
  }
  return state;
}

}  // namespace

void StraightSearch::TimeOfContactBounds::leaveOpen(double time, narrowphase::Status why) {
  undecided = std::min(undecided, time);
  status = lessComplete(status, why);
}

StraightSearch::StraightSearch(State state)
    : state_(std::move(state)), states_(state_.model(), Skipping::On), pairs_(state_.sharedModel(), state_.volumes()) {
  const Volumes& volumes = *state_.volumes();
  for (int root = 0; root < volumes.rootCount(); ++root) links_have_interiors_ |= volumes[root].has_interior;
  use(state_.objects());
}

std::optional<std::vector<StraightSearch::OpenPair>> StraightSearch::openPairs() {
  if (!are_open_pairs_known_) return std::nullopt;
  std::vector<OpenPair> open;
  int last = -1;  // the number of the last pair in the question
  for (int i = 0; i < pairs_.size(); ++i) {
    const PairInMotion& moving = pairs_[i];
    if (!moving.isOfShapes() || !(moving.is_examined || moving.nearest < kInfinity)) continue;
    const double lower_bound = hasInterior(moving) ? -kInfinity : moving.nearest;
    if (moving.number == last)
      open.back().lower_bound = std::min(open.back().lower_bound, lower_bound);
    else
      open.push_back({moving.asked, lower_bound});
    last = moving.number;
  }
  return open;
}

void StraightSearch::use(std::shared_ptr<const Objects> objects) {
  state_.set(objects);
  objects_have_interiors_ = false;
  for (const int number : objects->numbers())
    objects_have_interiors_ |= objects->placed(number)->geometry->root().has_interior;
  pairs_.use(std::move(objects));
}

/// If the question is about a contact, the earliest interval comes first; otherwise the nearest.
void StraightSearch::begin(const Pairs& pairs, const RobotMotion& motion, const JointDeviations& deviations,
                           const MotionQuestion* contact, MotionCounts& counts, double limit) {
  order_ = contact ? Order::Earliest : Order::Nearest;
  queue_.clear();
  settled_nodes_.clear();
  pairs_.begin(pairs, motion, deviations, contact, limit);
  std::int64_t total = pairs.includeLinks() ? static_cast<std::int64_t>(pairs.size()) : 0;
  std::int64_t unknown = pairs_.unknownOfList();
  if (pairs.includeObjects(objects().get())) {
    total += objects()->pairCount();
    unknown += unknownPairsWithObjects() + pairs_.tooFar();
  }
  constexpr std::int64_t kMost = std::numeric_limits<int>::max();
  counts.pairs = static_cast<int>(std::min(total, kMost));
  counts.unknown = static_cast<int>(std::min({unknown, total, kMost}));
}

/// The number of candidates with objects that have no pose. A frame that has a pose at the beginning has one at all
/// times.
std::int64_t StraightSearch::unknownPairsWithObjects() {
  if (!isInWorld()) return objects()->pairCount() - pairs_.withObjects() - pairs_.tooFar();
  placeStates(0.0);
  return states_.unknownPairsWithObjects(state_);
}

/// Puts all pairs that one bound for the whole motion does not settle into the queue.
void StraightSearch::enterAll(double limit) {
  for (int i = 0; i < pairs_.size(); ++i) {
    const IntervalVisit visit = withSpheres(wholeMotionOf(i));
    if (!isSettled(visit, limit)) push(visit);
  }
}

void StraightSearch::push(IntervalVisit visit) {
  movingPairOf(visit).is_examined = true;
  visit.earliest = order_ == Order::Earliest ? visit.interval.begin : 0.0;
  queue_.push(visit);
}

StraightSearch::IntervalVisit StraightSearch::withSpheres(IntervalVisit visit) {
  PairInMotion& moving = movingPairOf(visit);
  const Bounds& a = moving.a[visit.a].bounds;
  const MovingBodies::SphereGap spheres =
      moving.isOfShapes()
          ? moving.bodies.sphereGap(a, moving.b[visit.b].bounds, visit.interval, pairs_.poses())
          : moving.bodies.sphereGap(a, boundsOf(pairs_.tree()[visit.b].box), visit.interval, pairs_.poses());
  visit.lower_bound = std::max(visit.lower_bound, spheres.gap - moving.loss());
  visit.travel = spheres.travel;
  return visit;
}

StraightSearch::IntervalVisit StraightSearch::withBoxes(IntervalVisit visit) {
  PairInMotion& moving = movingPairOf(visit);
  const Bounds& a = moving.a[visit.a].bounds;
  const double gap =
      moving.isOfShapes()
          ? moving.bodies.boxGap(a, moving.b[visit.b].bounds, visit.interval, pairs_.poses())
          : moving.bodies.boxGap(a, boundsOf(pairs_.tree()[visit.b].box), visit.interval, pairs_.poses());
  visit.lower_bound = std::max(visit.lower_bound, gap - moving.loss());
  return visit;
}

bool StraightSearch::isLeaf(const IntervalVisit& visit) {
  const PairInMotion& moving = movingPairOf(visit);
  return moving.isOfShapes() && moving.a[visit.a].isLeaf() && moving.b[visit.b].isLeaf();
}

/// Puts a visit into the queue if its bounds do not settle it.
void StraightSearch::enter(IntervalVisit visit, double limit) {
  visit = withSpheres(visit);
  if (!isSettled(visit, limit)) visit = withBoxes(visit);
  isSettled(visit, limit) ? settle(visit) : push(visit);
}

/// Takes note of the lower bound of a visit that is not searched further.
void StraightSearch::settle(const IntervalVisit& visit) {
  if (order_ != Order::Nearest) return;
  PairInMotion& moving = movingPairOf(visit);
  if (!moving.isOfShapes()) return settled_nodes_.push_back(visit);
  moving.nearest = std::min(moving.nearest, visit.lower_bound);
}

/// Takes note of all pairs with the fixed objects below a node. False: they are too many.
bool StraightSearch::openObjectsBelow(const IntervalVisit& visit) {
  std::vector<int> nodes{visit.b};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const BoxTree::Node& node = pairs_.tree()[nodes[i]];
    if (nodes.size() > 2 * kMaxOpenObjects) return false;
    if (!node.isLeaf()) {
      nodes.insert(nodes.end(), node.parts.begin(), node.parts.end());
      continue;
    }
    IntervalVisit leaf = visit;
    leaf.pair = pairs_.pairAt(visit.pair, node);
    if (leaf.pair >= 0) settle(leaf);
  }
  return true;
}

/// Takes note of what the search of the minimum has left in the queue.
void StraightSearch::noteQueue(double limit) {
  are_open_pairs_known_ = true;
  for (const IntervalVisit& visit : queue_.all()) settle(visit);
  const std::vector<IntervalVisit> nodes = std::move(settled_nodes_);
  settled_nodes_.clear();
  for (const IntervalVisit& node : nodes)
    if (!(node.lower_bound > limit)) are_open_pairs_known_ &= openObjectsBelow(node);
}

void StraightSearch::enterHalves(const IntervalVisit& visit, double limit) {
  IntervalVisit part = visit;
  for (const MovingBodies::Interval& half : visit.interval.halves()) {
    part.interval = half;
    enter(part, limit);
  }
}

/// Splits the interval if the volumes move farther than their size, otherwise one of the volumes, see splitsFirst().
void StraightSearch::split(const IntervalVisit& visit, double limit) {
  const PairInMotion& moving = movingPairOf(visit);
  if (!moving.isOfShapes()) return splitFixedObjects(visit, limit);
  const Volume &a = moving.a[visit.a], &b = moving.b[visit.b];
  const bool split_a = splitsFirst(a, b);
  if (visit.travel > (split_a ? a : b).bounds.radius && visit.interval.isLongerThan(kMaxLevels))
    return enterHalves(visit, limit);
  IntervalVisit part = visit;
  for (const int volume : split_a ? a.parts : b.parts) {
    (split_a ? part.a : part.b) = volume;
    enter(part, limit);
  }
}

/// Splits a visit of a node of the tree of fixed objects. At a leaf, the search continues with the pair of its object.
void StraightSearch::splitFixedObjects(const IntervalVisit& visit, double limit) {
  const BoxTree::Node& node = pairs_.tree()[visit.b];
  IntervalVisit part = visit;
  if (node.isLeaf()) {
    part.pair = pairs_.pairAt(visit.pair, node);
    if (part.pair < 0) return;
    part.a = movingPairOf(part).a.root;
    part.b = movingPairOf(part).b.root;
    return enter(part, limit);
  }
  if (visit.travel > 0.5 * node.box.diagonal().norm() && visit.interval.isLongerThan(kMaxLevels))
    return enterHalves(visit, limit);
  for (const int next : node.parts) {
    part.b = next;
    enter(part, limit);
  }
}

/// Sets the chains to the motions of two pieces.
void StraightSearch::follow(const PairInMotion& moving, const Piece& a, const Piece& b) {
  const auto fix = [](const narrowphase::MotionChain& body, const Piece& piece, narrowphase::MotionChain& chain) {
    chain = body;
    chain.back() = chain.back() * piece.body_T_piece;
  };
  fix(moving.bodies.chainOfA(), a, chain_a_);
  fix(moving.bodies.chainOfB(), b, chain_b_);
}

narrowphase::TimeOfContact StraightSearch::timeOfContactOf(const IntervalVisit& visit, const MotionQuestion& question,
                                                           double latest) {
  const PairInMotion& moving = movingPairOf(visit);
  const Piece &a = moving.a.pieces[moving.a[visit.a].piece], &b = moving.b.pieces[moving.b[visit.b].piece];
  narrowphase::ContactOptions options;
  options.contact_distance = moving.contact_distance + moving.loss() + moving.error;
  options.tolerance = narrowphase::usableTolerance(question.tolerance - 2.0 * moving.error);
  options.begin = visit.interval.begin;
  options.end = std::min(visit.interval.end, latest);
  options.is_over = [&] { return question.deadline.hasPassed(); };
  follow(moving, a, b);
  return narrowphase::timeOfContact(a.shape, chain_a_, b.shape, chain_b_, options);
}

narrowphase::MinimumOverMotion StraightSearch::minimumOf(const IntervalVisit& visit, const MotionQuestion& question,
                                                         double upper_bound) {
  const PairInMotion& moving = movingPairOf(visit);
  const Piece &a = moving.a.pieces[moving.a[visit.a].piece], &b = moving.b.pieces[moving.b[visit.b].piece];
  narrowphase::MinimumOptions options;
  options.tolerance = narrowphase::usableTolerance(question.tolerance - 2.0 * moving.error);
  options.begin = visit.interval.begin;
  options.end = visit.interval.end;
  options.stop_above = upper_bound - narrowphase::usableTolerance(question.tolerance) + moving.loss() + moving.error;
  follow(moving, a, b);
  narrowphase::MinimumOverMotion minimum = minimumDistance(a.shape, chain_a_, b.shape, chain_b_, options);
  minimum.lower_bound -= moving.loss() + moving.error;
  minimum.upper_bound -= moving.loss() - moving.error;
  return minimum;
}

RobotTimeOfContact StraightSearch::timeOfContact(const Pairs& pairs, const RobotMotion& motion,
                                                 const MotionQuestion& question) {
  return timeOfContact(pairs, motion, {}, question);
}

RobotTimeOfContact StraightSearch::timeOfContact(const Pairs& pairs, const RobotMotion& motion,
                                                 const JointDeviations& deviations, const MotionQuestion& question) {
  RobotTimeOfContact answer;
  begin(pairs, motion, deviations, &question, answer.counts);
  if (answer.counts.unknown == answer.counts.pairs) return answer;
  enterAll(kInfinity);
  TimeOfContactBounds bounds;
  considerStart(pairs, question, bounds, answer);
  while (!queue_.empty()) {
    const IntervalVisit visit = queue_.pop();
    const double time = visit.interval.begin;
    if (answer.contact && !(time < bounds.latest)) break;
    ++answer.counts.intervals;
    if (question.deadline.hasPassed()) {
      bounds.leaveOpen(time, narrowphase::Status::IterationLimit);
      break;
    }
    if (isLeaf(visit))
      measure(visit, question, bounds, answer);
    else
      split(visit, kInfinity);
  }
  if (answer.contact) answer.pair = ofAllPieces(answer.pair, answer.t_contact);
  leaveOpenIfWide(answer.pair, question);
  answer.counts.by_one_bound = answer.counts.pairs - answer.counts.unknown - pairs_.examined();
  answer.t_free = std::min(bounds.undecided, bounds.latest);
  answer.status = bounds.undecided < bounds.latest ? bounds.status : narrowphase::Status::Converged;
  return answer;
}

/// True if an interior matters to the distance of two shapes. The box that stands for a half-space has no interior.
bool StraightSearch::hasInterior(const PairInMotion& moving) {
  return moving.kind == PairInMotion::Kind::Shapes && haveInterior(moving.a, moving.b);
}

/// True if candidates with objects may have an interior.
bool StraightSearch::hasInteriors(const Pairs& pairs) const {
  return pairs.includeObjects(objects().get()) && (links_have_interiors_ || objects_have_interiors_);
}

/// False for an object that does not exist.
bool StraightSearch::hasInterior(const ShapeRef& ref) const {
  if (ref.isObject() && !(objects() && objects()->placed(ref.object()))) return false;
  return state_.volumes()->part(ref, objects().get()).whole().has_interior;
}

/// Finds shapes that are inside a closed mesh at the start. Depths that are reached later are left open.
void StraightSearch::considerStart(const Pairs& pairs, const MotionQuestion& question, TimeOfContactBounds& bounds,
                                   RobotTimeOfContact& answer) {
  for (const PairContactDistance& own : question.nearer_pairs)
    if (own.contact_distance < 0.0 && std::isfinite(own.contact_distance) &&
        (hasInterior(own.pair.a) || hasInterior(own.pair.b)))
      bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
  if (hasInteriors(pairs) && isInWorld()) considerObjectsAtStart(pairs, question, bounds, answer);
  bool is_placed = false;
  for (int i = 0; i < pairs_.size() && !answer.contact; ++i) {
    const PairInMotion& moving = pairs_[i];
    if (!hasInterior(moving)) continue;
    if (question.deadline.hasPassed()) return bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
    if (!is_placed) placeStates(0.0);
    is_placed = true;
    const DistanceBounds inside = states_.interiorOf(state_, moving.asked, 0.0);
    const double rounding = pairs_.roundingOf(moving.asked, 0.0);
    const double contact_distance = moving.contact_distance;
    const bool may_get_inside = !(withSpheres(wholeMotionOf(i)).lower_bound > 0.0);
    if (inside.upper + rounding <= contact_distance + narrowphase::usableTolerance(question.tolerance)) {
      answer.contact = true;
      answer.t_contact = bounds.latest = 0.0;
      answer.pair = inPosesFrame(states_.one(state_, moving.asked, {}), 0.0);
    } else if (inside.lower - rounding <= contact_distance ||
               (contact_distance < 0.0 && std::isfinite(contact_distance) && may_get_inside)) {
      bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
    }
  }
}

/// Like considerStart(), for all candidates with objects at once, because the pairs with fixed objects are not in
/// pairs_ yet.
void StraightSearch::considerObjectsAtStart(const Pairs& pairs, const MotionQuestion& question,
                                            TimeOfContactBounds& bounds, RobotTimeOfContact& answer) {
  placeStates(0.0);
  Question near;
  near.threshold = question.contact_distance + roundingAtStart();
  near.thresholds = question.thresholds;
  near.deadline = question.deadline;
  const double of_objects = question.thresholds ? question.thresholds->range(PairKind::WithObject).smallest : 0.0;
  if (question.contact_distance + of_objects < 0.0) bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
  // Pairs with contact distances of their own may come before the pair in contact.
  for (const PairProximity& found :
       states_.closest(state_, pairs, 1 + question.nearer_pairs.size(), PairRanking::Goal::Closest, near)) {
    const PairProximity pair = inPosesFrame(found, 0.0);
    const double contact_distance = pairs_.contactDistanceOf(pair.asked);
    if (pair.result.lower_bound > contact_distance) continue;
    if (!(pair.result.upper_bound <= contact_distance + narrowphase::usableTolerance(question.tolerance))) {
      bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
      continue;
    }
    answer.contact = true;
    answer.t_contact = bounds.latest = 0.0;
    answer.pair = pair;
    return;
  }
  if (question.deadline.hasPassed()) bounds.leaveOpen(0.0, narrowphase::Status::IterationLimit);
}

/// Measures two pieces. They may be in contact earlier than the contact found before, or leave it undecided whether
/// there is a contact.
void StraightSearch::measure(const IntervalVisit& visit, const MotionQuestion& question, TimeOfContactBounds& bounds,
                             RobotTimeOfContact& answer) {
  const narrowphase::TimeOfContact contact = timeOfContactOf(visit, question, bounds.latest);
  answer.counts.queries += contact.queries;
  if (contact.status != narrowphase::Status::Converged) return bounds.leaveOpen(contact.t_free, contact.status);
  if (!contact.contact || (answer.contact && !(contact.t_contact < bounds.latest))) return;
  answer.contact = true;
  answer.t_contact = bounds.latest = contact.t_contact;
  answer.pair = inPosesFrame(visit, contact.at_contact, contact.t_contact);
}

/// True if there are objects, and the pose of the world is known.
bool StraightSearch::isInWorld() {
  return objects() && !objects()->empty() && pairs_.poses().isKnown(pairs_.poses().world());
}

/// Sets the poses at one time for questions about one state. If there are objects, the poses are in the world. If the
/// pose of the world is not known, questions about objects in the world must not be asked.
void StraightSearch::placeStates(double time) {
  if (!objects() || objects()->empty()) return state_.set(pairs_.poses().at(time));
  const RobotMotion& motion = pairs_.poses().motion();
  const RobotMotion::State state = isInWorld() ? motion.inWorld(time) : withoutWorld(motion, time);
  state.frames.empty() ? state_.set(state.bodies) : state_.set(state.bodies, state.frames);
}

/// Measures a few states of the motion first: their smallest distance is an upper bound, which leaves little to search.
/// Returns false if no state contains all shapes, because the pose of the fixed objects is not known.
bool StraightSearch::considerStates(const Pairs& pairs, const Deadline& deadline, RobotMinimum& answer) {
  if (objects() && !objects()->empty() && !isInWorld()) return false;
  Question question;
  question.deadline = deadline.withoutTime();  // of the first state, so that there is an upper bound
  for (const double time : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    placeStates(time);
    const std::vector<PairProximity>& closest = states_.closest(state_, pairs, 1, PairRanking::Goal::Closest, question);
    question.deadline = deadline;
    if (closest.empty() || !(closest.front().result.upper_bound < answer.upper_bound)) continue;
    answer.pair = inPosesFrame(closest.front(), time);
    answer.upper_bound = answer.pair.result.upper_bound;
    answer.time = time;
  }
  return true;
}

/// [m] What the transform of the poses into the world adds at time 0 to the rounding of any distance.
double StraightSearch::roundingAtStart() {
  double farthest = 0.0;
  for (const std::optional<Eigen::Isometry3d>& pose : pairs_.poses().at(0.0))
    if (pose) farthest = std::max(farthest, pose->translation().norm());
  return kPoseRounding * (pairs_.poses().pose(pairs_.poses().world(), 0.0).translation().norm() + farthest);
}

/// Transforms an answer about the state at one time from the world, if there is one, into the frame of the poses, and
/// widens its bounds by the rounding of the state.
PairProximity StraightSearch::inPosesFrame(const PairProximity& in_world, double time) {
  PairProximity pair = in_world;
  found_pieces_ = false;
  const double rounding = pairs_.roundingOf(pair.asked, time);
  pair.result.lower_bound -= rounding;
  pair.result.upper_bound += rounding;
  const int world = pairs_.poses().world();
  if (world < 0 || !isInWorld()) return pair;
  const Eigen::Isometry3d poses_T_world = pairs_.poses().pose(world, time);
  pair.result.normal = (poses_T_world.linear() * pair.result.normal).normalized();
  pair.result.point_a = poses_T_world * pair.result.point_a;
  pair.result.point_b = poses_T_world * pair.result.point_b;
  return pair;
}

RobotMinimum StraightSearch::minimum(const Pairs& pairs, const RobotMotion& motion, const MotionQuestion& question) {
  RobotMinimum answer;
  begin(pairs, motion, {}, nullptr, answer.counts);
  if (answer.counts.unknown == answer.counts.pairs) return answer;
  searchMinimum(considerStates(pairs, question.deadline, answer) ? States::Seen : States::NotSeen, question, answer);
  return answer;
}

RobotMinimum StraightSearch::minimumBelow(double limit, const Pairs& pairs, const RobotMotion& motion,
                                          const JointDeviations& deviations, const MotionQuestion& question) {
  RobotMinimum answer;
  begin(pairs, motion, deviations, nullptr, answer.counts, limit);
  if (answer.counts.unknown == answer.counts.pairs) return answer;
  answer.upper_bound = answer.pair.result.upper_bound = limit;
  searchMinimum(States::NotSeen, question, answer);
  return answer;
}

std::optional<PairProximity> StraightSearch::closestAtStart(const Pairs& pairs, const RobotMotion& motion,
                                                            const Deadline& deadline) {
  const std::vector<ShapeRefPair> none;
  pairs_.begin(none, motion);
  if (objects() && !objects()->empty() && !isInWorld()) return std::nullopt;
  placeStates(0.0);
  Question question;
  question.deadline = deadline;
  const std::vector<PairProximity>& closest = states_.closest(state_, pairs, 1, PairRanking::Goal::Closest, question);
  if (closest.empty() || closest.front().result.status == narrowphase::Status::Unknown) return std::nullopt;
  return inPosesFrame(closest.front(), 0.0);
}

/// Searches the pairs that can be nearer than the upper bound of the answer.
void StraightSearch::searchMinimum(States at_start, const MotionQuestion& question, RobotMinimum& answer) {
  const double limit = answer.upper_bound;
  enterAll(limit);
  answer.status = narrowphase::Status::Converged;
  const double proven = searchPieces(question, answer);
  answer.counts.by_one_bound = answer.counts.pairs - answer.counts.unknown - pairs_.examined();
  if (answer.time >= 0.0) {
    answer.pair = ofAllPieces(answer.pair, answer.time);
    takeUpperBound(answer.upper_bound, answer);
  }
  const double open = queue_.empty() ? kInfinity : queue_.first().lower_bound;
  answer.lower_bound = std::min({proven, open, answer.upper_bound});
  if (at_start == States::NotSeen) noteQueue(limit);
  // Without the state at the start, what is inside from the start on has not been seen.
  if (at_start == States::NotSeen || !(answer.lower_bound > 0.0)) searchInteriors(question, answer);
  leaveOpenIfWide(answer.pair, question);
}

/// Takes the nearest visits from the queue, and measures their pieces where they cannot be divided. Returns the
/// smallest lower bound [m] of all pieces that it measured.
double StraightSearch::searchPieces(const MotionQuestion& question, RobotMinimum& answer) {
  double proven = kInfinity;
  while (!queue_.empty() &&
         answer.upper_bound - queue_.first().lower_bound > narrowphase::usableTolerance(question.tolerance)) {
    ++answer.counts.intervals;
    if (question.deadline.hasPassed()) {
      answer.status = narrowphase::Status::IterationLimit;
      break;
    }
    const IntervalVisit visit = queue_.pop();
    if (!isLeaf(visit)) {
      split(visit, answer.upper_bound);
      continue;
    }
    const narrowphase::MinimumOverMotion pieces = minimumOf(visit, question, answer.upper_bound);
    answer.counts.queries += pieces.queries;
    proven = std::min(proven, pieces.lower_bound);
    PairInMotion& moving = movingPairOf(visit);
    moving.nearest = std::min(moving.nearest, pieces.lower_bound);
    if (pieces.status != narrowphase::Status::Threshold) answer.status = lessComplete(answer.status, pieces.status);
    if (!(pieces.upper_bound < answer.upper_bound)) continue;
    answer.upper_bound = pieces.upper_bound;
    answer.time = pieces.time;
    answer.pair = inPosesFrame(visit, pieces.at_minimum, pieces.time);
  }
  return proven;
}

/// Bounds a pair with interiors during an interval: the depth in the middle of the interval, minus how far the shapes
/// can move from there.
StraightSearch::IntervalVisit StraightSearch::withInterior(IntervalVisit visit, RobotMinimum& answer) {
  PairInMotion& moving = movingPairOf(visit);
  const double middle = 0.5 * (visit.interval.begin + visit.interval.end),
               rounding = pairs_.roundingOf(moving.asked, middle);
  const MovingBodies::Drift moved = moving.bodies.driftIn(visit.interval, pairs_.poses());
  const double drift = moved.motion + moved.rounding + rounding;
  placeStates(middle);
  const DistanceBounds inside = states_.interiorOf(state_, moving.asked, drift + moving.deviation);
  visit.travel = moved.motion;
  visit.lower_bound = inside.lower - drift - moving.deviation;
  if (const double upper_bound = inside.upper + rounding - moving.deviation; upper_bound < answer.upper_bound) {
    answer.pair = inPosesFrame(states_.one(state_, moving.asked, {}), middle);
    takeUpperBound(upper_bound, answer);
    answer.time = middle;
  }
  return visit;
}

/// True if to divide an interval is vain: the state in its middle alone, by its rounding, leaves more open than the
/// tolerance, so that the bounds cannot come within it, and no less than the motion away from there does.
bool StraightSearch::isVain(const IntervalVisit& visit, double upper_bound, const MotionQuestion& question) {
  const double at_middle = upper_bound - (visit.lower_bound + visit.travel);
  return at_middle > narrowphase::usableTolerance(question.tolerance) && at_middle >= visit.travel;
}

/// Searches for depths in closed meshes that are larger than the depths of the pieces, the deepest first.
void StraightSearch::searchInteriors(const MotionQuestion& question, RobotMinimum& answer) {
  queue_.clear();
  for (int i = 0; i < pairs_.size(); ++i)
    if (hasInterior(pairs_[i]))
      push(question.deadline.hasPassed() ? wholeMotionOf(i) : withInterior(wholeMotionOf(i), answer));
  double proven = kInfinity;  // [m] the smallest lower bound of the intervals that are not divided further
  for (int i = 0; i < kMaxInteriorIntervals && !queue_.empty() && !question.deadline.hasPassed(); ++i) {
    if (!(answer.upper_bound - queue_.first().lower_bound > narrowphase::usableTolerance(question.tolerance))) break;
    const IntervalVisit visit = queue_.pop();
    ++answer.counts.intervals;
    if (isVain(visit, answer.upper_bound, question) || !visit.interval.isLongerThan(kMaxInteriorLevels)) {
      proven = std::min(proven, visit.lower_bound);
      continue;
    }
    IntervalVisit part = visit;
    for (const MovingBodies::Interval& half : visit.interval.halves()) {
      part.interval = half;
      push(withInterior(part, answer));
    }
  }
  const double open = queue_.empty() ? kInfinity : queue_.first().lower_bound;
  answer.lower_bound = std::min({answer.lower_bound, proven, open, answer.upper_bound});
  if (answer.upper_bound - answer.lower_bound > narrowphase::usableTolerance(question.tolerance))
    answer.status = lessComplete(answer.status, narrowphase::Status::IterationLimit);
}

/// Turns a result of the narrowphase into an answer about links and objects, and transforms it from the frame
/// MovingBodies::middle() into the frame of the poses.
PairProximity StraightSearch::inPosesFrame(const IntervalVisit& visit, const narrowphase::SignedDistance& in_middle,
                                           double time) {
  const PairInMotion& moving = movingPairOf(visit);
  const Volume &a = moving.a[visit.a], &b = moving.b[visit.b];
  narrowphase::SignedDistance result = in_middle;
  if (moving.bodies.middle() >= 0) {
    const Eigen::Isometry3d poses_T_middle = pairs_.poses().pose(moving.bodies.middle(), time);
    result.normal = (poses_T_middle.linear() * result.normal).normalized();
    result.point_a = poses_T_middle * result.point_a;
  }
  PairProximity proximity;
  proximity.asked = moving.asked;
  // Not by the parts: the box of a half-space is a part without its object.
  proximity.collision_a = collisionNumber(pairs_.robot(), moving.a.pieces[a.piece], moving.asked.a.isObject());
  proximity.collision_b = collisionNumber(pairs_.robot(), moving.b.pieces[b.piece], moving.asked.b.isObject());
  proximity.result = padded(result, moving.padding);
  proximity.result.lower_bound -= moving.error;
  proximity.result.upper_bound += moving.error;
  proximity.representation = std::max(a.representation, b.representation);
  proximity.depth_is_lower_bound = proximity.result.distance < 0.0 && moving.is_compound;
  found_pieces_ = moving.is_compound || !moving.a.whole().isLeaf() || !moving.b.whole().isLeaf();
  return proximity;
}

/// Widens the bounds of a pair to the bounds of all pieces of its shapes: only two pieces were measured, and others may
/// be nearer.
PairProximity StraightSearch::ofAllPieces(PairProximity pair, double time) {
  if (!found_pieces_) return pair;
  placeStates(time);
  const PairProximity whole = states_.one(state_, pair.asked, {});
  return whole.result.status == narrowphase::Status::Unknown ? pair : inPosesFrame(whole, time);
}

}  // namespace proximity_server::scene
