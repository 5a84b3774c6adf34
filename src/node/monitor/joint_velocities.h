#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"

namespace proximity_server::node {

/// The joint velocities of joint_states, with a status that says why one is missing.
struct VelocitySnapshot {
  std::vector<double> velocities;  ///< [rad/s] or [m/s] of each of RobotModel::joints; 0 if not asked for
  /// [rad] or [m] of each, in the messages of the velocities; nullopt if it is not known.
  std::vector<std::optional<double>> positions;
  QueryStatus status;  ///< OK, or NO_VELOCITY with the name of a joint whose velocity is missing or too old
};

/// Listens to joint_states. Several publishers may each publish some of the joints. Thread-safe.
class JointVelocities {
 public:
  explicit JointVelocities(const ros::NodeHandle& nh) : nh_(nh) {}

  void listen();
  void ignore();

  /// The latest velocities of `joints`, none further from `now` than Config::max_tf_age.
  VelocitySnapshot lookUp(const Robot& robot, const std::vector<int>& joints, const ros::Time& now) const;

 private:
  struct Entry {
    double velocity;
    std::optional<double> position;
    ros::Time stamp;
  };

  void onJointState(const sensor_msgs::JointState& state);

  /// Returns why a joint has no usable velocity, or "" if it has one.
  static std::string problemOf(const scene::Joint& joint, const Entry* entry, const ros::Time& now, double max_age);

  ros::NodeHandle nh_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> latest_;
  ros::Subscriber subscriber_;  // destroyed first, as its callback uses the members above
};

}  // namespace proximity_server::node
