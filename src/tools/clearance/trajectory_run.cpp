#include "tools/clearance/trajectory_run.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "system/pipeline.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {
namespace {

// So few that the hundreds of segments of a planned trajectory use all threads.
constexpr std::size_t kSegmentsInBlock = 16;

// The parts of a segment for the curve of the report: at most so long, and so many.
constexpr double kLongestPart = 0.02;  // [s]
constexpr int kMostParts = 64;

scene::Motion motionOf(const TrajectorySegment& segment, const scene::RobotModel& robot,
                       const std::vector<double>& tracking_error) {
  scene::Motion motion = segment.spline
                             ? scene::Motion(robot, *segment.spline, tracking_error)
                             : scene::Motion(robot, {segment.begin, segment.from}, {segment.end, segment.to});
  if (segment.objects) motion.carryObjects(framesOnLinks(*segment.objects));
  return motion;
}

ClearanceAnswer::OfPair answerOf(const TrajectorySegment& segment, const scene::RobotMinimum& minimum) {
  ClearanceAnswer::OfPair answer{minimum.pair, minimum.status, segment.timeAt(minimum.time), minimum.state};
  answer.pair.result.lower_bound = minimum.lower_bound;
  answer.pair.result.upper_bound = minimum.upper_bound;
  return answer;
}

/// A level is reached unless all states of the motion are proven to be farther apart. Only a state that is in contact is
/// COLLISION, as with an uncertainty.
std::optional<SegmentLevel> levelOf(const TrajectorySegment& segment, const scene::Motion& motion,
                                    const scene::Pairs& pairs, const ClearanceQuestion& question,
                                    const scene::RobotMinimum& minimum, scene::MotionSearch& search) {
  using scene::ClearanceLevel;
  if (minimum.status == narrowphase::Status::Unknown || minimum.counts.unknown > 0) return std::nullopt;
  const scene::PairDistances contact;
  for (const auto& [level, distances] : {std::pair{ClearanceLevel::Collision, &contact},
                                         {ClearanceLevel::Stop, &question.thresholds->stop},
                                         {ClearanceLevel::Warn, &question.thresholds->warn}}) {
    if (minimum.lower_bound > distances->range(scene::PairKind::Any).largest) continue;
    scene::MotionQuestion asked = question.motion;
    asked.contact_distance = 0.0;
    asked.thresholds = distances;
    const scene::RobotTimeOfContact reached = search.timeOfContact(pairs, motion, asked);
    const bool is_open = reached.status != narrowphase::Status::Converged && level != ClearanceLevel::Collision;
    if (reached.contact || is_open) return SegmentLevel{level, segment.timeAt(reached.t_free), reached.pair.asked};
  }
  return SegmentLevel();
}

ClearanceAnswer answerSegment(const TrajectorySegment& segment, const scene::Motion& motion, const scene::Pairs& pairs,
                              const ClearanceQuestion& question, scene::MotionSearch& search) {
  const scene::RobotMinimum minimum = search.minimum(pairs, motion, question.motion);
  ClearanceAnswer answer{segment.number, segment.begin, segment.end, segment.objects, answerOf(segment, minimum)};
  answer.unknown_pairs = minimum.counts.unknown;
  if (minimum.state.empty()) answer.closest.positions = segment.positionsAt(minimum.time);
  if (question.thresholds) answer.level = levelOf(segment, motion, pairs, question, minimum, search);
  scene::RobotTimeOfContact& contact = answer.contact;
  // If the minimum proves that there is no contact, a search is not needed, and the two cannot contradict each other.
  if (minimum.status != narrowphase::Status::Unknown && minimum.lower_bound > question.motion.contact_distance) {
    contact.status = narrowphase::Status::Converged;
    contact.t_free = 1.0;
  } else {
    contact = search.timeOfContact(pairs, motion, question.motion);
  }
  contact.t_free = segment.timeAt(contact.t_free);
  contact.t_contact = segment.timeAt(contact.t_contact);
  return answer;
}

/// Adds the answers about the parts of the segment. If the only part is the whole, its answer is known.
void addParts(const TrajectorySegment& segment, const scene::Pairs& pairs, const ClearanceQuestion& question,
              scene::MotionSearch& search, ClearanceAnswer& answer) {
  const auto add = [&](const TrajectorySegment& part, narrowphase::Status status, double lower_bound,
                       const std::optional<SegmentLevel>& level) {
    const bool is_known = status != narrowphase::Status::Unknown;
    const double bound = is_known ? lower_bound : std::numeric_limits<double>::quiet_NaN();
    answer.parts.push_back({part.begin, part.end, bound, level});
  };
  const double count = std::clamp(std::ceil((segment.end - segment.begin) / kLongestPart), 1.0, 1.0 * kMostParts);
  if (count == 1.0) return add(segment, answer.closest.status, answer.closest.pair.result.lower_bound, answer.level);
  for (double i = 0.0; i < count; ++i) {
    const TrajectorySegment part = segment.between(i / count, (i + 1.0) / count);
    const scene::Motion motion = motionOf(part, question.model->robot, question.tracking_error);
    const scene::RobotMinimum minimum = search.minimum(pairs, motion, question.motion);
    std::optional<SegmentLevel> level;
    if (question.thresholds) level = levelOf(part, motion, pairs, question, minimum, search);
    add(part, minimum.status, minimum.lower_bound, level);
  }
}

/// Adds the answer about each pair by itself. That about the closest pair is known.
void addPairs(const TrajectorySegment& segment, const scene::Motion& motion,
              const std::vector<scene::ShapeRefPair>& pairs, const scene::MotionQuestion& question,
              scene::MotionSearch& search, ClearanceAnswer& answer) {
  const scene::ShapeRefPair& closest = answer.closest.pair.asked;
  for (const scene::ShapeRefPair& pair : pairs) {
    const bool is_known = pair.a == closest.a && pair.b == closest.b;
    const std::vector<scene::ShapeRefPair> alone{pair};
    answer.of_pairs.push_back(is_known ? answer.closest : answerOf(segment, search.minimum(alone, motion, question)));
    answer.of_pairs.back().pair.asked = pair;  // also without an answer
  }
}

/// Counts the segments of which the spline leaves the limits of a joint, or breaks an inequality, and tells the first
/// of each.
class SplineLimits {
 public:
  explicit SplineLimits(const scene::RobotModel& robot) : robot_(robot) {}

