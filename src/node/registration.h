#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Tells the ROS master that a service of this node is at `address` ("rosrpc://HOST:PORT"), and no longer at roscpp's.
void registerService(const std::string& service, const std::string& address);

/// Registers the node again after a restart of the ROS master. roscpp registers a node only once, so a new master does
/// not know the running nodes: a node that starts later does not find them, and they do not find it.
///
/// A thread of its own asks the master every second. Existing connections are not affected.
/// Limit: if the master is restarted while this node starts, the new master does not get the services and topics that
///        were registered before the restart.
class Registration {
 public:
  /// Registers the services and topics that the node offers now, and the topics that it offers later. All services
  /// are registered at `service_api`, see registerService().
  explicit Registration(std::string service_api);
  /// Takes the services from the master: roscpp does so for its own address only.
  ~Registration();

 private:
  void check();
  void registerAgain() const;

  // The addresses of the node. They are stored because roscpp may end before this object, and then does not know them
  // any more.
  const std::string api_;
  const std::string service_api_;
  const std::vector<std::string> services_;  // names of the services, as the first master listed them
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::WallTimer timer_;
  ros::AsyncSpinner spinner_;
};

}  // namespace proximity_server::node
