#include "node/monitor/monitor.h"

#include "node/answers/gradients.h"
#include "node/answers/guarantees.h"
#include "node/answers/statuses.h"
#include "node/monitor/pose_age.h"
#include "node/objects/object_needs.h"
#include "node/robot/query_status.h"
#include "system/durations.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

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

std::uint8_t levelCode(scene::ClearanceLevel level) {
  static_assert(Clearance::CLEAR == static_cast<std::uint8_t>(scene::ClearanceLevel::Clear) &&
                Clearance::WARN == static_cast<std::uint8_t>(scene::ClearanceLevel::Warn) &&
                Clearance::STOP == static_cast<std::uint8_t>(scene::ClearanceLevel::Stop) &&
                Clearance::COLLISION == static_cast<std::uint8_t>(scene::ClearanceLevel::Collision));
  return static_cast<std::uint8_t>(level);
}

/// Returns whether the level of all pairs is set by `p`, and not by `q`. Each of the two sets the level of its kind of
/// pairs.
bool outranks(const scene::GuaranteedDecidingPair& p, const scene::GuaranteedDecidingPair& q) {
  const auto excess = [](const scene::GuaranteedDecidingPair& deciding) {
    return deciding.guaranteed - deciding.level.threshold;
  };
  return p.level.level != q.level.level ? p.level.level > q.level.level : excess(p) <= excess(q);
}

bool hasObject(const scene::PairProximity& pair) { return !pair.asked.areLinks(); }

}  // namespace

MonitoredObjects::MonitoredObjects(const Robot& robot, const RobotObjects& present)
    : objects(present),
      bodies(withInequalities(robot, bodiesOfCheckedPairs(robot, *present.all))),
      motion_sources(motionSourcesOf(robot, *present.all)),
      frames(framesOf(*present.all)),
      carriers(carriersOf(robot, *present.all)),
      longest_name(longestName(robot.robotModel(), *present.all)) {}

void Monitor::follow(const std::shared_ptr<const Robot>& robot) {
  scenes_.reset();
  constraints_.reset();
  broken_.reset();
  robot_ = robot;
  text_.emplace(robot_->robotModel());
  scenes_ = robot_->borrowScenes();
  self_level_ = object_level_ = std::nullopt;
  thresholds_ = *robot_->thresholds();
  scale_input_ = {};
  if (guaranteed()) guaranteed()->assume(robot_->uncertainty());
  MonitoredObjects objects(*robot_, robot_->objects().get());
  use(objects);
}

void Monitor::assumeLevel(Clearance::_level_type level) {
  self_level_ = object_level_ = std::nullopt;
  if (level < Clearance::INVALID) self_level_ = object_level_ = static_cast<scene::ClearanceLevel>(level);
}

void Monitor::use(MonitoredObjects& objects) {
  scenes_->state.set(objects.objects.all, objects.carriers);
  std::swap(monitored_, objects);
  text_capacity_ = text_->capacity(monitored_.longest_name);
  aged_ = robot_->uncertainty();
}

const Clearance& Monitor::cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                const MonitorSettings& settings, const FrameSnapshot& frames,
                                const CommandedMotion& commanded) {
  const Clock::time_point start = Clock::now();
  clearance_.header.stamp = snapshot.stamp;
  clearance_.header.frame_id = robot_->referenceFrame();
  clearance_.status = snapshot.status;
  clearance_.objects_revision = objects().revision;
  for (Proximity* pair :
       {&clearance_.deciding, &clearance_.minimum, &clearance_.self_minimum, &clearance_.object_minimum})
    assignUnknown(*pair);
  clearance_.deciding_threshold = kNaN;
  clearance_.deciding_reached = false;
  clearance_.by_guaranteed = robot_->isUncertain();
  clearance_.tf_age = snapshot.age;
  clearance_.tf_skew = snapshot.skew;
  ++clearance_.cycle;
  if (frames.poses.size() == monitored_.frames.names.size())
    scenes_->state.set(snapshot.poses, frames.poses);
  else
    scenes_->state.set(snapshot.poses);
  assignJoints(snapshot, settings);
  findBroken(snapshot);
  measurePairs({snapshot, frames, settings}, velocities);
  lookAhead(snapshot, velocities, settings, frames, commanded);

  const std::chrono::duration<double> elapsed = Clock::now() - start;
  clearance_.computation_time = ros::Duration(elapsed.count());
  return clearance_;
}

void Monitor::assignJoints(const PoseSnapshot& snapshot, const MonitorSettings& settings) {
  text_->move(snapshot.poses, snapshot.stamp);
  if (!settings.gradients) {
    clearance_.joint_names.clear();
    clearance_.joint_positions.clear();
    return;
  }
  assignColumns(clearance_.joint_names, state().degreesOfFreedom());
  assignPositions(clearance_.joint_positions, state(), snapshot.poses);
}

