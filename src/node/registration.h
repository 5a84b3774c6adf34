#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Registers the node again if the ROS master was restarted. roscpp registers only once, so a new master does not know
/// the running nodes: a node that starts later does not find them, and they do not find it.
///
/// A thread of its own asks the master every second. Existing connections are not affected. Limit: if the master is
/// restarted while this node starts, the services and topics that were registered before are missing in the new one.
class Registration {
 public:
  /// Takes care of the services and topics that the node offers now, and of the topics that it offers later.
  Registration();
  ~Registration();

 private:
  void check();
  void renew() const;

  // The addresses of the node, stored because roscpp knows them only while it runs, which may end before this object.
  const std::string api_;
  const std::string service_api_;
  const std::vector<std::string> services_;  // the names that the first master listed
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::WallTimer timer_;
  ros::AsyncSpinner spinner_;
};

}  // namespace proximity_server::node
