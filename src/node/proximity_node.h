#pragma once

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
#include "node/sources/tracked_ages.h"
#include "node/sources/tracked_sources.h"
#include "node/tf/tf_listener.h"
#include "node/tf/tf_poses.h"
#include "node/threads/request_queue.h"
#include "node/threads/service_port.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The ROS interface: services, topics and parameters in the private namespace. Several threads may run its callbacks.
class ProximityNode {
 public:
  /// Once `ends` is set, no more meshes are loaded: neither here nor in a request.
  /// Failure: throws std::invalid_argument naming the parameter, file, link or element that is missing or wrong, and
  ///          std::runtime_error once `ends` is set.
  ProximityNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, const std::atomic<bool>& ends);

 private:
  ProximityNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, const std::atomic<bool>& ends,
                const std::shared_ptr<const Robot>& robot);
  template <class Request, class Response>
  bool onQuery(Request& request, Response& response) {
    response = answer(*robot(), tf_, request);
    return true;
  }
  /// Advertises a service at service_port_. Its requests run in the threads of `queue`.
  template <class Request, class Response>
  void advertise(const std::string& name, RequestQueue& queue, bool (ProximityNode::*callback)(Request&, Response&)) {
    services_.push_back(withQueue(private_nh_, queue).advertiseService(name, callback, this));
    // At once: a client that waits for the service connects as soon as the master knows it, and may stay connected.
    registerService(services_.back().getService(), service_port_.address());
  }
  /// Advertises a service of queries.h.
  template <class Service>
  void advertise(const std::string& name, RequestQueue& queue) {
    advertise(name, queue, &ProximityNode::onQuery<typename Service::Request, typename Service::Response>);
  }
  void advertiseServices();
  bool onApplyObjects(ApplyObjects::Request& request, ApplyObjects::Response& response);
  void publishChangedObjects();
  void publishObjects();  // also lets object_keeper_ write them
  bool onReload(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onSaveRecord(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onEnableMonitor(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);

  /// Throws std::invalid_argument if the settings contradict each other, or thresholds of the robot. Then nothing
  /// changes.
  void onSettings(const MonitorSettings& settings);

  /// [s] Shortest time between two messages on ~objects, because a message about many objects is long.
  static constexpr double kObjectsPeriod = 0.1;
  /// While objects change all the time, the pause between two such messages is this factor times the duration of making
  /// one. So a thread spends a tenth of its time on them, however many objects there are.
  static constexpr double kPauseFactor = 9.0;
  /// Number of messages on ~apply_objects that may wait for the thread that hands them to the stream. Further messages
  /// replace the oldest ones.
  static constexpr std::uint32_t kTopicQueueSize = 1000;

  /// Long requests have a lower priority than the monitor, tf and requests about single pairs.
  /// A larger niceness delays the monitor itself: such a thread that has lost its processor may hold a lock of tf.
  /// Evidence: with 10 more, 99 % of the ages of a level rose from 9 to 17 ms (16 clients on 2 busy cores, no limit of
  /// requests, 2026-11).
  static constexpr int kNicenessOfLongRequests = 5;

  std::shared_ptr<const Robot> robot() const { return std::atomic_load(&robot_); }
  void announce(const Robot& robot);

  ros::NodeHandle nh_;
  ros::NodeHandle private_nh_;
  const std::atomic<bool>& ends_;
  std::shared_ptr<const Robot> robot_;  // a reload replaces it, so access needs std::atomic_load and atomic_store
  std::mutex reload_mutex_;
  TfPoses tf_;
  TfListener tf_listener_;
  Recorder recorder_;
  TrackedAges tracked_ages_;
  ObjectStore objects_;
  ObjectKeeper object_keeper_;
  MonitorLoop monitor_;
  Diagnostics diagnostics_;
  ros::Publisher model_info_pub_;
  ros::Publisher objects_pub_;
  ros::Publisher object_markers_pub_;
  std::atomic<bool> object_markers_{true};  // true if the settings want markers of objects
  // Only the main thread uses the next three members.
  std::uint64_t published_revision_ = 0;        // revision of the latest message on ~objects
  std::weak_ptr<const Robot> published_robot_;  // robot of this message; a reload may give the frames other names
  ros::WallTime publish_objects_after_;         // the earliest time of the next message
  ros::WallTimer objects_timer_;
  ServicePort service_port_;  // declared before the queues, whose threads write to its connections
  RequestQueue requests_{0};
  RequestQueue long_requests_{kNicenessOfLongRequests};
  // Changes of objects have a queue of their own, because they wait for each other and would occupy the threads of
  // other requests.
  RequestQueue changes_{kNicenessOfLongRequests};
  ChangeStream change_stream_;
  TrackedSources tracked_sources_;
  ros::CallbackQueue arrivals_;
  ros::AsyncSpinner arrivals_spinner_{1, &arrivals_};
  std::unique_ptr<SettingsServer> settings_server_;
  // The end of each service waits for its running requests, which may use all members above.
  ros::Subscriber apply_objects_sub_;
  std::vector<ros::ServiceServer> services_;
  std::unique_ptr<Registration> registration_;
};

}  // namespace proximity_server::node
