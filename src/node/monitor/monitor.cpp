#include "node/monitor/monitor.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "node/monitor/clearance_level.h"
#include "node/objects/object_needs.h"
#include "node/robot/conversions.h"
#include "node/services/pair_questions.h"
#include "node/services/requests.h"

namespace proximity_server::node {
namespace {

using Clock = std::chrono::steady_clock;

std::size_t longestName(const scene::RobotModel& robot, const scene::Objects& objects) {
  std::size_t longest = 0;
  for (const int number : objects.numbers()) longest = std::max(longest, objects.object(number)->id.size());
  for (const scene::Link& link : robot.links) longest = std::max(longest, link.name.size());
  for (const scene::Member& member : robot.robots) longest = std::max(longest, member.name.size());
  for (const scene::Collision& collision : robot.collisions) longest = std::max(longest, collision.name.size());
  return longest;
}

/// Reserves memory for names of so many characters.
void makeRoom(Proximity& message, std::size_t characters) {
  for (ShapeRef* ref : {&message.a, &message.b})
    for (std::string* name : {&ref->link, &ref->name, &ref->robot}) name->reserve(characters);
}

bool hasObject(const scene::PairProximity& pair) { return pair.asked.a.link < 0 || pair.asked.b.link < 0; }

/// The status for a robot of which the filter leaves no pair.
QueryStatus nothingToCheck() {
  QueryStatus status;
  status.code = QueryStatus::NO_COLLISION_GEOMETRY;
  status.message = "the filter leaves no pair to check";
  return status;
}

}  // namespace

MonitoredObjects::MonitoredObjects(const Robot& robot, const RobotObjects& present)
    : objects(present),
      bodies(bodiesOfCheckedPairs(robot, *present.all)),
      movers(moversOf(robot, *present.all)),
      frames(framesOf(*present.all)),
      longest_name(longestName(robot.robotModel(), *present.all)) {}

void Monitor::follow(const std::shared_ptr<const Robot>& robot) {
  scene_.reset();
  moving_scene_.reset();
  robot_ = robot;
  scene_ = robot_->borrowScene();
  moving_scene_ = robot_->borrowMovingScene();
  self_level_ = object_level_ = Clearance::INVALID;
  MonitoredObjects objects(*robot_, robot_->objects().get());
  use(objects);
}

void Monitor::use(MonitoredObjects& objects) {
  scene_->use(objects.objects.all);
  std::swap(monitored_, objects);
}

const Clearance& Monitor::cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                const MonitorSettings& settings, const FrameSnapshot& frames) {
  const Clock::time_point start = Clock::now();
  clearance_.header.stamp = snapshot.stamp;
  clearance_.header.frame_id = robot_->referenceFrame();
  clearance_.status = snapshot.status;
  clearance_.objects_revision = objects().revision;
  for (Proximity* minimum : {&clearance_.minimum, &clearance_.self_minimum, &clearance_.object_minimum})
    assignUnknown(*minimum);
  clearance_.tf_age = snapshot.age;
  clearance_.tf_skew = snapshot.skew;
  ++clearance_.cycle;
  measure(snapshot, frames, settings);
  lookAhead(snapshot, velocities, settings, frames);

  const std::chrono::duration<double> elapsed = Clock::now() - start;
  clearance_.computation_time = ros::Duration(elapsed.count());
  return clearance_;
}

void Monitor::measure(const PoseSnapshot& snapshot, const FrameSnapshot& frames, const MonitorSettings& settings) {
  scene::Question question;
  question.tolerance = robot_->config().tolerance;
  question.threshold = settings.threshold;
  const scene::Candidates& pairs = robot_->candidates();
  if (frames.poses.size() == monitored_.frames.names.size())
    scene_->update(snapshot.poses, frames.poses);
  else
    scene_->update(snapshot.poses);

  const scene::PairsBelow below = scene_->closestBelow(pairs, std::max(1, settings.max_reported_pairs), question);
  report(snapshot, below, question, static_cast<std::size_t>(settings.max_reported_pairs));
  const scene::PairProximity* minimum = below.closest.empty() ? nullptr : &below.closest.front();
  question.threshold = scene::Question().threshold;
  if (!minimum) minimum = scene_->minimum(pairs, question);
  countPairs();

  if (minimum && clearance_.pairs_unknown == 0) {
    judge(snapshot, scene::PairProximity(*minimum), question, settings);
    return;
  }
  self_level_ = object_level_ = clearance_.level = Clearance::INVALID;
  if (clearance_.status.code != QueryStatus::OK) return;
  const bool nothing = pairs.empty() && objects().all->pairCount() == 0;
  clearance_.status = nothing ? nothingToCheck() : incompleteness(*robot_, scene_->counts(), question);
  if (!nothing && frames.status.code != QueryStatus::OK) clearance_.status = frames.status;
}

