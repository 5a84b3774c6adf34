#include "node/monitor/velocity_scale.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "node/answers/timed_motion.h"
#include "node/robot/query_status.h"
#include "proximity_server/scene/derivative/velocity_scale.h"

namespace proximity_server::node {
namespace {

QueryStatus unbrakedJoint(const scene::Joint& joint) {
  return statusOf(QueryStatus::INVALID_ARGUMENT,
                  "the parameter max_deceleration has no number for joint '" + joint.name + "'");
}

/// OK, or the first of `joints` whose deceleration is not known. Floating and planar joints can have none: of them
/// the velocities are not known, which says more.
QueryStatus knowledgeOf(const Robot& robot, const std::vector<int>& joints) {
  for (const int joint : joints) {
    const scene::Joint& model = robot.robotModel().joints[joint];
    if (scene::hasOnePosition(model) && !robot.maxDecelerations()[joint]) return unbrakedJoint(model);
  }
  return {};
}

/// Of the other joints the velocity is 0; mimic joints without a number of their own stop with their leaders.
scene::Braking brakingOf(const Robot& robot, const ros::Duration& age, const MonitorSettings& settings) {
  scene::Braking braking;
  braking.latency = stopLatency(age, settings);
  for (const std::optional<double>& deceleration : robot.maxDecelerations())
    braking.deceleration.push_back(deceleration.value_or(std::numeric_limits<double>::infinity()));
  return braking;
}

/// The decelerations of all joints that move are known.
StoppingScale scaleOf(const Robot& robot, scene::MovingScene& moving_scene, scene::Scene& scene,
                      const LookaheadStart& start, const VelocitySnapshot& velocities, const scene::PairDistances& stop,
                      const ros::Duration& age, const MonitorSettings& settings) {
  const scene::MovingState state{start.poses, velocities.velocities, velocities.positions,
                                 objectFramesAtStart(robot, start.frames, start.placed.poses)};
  const scene::VelocityScale found =
      scene::velocityScale(moving_scene, scene, state, brakingOf(robot, age, settings), stop, endOfSearch(settings));
  StoppingScale result;
  if (found.status != narrowphase::Status::Unknown) {
    result.scale = found.scale;
    result.is_complete = found.status == narrowphase::Status::Converged;
    return result;
  }
  result.status = statusOf(QueryStatus::TF_UNAVAILABLE, "a pair has no usable pose, or a joint no finite velocity");
  return result;
}

bool areSame(const std::vector<std::optional<Eigen::Isometry3d>>& p,
             const std::vector<std::optional<Eigen::Isometry3d>>& q) {
  return std::equal(p.begin(), p.end(), q.begin(), q.end(),
                    [](const auto& a, const auto& b) { return a && b ? a->matrix() == b->matrix() : !a && !b; });
}

}  // namespace

double stopLatency(const ros::Duration& age, const MonitorSettings& settings) {
  return settings.stop_latency + std::max(0.0, age.toSec());
}

bool differInLatencyOnly(const ScaledState& p, const ScaledState& q) {
  return p.stop == q.stop && p.objects == q.objects && p.velocities == q.velocities && p.positions == q.positions &&
         areSame(p.poses, q.poses) && areSame(p.frames, q.frames);
}

StoppingScale stoppingScale(const Robot& robot, scene::MovingScene& moving_scene, scene::Scene& scene,
                            const LookaheadStart& start, const VelocitySnapshot& velocities,
                            const std::vector<int>& joints, const scene::PairDistances& stop, const ros::Duration& age,
                            const MonitorSettings& settings) {
  StoppingScale result;
  result.status = knowledgeOf(robot, joints);  // first: it stays so, while velocities may come
  if (result.status.code == QueryStatus::OK) result.status = velocities.status;
  if (result.status.code != QueryStatus::OK) return result;

  try {
    return scaleOf(robot, moving_scene, scene, start, velocities, stop, age, settings);
  } catch (const std::invalid_argument& error) {  // the way to stop is not finite, or a turn is not known
    result.status = statusOf(QueryStatus::NO_VELOCITY, error.what());
    return result;
  }
}

}  // namespace proximity_server::node
