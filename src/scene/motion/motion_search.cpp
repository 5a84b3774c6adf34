#include "proximity_server/scene/motion/motion_search.h"

#include "scene/model/numbers.h"
#include "scene/motion/joint_deviations.h"
#include "scene/motion/straight_search.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using narrowphase::Status;

// So many parts of a segment are searched, so that a question without a deadline ends. The minimum along segments of
// half a second of the Panda robot took 21 to 93 (19 segments, default tolerance).
constexpr int kMaxParts = 10000;

void add(const MotionCounts& more, MotionCounts& counts) {
  counts.pairs = std::max(counts.pairs, more.pairs);
  counts.unknown = std::max(counts.unknown, more.unknown);
  counts.intervals += more.intervals;
  counts.queries += more.queries;
}

/// A straight motion with the deviations from it, and what they are made of: working memory of SplineSearch.
struct Straight {
  SplineSegment::Chord chord;
  Positions at;
  std::vector<double> before, travel, most;
  std::vector<double> nowhere;  ///< 0 for each joint
  RobotMotion motion;
  JointDeviations deviations;
};

/// Searches the parts of one piece along a spline, at times in [0, 1] of this piece.
class SplineSearch {
 public:
  SplineSearch(const Pairs& pairs, const Motion::Piece& piece, const MotionQuestion& question, StraightSearch& search,
               Straight& straight)
      : pairs_(pairs),
        piece_(piece),
        segment_(*piece.spline),
        question_(question),
        search_(search),
        straight_(straight),
        robot_(search.state().robot()),
        tube_(piece.tracking_error.empty() ? straight.nowhere : piece.tracking_error) {
    const std::size_t joints = robot_.joints.size();
    straight_.nowhere.assign(joints, 0.0);
    if (tube_.size() != joints)
      throw std::invalid_argument("there are " + std::to_string(tube_.size()) + " tracking errors for " +
                                  std::to_string(joints) + " joints");
    for (std::size_t i = 0; i < tube_.size(); ++i)
      if (!(std::isfinite(tube_[i]) && tube_[i] >= 0.0))
        throw std::invalid_argument("the tracking error of joint '" + robot_.joints[i].name +
                                    "' is not a number from 0 on");
    const auto moves = [](const RobotMotion::Segment& frame) { return frame.is_known && !frame.motion.isRest(); };
    const RobotMotion::ObjectFrames& frames = piece.robot.objectFrames();
    if (moves(frames.world) || std::any_of(frames.moving.begin(), frames.moving.end(), moves))
      throw std::invalid_argument("a frame of the objects moves relative to its parent, which a spline does not know");
    has_tube_ = std::any_of(tube_.begin(), tube_.end(), [](double error) { return error > 0.0; });
  }

  RobotMinimum minimum();
  /// `begin`: the time until which the piece is known to be free.
  RobotTimeOfContact timeOfContact(double begin = 0.0);

 private:
  /// The pairs that may have the smallest distance during a part of the segment; nullptr: all.
  using PairList = std::shared_ptr<const std::vector<StraightSearch::OpenPair>>;
  struct Part {
    double begin, end;
    double lower_bound;  ///< [m] of the smallest guaranteed distance
    PairList pairs;
    bool operator<(const Part& other) const { return lower_bound > other.lower_bound; }
  };

  // These return straight_.
  const Straight& alongChord(const std::vector<double>& tube);
  const Straight& along(double begin, double end);
  const Straight& atRest(const Positions& state, const std::vector<double>& tube);
  const Straight& atTime(double time);
  MotionQuestion within(double tolerance) const;
  void considerState(double time, const Pairs& pairs);
  void considerClosest(double time);
  bool isPromising(const RobotMinimum& found, const SplineSegment::Chord& chord) const;
  std::vector<ShapeRefPair> openPairsOf(const std::vector<StraightSearch::OpenPair>& list) const;
  void search(const Part& part);
  RobotMinimum minimumIn(const Positions& state, const Pairs& pairs);
  void nearestInTube();
  Positions nearestCorner(const Positions& state, const ShapeRefPair& pair);
  MotionQuestion nearly() const;
  bool touches(double time, RobotTimeOfContact& contact);
  double advance(double begin, double end, RobotTimeOfContact& contact);
  void touchInTube(RobotTimeOfContact& contact);