/// The level and the minimum of each kind of pairs; all poses are known.
void Monitor::judge(const PoseSnapshot& snapshot, const scene::PairProximity& minimum, const scene::Question& question,
                    const MonitorSettings& settings) {
  const auto say = [&](Proximity& message, const scene::PairProximity& pair) {
    makeRoom(message, monitored_.longest_name);
    assign(message, named(), snapshot.poses, pair, question);
  };
  say(clearance_.minimum, minimum);
  clearance_.status.code = statusCode(minimum.result);

  const auto of_links = minimumOf(scene::PairKind::OfLinks, minimum, question);
  if (of_links) say(clearance_.self_minimum, *of_links);
  self_level_ = of_links ? clearanceLevel(of_links->result.lower_bound, self_level_, settings)
                         : static_cast<std::uint8_t>(Clearance::CLEAR);

  const auto with_object = minimumOf(scene::PairKind::WithObject, minimum, question);
  if (with_object) say(clearance_.object_minimum, *with_object);
  object_level_ = with_object ? clearanceLevel(with_object->result.lower_bound, object_level_, ofObjects(settings))
                              : static_cast<std::uint8_t>(Clearance::CLEAR);
  clearance_.level = std::max(self_level_, object_level_);
}

/// The closest pair of a kind, given the closest of all; nullopt if no pair of this kind is checked.
std::optional<scene::PairProximity> Monitor::minimumOf(scene::PairKind kind, const scene::PairProximity& minimum,
                                                       const scene::Question& question) {
  if (hasObject(minimum) == (kind == scene::PairKind::WithObject)) return minimum;
  const scene::Candidates& pairs = robot_->candidates();
  const bool is_empty = kind == scene::PairKind::WithObject ? objects().all->pairCount() == 0 : pairs.empty();
  const scene::PairProximity* found = is_empty ? nullptr : scene_->minimum(scene::Pairs(pairs, kind), question);
  if (!found) return std::nullopt;
  return *found;
}

void Monitor::report(const PoseSnapshot& snapshot, const scene::PairsBelow& below, const scene::Question& question,
                     std::size_t most) {
  std::vector<Proximity>& listed = clearance_.below_threshold;
  clearance_.pairs_below_threshold = static_cast<std::uint32_t>(below.count);
  listed.reserve(most);
  unlisted_.reserve(most);
  while (listed.size() + unlisted_.size() < most) makeRoom(unlisted_.emplace_back(), monitored_.longest_name);
  const std::size_t count = std::min(below.closest.size(), most);
  for (; listed.size() > count; listed.pop_back()) unlisted_.push_back(std::move(listed.back()));
  for (; listed.size() < count; unlisted_.pop_back()) listed.push_back(std::move(unlisted_.back()));
  for (std::size_t i = 0; i < count; ++i) {
    makeRoom(listed[i], monitored_.longest_name);
    assign(listed[i], named(), snapshot.poses, below.closest[i], question);
  }
}

void Monitor::lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                        const MonitorSettings& settings, const FrameSnapshot& frames) {
  clearance_.lookahead = noLookahead(settings);
  if (settings.lookahead == 0.0) return;
  if (clearance_.level == Clearance::INVALID) {
    clearance_.lookahead.status = clearance_.status;
    return;
  }
  if (moving_scene_->objects() != objects().all.get()) moving_scene_->use(objects().all);
  const LookaheadStart start{snapshot.poses, monitored_.frames, frames};
  clearance_.lookahead = contactAhead(*robot_, *moving_scene_, start, velocities, settings);
}

void Monitor::countPairs() {
  const scene::PairTable& table = robot_->sceneModel().pairs;
  assignCounts(clearance_, scene_->counts());
  const std::uint64_t total = table.pairs.size() + static_cast<std::uint64_t>(objects().all->pairCount());
  clearance_.pairs_total = static_cast<std::uint32_t>(std::min<std::uint64_t>(total, UINT32_MAX));
  clearance_.pairs_filtered = static_cast<std::uint32_t>(table.pairs.size() - table.checked.size());
}

}  // namespace proximity_server::node
