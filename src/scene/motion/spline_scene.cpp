#include "proximity_server/scene/motion/spline_scene.h"

#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/numbers.h"
#include "scene/motion/joint_deviations.h"
#include "scene/motion/motion_search.h"
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

/// Searches the parts of one segment.
class SegmentSearch {
 public:
  SegmentSearch(const Pairs& pairs, const SplineSegment& segment, const SplineQuestion& question, MotionSearch& search)
      : pairs_(pairs), segment_(segment), question_(question), search_(search), robot_(search.state().robot()) {
    const std::size_t joints = robot_.joints.size();
    if (!question.tracking_error.empty() && question.tracking_error.size() != joints)
      throw std::invalid_argument("there are " + std::to_string(question.tracking_error.size()) +
                                  " tracking errors for " + std::to_string(joints) + " joints");
    for (std::size_t i = 0; i < question.tracking_error.size(); ++i)
      if (!(std::isfinite(question.tracking_error[i]) && question.tracking_error[i] >= 0.0))
        throw std::invalid_argument("the tracking error of joint '" + robot_.joints[i].name +
                                    "' is not a number from 0 on");
    const auto moves = [](const RobotMotion::Segment& frame) { return frame.is_known && !frame.motion.isRest(); };
    if (moves(question.frames.world) ||
        std::any_of(question.frames.moving.begin(), question.frames.moving.end(), moves))
      throw std::invalid_argument("a frame of the objects moves relative to its parent, which a spline does not know");
    tube_ = question.tracking_error;
    tube_.resize(joints, 0.0);
    has_tube_ = std::any_of(tube_.begin(), tube_.end(), [](double error) { return error > 0.0; });
  }

  SplineMinimum minimum();
  /// `begin`: the time until which the segment is known to be free.
  SplineContact timeOfContact(double begin = 0.0);

 private:
  /// A straight motion with the deviations from it.
  struct Straight {
    RobotMotion motion;
    JointDeviations deviations;
  };
  /// The pairs that may have the smallest distance during a part of the segment; nullptr: all.
  using PairList = std::shared_ptr<const std::vector<MotionSearch::OpenPair>>;
  struct Part {
    double begin, end;
    double lower_bound;  ///< [m] of the smallest guaranteed distance
    PairList pairs;
    bool operator<(const Part& other) const { return lower_bound > other.lower_bound; }
  };

  Straight along(const SplineSegment::Chord& chord, const std::vector<double>& tube) const;
  Straight along(double begin, double end) const;
  Straight atRest(const Positions& state, const std::vector<double>& tube) const;
  MotionQuestion within(double tolerance) const;
  void considerState(double time, const Pairs& pairs);
  void considerClosest(double time);
  bool isPromising(const RobotMinimum& found, const SplineSegment::Chord& chord) const;
  std::vector<ShapeRefPair> openPairsOf(const std::vector<MotionSearch::OpenPair>& list) const;
  void search(const Part& part);
  RobotMinimum minimumIn(const Positions& state, const Pairs& pairs);
  void nearestInTube();
  Positions nearestCorner(const Positions& state, const ShapeRefPair& pair);
  MotionQuestion nearly() const;
  bool touches(double time, SplineContact& contact);
  double advance(double begin, double end, SplineContact& contact);
  void touchInTube(SplineContact& contact);

  const Pairs& pairs_;
  const SplineSegment& segment_;
  const SplineQuestion& question_;
  MotionSearch& search_;
  const RobotModel& robot_;
  std::vector<double> tube_;
  bool has_tube_ = false;
  SplineMinimum best_;  ///< its upper bound is that of the smallest guaranteed distance at any state of the spline
  double proven_ = kInfinity;  ///< [m] the smallest lower bound of the parts that need no further search
  Heap<Part> parts_;
};

SegmentSearch::Straight SegmentSearch::along(const SplineSegment::Chord& chord, const std::vector<double>& tube) const {
  std::vector<double> travel(chord.from.size()), most(chord.from.size());
  for (std::size_t i = 0; i < travel.size(); ++i) {
    travel[i] = chord.to[i] - chord.from[i];
    most[i] = chord.deviation[i] + tube[i];
  }
  const BodyPoses start = question_.poses ? question_.poses(chord.from) : forwardKinematics(robot_, chord.from);
  Straight straight{RobotMotion::ofTravel(robot_, start, travel), jointDeviations(robot_, travel, most)};
  straight.motion.carryObjects(question_.frames);
  return straight;
}

SegmentSearch::Straight SegmentSearch::along(double begin, double end) const {
  return along(segment_.chord(begin, end), tube_);
}

