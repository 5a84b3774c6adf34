#pragma once

#include <ros/param.h>

#include <string>

namespace proximity_server::node {

/// False of the robot_state_publisher of Debian 11, whose frames have no tf_prefix. The launch file of the test gives its
/// version.
inline bool statePublisherKnowsPrefixes() {
  const auto version = ros::param::param<std::string>("/robot_state_publisher_version", "");
  return version.rfind("1.15.0", 0) != 0 && version.rfind("1.15.1", 0) != 0;
}

inline constexpr char kStatePublisherWithoutPrefixes[] = "robot_state_publisher before 1.15.2 has no tf_prefix";

}  // namespace proximity_server::node
