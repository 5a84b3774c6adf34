#pragma once

#include <ros/param.h>

#include <string>

namespace proximity_server::node {

/// False of the robot_state_publisher of Debian 11, whose frames have no tf_prefix. The launch file of the test gives its
/// version.
inline bool statePublisherKnowsPrefixes() {
  return ros::param::param<std::string>("/robot_state_publisher_version", "").rfind("1.15.0", 0) != 0;
}

inline constexpr char kStatePublisherWithoutPrefixes[] = "robot_state_publisher 1.15.0 has no tf_prefix";

}  // namespace proximity_server::node
