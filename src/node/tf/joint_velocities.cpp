#include "node/tf/joint_velocities.h"

#include <cmath>
#include <limits>
#include <string>

namespace proximity_server::node {
namespace {

/// Returns why a joint has no usable velocity, or "" if it has one. The velocity is expected on `topic`.
std::string problemOf(const scene::Joint& joint, const std::string& topic, const StatedJoints::Entry* entry,
                      const ros::Time& now, double max_age) {
  if (joint.type == scene::Joint::Type::Floating || joint.type == scene::Joint::Type::Planar) {
    return "it is floating or planar, it has not one velocity";
  }
  if (!entry || !std::isfinite(entry->velocity.value)) return topic + " has no velocity of it";
  if (entry->velocity.isFresh(now, max_age)) return {};
  const double age = now.toSec() - entry->velocity.stamp.toSec();
  return "its latest velocity is " + std::to_string(age) + " s old, max_tf_age is " + std::to_string(max_age) + " s";
}

}  // namespace

VelocitySnapshot velocitiesOf(const Robot& robot, const StatedJoints& stated, const std::vector<int>& joints,
                              const ros::Time& now) {
  const double max_age = robot.config().max_tf_age;
  VelocitySnapshot snapshot;
  snapshot.velocities.assign(robot.robotModel().joints.size(), 0.0);
  snapshot.stamps.assign(robot.robotModel().joints.size(), ros::Time());
  const StatedJoints::View view = stated.view();
  for (const int index : joints) {
    const scene::Joint& joint = robot.robotModel().joints[index];
    const StatedJoints::Entry* const entry = view.find(robot, index);
    const std::string problem = problemOf(joint, topicOf(robot, index), entry, now, max_age);
    if (problem.empty()) {
      snapshot.velocities[index] = entry->velocity.value;
      snapshot.stamps[index] = entry->velocity.stamp;
      continue;
    }
    snapshot.velocities[index] = std::numeric_limits<double>::quiet_NaN();
    if (snapshot.status.code != QueryStatus::OK) continue;
    snapshot.status.code = QueryStatus::NO_VELOCITY;
    snapshot.status.message = "joint '" + joint.name + "': " + problem;
  }
  return snapshot;
}

}  // namespace proximity_server::node