  void add(const TrajectorySegment& segment) {
    const std::vector<scene::SplineSegment::Excess> beyond = segment.spline->beyondLimits(robot_);
    if (!beyond.empty() && beyond_.count++ == 0)
      beyond_.first = place(segment, beyond.front().time) + text(beyond.front());
    const std::vector<scene::SplineSegment::Break> broken = segment.spline->brokenInequalities(robot_);
    if (!broken.empty() && broken_.count++ == 0)
      broken_.first =
          place(segment, broken.front().time) + broken.front().inequality->brokenText(broken.front().excess);
  }

  std::vector<std::string> warnings(const std::string& source) const {
    return {beyond_.warning(source + ": the motion is beyond the limits of a joint in "),
            broken_.warning(source + ": the motion breaks a joint inequality in ")};
  }

 private:
  struct Counted {
    long count = 0;
    std::string first;

    std::string warning(const std::string& what) const {
      if (count == 0) return "";
      return what + std::to_string(count) + (count == 1 ? " segment. That is " : " segments. The first is ") + first +
             ".";
    }
  };

  static std::string place(const TrajectorySegment& segment, double time) {
    return "segment " + std::to_string(segment.number) + ", at " + shortest(segment.timeAt(time)) + " s: ";
  }

  std::string text(const scene::SplineSegment::Excess& excess) const {
    const scene::Joint& joint = robot_.joints[excess.joint];
    const std::string unit = joint.type == scene::Joint::Type::Prismatic ? " m" : " rad";
    return scene::quoted(joint.name) + " is at " + shortest(excess.position) + unit + ", its limit is " +
           shortest(excess.limit) + unit;
  }

  const scene::RobotModel& robot_;
  Counted beyond_, broken_;
};

}  // namespace

