#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "node/monitor/diagnostics.h"
#include "node/monitor/monitor_loop.h"
#include "node/monitor/object_markers.h"
#include "node/objects/apply_objects.h"
#include "node/objects/change_stream.h"
#include "node/objects/object_keeper.h"
#include "node/objects/object_store.h"
#include "node/registration.h"
#include "node/robot/robot.h"
#include "node/robot/settings_server.h"
#include "node/services/queries.h"
#include "node/tf/tf_poses.h"
#include "node/threads/request_queue.h"

namespace proximity_server::node {

/// The ROS interface: services, topics and parameters in the private namespace. Several threads may run its callbacks.
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
  /// Advertises a service of queries.h, whose requests run in the threads of `queue`.
  template <class Service>
  ros::ServiceServer advertise(const std::string& name, RequestQueue& queue) {
    using Node = ProximityNode;
    return withQueue(private_nh_, queue)
        .advertiseService(name, &Node::onQuery<typename Service::Request, typename Service::Response>, this);
  }
  bool onApplyObjects(ApplyObjects::Request& request, ApplyObjects::Response& response);
  void publishChangedObjects();
  void publishObjects();  // and has them kept
  bool onReload(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onEnableMonitor(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);

  /// Throws std::invalid_argument if they contradict each other, or what the robot has; then nothing changes.
  void onSettings(const MonitorSettings& settings);

  /// [s] at least between two messages on ~objects, as one with many objects is long.
  static constexpr double kObjectsPeriod = 0.1;
  /// Times the duration of such a message from its end to the next one, while objects change all the time: a tenth of a
  /// thread is spent on them, however many objects there are.
  static constexpr double kObjectsPause = 9.0;
  /// Messages of ~apply_objects that wait for the thread that hands them to the stream; further ones push out the oldest.
  static constexpr std::uint32_t kArrivingChanges = 1000;

  /// Long requests have a lower priority than the monitor, tf and requests about single pairs.
  static constexpr int kNicenessOfLongRequests = 5;

  std::shared_ptr<const Robot> robot() const { return std::atomic_load(&robot_); }
  void announce(const Robot& robot);

  ros::NodeHandle nh_;
  ros::NodeHandle private_nh_;
  std::shared_ptr<const Robot> robot_;  // a reload replaces it, so access needs std::atomic_load and atomic_store
  std::mutex reload_mutex_;
  TfPoses tf_;
  ObjectStore objects_;  // before the monitor, whose first cycle knows what stands there from the start
  ObjectKeeper object_keeper_;
  MonitorLoop monitor_;
  Diagnostics diagnostics_;
  ros::Publisher model_info_pub_;
  ros::Publisher objects_pub_;
  ros::Publisher object_markers_pub_;
  std::atomic<bool> object_markers_{true};      // whether these are wanted
  std::uint64_t published_revision_ = 0;        // of objects_pub_; only the main thread uses it
  std::weak_ptr<const Robot> published_robot_;  // the same: a reload may give the frames other names
  ros::WallTime publish_objects_after_;         // as published_revision_
  ros::WallTimer objects_timer_;
  RequestQueue requests_{0};
  RequestQueue long_requests_{kNicenessOfLongRequests};
  // Changes are applied one after the other. Those that wait do not take the threads of other requests.
  RequestQueue changes_{kNicenessOfLongRequests};
  ChangeStream change_stream_;
  ros::CallbackQueue arrivals_;
  ros::AsyncSpinner arrivals_spinner_{1, &arrivals_};
  ros::ServiceServer minimum_distance_srv_;
  ros::ServiceServer separation_axis_srv_;
  ros::ServiceServer penetration_depth_srv_;
  ros::ServiceServer query_pairs_srv_;
  ros::ServiceServer query_configuration_srv_;
  ros::ServiceServer time_of_contact_srv_;
  ros::ServiceServer query_trajectory_srv_;
  ros::ServiceServer apply_objects_srv_;
  ros::Subscriber apply_objects_sub_;
  SettingsServer settings_server_;
  ros::ServiceServer reload_srv_;
  ros::ServiceServer enable_monitor_srv_;
  Registration registration_;  // last, as it registers all services and topics above
};

}  // namespace proximity_server::node
