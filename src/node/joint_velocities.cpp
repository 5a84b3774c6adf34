#include "joint_velocities.h"

#include <cmath>

namespace proximity_server {
namespace {

QueryStatus withoutVelocity(const Joint& joint, const std::string& why) {
  QueryStatus status;
  status.code = QueryStatus::NO_VELOCITY;
  status.message = "joint '" + joint.name + "': " + why;
  return status;
}

}  // namespace

void JointVelocities::listen() {
  if (subscriber_) return;
  subscriber_ = nh_.subscribe<sensor_msgs::JointState>(
      "joint_states", 10, [this](const sensor_msgs::JointState::ConstPtr& state) { onJointState(*state); });
}

void JointVelocities::ignore() {
  subscriber_.shutdown();
  const std::lock_guard<std::mutex> lock(mutex_);
  latest_.clear();
}

void JointVelocities::onJointState(const sensor_msgs::JointState& state) {
  if (state.velocity.size() != state.name.size()) return;  // many publishers leave it empty
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < state.name.size(); ++i) latest_[state.name[i]] = {state.velocity[i], state.header.stamp};
}

VelocitySnapshot JointVelocities::lookUp(const Robot& robot, const std::vector<int>& joints,
                                         const ros::Time& now) const {
  VelocitySnapshot snapshot;
  snapshot.velocities.assign(robot.links().joints.size(), 0.0);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const int index : joints) {
    const Joint& joint = robot.links().joints[static_cast<std::size_t>(index)];
    const auto entry = latest_.find(joint.name);
    if (entry == latest_.end() || !std::isfinite(entry->second.velocity)) {
      snapshot.status = withoutVelocity(joint, "joint_states has no velocity of it");
      return snapshot;
    }
    // As numbers: ros::Duration throws for stamps that are decades apart.
    const double age = now.toSec() - entry->second.stamp.toSec();
    if (!(std::abs(age) <= robot.config().max_tf_age)) {
      snapshot.status =
          withoutVelocity(joint, "its latest velocity is " + std::to_string(age) + " s old, max_tf_age is " +
                                     std::to_string(robot.config().max_tf_age) + " s");
      return snapshot;
    }
    snapshot.velocities[static_cast<std::size_t>(index)] = entry->second.velocity;
  }
  return snapshot;
}

}  // namespace proximity_server
