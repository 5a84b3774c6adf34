#include "node/monitor/monitor.h"

#include "node/answers/motions.h"
#include "node/monitor/pose_age.h"
#include "node/robot/query_status.h"
#include "system/durations.h"

#include <chrono>
#include <utility>

namespace proximity_server::node {

using Clock = std::chrono::steady_clock;

void Monitor::follow(const std::shared_ptr<const Robot>& robot) {
  scenes_.reset();
  constraints_.reset();
  robot_ = robot;
  scenes_ = robot_->borrowScenes();
  message_.follow(*robot_);
  assessment_ = {};
  thresholds_ = *robot_->thresholds();
  scales_ = {};
  if (guaranteed()) guaranteed()->assume(robot_->uncertainty());
  MonitoredObjects objects(*robot_, robot_->objects().get());
  use(objects);
}

void Monitor::assumeLevel(Clearance::_level_type level) {
  std::optional<scene::ClearanceLevel> assumed;
  if (level < Clearance::INVALID) assumed = static_cast<scene::ClearanceLevel>(level);
  assessment_.of_links.level = assessment_.with_object.level = assumed;
}

void Monitor::use(MonitoredObjects& objects) {
  scenes_->state.set(objects.objects.all, objects.carriers);
  std::swap(monitored_, objects);
  message_.use(monitored_.objects.revision, monitored_.longest_name);
  aged_ = robot_->uncertainty();
}

const Clearance& Monitor::cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                const MonitorSettings& settings, const FrameSnapshot& frames,
                                const CommandedMotion& commanded) {
  const Clock::time_point start = Clock::now();
  scene::State& state = scenes_->state;
  if (frames.poses.size() == monitored_.frames.names.size())
    state.set(snapshot.poses, frames.poses);
  else
    state.set(snapshot.poses);
  assignDefaults(thresholds_, settings);
  assignTracked(robot_->config().tracked, *monitored_.objects.all, settings, thresholds_);
  const QueryStatus bounded = prepareGuaranteed(snapshot, velocities, settings, frames);
  scene::AssessmentQuestion question{thresholds_, snapshot.stated};
  question.question.tolerance = robot_->config().tolerance;
  question.question.threshold = settings.threshold;
  question.most_listed = settings.max_reported_pairs;
  question.hysteresis = settings.hysteresis;
  question.guaranteed = guaranteed();
  question.is_bounded = bounded.code == QueryStatus::OK;
  question.wants_gradients = settings.gradients;
  const LookaheadStart start_ahead{state, snapshot.stated, monitored_.frames, frames.may_move};
  if (settings.lookahead > 0.0 && velocities.status.code == QueryStatus::OK && knowsRoot(*robot_, snapshot.poses)) {
    assign(lookahead_.question(), *robot_, scenes_->motions(), start_ahead, velocities, commanded, settings);
    question.lookahead = &lookahead_;
  }
  const std::optional<scene::ClearanceLevel> before[] = {assessment_.of_links.level, assessment_.with_object.level};
  scene::assess(scenes_->scene, state, question, assessment_);
  if (const std::optional<scene::LevelDistances> distances = debounced(snapshot.stamp, settings)) {
    assessment_.of_links.level = before[0];
    assessment_.with_object.level = before[1];
    assignTracked(robot_->config().tracked, *monitored_.objects.all, *distances, thresholds_);
    scene::assess(scenes_->scene, state, question, assessment_);
    assignTracked(robot_->config().tracked, *monitored_.objects.all, settings, thresholds_);
  }

  Clearance& message = message_.write({snapshot, frames, settings, state, assessment_, bounded, question.guaranteed});
  if (assessment_.ahead) {
    assign(message.lookahead, *assessment_.ahead, *robot_, start_ahead, commanded, settings);
  } else {
    message.lookahead = noLookahead(settings);
    if (settings.lookahead > 0.0) message.lookahead.status = assessment_.level ? velocities.status : message.status;
  }
  message.computation_time = ros::Duration(std::chrono::duration<double>(Clock::now() - start).count());
  return message;
}

/// The distances for a level without sensed pairs, if the level has been so for less than the debounce. A pair in contact
/// and a pair without a sensed source set it at once.
std::optional<scene::LevelDistances> Monitor::debounced(const ros::Time& stamp, const MonitorSettings& settings) {
  if (!(settings.sensed_debounce > 0.0) || !assessment_.level) return std::nullopt;
  const scene::ClearanceLevel level = assessment_.level->level;
  const auto is_early = [&](scene::ClearanceLevel of, std::optional<ros::Time>& since) {
    if (level < of)
      since.reset();
    else if (!since || stamp < *since)
      since = stamp;
    return since && (stamp - *since).toSec() < settings.sensed_debounce;
  };
  const bool is_early_warn = is_early(scene::ClearanceLevel::Warn, warn_since_);
  const bool is_early_stop = is_early(scene::ClearanceLevel::Stop, stop_since_);
  if (!is_early_warn && !is_early_stop) return std::nullopt;
  scene::LevelDistances distances = settings;
  distances.sensed_stop_distance = 0.0;
  if (is_early_warn) distances.sensed_warn_distance = 0.0;
  return distances;
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
QueryStatus Monitor::prepareGuaranteed(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                       const MonitorSettings& settings, const FrameSnapshot& frames) {
  if (!guaranteed()) return {};
  guaranteed()->limit(limits(settings));
  guaranteed()->forget();
  if (robot_->config().pose_latency == PoseLatency::Off) return {};
  const QueryStatus status =
      addAge(*robot_, {snapshot, velocities, monitored_.frames, frames, monitored_.motion_sources},
             *monitored_.objects.all, aged_);
  guaranteed()->assume(aged_);
  return status;
}

const ConstraintRows& Monitor::constraints(const PoseSnapshot& snapshot, const MonitorSettings& settings) {
  if (!constraints_ || constraints_->capacity() != settings.max_constraints)
    constraints_.emplace(*robot_, settings.max_constraints);
  return constraints_->rowsOf({latest(),
                               snapshot,
                               *scenes_,
                               thresholds_.stop,
                               {robot_->robotModel(), monitored_.objects.all.get()},
                               guaranteed(),
                               monitored_.longest_name},
                              settings);
}

StoppingScale Monitor::velocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                     const MonitorSettings& settings, const FrameSnapshot& frames) {
  if (!assessment_.level) return {0.0, latest().status};
  return scales_.find(*robot_, *scenes_, {scenes_->state, snapshot.stated, monitored_.frames, frames.may_move},
                      velocities, joints(), thresholds_.stop, snapshot.age, settings, guaranteed());
}

Separation Monitor::separation(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                               const MonitorSettings& settings, const FrameSnapshot& frames,
                               const std::vector<std::optional<double>>& ages) {
  Separation message = unknownSeparation(latest().status);
  if (assessment_.level)
    message = separationOf(*robot_, *scenes_, {scenes_->state, snapshot.stated, monitored_.frames, frames.may_move},
                           velocities, joints(), snapshot.age, ages, settings, guaranteed());
  message.header = latest().header;
  return message;
}

Sensed Monitor::sensed(const std::vector<SensedCloud>& clouds) {
  Sensed message;
  message.header = latest().header;
  message.status = latest().status;
  message.sources = sensedSources(*robot_, *scenes_, assessment_.level.has_value(), clouds);
  return message;
}

}  // namespace proximity_server::node
