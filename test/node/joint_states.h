#pragma once

#include "node/ticker.h"

#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <string>

namespace proximity_server::node {

/// Publishes joint_states a hundred times a second, with the current time.
class JointStates {
 public:
  explicit JointStates(const std::string& ns = "/")
      : nh_(ns),
        publisher_(nh_.advertise<sensor_msgs::JointState>("joint_states", 10)),
        ticker_(nh_, 100.0, [this] { publish(ros::Time::now()); }) {}

  /// `positions` may name fewer joints; then none has one.
  void hold(const std::map<std::string, double>& velocities, const std::map<std::string, double>& positions = {}) {
    ticker_.stop();
    velocities_ = velocities;
    positions_ = positions;
    ticker_.start();
  }
  void release() { ticker_.stop(); }

  void publish(const ros::Time& stamp) {
    sensor_msgs::JointState state;
    state.header.stamp = stamp;
    for (const auto& [name, velocity] : velocities_) {
      state.name.push_back(name);
      state.velocity.push_back(velocity);
      if (const auto position = positions_.find(name); position != positions_.end())
        state.position.push_back(position->second);
    }
    publisher_.publish(state);
  }

 private:
  ros::NodeHandle nh_;
  std::map<std::string, double> velocities_, positions_;
  ros::Publisher publisher_;
  Ticker ticker_;  // last: it publishes what is above
};

/// Velocities of gantry.urdf [m/s].
inline std::map<std::string, double> slidingAt(double velocity) {
  return {{"x_axis", velocity}, {"y_axis", 0.0}, {"lift", 0.0}};
}

/// Positions of gantry.urdf [m].
inline std::map<std::string, double> positionsAt(double x) { return {{"x_axis", x}, {"y_axis", 0.0}, {"lift", 0.0}}; }

}  // namespace proximity_server::node