  const Pairs& pairs_;
  const Motion::Piece& piece_;
  const SplineSegment& segment_;
  const MotionQuestion& question_;
  StraightSearch& search_;
  Straight& straight_;
  const RobotModel& robot_;
  const std::vector<double>& tube_;
  bool has_tube_ = false;
  RobotMinimum best_;  ///< its upper bound is the upper bound of the smallest guaranteed distance at any state of the
                       ///< spline
  double proven_ = kInfinity;  ///< [m] the smallest lower bound of the parts that need no further search
  Heap<Part> parts_;
};

const Straight& SplineSearch::alongChord(const std::vector<double>& tube) {
  const SplineSegment::Chord& chord = straight_.chord;
  const std::size_t joints = chord.from.size();
  for (std::vector<double>* numbers : {&straight_.before, &straight_.travel, &straight_.most}) numbers->resize(joints);
  for (std::size_t i = 0; i < joints; ++i) {
    straight_.before[i] = chord.from[i] - piece_.from[i];
    straight_.travel[i] = chord.to[i] - chord.from[i];
    straight_.most[i] = chord.deviation[i] + tube[i];
  }
  piece_.robot.after(straight_.before, straight_.travel, straight_.motion);
  setDeviations(robot_, straight_.travel, straight_.most, straight_.deviations);
  return straight_;
}

const Straight& SplineSearch::along(double begin, double end) {
  segment_.chord(begin, end, straight_.chord);
  return alongChord(tube_);
}

const Straight& SplineSearch::atTime(double time) {
  segment_.at(time, straight_.at);
  return atRest(straight_.at, tube_);
}

const Straight& SplineSearch::atRest(const Positions& state, const std::vector<double>& tube) {
  straight_.chord.from = straight_.chord.to = state;
  straight_.chord.deviation.assign(state.size(), 0.0);
  return alongChord(tube);
}

MotionQuestion SplineSearch::within(double tolerance) const {
  MotionQuestion question = question_;
  question.tolerance = tolerance;
  return question;
}

// --- minimum

/// Takes the guaranteed distance of one state of the spline, if it is smaller than of all before.
void SplineSearch::considerState(double time, const Pairs& pairs) {
  const Straight& rest = atTime(time);
  const RobotMinimum here =
      search_.minimumBelow(best_.upper_bound, pairs, rest.motion, rest.deviations, within(0.25 * question_.tolerance));
  add(here.counts, best_.counts);
  if (here.status != Status::Unknown && best_.status == Status::Unknown) best_.status = Status::Converged;
  if (!(here.upper_bound < best_.upper_bound) || std::isnan(here.time)) return;
  best_.upper_bound = here.upper_bound;
  best_.pair = here.pair;
  best_.time = time;
}

/// Takes the guaranteed distance of the pair that is closest at one state of the spline.
void SplineSearch::considerClosest(double time) {
  const Straight& rest = atTime(time);
  const std::optional<PairProximity> closest = search_.closestAtStart(pairs_, rest.motion, question_.deadline);
  if (!closest) return considerState(time, pairs_);
  considerState(time, std::vector<ShapeRefPair>{closest->asked});
}

/// True if the state of the spline, at the time at which the straight motion of a part is nearest, is probably nearer
/// than the ones before. The deviations of the pair without the tube are taken to be the same share as the deviations
/// of all joints together. If they approach 0, and no state is promising, then the bounds of the part approach the
/// upper bound.
bool SplineSearch::isPromising(const RobotMinimum& found, const SplineSegment::Chord& chord) const {
  if (!(found.time >= 0.0)) return false;
  const double of_chord = std::accumulate(chord.deviation.begin(), chord.deviation.end(), 0.0);
  const double of_tube = std::accumulate(tube_.begin(), tube_.end(), 0.0);
  const double deviation = std::max(0.0, found.pair.result.upper_bound - found.upper_bound);
  const double share = of_chord > 0.0 ? of_chord / (of_chord + of_tube) : 0.0;
  return found.upper_bound + share * deviation < best_.upper_bound;
}