/// Reserves as much memory as any pair needs.
void Monitor::reserveMemory(Proximity& message, const MonitorSettings& settings) const {
  node::reserveNames(message.a, monitored_.longest_name);
  node::reserveNames(message.b, monitored_.longest_name);
  if (settings.gradients) message.gradient.reserve(static_cast<std::size_t>(state().degreesOfFreedom().size()));
}

void Monitor::assignPair(Proximity& message, const Cycle& cycle, const scene::PairProximity& pair) {
  reserveMemory(message, cycle.settings);
  assign(message, model(), cycle.snapshot.poses, pair, cycle.question);
  if (cycle.age.code != QueryStatus::OK)
    message.guaranteed = kNaN;
  else if (guaranteed())
    message.guaranteed = guaranteedOf(pair, cycle.settings);
  if (cycle.settings.gradients) assignGradient(message, state(), pair);
}

/// [m] It is tight only near the thresholds.
double Monitor::guaranteedOf(const scene::PairProximity& pair, const MonitorSettings& settings) {
  const double enough = thresholds(settings).warn.of(pair.asked) + settings.hysteresis;
  return guaranteed()->of(state(), pair, enough);
}

const ConstraintRows& Monitor::constraints(const PoseSnapshot& snapshot, const MonitorSettings& settings) {
  if (!constraints_ || constraints_->capacity() != settings.max_constraints)
    constraints_.emplace(*robot_, settings.max_constraints);
  return constraints_->rowsOf(
      {clearance_, snapshot, *scenes_, thresholds(settings).stop, model(), guaranteed(), monitored_.longest_name},
      settings);
}

/// The limits of the guaranteed distances of a cycle that begins now: steps for the time of a search, and the clock if
/// they take twice as long.
scene::GuaranteeLimits Monitor::limits(const MonitorSettings& settings) const {
  scene::GuaranteeLimits limits;
  limits.most_steps = scene::stepsIn(searchTime(settings));
  if (steps_to_deadline_)
    limits.steps_to_deadline = *steps_to_deadline_;
  else
    limits.deadline = system::deadlineIn(2.0 * searchTime(settings));
  return limits;
}

/// Prepares the guaranteed distances at the poses of this cycle. No cycle depends on those before it, so that a replay
/// ends them at the same steps.
QueryStatus Monitor::prepareGuaranteed(const Cycle& cycle, const VelocitySnapshot& velocities) {
  if (!guaranteed()) return {};
  guaranteed()->limit(limits(cycle.settings));
  guaranteed()->forget();
  if (robot_->config().pose_latency == PoseLatency::Off) return {};
  const QueryStatus status =
      addAge(*robot_, {cycle.snapshot, velocities, monitored_.frames, cycle.frames, monitored_.motion_sources},
             *objects().all, aged_);
  guaranteed()->assume(aged_);
  return status;
}

void Monitor::measurePairs(Cycle cycle, const VelocitySnapshot& velocities) {
  const FrameSnapshot& frames = cycle.frames;
  cycle.question.tolerance = robot_->config().tolerance;
  cycle.question.threshold = cycle.settings.threshold;
  const scene::Candidates& pairs = robot_->candidates();
  cycle.age = prepareGuaranteed(cycle, velocities);

  const scene::PairsBelow below =
      scenes_->scene.closestBelow(state(), pairs, std::max(1, cycle.settings.max_reported_pairs), cycle.question);
  listPairs(cycle, below);
  if (guaranteed()) {
    near_ = below.closest;
    others_ = othersThan(below, cycle);
  }
  const scene::PairProximity* minimum = below.closest.empty() ? nullptr : &below.closest.front();
  cycle.question.threshold = scene::Question().threshold;
  if (!minimum) minimum = scenes_->scene.minimum(state(), pairs, cycle.question);
  countPairs();

  const bool is_guaranteed = cycle.age.code == QueryStatus::OK;
  if (minimum && clearance_.pairs_unknown == 0 && is_guaranteed) {
    assignLevels(cycle, scene::PairProximity(*minimum));
    return;
  }
  self_level_ = object_level_ = std::nullopt;
  clearance_.level = Clearance::INVALID;
  if (clearance_.status.code != QueryStatus::OK) return;
  const bool nothing = pairs.empty() && objects().all->pairCount() == 0;
  clearance_.status = nothing ? statusOf(QueryStatus::NO_COLLISION_GEOMETRY, "the filter leaves no pair to check")
                              : incompleteness(*robot_, scenes_->scene.counts(), cycle.question);
  if (!nothing && frames.status.code != QueryStatus::OK) clearance_.status = frames.status;
  if (!nothing && clearance_.pairs_unknown == 0 && !is_guaranteed) clearance_.status = cycle.age;
}

