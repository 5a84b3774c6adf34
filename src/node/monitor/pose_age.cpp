#include "node/monitor/pose_age.h"

#include "node/robot/query_status.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

namespace proximity_server::node {
namespace {

QueryStatus unbounded(const std::string& what) {
  return statusOf(QueryStatus::NO_VELOCITY, "guaranteed distances are unknown: " + what);
}

/// [rad] or [m] How far a joint may have moved during `time` [s]; nullopt if that is not known.
std::optional<double> travelOf(const Robot& robot, const AgedPoses& aged, int joint, double time) {
  const bool by_velocity = robot.config().pose_latency == PoseLatency::Velocity &&
                           static_cast<std::size_t>(joint) < aged.velocities.velocities.size();
  const std::optional<double>& acceleration = robot.maxAccelerations()[joint];
  if (by_velocity && acceleration && std::isfinite(aged.velocities.velocities[joint])) {
    // Computed in double, because ros::Duration throws for stamps that are decades apart.
    const double offset = std::abs(aged.velocities.stamps[joint].toSec() - aged.poses.stamp.toSec());
    return std::abs(aged.velocities.velocities[joint]) * time + *acceleration * (offset * time + 0.5 * time * time);
  }
  const double travel = robot.robotModel().joints[joint].max_velocity * time;
  return std::isfinite(travel) ? std::optional<double>(travel) : std::nullopt;
}

scene::PoseUncertainty grown(scene::PoseUncertainty pose, const scene::PoseUncertainty& speed, double time) {
  return {pose.translation + speed.translation * time, pose.angle + speed.angle * time};
}

/// Tells why the travel of a joint is not known.
QueryStatus unboundedJoint(const Robot& robot, int joint) {
  const scene::Joint& model = robot.robotModel().joints[joint];
  const std::string name = "joint '" + model.name + "' ";
  if (!scene::hasOnePosition(model)) return unbounded(name + "is floating or planar, nothing limits its velocity");
  const std::string no_limit = name + "has no velocity limit in the URDF";
  if (robot.config().pose_latency != PoseLatency::Velocity) return unbounded(no_limit);
  if (!robot.maxAccelerations()[joint]) return unbounded(no_limit + ", and max_acceleration has no number for it");
  return unbounded(no_limit + ", and its velocity is not known");
}

QueryStatus addJoints(const Robot& robot, const AgedPoses& aged, double time, scene::Uncertainty& uncertainty) {
  for (const int joint : aged.sources.joints) {
    std::optional<double> travel;
    if (scene::hasOnePosition(robot.robotModel().joints[joint])) travel = travelOf(robot, aged, joint, time);
    if (!travel) return unboundedJoint(robot, joint);
    uncertainty.positions[joint] = robot.uncertainty().positions[joint] + *travel;
  }
  return {};
}

/// The reference robot is at rest, so the others move relative to it.
QueryStatus addBases(const Robot& robot, const AgedPoses& aged, double time, scene::Uncertainty& uncertainty) {
  uncertainty.bases = robot.uncertainty().bases;
  if (aged.velocities.roots.code == QueryStatus::OK) return {};
  for (const int member : aged.sources.roots) {
    if (member < 0 || member == robot.referenceRobot()) continue;
    const std::string& name = robot.robotModel().robots[member].name;
    const scene::PoseUncertainty* speed = scene::speedOf(robot.baseSpeeds(), name);
    if (!speed) return unbounded(aged.velocities.roots.message + ", and base_speed does not tell how fast");
    uncertainty.bases[member] = grown(robot.uncertainty().bases[member], *speed, time);
  }
  return {};
}

QueryStatus addObjects(const Robot& robot, const AgedPoses& aged, const scene::Objects& objects, double time,
                       scene::Uncertainty& uncertainty) {
  if (aged.frame_poses.may_move.empty()) return {};
  for (const int number : objects.numbers()) {
    const scene::Object& object = *objects.object(number);
    const auto* moving = std::get_if<scene::Moving>(&object.placement);
    const auto& may_move = aged.frame_poses.may_move;
    if (!moving || std::none_of(may_move.begin(), may_move.end(),
                                [&](int frame) { return aged.frames.names[frame] == moving->frame; }))
      continue;
    const scene::PoseUncertainty* speed = scene::speedOf(robot.objectSpeeds(), object.id);
    if (!speed)
      return unbounded("object '" + object.id + "' may move with frame '" + moving->frame +
                       "', and object_speed does not tell how fast");
    uncertainty.own_objects[object.id] = grown(robot.uncertainty().ofObject(object.id), *speed, time);
  }
  return {};
}

}  // namespace

QueryStatus addAge(const Robot& robot, const AgedPoses& aged, const scene::Objects& objects,
                   scene::Uncertainty& uncertainty) {
  const double time = std::max(0.0, aged.poses.age.toSec()) + robot.config().message_latency;
  QueryStatus status = addJoints(robot, aged, time, uncertainty);
  if (status.code == QueryStatus::OK) status = addBases(robot, aged, time, uncertainty);
  if (status.code == QueryStatus::OK) status = addObjects(robot, aged, objects, time, uncertainty);
  return status;
}

}  // namespace proximity_server::node