/// The pairs that may come as near as the upper bound.
std::vector<ShapeRefPair> SplineSearch::openPairsOf(const std::vector<StraightSearch::OpenPair>& list) const {
  std::vector<ShapeRefPair> open;
  for (const StraightSearch::OpenPair& pair : list)
    if (!(pair.lower_bound > best_.upper_bound)) open.push_back(pair.pair);
  return open;
}

/// Searches one part, and halves it if the smallest distance may be there. The halves are searched for the pairs that
/// the bounds of the whole part leave open.
void SplineSearch::search(const Part& part) {
  const double tolerance = narrowphase::usableTolerance(question_.tolerance);
  std::vector<ShapeRefPair> listed;
  if (part.pairs) listed = openPairsOf(*part.pairs);
  if (part.pairs && listed.empty()) {
    proven_ = std::min(proven_, best_.upper_bound);
    return;
  }
  const Pairs pairs = part.pairs ? Pairs(listed) : pairs_;
  const Straight& straight = along(part.begin, part.end);
  const SplineSegment::Chord& chord = straight.chord;
  // More exact than the deviations, if 1 rad moves a point by a metre, the bound need not be.
  const double deviation = *std::max_element(chord.deviation.begin(), chord.deviation.end());
  const RobotMinimum found = search_.minimumBelow(best_.upper_bound, pairs, straight.motion, straight.deviations,
                                                  within(0.25 * std::max(tolerance, deviation)));
  add(found.counts, best_.counts);
  PairList rest = part.pairs;
  if (auto open = search_.openPairs())
    rest = std::make_shared<const std::vector<StraightSearch::OpenPair>>(std::move(*open));
  const double lower_bound = std::max(part.lower_bound, found.lower_bound);
  const double middle = 0.5 * (part.begin + part.end);
  if (best_.upper_bound - lower_bound > tolerance && isPromising(found, chord)) {
    const std::vector<ShapeRefPair> near = rest ? openPairsOf(*rest) : std::vector<ShapeRefPair>();
    considerState(part.begin + found.time * (part.end - part.begin), rest ? Pairs(near) : pairs_);
  }
  const bool is_short = !(middle > part.begin && middle < part.end);
  if (is_short || !(best_.upper_bound - lower_bound > tolerance)) {
    proven_ = std::min(proven_, lower_bound);
    return;
  }
  parts_.push({part.begin, middle, lower_bound, rest});
  parts_.push({middle, part.end, lower_bound, rest});
}

RobotMinimum SplineSearch::minimum() {
  const double tolerance = narrowphase::usableTolerance(question_.tolerance);
  for (const double time : {0.0, 0.5, 1.0}) considerClosest(time);
  if (best_.status == Status::Unknown) return best_;
  parts_.push({0.0, 1.0, -kInfinity, nullptr});
  int count = 0;
  while (!parts_.empty() && best_.upper_bound - parts_.first().lower_bound > tolerance) {
    if (++count > kMaxParts || question_.deadline.hasPassed()) break;
    search(parts_.pop());
  }
  const double open = parts_.empty() ? kInfinity : parts_.first().lower_bound;
  best_.lower_bound = std::min({proven_, open, best_.upper_bound});
  if (best_.upper_bound - best_.lower_bound > tolerance) best_.status = Status::IterationLimit;
  best_.counts.by_one_bound = 0;
  if (std::isnan(best_.time)) return best_;
  best_.state = segment_.at(best_.time);
  if (has_tube_) nearestInTube();
  return best_;
}

/// The smallest distance in one state.
RobotMinimum SplineSearch::minimumIn(const Positions& state, const Pairs& pairs) {
  const Straight& rest = atRest(state, straight_.nowhere);
  const std::optional<PairProximity> closest =
      search_.closestAtStart(pairs, rest.motion, question_.deadline.withoutTime());
  if (!closest)
    return search_.minimumBelow(kInfinity, pairs, rest.motion, rest.deviations, within(question_.tolerance));
  RobotMinimum minimum;
  minimum.upper_bound = closest->result.upper_bound;
  minimum.pair = *closest;
  return minimum;
}

/// Replaces the guaranteed distance in the upper bound by the distance of a state of the tube.
void SplineSearch::nearestInTube() {
  best_.upper_bound = kInfinity;
  for (const Positions& state : {best_.state, nearestCorner(best_.state, best_.pair.asked)}) {
    const RobotMinimum here = minimumIn(state, pairs_);
    if (!(here.upper_bound < best_.upper_bound)) continue;
    best_.upper_bound = here.upper_bound;
    best_.pair = here.pair;
    best_.state = state;
  }
}