/// Sets the level and the minima of the clearance. All poses are known.
void Monitor::assignLevels(const Cycle& cycle, const scene::PairProximity& minimum) {
  assignPair(clearance_.minimum, cycle, minimum);
  clearance_.status.code = statusCode(minimum.result);
  const auto of_links = levelOfKind(scene::PairKind::OfLinks, cycle, minimum);
  const auto with_object = levelOfKind(scene::PairKind::WithObject, cycle, minimum);
  const scene::GuaranteedDecidingPair& deciding =
      !with_object || (of_links && outranks(*of_links, *with_object)) ? *of_links : *with_object;
  assignPair(clearance_.deciding, cycle, deciding.pair);
  clearance_.deciding.guaranteed = deciding.guaranteed;
  clearance_.deciding_threshold = deciding.level.threshold;
  clearance_.deciding_reached = isReached(deciding);
  clearance_.level = levelCode(deciding.level.level);
  explain(deciding.pair, cycle.snapshot);
}

/// Writes the text about the pair that sets the level. Far from all thresholds its motion does not matter.
void Monitor::explain(const scene::PairProximity& deciding, const PoseSnapshot& snapshot) {
  explained_.gradient.clear();
  if (clearance_.level != Clearance::CLEAR) assignGradient(explained_, state(), deciding);
  clearance_.status.message.reserve(text_capacity_);
  text_->write(clearance_.status.message, clearance_, explained_.gradient);
  if (broken_) text_->append(clearance_.status.message, *broken_);
  if (snapshot.beyond) {
    clearance_.status.message += "; ";
    append(clearance_.status.message, *robot_, *snapshot.beyond);
  }
  if (guaranteed()) appendEnd(clearance_.status.message, "; ", *guaranteed());
}

/// Finds the inequality that is broken most.
void Monitor::findBroken(const PoseSnapshot& snapshot) {
  broken_.reset();
  double largest = 1.0;
  for (const scene::JointInequality& inequality : robot_->robotModel().inequalities) {
    const auto excess = excessAt(robot_->robotModel(), inequality, snapshot.poses, snapshot.stated);
    if (!excess || !(*excess / inequality.tolerance() > largest)) continue;
    largest = *excess / inequality.tolerance();
    broken_ = BrokenInequality{&inequality, *excess};
  }
}

/// Sets the minimum and the level of one kind of pairs, and returns the pair that sets this level; nullopt if no pair
/// of this kind is checked.
std::optional<scene::GuaranteedDecidingPair> Monitor::levelOfKind(scene::PairKind kind, const Cycle& cycle,
                                                                  const scene::PairProximity& minimum) {
  const bool of_links = kind == scene::PairKind::OfLinks;
  std::optional<scene::ClearanceLevel>& level = of_links ? self_level_ : object_level_;
  const auto closest = minimumOf(kind, minimum, cycle.question);
  if (!closest) {
    level = scene::ClearanceLevel::Clear;
    return std::nullopt;
  }
  assignPair(of_links ? clearance_.self_minimum : clearance_.object_minimum, cycle, *closest);
  const scene::Pairs pairs(robot_->candidates(), kind);
  const scene::LevelBefore before{level, cycle.settings.hysteresis};
  scene::GuaranteedDecidingPair deciding;
  if (guaranteed()) {
    deciding = scene::decidingPair(scenes_->scene, *guaranteed(), state(), pairs, *closest,
                                   {near_.data(), near_.data() + near_.size(), others_}, thresholds(cycle.settings),
                                   cycle.question, before);
  } else {
    deciding = {scene::decidingPair(scenes_->scene, state(), pairs, *closest, thresholds(cycle.settings),
                                    cycle.question, before)};
    deciding.guaranteed = deciding.pair.result.lower_bound;
  }
  level = deciding.level.level;
  return deciding;
}

/// Returns whether a state within the uncertainty is certainly at the level of the pair.
bool Monitor::isReached(const scene::GuaranteedDecidingPair& deciding) {
  if (deciding.level.level != scene::ClearanceLevel::Warn && deciding.level.level != scene::ClearanceLevel::Stop)
    return false;
  if (deciding.pair.result.upper_bound <= deciding.level.threshold) return true;
  return guaranteed() && guaranteed()->reached(state(), deciding.pair, deciding.level.threshold);
}

const scene::LevelThresholds& Monitor::thresholds(const MonitorSettings& settings) {
  assignDefaults(thresholds_, settings);
  return thresholds_;
}

