#include "trajectory_run.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "answers_in_blocks.h"
#include "csv.h"

namespace proximity_server {
namespace {

constexpr std::size_t kBlockSize = 16;  // segments: a planned trajectory, of some hundred, goes to all threads

RobotContact provenFree() {
  RobotContact free;
  free.status = Status::Converged;
  free.t_free = 1.0;
  return free;
}

SegmentClearance answerSegment(const std::vector<SubjectPair>& pairs, const MotionQuestion& question,
                               const Segment& segment, MovingScene& scene) {
  const RobotMotion motion = RobotMotion::ofJoints(scene.model().robot, segment.from, segment.to);
  const RobotMinimum minimum = scene.minimum(pairs, motion, question);
  // What the minimum has proven need not be asked again, and the two cannot contradict each other.
  const bool is_free = minimum.lower_bound > question.clearance;
  return {segment, minimum, is_free ? provenFree() : scene.timeOfContact(pairs, motion, question)};
}

}  // namespace

double Segment::timeAt(double fraction) const {
  if (fraction >= 1.0) return end;
  const double time = begin + fraction * (end - begin);
  return time > end ? end : time;  // so that NaN stays
}

Positions Segment::positionsAt(double fraction) const {
  Positions positions = from;
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += fraction * (to[i] - from[i]);
  return positions;
}

bool TrajectorySegments::next(Segment& segment) {
  if (!last_) last_ = readWayPoint();
  std::optional<WayPoint> way_point = last_ ? readWayPoint() : std::nullopt;
  if (!way_point && segments_ == 0) {
    throw std::invalid_argument(states_.source() + ": a trajectory has at least two way points, this one has " +
                                (last_ ? "1" : "none"));
  }
  if (!way_point) return false;
  segment = {segments_++, last_->time, way_point->time, last_->positions, way_point->positions};
  last_ = std::move(way_point);
  return true;
}

std::optional<TrajectorySegments::WayPoint> TrajectorySegments::readWayPoint() {
  WayPoint way_point;
  if (!states_.next(way_point.positions)) return std::nullopt;
  way_point.time = states_.time().value_or(last_ ? last_->time + 1.0 : 0.0);
  if (last_ && way_point.time <= last_->time) {
    throw std::invalid_argument(states_.place() + ": column \"time\": " + numberText(way_point.time) +
                                " is not later than " + numberText(last_->time));
  }
  return way_point;
}

void answerSegments(const ClearanceQuestion& question, const MotionQuestion& motion_question, JointStates& states,
                    const std::function<void(const SegmentClearance&)>& take) {
  TrajectorySegments segments(states);
  const auto answerBlock = [&](const std::vector<Segment>& block) {
    MovingScene scene(question.model);
    std::vector<SegmentClearance> answers;
    for (const Segment& segment : block) {
      answers.push_back(answerSegment(question.pairs, motion_question, segment, scene));
    }
    return answers;
  };
  answerInBlocks<Segment, SegmentClearance>(
      {kBlockSize, [&](Segment& segment) { return segments.next(segment); }, answerBlock, take}, question.threads);
}

}  // namespace proximity_server
