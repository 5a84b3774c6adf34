#include <ros/ros.h>

#include "proximity_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "proximity_server");
  try {
    proximity_server::ProximityNode node(ros::NodeHandle(), ros::NodeHandle("~"));
    ros::AsyncSpinner spinner(4);  // threads: a request may wait for tf
    spinner.start();
    ros::waitForShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
}
