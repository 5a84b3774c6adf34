#include <ros/ros.h>

#include "proximity_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "proximity_server");
  ros::NodeHandle nh, private_nh("~");  // outlive the node: without one the last words are not logged
  try {
    proximity_server::ProximityNode node(nh, private_nh);
    ros::AsyncSpinner spinner(4);  // threads: a request may wait for tf
    spinner.start();
    ros::waitForShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
}
