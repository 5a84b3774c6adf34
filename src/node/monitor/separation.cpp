#include "node/monitor/separation.h"

#include "node/answers/conversions.h"
#include "node/robot/query_status.h"
#include "proximity_server/scene/separation.h"

#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace proximity_server::node {
namespace {

/// The sources that see somebody. Their index in Config::tracked goes into `numbers`.
/// `latency` [s] is the time from now until the robot begins to brake, and `braking` has what of the age of the poses is
/// added to it: persons move during all of their own age.
std::vector<scene::Tracked> seenBy(const Robot& robot, const scene::Objects& objects, const scene::Braking& braking,
                                   double latency, const std::vector<std::optional<double>>& ages,
                                   std::vector<std::size_t>& numbers) {
  std::vector<scene::Tracked> seen;
  const std::vector<TrackedSource>& sources = robot.config().tracked;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const TrackedSource& source = sources[i];
    if (source.sensing) continue;
    const int number = objects.find(source.name);
    if (number < 0) continue;
    numbers.push_back(i);
    const double older = *ages[i] + latency - braking.latency;
    seen.push_back({number, source.speed, source.near_speed, older, source.intrusion, source.uncertainty});
  }
  return seen;
}

void assignTerms(Separation& message, const scene::Separation& found) {
  message.margin = found.margin;
  message.distance = found.distance;
  message.protective_distance = found.protective_distance;
  message.human_speed = found.human_speed;
  message.robot_speed = found.robot_speed;
  message.reaction_time = found.reaction_time;
  message.stopping_time = found.stopping_time;
  message.human_way = found.human_way;
  message.reaction_way = found.reaction_way;
  message.stopping_way = found.stopping_way;
  message.intrusion = found.intrusion;
  message.sensor_uncertainty = found.sensor_uncertainty;
  message.robot_uncertainty = found.robot_uncertainty;
}

Separation find(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                const VelocitySnapshot& velocities, const ros::Duration& age,
                const std::vector<std::optional<double>>& ages, const MonitorSettings& settings,
                scene::GuaranteedDistances* guaranteed) {
  const scene::Objects& objects = *scenes.state.objects();
  std::vector<std::size_t> numbers;
  const scene::Braking braking = brakingOf(robot, age, settings);
  const std::vector<scene::Tracked> seen = seenBy(robot, objects, braking, settings.stop_latency, ages, numbers);
  const scene::MovingState state = movingState(robot, scenes, start, velocities, age, braking, guaranteed);
  const scene::Separation found =
      scene::separation(scenes.motions(), scenes.scene, scenes.state, state, braking, seen, searchDeadline(settings));
  if (found.status == narrowphase::Status::Unknown)
    return unknownSeparation(
        statusOf(QueryStatus::TF_UNAVAILABLE, "a pair has no usable pose, or a joint no finite velocity"));
  Separation message = unknownSeparation({});
  message.scale = found.scale;
  message.complete = found.status == narrowphase::Status::Converged;
  if (found.tracked < 0) return message;
  assignTerms(message, found);
  message.source = robot.config().tracked[numbers[found.tracked]].name;
  message.person_age = seen[found.tracked].older;
  const bool is_a = found.pair.asked.a.object() == seen[found.tracked].object;
  assign(message.shape, {robot.robotModel(), &objects}, is_a ? found.pair.asked.b : found.pair.asked.a);
  return message;
}

}  // namespace

Separation unknownSeparation(const QueryStatus& status) {
  Separation message;
  message.status = status;
  assignTerms(message, {});
  message.margin = message.distance = message.person_age = kNaN;
  clear(message.shape);
  return message;
}

Separation separationOf(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                        const VelocitySnapshot& velocities, const std::vector<int>& joints, const ros::Duration& age,
                        const std::vector<std::optional<double>>& ages, const MonitorSettings& settings,
                        scene::GuaranteedDistances* guaranteed) {
  if (!robot.config().isTracking())
    return unknownSeparation(
        statusOf(QueryStatus::INVALID_ARGUMENT, "the parameter tracked is empty: nobody would be seen"));
  const QueryStatus known = stopStatus(robot, joints, velocities);
  if (known.code != QueryStatus::OK) return unknownSeparation(known);
  for (std::size_t i = 0; i < robot.config().tracked.size(); ++i)
    if (!robot.config().tracked[i].sensing && (i >= ages.size() || !ages[i]))
      return unknownSeparation(
          statusOf(QueryStatus::TF_STALE, "tracked source '" + robot.config().tracked[i].name + "' has no message"));
  try {
    return find(robot, scenes, start, velocities, age, ages, settings, guaranteed);
  } catch (const std::invalid_argument& error) {
    return unknownSeparation(statusOf(QueryStatus::NO_VELOCITY, error.what()));
  }
}

}  // namespace proximity_server::node