/// The corner of the tube to which each joint by itself leads a pair nearer.
Positions SplineSearch::nearestCorner(const Positions& state, const ShapeRefPair& pair) {
  const std::vector<ShapeRefPair> only{pair};
  Positions corner = state;
  for (std::size_t i = 0; i < tube_.size(); ++i) {
    if (!(tube_[i] > 0.0)) continue;
    Positions more = state, less = state;
    more[i] += tube_[i];
    less[i] -= tube_[i];
    corner[i] = minimumIn(more, only).upper_bound < minimumIn(less, only).upper_bound ? more[i] : less[i];
  }
  return corner;
}

// --- contact

/// The question about contact at one time, with contact distances that are larger by half of the tolerance: a state that
/// is free by it has room for a motion.
MotionQuestion SplineSearch::nearly() const {
  const double half = 0.5 * narrowphase::usableTolerance(question_.tolerance);
  MotionQuestion question = within(half);
  question.contact_distance += half;
  for (PairContactDistance& own : question.nearer_pairs) own.contact_distance += half;
  return question;
}

/// True if the state of the spline at one time, or of the tube there, cannot be told from one in contact.
bool SplineSearch::touches(double time, RobotTimeOfContact& contact) {
  const Straight& rest = atTime(time);
  const RobotTimeOfContact here = search_.timeOfContact(pairs_, rest.motion, rest.deviations, nearly());
  add(here.counts, contact.counts);
  contact.status = here.status;
  if (!here.contact) return false;
  contact.pair = here.pair;
  return true;
}

/// Returns the time until which the spline, or the tube, is proven to be free. It begins at `begin`.
double SplineSearch::advance(double begin, double end, RobotTimeOfContact& contact) {
  const Straight& straight = along(begin, end);
  const RobotTimeOfContact found =
      search_.timeOfContact(pairs_, straight.motion, straight.deviations, within(0.25 * question_.tolerance));
  add(found.counts, contact.counts);
  contact.status = found.status == Status::Unknown ? Status::Unknown : Status::Converged;
  if (found.status == Status::Converged && !found.contact) return end;
  return std::min(end, begin + found.t_free * (end - begin));
}

RobotTimeOfContact SplineSearch::timeOfContact(double begin) {
  RobotTimeOfContact contact;
  double free = begin, step = 1.0;
  for (int count = 0; free < 1.0; ++count) {
    const double end = std::min(1.0, free + step);
    if (count == kMaxParts || question_.deadline.hasPassed() || !(end > free)) {
      contact.status = Status::IterationLimit;
      break;
    }
    const double next = advance(free, end, contact);
    if (contact.status == Status::Unknown) return contact;
    free = next;
    step *= next < end ? 0.25 : 2.0;
    if (next == end) continue;
    contact.contact = touches(free, contact);
    if (contact.contact || contact.status != Status::Converged) break;
    // The state at `free` is not in contact, so a part that is short enough is free, too.
  }
  contact.t_free = free;
  if (!contact.contact) return contact;
  contact.t_contact = free;
  contact.state = segment_.at(free);
  if (has_tube_) touchInTube(contact);
  return contact;
}

/// The tube may touch at `t_contact`. Looks for a state of it that does, there or where the spline itself touches later.
void SplineSearch::touchInTube(RobotTimeOfContact& contact) {
  for (const Positions& state : {contact.state, nearestCorner(contact.state, contact.pair.asked)}) {
    const Straight& rest = atRest(state, straight_.nowhere);
    const RobotTimeOfContact here = search_.timeOfContact(pairs_, rest.motion, rest.deviations, nearly());
    if (!here.contact) continue;
    contact.pair = here.pair;
    contact.state = state;
    return;
  }
  Motion::Piece without_tube = piece_;
  without_tube.tracking_error.clear();
  SplineSearch spline(pairs_, without_tube, question_, search_, straight_);
  const RobotTimeOfContact later = spline.timeOfContact(contact.t_free);
  add(later.counts, contact.counts);
  if (later.contact) {
    contact.pair = later.pair;
    contact.t_contact = later.t_contact;
    contact.state = later.state;
    contact.status = later.status;
    return;
  }
  contact.contact = false;
  contact.t_contact = std::numeric_limits<double>::quiet_NaN();
  contact.state.clear();
  contact.status = Status::Degenerate;
}

