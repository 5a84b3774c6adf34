#include "node/monitor/joint_velocities.h"

#include <cmath>

namespace proximity_server::node {
void JointVelocities::listen() {
  if (subscriber_) return;
  subscriber_ = nh_.subscribe<sensor_msgs::JointState>(
      "joint_states", 10, [this](const sensor_msgs::JointState::ConstPtr& state) { onJointState(*state); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());  // for the reason given in TfTree
}

void JointVelocities::ignore() {
  subscriber_.shutdown();
  const std::lock_guard<std::mutex> lock(mutex_);
  latest_.clear();
}

void JointVelocities::onJointState(const sensor_msgs::JointState& state) {
  if (state.velocity.size() != state.name.size()) return;  // many publishers leave the velocities empty
  const bool has_positions = state.position.size() == state.name.size();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const bool is_known = has_positions && std::isfinite(state.position[i]);
    latest_[state.name[i]] = {state.velocity[i], is_known ? std::optional<double>(state.position[i]) : std::nullopt,
                              state.header.stamp};
  }
}

VelocitySnapshot JointVelocities::lookUp(const Robot& robot, const std::vector<int>& joints,
                                         const ros::Time& now) const {
  VelocitySnapshot snapshot;
  snapshot.velocities.assign(robot.robotModel().joints.size(), 0.0);
  snapshot.positions.assign(robot.robotModel().joints.size(), std::nullopt);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const int index : joints) {
    const scene::Joint& joint = robot.robotModel().joints[index];
    const auto entry = latest_.find(joint.name);
    const std::string problem =
        problemOf(joint, entry == latest_.end() ? nullptr : &entry->second, now, robot.config().max_tf_age);
    if (problem.empty()) {
      snapshot.velocities[index] = entry->second.velocity;
      snapshot.positions[index] = entry->second.position;
      continue;
    }
    snapshot.status.code = QueryStatus::NO_VELOCITY;
    snapshot.status.message = "joint '" + joint.name + "': " + problem;
    return snapshot;
  }
  return snapshot;
}

std::string JointVelocities::problemOf(const scene::Joint& joint, const Entry* entry, const ros::Time& now,
                                       double max_age) {
  if (joint.type == scene::Joint::Type::Floating || joint.type == scene::Joint::Type::Planar) {
    return "it is floating or planar, it has not one velocity";
  }
  if (!entry || !std::isfinite(entry->velocity)) return "joint_states has no velocity of it";
  // Computed in double, because ros::Duration throws for stamps that are decades apart.
  const double age = now.toSec() - entry->stamp.toSec();
  if (std::abs(age) <= max_age) return {};
  return "its latest velocity is " + std::to_string(age) + " s old, max_tf_age is " + std::to_string(max_age) + " s";
}

}  // namespace proximity_server::node
