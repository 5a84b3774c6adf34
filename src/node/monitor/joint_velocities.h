#pragma once

#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"

#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The joint velocities of joint_states, with a status that says why one is missing.
struct VelocitySnapshot {
  /// [rad/s] or [m/s] of each of RobotModel::joints; 0 if it was not requested, NaN if it is missing or too old. Empty if
  /// nobody needs velocities.
  std::vector<double> velocities;
  std::vector<ros::Time> stamps;  ///< of the messages with the velocities
  /// Positions [rad] or [m] in the messages with the velocities; nullopt if a position is not known.
  std::vector<std::optional<double>> positions;
  QueryStatus roots;   ///< of TfPoses::standingStill(); OK if it was not asked
  QueryStatus status;  ///< OK, or NO_VELOCITY with the name of a joint whose velocity is missing or too old
};

/// Listens to joint_states, or to the topics that the parameter `robots` names. Several publishers may each publish
/// some of the joints. If there are several robots, a message may name a joint as the model does, "left/elbow", or as
/// the URDF does, "elbow", unless another robot on the same topic has a joint of this name, too. Thread-safe.
class JointVelocities {
 public:
  explicit JointVelocities(const ros::NodeHandle& nh) : nh_(nh) {}

  /// Subscribes to the topics of this robot, and to no others.
  void listen(const Robot& robot);

  /// Ends all subscriptions, and forgets all velocities.
  void stopListening();

  /// The latest velocities of `joints`. The status is not OK if one of them is farther from `now` than
  /// Config::max_tf_age.
  VelocitySnapshot lookUp(const Robot& robot, const std::vector<int>& joints, const ros::Time& now) const;

 private:
  struct Entry {
    double velocity;
    std::optional<double> position;
    ros::Time stamp;
  };

  using Entries = std::map<std::string, Entry>;  ///< by name of the joint

  void onJointState(const sensor_msgs::JointState& state, const std::string& topic);

  /// The full name of each robot's topic, after remapping.
  std::vector<std::string> topicsOf(const Robot& robot) const;

  /// The latest velocity of a joint; nullptr if there is none. `topics` are those of the robots.
  const Entry* find(const scene::RobotModel& robots, const std::vector<std::string>& topics, int joint) const;

  /// Returns why a joint has no usable velocity, or "" if it has one. The velocity is expected on `topic`.
  static std::string problemOf(const scene::Joint& joint, const std::string& topic, const Entry* entry,
                               const ros::Time& now, double max_age);

  ros::NodeHandle nh_;
  mutable std::mutex mutex_;
  std::map<std::string, Entries> latest_;  // by full name of the topic
  // By full name of the topic. They are destroyed first, because their callbacks use the members above.
  std::map<std::string, ros::Subscriber> subscribers_;
};

}  // namespace proximity_server::node