/// The closest pair of a kind; nullopt if no pair of this kind is checked. `minimum` is the closest pair of all kinds.
std::optional<scene::PairProximity> Monitor::minimumOf(scene::PairKind kind, const scene::PairProximity& minimum,
                                                       const scene::Question& question) {
  if (hasObject(minimum) == (kind == scene::PairKind::WithObject)) return minimum;
  const scene::Candidates& pairs = robot_->candidates();
  const bool is_empty = kind == scene::PairKind::WithObject ? objects().all->pairCount() == 0 : pairs.empty();
  const scene::PairProximity* found =
      is_empty ? nullptr : scenes_->scene.minimum(state(), scene::Pairs(pairs, kind), question);
  if (!found) return std::nullopt;
  return *found;
}

void Monitor::listPairs(const Cycle& cycle, const scene::PairsBelow& below) {
  const auto most = static_cast<std::size_t>(cycle.settings.max_reported_pairs);
  std::vector<Proximity>& listed = clearance_.below_threshold;
  clearance_.pairs_below_threshold = static_cast<std::uint32_t>(below.count);
  listed.reserve(most);
  clearance_.levels.reserve(most);
  unlisted_.reserve(most);
  while (listed.size() + unlisted_.size() < most) unlisted_.emplace_back();
  for (Proximity& message : unlisted_) reserveMemory(message, cycle.settings);
  const std::size_t count = std::min(below.closest.size(), most);
  for (; listed.size() > count; listed.pop_back()) unlisted_.push_back(std::move(listed.back()));
  for (; listed.size() < count; unlisted_.pop_back()) listed.push_back(std::move(unlisted_.back()));
  clearance_.levels.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const scene::PairProximity& pair = below.closest[i];
    assignPair(listed[i], cycle, pair);
    clearance_.levels[i] = levelCode(scene::levelOf(pair, listed[i].guaranteed, thresholds(cycle.settings)).level);
  }
}

/// [m] No pair is closer that is not listed.
double Monitor::othersThan(const scene::PairsBelow& below, const Cycle& cycle) const {
  if (static_cast<std::size_t>(below.count) == below.closest.size()) return cycle.question.threshold;
  const narrowphase::SignedDistance& last = below.closest.back().result;
  return std::min(last.distance, last.lower_bound) - cycle.question.tolerance;
}

void Monitor::lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                        const MonitorSettings& settings, const FrameSnapshot& frames,
                        const CommandedMotion& commanded) {
  clearance_.lookahead = noLookahead(settings);
  if (settings.lookahead == 0.0) return;
  if (clearance_.level == Clearance::INVALID) {
    clearance_.lookahead.status = clearance_.status;
    return;
  }
  const LookaheadStart start{snapshot.poses, snapshot.stated, monitored_.frames, frames};
  const scene::PairDistances& stop = thresholds(settings).stop;
  clearance_.lookahead = commanded.followed.empty()
                             ? contactAhead(*robot_, scenes_->moving(), start, velocities, stop, settings)
                             : contactAlong(commanded, *robot_, scenes_->splines(), start, velocities, stop, settings);
  QueryStatus& status = clearance_.lookahead.status;
  if (status.code != QueryStatus::OK || commanded.text.empty()) return;
  if (!status.message.empty()) status.message += "; ";
  status.message += commanded.text;
}

StoppingScale Monitor::velocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                     const MonitorSettings& settings, const FrameSnapshot& frames) {
  if (clearance_.level == Clearance::INVALID) return {0.0, clearance_.status};
  const LookaheadStart start{snapshot.poses, snapshot.stated, monitored_.frames, frames};
  StoppingScale found = stoppingScale(*robot_, *scenes_, start, velocities, joints(), thresholds(settings).stop,
                                      snapshot.age, settings, guaranteed());
  if (found.status.code != QueryStatus::OK) return found;
  ScaleInput state{snapshot.poses,
                   frames.poses,
                   velocities.velocities,
                   snapshot.stated,
                   objects().all,
                   thresholds_.stop,
                   stopLatency(snapshot.age, settings)};
  const double period = settings.rate > 0.0 ? 1.0 / settings.rate : 0.0;
  if (found.is_complete) {
    scale_input_ = std::move(state);
    scale_ = found.scale;
  } else if (state.latency <= scale_input_.latency + period && differInLatencyOnly(state, scale_input_)) {
    found.scale = std::max(found.scale, scale_);
  }
  return found;
}

void Monitor::countPairs() {
  const scene::PairTable& table = robot_->sceneModel().pairs;
  assignCounts(clearance_, scenes_->scene.counts());
  const std::uint64_t total = table.pairs.size() + static_cast<std::uint64_t>(objects().all->pairCount());
  clearance_.pairs_total = static_cast<std::uint32_t>(std::min<std::uint64_t>(total, UINT32_MAX));
  clearance_.pairs_filtered = static_cast<std::uint32_t>(table.pairs.size() - table.checked.size());
}

}  // namespace proximity_server::node