double TrajectorySegment::timeAt(double fraction) const {
  if (fraction >= 1.0) return end;
  const double time = begin + fraction * (end - begin);
  return time > end ? end : time;  // not std::min, so that NaN gives NaN
}

scene::Positions TrajectorySegment::positionsAt(double fraction) const {
  if (spline) return spline->at(fraction);
  scene::Positions positions = from;
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += fraction * (to[i] - from[i]);
  return positions;
}

TrajectorySegment TrajectorySegment::between(double fraction, double end_fraction) const {
  TrajectorySegment part = *this;
  part.begin = timeAt(fraction);
  part.end = timeAt(end_fraction);
  part.from = positionsAt(fraction);
  if (end_fraction < 1.0) part.to = positionsAt(end_fraction);
  if (spline) part.spline = spline->between(fraction, end_fraction);
  return part;
}

bool TrajectorySegments::next(TrajectorySegment& segment) {
  if (rest_) {
    segment = *std::exchange(rest_, std::nullopt);
  } else if (!nextWhole(segment)) {
    return false;
  }
  segment.number = count_++;
  if (objects_) {
    divide(segment);
    segment.objects = objects_->now();
  }
  return true;
}

bool TrajectorySegments::nextWhole(TrajectorySegment& segment) {
  if (start_) beginAtStart();
  if (!last_) last_ = readWayPoint();
  std::optional<scene::TrajectoryPoint> way_point = last_ ? nextWayPoint() : std::nullopt;
  if (!way_point && count_ == 0) {
    throw std::invalid_argument(states_.header().source + ": a trajectory has at least two way points, this one has " +
                                (last_ ? "1" : "none"));
  }
  if (!way_point) return false;
  ++way_points_;
  segment = {0, last_->time, way_point->time, last_->positions, way_point->positions};
  if (interpolation_)
    segment.spline =
        naming(states_.place(), [&] { return scene::SplineSegment(states_.header().robot, *last_, *way_point); });
  last_ = std::move(way_point);
  return true;
}

std::optional<scene::TrajectoryPoint> TrajectorySegments::nextWayPoint() {
  return next_ ? std::exchange(next_, std::nullopt) : readWayPoint();
}

/// Passes the way points that the controller drops, and finds the full turns that it adds to all others.
void TrajectorySegments::beginAtStart() {
  std::optional<scene::TrajectoryPoint> first = readWayPoint();
  --way_points_;  // the segment begins before way point 0
  for (; first && !(first->time > 0.0); ++way_points_) {
    last_ = std::move(first);
    first = readWayPoint();
  }
  if (!first) throw std::invalid_argument(states_.header().source + ": no way point is later than --start, at time 0");
  const std::vector<scene::TrajectoryPoint> driven = scene::drivenFrom(states_.header().robot, *start_, {*first});
  offsets_ = driven[1].positions;
  for (std::size_t i = 0; i < offsets_.size(); ++i) offsets_[i] -= first->positions[i];
  last_ = driven[0];
  if (first->velocities.empty()) last_->velocities.clear();
  if (first->accelerations.empty()) last_->accelerations.clear();
  next_ = driven[1];
  start_.reset();
  check(*last_, *next_);
}

/// Cuts the segment where objects change next, and keeps the rest of it.
void TrajectorySegments::divide(TrajectorySegment& segment) {
  objects_->advance(way_points_ - 1, segment.begin, segment.from);
  const std::optional<double> change = objects_->nextTime();
  if (!change || !(*change < segment.end)) return;
  const double fraction = (*change - segment.begin) / (segment.end - segment.begin);
  rest_ = segment.between(fraction, 1.0);
  segment = segment.between(0.0, fraction);
  rest_->begin = segment.end = *change;
}

