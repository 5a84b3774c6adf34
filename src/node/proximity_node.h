#pragma once

#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <mutex>
#include <string>

#include "node/monitor/diagnostics.h"
#include "node/monitor/monitor_loop.h"
#include "node/robot/robot.h"
#include "node/services/queries.h"
#include "node/system/registration.h"
#include "node/system/request_queue.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/ProximityConfig.h"

namespace proximity_server::node {

/// The ROS interface: services, topics and parameters in the private namespace. Callbacks translate; several threads
/// may run them.
class ProximityNode {
 public:
  /// Failure: throws std::invalid_argument naming the parameter, file, link or element that is missing or wrong.
  ProximityNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

 private:
  template <class Request, class Response>
  bool onQuery(Request& request, Response& response) {
    response = answer(*robot(), tf_, request);
    return true;
  }
  /// A service of queries.h, with its requests in `queue`.
  template <class Service>
  ros::ServiceServer advertise(const std::string& name, RequestQueue& queue) {
    using Node = ProximityNode;
    return withQueue(private_nh_, queue)
        .advertiseService(name, &Node::onQuery<typename Service::Request, typename Service::Response>, this);
  }
  bool onReload(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onEnableMonitor(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);

  /// Settings that contradict each other become those before, which the client then sees.
  void onSettings(ProximityConfig& asked);

  /// The monitor, tf and requests of single pairs go first where the processor is scarce.
  static constexpr int kNicenessOfLongRequests = 5;

  std::shared_ptr<const Robot> robot() const { return std::atomic_load(&robot_); }
  void announce(const Robot& robot);

  ros::NodeHandle nh_;
  ros::NodeHandle private_nh_;
  std::shared_ptr<const Robot> robot_;  // replaced by a reload: only through atomic_load and atomic_store
  std::mutex reload_mutex_;
  TfPoses tf_;
  MonitorLoop monitor_;
  Diagnostics diagnostics_;
  ProximityConfig settings_ = ProximityConfig::__getDefault__();  // in force; of the settings server's callback only
  dynamic_reconfigure::Server<ProximityConfig> settings_server_;
  ros::Publisher model_info_pub_;
  RequestQueue requests_{0};
  RequestQueue long_requests_{kNicenessOfLongRequests};
  ros::ServiceServer minimum_distance_srv_;
  ros::ServiceServer separation_axis_srv_;
  ros::ServiceServer penetration_depth_srv_;
  ros::ServiceServer query_pairs_srv_;
  ros::ServiceServer query_configuration_srv_;
  ros::ServiceServer time_of_contact_srv_;
  ros::ServiceServer query_trajectory_srv_;
  ros::ServiceServer reload_srv_;
  ros::ServiceServer enable_monitor_srv_;
  Registration registration_;  // last: of all of the above
};

}  // namespace proximity_server::node
