#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// Keeps the node known to the ROS master. roscpp registers once, so a master that died and came back knows nothing of
/// the nodes that are left: no newcomer finds them, and they find no newcomer.
///
/// Asks every second, in a thread of its own. Connections that stand notice nothing of it. A master that dies while the
/// node starts is not seen: what came before is registered with the old one only.
class Registration {
 public:
  /// Watches the services and topics that the node offers now, and topics that it offers later.
  Registration();
  ~Registration();

 private:
  void look();
  void renew() const;

  // Where others reach the node: known as long as ROS runs, this lives a little longer.
  const std::string api_;
  const std::string service_api_;
  const std::vector<std::string> services_;  // as the master knew them
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::WallTimer timer_;
  ros::AsyncSpinner spinner_;
};

}  // namespace proximity_server::node
