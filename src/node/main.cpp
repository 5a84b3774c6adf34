#include <ros/ros.h>

#include "node/proximity_node.h"
#include "node/system/log_fatal.h"
#include "node/system/process.h"
#include "node/system/version.h"

int main(int argc, char** argv) {
  if (proximity_server::node::tellsVersion(argc, argv, "proximity_server_node")) return 0;
  proximity_server::node::askForShortTurns();
  proximity_server::node::giveBackLargeMemory();
  ros::init(argc, argv, "proximity_server");
  ros::NodeHandle nh, private_nh("~");  // outlive the node: without a handle its last messages are not logged
  try {
    proximity_server::node::ProximityNode node(nh, private_nh);
    ros::spin();  // runs the short callbacks; requests and the monitor have threads of their own
  } catch (const std::exception& error) {
    proximity_server::node::logFatal(error.what());
    return 1;
  }
}