SegmentSearch::Straight SegmentSearch::atRest(const Positions& state, const std::vector<double>& tube) const {
  return along({state, state, std::vector<double>(state.size(), 0.0)}, tube);
}

MotionQuestion SegmentSearch::within(double tolerance) const {
  MotionQuestion question = question_.motion;
  question.tolerance = tolerance;
  return question;
}

// --- minimum

/// Takes the guaranteed distance of one state of the spline, if it is smaller than that of all before.
void SegmentSearch::considerState(double time, const Pairs& pairs) {
  const Straight rest = atRest(segment_.at(time), tube_);
  const RobotMinimum here = search_.minimumBelow(best_.upper_bound, pairs, rest.motion, rest.deviations,
                                                 within(0.25 * question_.motion.tolerance));
  add(here.counts, best_.counts);
  if (here.status != Status::Unknown && best_.status == Status::Unknown) best_.status = Status::Converged;
  if (!(here.upper_bound < best_.upper_bound) || std::isnan(here.time)) return;
  best_.upper_bound = here.upper_bound;
  best_.pair = here.pair;
  best_.time = time;
}

/// Takes the guaranteed distance of the pair that is closest at one state of the spline.
void SegmentSearch::considerClosest(double time) {
  const Straight rest = atRest(segment_.at(time), tube_);
  const std::optional<PairProximity> closest = search_.closestAtStart(pairs_, rest.motion, question_.motion.deadline);
  if (!closest) return considerState(time, pairs_);
  considerState(time, std::vector<ShapeRefPair>{closest->asked});
}

/// True if the state of the spline, at the time at which the straight motion of a part is nearest, is probably nearer
/// than those before. The deviations of the pair without the tube are taken to be the same share as those of all joints
/// together. If they approach 0, and no state is promising, then the bounds of the part approach the upper bound.
bool SegmentSearch::isPromising(const RobotMinimum& found, const SplineSegment::Chord& chord) const {
  if (!(found.time >= 0.0)) return false;
  const double of_chord = std::accumulate(chord.deviation.begin(), chord.deviation.end(), 0.0);
  const double of_tube = std::accumulate(tube_.begin(), tube_.end(), 0.0);
  const double deviation = std::max(0.0, found.pair.result.upper_bound - found.upper_bound);
  const double share = of_chord > 0.0 ? of_chord / (of_chord + of_tube) : 0.0;
  return found.upper_bound + share * deviation < best_.upper_bound;
}

/// The pairs that may come as near as the upper bound.
std::vector<ShapeRefPair> SegmentSearch::openPairsOf(const std::vector<MotionSearch::OpenPair>& list) const {
  std::vector<ShapeRefPair> open;
  for (const MotionSearch::OpenPair& pair : list)
    if (!(pair.lower_bound > best_.upper_bound)) open.push_back(pair.pair);
  return open;
}

