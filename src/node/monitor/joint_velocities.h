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

/// What joint_states says of the joints' velocities, or why that is not known.
struct VelocitySnapshot {
  std::vector<double> velocities;  ///< [rad/s] or [m/s] of each of RobotModel::joints; 0 where not asked for
  /// [rad] or [m] of each, in the messages of the velocities; nothing where that is not known.
  std::vector<std::optional<double>> positions;
  QueryStatus status;  ///< OK, or NO_VELOCITY and which joint has none, or an old one
};

/// Listens to joint_states, several publishers of which may each tell of a few joints. Thread-safe.
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

  /// Why a joint has no usable velocity; "" where it has one.
  static std::string problemOf(const scene::Joint& joint, const Entry* entry, const ros::Time& now, double max_age);

  ros::NodeHandle nh_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> latest_;
  ros::Subscriber subscriber_;  // last: it writes into the above
};

}  // namespace proximity_server::node
