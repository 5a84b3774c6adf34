#include "tools/clearance/trajectory_run.h"

#include "proximity_server/scene/motion/frames_on_links.h"
#include "system/pipeline.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/text/csv.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {
namespace {

// So few that the hundreds of segments of a planned trajectory use all threads.
constexpr std::size_t kSegmentsInBlock = 16;

scene::RobotTimeOfContact provenFree() {
  scene::RobotTimeOfContact free;
  free.status = narrowphase::Status::Converged;
  free.t_free = 1.0;
  return free;
}

SegmentClearance answerSegment(const TrajectorySegment& segment, const scene::Pairs& pairs,
                               const scene::MotionQuestion& question, scene::MovingScene& scene) {
  scene::RobotMotion motion = scene::RobotMotion::between(scene.model().robot, segment.from, segment.to);
  if (segment.objects) motion.carryObjects(framesOnLinks(*segment.objects));
  const scene::RobotMinimum minimum = scene.minimum(pairs, motion, question);
  // If the minimum proves that there is no contact, a search is not needed, and the two cannot contradict each other.
  const bool is_free =
      minimum.status != narrowphase::Status::Unknown && minimum.lower_bound > question.contact_distance;
  return {segment, minimum, is_free ? provenFree() : scene.timeOfContact(pairs, motion, question)};
}

}  // namespace

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
  if (!last_) last_ = readWayPoint();
  std::optional<WayPoint> way_point = last_ ? readWayPoint() : std::nullopt;
  if (!way_point && way_points_ == 0) {
    throw std::invalid_argument(states_.source() + ": a trajectory has at least two way points, this one has " +
                                (last_ ? "1" : "none"));
  }
  if (!way_point) return false;
  ++way_points_;
  segment = {0, last_->time, way_point->time, last_->positions, way_point->positions};
  last_ = std::move(way_point);
  return true;
}

/// Cuts the segment where objects change next, and keeps the rest of it.
void TrajectorySegments::divide(TrajectorySegment& segment) {
  objects_->advance(way_points_ - 1, segment.begin, segment.from);
  const std::optional<double> change = objects_->nextTime();
  if (!change || !(*change < segment.end)) return;
  rest_ = segment;
  rest_->begin = segment.end = *change;
  const double fraction = (*change - segment.begin) / (rest_->end - segment.begin);
  rest_->from = segment.to = segment.positionsAt(fraction);
}

std::optional<TrajectorySegments::WayPoint> TrajectorySegments::readWayPoint() {
  WayPoint way_point;
  if (!states_.next(way_point.positions)) return std::nullopt;
  way_point.time = states_.time().value_or(last_ ? last_->time + 1.0 : 0.0);
  if (last_) check(*last_, way_point);
  return way_point;
}

void TrajectorySegments::check(const WayPoint& from, const WayPoint& to) const {
  const auto fail = [&](const std::string& column, double of_to, const std::string& what, double of_from) {
    throw std::invalid_argument(states_.place() + ": column \"" + column + "\": " + shortest(of_to) + what +
                                shortest(of_from));
  };
  if (to.time <= from.time) fail("time", to.time, " is not later than ", from.time);
  if (!std::isfinite(to.time - from.time)) fail("time", to.time, " is too far from ", from.time);
  for (std::size_t i = 0; i < to.positions.size(); ++i) {
    if (std::isfinite(to.positions[i] - from.positions[i])) continue;
    fail(states_.robot().joints[i].name, to.positions[i], " is too far from ", from.positions[i]);
  }
}

void answerSegments(const ClearanceQuestion& question, StateSource& states, AnswerOutput& output) {
  TrajectorySegments segments(states, question.objects.get());
  const scene::MovingScene fresh(question.model);
  const auto next = [&](TrajectorySegment& segment) { return segments.next(segment); };
  const auto answerBlock = [&](const std::vector<TrajectorySegment>& block) {
    scene::MovingScene scene = fresh.forAnotherThread();
    QuestionPairs pairs(question);
    std::vector<SegmentClearance> answers;
    for (const TrajectorySegment& segment : block) {
      pairs.use(segment.objects, scene);
      answers.push_back(answerSegment(segment, pairs.get(), question.motion, scene));
    }
    return answers;
  };
  const auto write = [&](const SegmentClearance& answer) {
    const scene::RobotModel& robot = question.model->robot;
    output.rows.write({rowText(answer, robot, output.format), 1});
    if (output.plot) output.plot->write({rowText(answer, robot, RowFormat::Csv), 1});
    if (output.assertion) output.assertion->add(answer);
    output.counter.count(1);
  };
  system::answerInBlocks<TrajectorySegment, SegmentClearance>({kSegmentsInBlock, next, answerBlock, write},
                                                              question.threads);
}

}  // namespace proximity_server::tools