/// Searches one part, and halves it if the smallest distance may be there. The halves are searched for the pairs that
/// the bounds of the whole part leave open.
void SegmentSearch::search(const Part& part) {
  const double tolerance = narrowphase::usableTolerance(question_.motion.tolerance);
  std::vector<ShapeRefPair> listed;
  if (part.pairs) listed = openPairsOf(*part.pairs);
  if (part.pairs && listed.empty()) {
    proven_ = std::min(proven_, best_.upper_bound);
    return;
  }
  const Pairs pairs = part.pairs ? Pairs(listed) : pairs_;
  const SplineSegment::Chord chord = segment_.chord(part.begin, part.end);
  const Straight straight = along(chord, tube_);
  // More exact than the deviations, if 1 rad moves a point by a metre, the bound need not be.
  const double deviation = *std::max_element(chord.deviation.begin(), chord.deviation.end());
  const RobotMinimum found = search_.minimumBelow(best_.upper_bound, pairs, straight.motion, straight.deviations,
                                                  within(0.25 * std::max(tolerance, deviation)));
  add(found.counts, best_.counts);
  PairList rest = part.pairs;
  if (auto open = search_.openPairs())
    rest = std::make_shared<const std::vector<MotionSearch::OpenPair>>(std::move(*open));
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

SplineMinimum SegmentSearch::minimum() {
  const double tolerance = narrowphase::usableTolerance(question_.motion.tolerance);
  for (const double time : {0.0, 0.5, 1.0}) considerClosest(time);
  if (best_.status == Status::Unknown) return best_;
  parts_.push({0.0, 1.0, -kInfinity, nullptr});
  int count = 0;
  while (!parts_.empty() && best_.upper_bound - parts_.first().lower_bound > tolerance) {
    if (++count > kMaxParts || question_.motion.deadline.hasPassed()) break;
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
RobotMinimum SegmentSearch::minimumIn(const Positions& state, const Pairs& pairs) {
  const Straight rest = atRest(state, std::vector<double>(tube_.size(), 0.0));
  const std::optional<PairProximity> closest =
      search_.closestAtStart(pairs, rest.motion, question_.motion.deadline.withoutTime());
  if (!closest)
    return search_.minimumBelow(kInfinity, pairs, rest.motion, rest.deviations, within(question_.motion.tolerance));
  RobotMinimum minimum;
  minimum.upper_bound = closest->result.upper_bound;
  minimum.pair = *closest;
  return minimum;
}

/// Replaces the guaranteed distance in the upper bound by the distance of a state of the tube.
void SegmentSearch::nearestInTube() {
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
Positions SegmentSearch::nearestCorner(const Positions& state, const ShapeRefPair& pair) {
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
MotionQuestion SegmentSearch::nearly() const {
  const double half = 0.5 * narrowphase::usableTolerance(question_.motion.tolerance);
  MotionQuestion question = within(half);
  question.contact_distance += half;
  for (PairContactDistance& own : question.nearer_pairs) own.contact_distance += half;
  return question;
}

/// True if the state of the spline at one time, or of the tube there, cannot be told from one in contact.
bool SegmentSearch::touches(double time, SplineContact& contact) {
  const Straight rest = atRest(segment_.at(time), tube_);
  const RobotTimeOfContact here = search_.timeOfContact(pairs_, rest.motion, rest.deviations, nearly());
  add(here.counts, contact.counts);
  contact.status = here.status;
  if (!here.contact) return false;
  contact.pair = here.pair;
  return true;
}

/// Returns the time until which the spline, or the tube, is proven to be free. It begins at `begin`.
double SegmentSearch::advance(double begin, double end, SplineContact& contact) {
  const Straight straight = along(begin, end);
  const RobotTimeOfContact found =
      search_.timeOfContact(pairs_, straight.motion, straight.deviations, within(0.25 * question_.motion.tolerance));
  add(found.counts, contact.counts);
  contact.status = found.status == Status::Unknown ? Status::Unknown : Status::Converged;
  if (found.status == Status::Converged && !found.contact) return end;
  return std::min(end, begin + found.t_free * (end - begin));
}

SplineContact SegmentSearch::timeOfContact(double begin) {
  SplineContact contact;
  double free = begin, step = 1.0;
  for (int count = 0; free < 1.0; ++count) {
    const double end = std::min(1.0, free + step);
    if (count == kMaxParts || question_.motion.deadline.hasPassed() || !(end > free)) {
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
void SegmentSearch::touchInTube(SplineContact& contact) {
  const std::vector<double> nowhere(tube_.size(), 0.0);
  for (const Positions& state : {contact.state, nearestCorner(contact.state, contact.pair.asked)}) {
    const Straight rest = atRest(state, nowhere);
    const RobotTimeOfContact here = search_.timeOfContact(pairs_, rest.motion, rest.deviations, nearly());
    if (!here.contact) continue;
    contact.pair = here.pair;
    contact.state = state;
    return;
  }
  SplineQuestion without_tube = question_;
  without_tube.tracking_error.clear();
  SegmentSearch spline(pairs_, segment_, without_tube, search_);
  const SplineContact later = spline.timeOfContact(contact.t_free);
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

}  // namespace

SplineScene::SplineScene(const std::shared_ptr<const SceneModel>& model)
    : search_(std::make_unique<MotionSearch>(State(model))) {}
SplineScene::SplineScene(const State& state) : search_(std::make_unique<MotionSearch>(state.forAnotherThread())) {}
SplineScene::~SplineScene() = default;
SplineScene::SplineScene(SplineScene&&) noexcept = default;
SplineScene& SplineScene::operator=(SplineScene&&) noexcept = default;

SplineScene SplineScene::forAnotherThread() const { return SplineScene(search_->state()); }

const SceneModel& SplineScene::model() const { return search_->state().model(); }

void SplineScene::use(std::shared_ptr<const Objects> objects) { search_->use(std::move(objects)); }

const Objects* SplineScene::objects() const { return search_->objects().get(); }

SplineMinimum SplineScene::minimum(const Pairs& pairs, const SplineSegment& segment, const SplineQuestion& question) {
  return SegmentSearch(pairs, segment, question, *search_).minimum();
}

SplineContact SplineScene::timeOfContact(const Pairs& pairs, const SplineSegment& segment,
                                         const SplineQuestion& question) {
  return SegmentSearch(pairs, segment, question, *search_).timeOfContact();
}

}  // namespace proximity_server::scene
