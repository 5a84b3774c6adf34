#pragma once

#include <ros/console.h>
#include <ros/node_handle.h>
#include <rosgraph_msgs/Log.h>

#include <string>

namespace proximity_server::node {

/// Logs why the program ends, and waits up to three seconds for somebody who hears it: rosout, to which a program that ends at once is not
/// connected yet, or in a rostest, which has no rosout, a clearancetest that is just starting.
inline void logFatal(const std::string& text) {
  ros::NodeHandle nh;
  const ros::Publisher log = nh.advertise<rosgraph_msgs::Log>("/rosout", 1);
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(3.0);
  while (log.getNumSubscribers() == 0 && ros::ok() && ros::SteadyTime::now() < end) ros::WallDuration(0.01).sleep();
  ROS_FATAL_STREAM(text);
  if (log.getNumSubscribers() > 0) ros::WallDuration(0.2).sleep();  // a thread of roscpp sends it
}

}  // namespace proximity_server::node
