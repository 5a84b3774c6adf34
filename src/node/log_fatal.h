#pragma once

#include "system/number_text.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <rosgraph_msgs/Log.h>

#include <string>

namespace proximity_server::node {

/// Logs why the program ends. Before that it waits up to three seconds for a subscriber of /rosout, because a program
/// that ends at once would lose the message. The subscriber is the node rosout, or in a rostest, which has no rosout, a
/// clearancetest that is starting.
inline void logFatal(const std::string& text) {
  ros::NodeHandle nh;
  const ros::Publisher log = nh.advertise<rosgraph_msgs::Log>("/rosout", 1);
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(3.0);
  while (log.getNumSubscribers() == 0 && ros::ok() && ros::SteadyTime::now() < end) ros::WallDuration(0.01).sleep();
  ROS_FATAL_STREAM(system::readable(text));
  if (log.getNumSubscribers() > 0) ros::WallDuration(0.2).sleep();  // a thread of roscpp sends the message
}

}  // namespace proximity_server::node
