#include "node/monitor/velocity_scale.h"

#include "node/answers/motions.h"
#include "node/robot/query_status.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

QueryStatus missingDeceleration(const scene::Joint& joint) {
  return statusOf(QueryStatus::INVALID_ARGUMENT,
                  "the parameter max_deceleration has no number for joint '" + joint.name + "'");
}

/// Names the first of `joints` whose deceleration is not known; OK if all are known. Floating and planar joints are not
/// named, because the status of their velocities tells more.
QueryStatus decelerationStatus(const Robot& robot, const std::vector<int>& joints) {
  for (const int joint : joints) {
    const scene::Joint& model = robot.robotModel().joints[joint];
    if (scene::hasOnePosition(model) && !robot.maxDecelerations()[joint]) return missingDeceleration(model);
  }
  return {};
}

/// The time [s] until the robot begins to brake. `age` is that of the poses.
double stopLatency(const ros::Duration& age, const MonitorSettings& settings) {
  return settings.stop_latency + std::max(0.0, age.toSec());
}

/// Searches for the scale. The decelerations of all joints that move must be known.
StoppingScale searchScale(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                          const VelocitySnapshot& velocities, const scene::PairDistances& stop,
                          const ros::Duration& age, const MonitorSettings& settings,
                          scene::GuaranteedDistances* guaranteed) {
  const scene::Braking braking = brakingOf(robot, age, settings);
  const scene::MovingState state = movingState(robot, scenes, start, velocities, age, braking, guaranteed);
  const scene::VelocityScale found = scene::velocityScale(scenes.motions(), scenes.scene, scenes.state, state, braking,
                                                          stop, searchDeadline(settings));
  StoppingScale result;
  if (found.status != narrowphase::Status::Unknown) {
    result.scale = found.scale;
    result.is_complete = found.status == narrowphase::Status::Converged;
    return result;
  }
  result.status = statusOf(QueryStatus::TF_UNAVAILABLE, "a pair has no usable pose, or a joint no finite velocity");
  return result;
}

/// Calls searchScale() if the numbers that it needs are known.
StoppingScale stoppingScale(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                            const VelocitySnapshot& velocities, const std::vector<int>& joints,
                            const scene::PairDistances& stop, const ros::Duration& age, const MonitorSettings& settings,
                            scene::GuaranteedDistances* guaranteed) {
  StoppingScale result;
  result.status = stopStatus(robot, joints, velocities);
  if (result.status.code != QueryStatus::OK) return result;

  try {
    return searchScale(robot, scenes, start, velocities, stop, age, settings, guaranteed);
  } catch (const std::invalid_argument& error) {  // a stopping distance is infinite, or a position far off its limits
    result.status = statusOf(QueryStatus::NO_VELOCITY, error.what());
    return result;
  }
}

bool areSame(const std::vector<std::optional<Eigen::Isometry3d>>& p,
             const std::vector<std::optional<Eigen::Isometry3d>>& q) {
  return std::equal(p.begin(), p.end(), q.begin(), q.end(),
                    [](const auto& a, const auto& b) { return a && b ? a->matrix() == b->matrix() : !a && !b; });
}

}  // namespace

QueryStatus stopStatus(const Robot& robot, const std::vector<int>& joints, const VelocitySnapshot& velocities) {
  // A missing deceleration is reported first, because it is permanent, while missing velocities may still arrive.
  const QueryStatus status = decelerationStatus(robot, joints);
  return status.code == QueryStatus::OK ? velocities.status : status;
}

scene::Braking brakingOf(const Robot& robot, const ros::Duration& age, const MonitorSettings& settings) {
  scene::Braking braking;
  braking.latency =
      robot.config().pose_latency == PoseLatency::Off ? stopLatency(age, settings) : settings.stop_latency;
  for (const std::optional<double>& deceleration : robot.maxDecelerations())
    braking.deceleration.push_back(deceleration.value_or(std::numeric_limits<double>::infinity()));
  return braking;
}

scene::MovingState movingState(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                               const VelocitySnapshot& velocities, const ros::Duration& age,
                               const scene::Braking& braking, scene::GuaranteedDistances* guaranteed) {
  scene::MovingState state{velocities.velocities, start.stated,
                           objectFramesAtStart(robot, start.frames, start.state.frames())};
  if (robot.config().pose_latency != PoseLatency::Off) state.age = std::max(0.0, age.toSec());
  if (guaranteed)
    state.largest_loss = guaranteed->largestLoss(
        scenes.state, scene::stoppingTravel(robot.robotModel(), velocities.velocities, braking));
  return state;
}

bool StoppingScales::differInLatencyOnly(const Input& p, const Input& q) {
  return p.stop == q.stop && p.objects == q.objects && p.velocities == q.velocities && p.stated == q.stated &&
         areSame(p.poses, q.poses) && areSame(p.frames, q.frames);
}

StoppingScale StoppingScales::find(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                                   const VelocitySnapshot& velocities, const std::vector<int>& joints,
                                   const scene::PairDistances& stop, const ros::Duration& age,
                                   const MonitorSettings& settings, scene::GuaranteedDistances* guaranteed) {
  StoppingScale found = stoppingScale(robot, scenes, start, velocities, joints, stop, age, settings, guaranteed);
  if (found.status.code != QueryStatus::OK) return found;
  Input input{start.state.poses(),       start.state.frames(),
              velocities.velocities,     start.stated,
              scenes.state.objects(),    stop,
              stopLatency(age, settings)};
  const double period = settings.rate > 0.0 ? 1.0 / settings.rate : 0.0;
  if (found.is_complete) {
    input_ = std::move(input);
    scale_ = found.scale;
  } else if (input.latency <= input_.latency + period && differInLatencyOnly(input, input_)) {
    found.scale = std::max(found.scale, scale_);
  }
  return found;
}

}  // namespace proximity_server::node
