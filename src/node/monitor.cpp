#include "monitor.h"

#include <algorithm>
#include <chrono>

#include "clearance_level.h"
#include "conversions.h"
#include "lookahead.h"
#include "requests.h"

namespace proximity_server {
namespace {

using Clock = std::chrono::steady_clock;

/// No pair at all: the robot cannot get close to itself.
QueryStatus nothingToCheck() {
  QueryStatus status;
  status.code = QueryStatus::NO_COLLISION_GEOMETRY;
  status.message = "the filter leaves no pair to check";
  return status;
}

}  // namespace

void Monitor::follow(const std::shared_ptr<const Robot>& robot) {
  scene_.reset();
  moving_scene_.reset();
  robot_ = robot;
  scene_ = robot_->takeScene();
  moving_scene_ = robot_->takeMovingScene();
  bodies_ = bodiesOf(robot_->links(), scene_->candidates());
  joints_ = jointsThatMatter(robot_->links(), scene_->candidates());
  level_ = Clearance::INVALID;
}

Clearance Monitor::cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                         const MonitorSettings& settings) {
  const Clock::time_point start = Clock::now();
  Clearance clearance;
  clearance.header.stamp = snapshot.stamp;
  clearance.header.frame_id = robot_->referenceFrame();
  clearance.status = snapshot.status;
  clearance.minimum = unknownProximity();
  clearance.tf_age = snapshot.age;
  clearance.tf_skew = snapshot.skew;
  clearance.cycle = ++cycles_;
  measure(snapshot, settings, clearance);
  lookAhead(snapshot, velocities, settings, clearance);

  const std::chrono::duration<double> elapsed = Clock::now() - start;
  clearance.computation_time = ros::Duration(elapsed.count());
  return clearance;
}

void Monitor::measure(const PoseSnapshot& snapshot, const MonitorSettings& settings, Clearance& clearance) {
  Question question;
  question.tolerance = robot_->config().tolerance;
  question.threshold = settings.threshold;
  const std::vector<SubjectPair>& pairs = scene_->candidates();
  scene_->update(snapshot.poses);

  const std::vector<PairProximity>& below = scene_->below(pairs, question);
  clearance.pairs_below_threshold = static_cast<std::uint32_t>(below.size());
  const std::size_t reported = std::min(below.size(), static_cast<std::size_t>(settings.max_reported_pairs));
  for (std::size_t i = 0; i < reported; ++i) {
    clearance.below_threshold.push_back(toMessage(robot_->links(), snapshot.poses, below[i], question));
  }

  const PairProximity* minimum = below.empty() ? nullptr : &below.front();
  if (!minimum) {
    question.threshold = Question().threshold;
    minimum = scene_->minimum(pairs, question);
  }
  countPairs(clearance);

  const bool known = minimum && clearance.pairs_unknown == 0;
  if (!known && clearance.status.code == QueryStatus::OK) clearance.status = nothingToCheck();
  level_ = known ? clearanceLevel(minimum->result.lower_bound, level_, settings)
                 : static_cast<std::uint8_t>(Clearance::INVALID);
  clearance.level = level_;
  if (!known) return;
  clearance.minimum = toMessage(robot_->links(), snapshot.poses, *minimum, question);
  clearance.status.code = statusCode(minimum->result);
}

void Monitor::lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                        const MonitorSettings& settings, Clearance& clearance) {
  clearance.lookahead = noLookahead(settings);
  if (settings.lookahead == 0.0) return;
  if (clearance.level == Clearance::INVALID) {
    clearance.lookahead.status = clearance.status;
    return;
  }
  const std::vector<SubjectPair>& pairs = scene_->candidates();
  clearance.lookahead = contactAhead(*robot_, *moving_scene_, pairs, snapshot.poses, velocities, settings);
}

void Monitor::countPairs(Clearance& clearance) const {
  const PairTable& table = robot_->model().pairs;
  const PairCounts& counts = scene_->counts();
  clearance.pairs_total = static_cast<std::uint32_t>(table.pairs.size());
  clearance.pairs_filtered = static_cast<std::uint32_t>(table.pairs.size() - table.checked.size());
  clearance.pairs_unknown = static_cast<std::uint32_t>(counts.unknown);
  clearance.pairs_at_rest = static_cast<std::uint32_t>(counts.at_rest);
  clearance.pairs_by_motion = static_cast<std::uint32_t>(counts.by_motion);
  clearance.pairs_by_bounds = static_cast<std::uint32_t>(counts.by_bounds);
  clearance.pairs_computed = static_cast<std::uint32_t>(counts.computed);
}

}  // namespace proximity_server
