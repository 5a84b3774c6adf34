#include "node/log_fatal.h"
#include "node/proximity_node.h"
#include "system/process.h"
#include "system/relay.h"
#include "system/version.h"

#include <ros/ros.h>

#include <atomic>
#include <memory>

int main(int argc, char** argv) {
  if (proximity_server::system::tellsVersion(argc, argv, "proximity_server_node")) return 0;
  proximity_server::system::requestShortTimeSlices();
  proximity_server::system::giveBackLargeMemory();
  ros::init(argc, argv, "proximity_server");
  ros::NodeHandle nh, private_nh("~");  // they outlive the node, because nothing is logged without a handle
  // A signal that interrupts roscpp while it sets a parameter makes it log an error, and its log then waits for that
  // parameter for ever. The threads of roscpp that the handles have started set none.
  proximity_server::system::leaveCtrlCToOtherThreads();
  std::atomic<bool> ends{false};  // true after a signal, also while meshes are loaded, which takes long
  try {
    std::unique_ptr<proximity_server::node::ProximityNode> node;
    const auto start = [&] { node = std::make_unique<proximity_server::node::ProximityNode>(nh, private_nh, ends); };
    proximity_server::system::runWatched(start, [&] { ends = ros::isShuttingDown(); });
    ros::spin();  // runs the short callbacks; requests and the monitor have threads of their own
    ends = true;
  } catch (const std::exception& error) {
    if (ends) return 0;
    proximity_server::node::logFatal(error.what());
    return 1;
  }
}
