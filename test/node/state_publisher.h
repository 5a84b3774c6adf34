#pragma once

#include <ros/param.h>

#include <string>

namespace proximity_server::node {

/// False of the robot_state_publisher of Debian 11, whose frames have no tf_prefix. The launch file of the test gives its
/// version.
inline bool statePublisherKnowsPrefixes() {
  const auto line = ros::param::param<std::string>("/robot_state_publisher_version", "");
  const std::string version = line.substr(0, line.find('\n'));
  return version != "1.15.0" && version != "1.15.1";
}

inline constexpr char kStatePublisherWithoutPrefixes[] = "robot_state_publisher before 1.15.2 has no tf_prefix";

}  // namespace proximity_server::node
