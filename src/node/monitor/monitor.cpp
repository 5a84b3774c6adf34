#include "node/monitor/monitor.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "node/monitor/clearance_level.h"
#include "node/monitor/lookahead.h"
#include "node/robot/conversions.h"
#include "node/services/pair_questions.h"
#include "node/services/requests.h"

namespace proximity_server::node {
namespace {

using Clock = std::chrono::steady_clock;

std::size_t longestName(const scene::RobotModel& robot) {
  std::size_t longest = 0;
  for (const scene::Link& link : robot.links) longest = std::max(longest, link.name.size());
  for (const scene::Collision& collision : robot.collisions) longest = std::max(longest, collision.name.size());
  return longest;
}

/// Reserves memory for names of so many characters.
void makeRoom(Proximity& message, std::size_t characters) {
  for (std::string* name : {&message.a.link, &message.a.name, &message.b.link, &message.b.name})
    name->reserve(characters);
}

/// The status for a robot of which the filter leaves no pair.
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
  scene_ = robot_->borrowScene();
  moving_scene_ = robot_->borrowMovingScene();
  bodies_ = robot_->candidateBodies();
  joints_ = jointsThatMatter(robot_->robotModel(), robot_->candidates().list());
  level_ = Clearance::INVALID;
  longest_name_ = longestName(robot_->robotModel());
}

const Clearance& Monitor::cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                const MonitorSettings& settings) {
  const Clock::time_point start = Clock::now();
  clearance_.header.stamp = snapshot.stamp;
  clearance_.header.frame_id = robot_->referenceFrame();
  clearance_.status = snapshot.status;
  assignUnknown(clearance_.minimum);
  clearance_.tf_age = snapshot.age;
  clearance_.tf_skew = snapshot.skew;
  ++clearance_.cycle;
  measure(snapshot, settings);
  lookAhead(snapshot, velocities, settings);

  const std::chrono::duration<double> elapsed = Clock::now() - start;
  clearance_.computation_time = ros::Duration(elapsed.count());
  return clearance_;
}

void Monitor::measure(const PoseSnapshot& snapshot, const MonitorSettings& settings) {
  scene::Question question;
  question.tolerance = robot_->config().tolerance;
  question.threshold = settings.threshold;
  const scene::Candidates& pairs = robot_->candidates();
  scene_->update(snapshot.poses);

  const scene::PairsBelow below = scene_->closestBelow(pairs, std::max(1, settings.max_reported_pairs), question);
  report(snapshot, below, question, static_cast<std::size_t>(settings.max_reported_pairs));
  const scene::PairProximity* minimum = below.closest.empty() ? nullptr : &below.closest.front();
  if (!minimum) {
    question.threshold = scene::Question().threshold;
    minimum = scene_->minimum(pairs, question);
  }
  countPairs();

  const bool known = minimum && clearance_.pairs_unknown == 0;
  if (!known && clearance_.status.code == QueryStatus::OK) {
    clearance_.status = pairs.empty() ? nothingToCheck() : incompleteness(*robot_, scene_->counts(), question);
  }
  level_ = known ? clearanceLevel(minimum->result.lower_bound, level_, settings)
                 : static_cast<std::uint8_t>(Clearance::INVALID);
  clearance_.level = level_;
  if (!known) return;
  makeRoom(clearance_.minimum, longest_name_);
  assign(clearance_.minimum, robot_->robotModel(), snapshot.poses, *minimum, question);
  clearance_.status.code = statusCode(minimum->result);
}

void Monitor::report(const PoseSnapshot& snapshot, const scene::PairsBelow& below, const scene::Question& question,
                     std::size_t most) {
  std::vector<Proximity>& listed = clearance_.below_threshold;
  clearance_.pairs_below_threshold = static_cast<std::uint32_t>(below.count);
  listed.reserve(most);
  unlisted_.reserve(most);
  while (listed.size() + unlisted_.size() < most) makeRoom(unlisted_.emplace_back(), longest_name_);
  const std::size_t count = std::min(below.closest.size(), most);
  for (; listed.size() > count; listed.pop_back()) unlisted_.push_back(std::move(listed.back()));
  for (; listed.size() < count; unlisted_.pop_back()) listed.push_back(std::move(unlisted_.back()));
  for (std::size_t i = 0; i < count; ++i) {
    makeRoom(listed[i], longest_name_);
    assign(listed[i], robot_->robotModel(), snapshot.poses, below.closest[i], question);
  }
}

void Monitor::lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                        const MonitorSettings& settings) {
  clearance_.lookahead = noLookahead(settings);
  if (settings.lookahead == 0.0) return;
  if (clearance_.level == Clearance::INVALID) {
    clearance_.lookahead.status = clearance_.status;
    return;
  }
  const scene::Candidates& pairs = robot_->candidates();
  clearance_.lookahead = contactAhead(*robot_, *moving_scene_, pairs, snapshot.poses, velocities, settings);
}

void Monitor::countPairs() {
  const scene::PairTable& table = robot_->sceneModel().pairs;
  assignCounts(clearance_, scene_->counts());
  clearance_.pairs_total = static_cast<std::uint32_t>(table.pairs.size());
  clearance_.pairs_filtered = static_cast<std::uint32_t>(table.pairs.size() - table.checked.size());
}

}  // namespace proximity_server::node