void TrajectorySegments::interpolate(Interpolation interpolation) {
  using Quantity = JointColumn::Quantity;
  interpolation_ = interpolation;
  const auto require = [&](Quantity quantity, const std::string& interpolation_name) {
    const std::vector<scene::Joint>& joints = states_.header().robot.joints;
    for (int joint = 0; joint < static_cast<int>(joints.size()); ++joint)
      if (!joints[joint].mimic && states_.header().has(Quantity::Position, joint) &&
          !states_.header().has(quantity, joint))
        throw std::invalid_argument(states_.header().source + ": there is no column " +
                                    scene::quoted(joints[joint].name + suffixOf(quantity)) + " for --interpolation " +
                                    interpolation_name);
  };
  if (interpolation == Interpolation::Cubic) require(Quantity::Velocity, "cubic");
  if (interpolation != Interpolation::Quintic) return;
  require(Quantity::Velocity, "quintic");
  require(Quantity::Acceleration, "quintic");
}

std::optional<scene::TrajectoryPoint> TrajectorySegments::readWayPoint() {
  scene::TrajectoryPoint way_point;
  if (!states_.next(way_point)) return std::nullopt;
  if (std::isnan(way_point.time)) way_point.time = last_ ? last_->time + 1.0 : 0.0;
  if (interpolation_.value_or(Interpolation::Linear) == Interpolation::Linear) way_point.velocities.clear();
  if (interpolation_ != Interpolation::Quintic) way_point.accelerations.clear();
  for (std::size_t i = 0; i < offsets_.size(); ++i) way_point.positions[i] += offsets_[i];
  if (last_) check(*last_, way_point);
  return way_point;
}

void TrajectorySegments::check(const scene::TrajectoryPoint& from, const scene::TrajectoryPoint& to) const {
  const auto fail = [&](const std::string& column, double of_to, const std::string& what, double of_from) {
    throw std::invalid_argument(states_.place() + ": column \"" + column + "\": " + shortest(of_to) + what +
                                shortest(of_from));
  };
  if (to.time <= from.time) fail("time", to.time, " is not later than ", from.time);
  if (!std::isfinite(to.time - from.time)) fail("time", to.time, " is too far from ", from.time);
  for (std::size_t i = 0; i < to.positions.size(); ++i) {
    if (std::isfinite(to.positions[i] - from.positions[i])) continue;
    fail(states_.header().robot.joints[i].name, to.positions[i], " is too far from ", from.positions[i]);
  }
}

std::vector<std::string> answerSegments(const ClearanceQuestion& question, StateSource& states, AnswerOutput& output) {
  const scene::RobotModel& robot = question.model->robot;
  TrajectorySegments segments(states, question.objects.get());
  if (question.start) segments.startFrom(*question.start);
  if (question.interpolation != Interpolation::Linear || !question.tracking_error.empty())
    segments.interpolate(question.interpolation);
  SplineLimits limits(robot);
  const auto next = [&](TrajectorySegment& segment) {
    if (!segments.next(segment)) return false;
    if (segment.spline) limits.add(segment);
    return true;
  };
  const auto write = [&](const ClearanceAnswer& answer) {
    output.rows.write({rowText(answer, question, output.format), 1});
    if (output.plot) output.plot->write({rowText(answer, question, RowFormat::Csv), 1});
    output.add(answer);
    output.counter.count(1);
  };
  const scene::MotionSearch fresh(question.model);
  const auto answerBlock = [&](const std::vector<TrajectorySegment>& block) {
    scene::MotionSearch search = fresh.forAnotherThread();
    QuestionPairs pairs(question);
    std::vector<ClearanceAnswer> answers;
    for (const TrajectorySegment& segment : block) {
      if (pairs.use(segment.objects)) search.use(segment.objects);
      const scene::Motion motion = motionOf(segment, robot, question.tracking_error);
      ClearanceAnswer& answer = answers.emplace_back(answerSegment(segment, motion, pairs.get(), question, search));
      if (output.report) {
        addPairs(segment, motion, pairs.list(segment.objects.get()), question.motion, search, answer);
        addParts(segment, pairs.get(), question, search, answer);
      }
      question.budget.require();
    }
    return answers;
  };
  system::answerInBlocks<TrajectorySegment, ClearanceAnswer>({kSegmentsInBlock, next, answerBlock, write},
                                                             question.threads);
  return limits.warnings(states.header().source);
}

}  // namespace proximity_server::tools
