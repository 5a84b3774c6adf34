#include "node/log_fatal.h"
#include "node/proximity_node.h"
#include "system/process.h"
#include "system/version.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  if (proximity_server::system::tellsVersion(argc, argv, "proximity_server_node")) return 0;
  proximity_server::system::requestShortTimeSlices();
  proximity_server::system::giveBackLargeMemory();
  ros::init(argc, argv, "proximity_server");
  ros::NodeHandle nh, private_nh("~");  // they outlive the node, because nothing is logged without a handle
  try {
    proximity_server::node::ProximityNode node(nh, private_nh);
    ros::spin();  // runs the short callbacks; requests and the monitor have threads of their own
  } catch (const std::exception& error) {
    proximity_server::node::logFatal(error.what());
    return 1;
  }
}