// --- pieces

MotionCounts together(const MotionCounts& p, const MotionCounts& q) {
  MotionCounts counts;
  counts.pairs = std::max(p.pairs, q.pairs);
  counts.unknown = std::max(p.unknown, q.unknown);
  counts.by_one_bound = std::min(p.by_one_bound, q.by_one_bound);
  counts.intervals = p.intervals + q.intervals;
  counts.queries = p.queries + q.queries;
  return counts;
}

RobotMinimum followedBy(const RobotMinimum& before, const RobotMinimum& next) {
  RobotMinimum closer = next.upper_bound < before.upper_bound ? next : before;
  closer.lower_bound = std::min(before.lower_bound, next.lower_bound);
  closer.status = lessComplete(before.status, next.status);
  closer.counts = together(before.counts, next.counts);
  return closer;
}

}  // namespace

RobotTimeOfContact followedBy(const RobotTimeOfContact& before, RobotTimeOfContact next) {
  next.counts = together(before.counts, next.counts);
  if (before.status == narrowphase::Status::Converged) return next;
  next.t_free = before.t_free;
  next.status = lessComplete(before.status, next.status);
  return next;
}

struct MotionSearch::Memory {
  StraightSearch search;
  Straight straight{};
};

MotionSearch::MotionSearch(const std::shared_ptr<const SceneModel>& model)
    : memory_(new Memory{StraightSearch(State(model))}) {}
MotionSearch::MotionSearch(const State& state) : memory_(new Memory{StraightSearch(state.forAnotherThread())}) {}
MotionSearch::~MotionSearch() = default;
MotionSearch::MotionSearch(MotionSearch&&) noexcept = default;
MotionSearch& MotionSearch::operator=(MotionSearch&&) noexcept = default;

MotionSearch MotionSearch::forAnotherThread() const { return MotionSearch(memory_->search.state()); }

const SceneModel& MotionSearch::model() const { return memory_->search.state().model(); }

void MotionSearch::use(std::shared_ptr<const Objects> objects) { memory_->search.use(std::move(objects)); }

const Objects* MotionSearch::objects() const { return memory_->search.objects().get(); }

RobotTimeOfContact MotionSearch::timeOfContact(const Pairs& pairs, const Motion& motion,
                                               const MotionQuestion& question) {
  const auto contactIn = [&](const Motion::Piece& piece) {
    RobotTimeOfContact found =
        piece.spline ? SplineSearch(pairs, piece, question, memory_->search, memory_->straight).timeOfContact()
                     : memory_->search.timeOfContact(pairs, piece.robot, question);
    if (found.contact && !piece.spline) found.state = piece.positionsAt(found.t_contact);
    found.t_free = piece.onWhole(found.t_free);
    if (found.contact) found.t_contact = piece.onWhole(found.t_contact);
    return found;
  };
  RobotTimeOfContact answer = contactIn(motion.pieces().front());
  for (std::size_t i = 1; i < motion.pieces().size() && !answer.contact; ++i) {
    if (motion.pieces()[i - 1].spline && answer.status != Status::Converged) break;
    answer = followedBy(answer, contactIn(motion.pieces()[i]));
  }
  return answer;
}

RobotMinimum MotionSearch::minimum(const Pairs& pairs, const Motion& motion, const MotionQuestion& question) {
  const auto minimumIn = [&](const Motion::Piece& piece) {
    RobotMinimum found = piece.spline
                             ? SplineSearch(pairs, piece, question, memory_->search, memory_->straight).minimum()
                             : memory_->search.minimum(pairs, piece.robot, question);
    if (found.time >= 0.0 && !piece.spline) found.state = piece.positionsAt(found.time);
    if (found.time >= 0.0) found.time = piece.onWhole(found.time);
    return found;
  };
  RobotMinimum answer = minimumIn(motion.pieces().front());
  for (std::size_t i = 1; i < motion.pieces().size(); ++i) answer = followedBy(answer, minimumIn(motion.pieces()[i]));
  return answer;
}

}  // namespace proximity_server::scene
