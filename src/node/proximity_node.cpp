#include "node/proximity_node.h"

#include "node/answers/conversions.h"
#include "node/robot/load_config.h"
#include "node/threads/latched_topic.h"
#include "node/threads/real_time.h"
#include "system/number_text.h"
#include "system/process.h"

#include <ros/console.h>

#include <exception>
#include <stdexcept>
#include <string>

namespace proximity_server::node {
namespace {

std::string description(const Robot& robot) {
  return "'" + robot.robotModel().name + "': " + std::to_string(robot.robotModel().links.size()) + " links, " +
         std::to_string(robot.sceneModel().pairs.checked.size()) + " of " +
         std::to_string(robot.sceneModel().pairs.pairs.size()) + " pairs are checked";
}

Config configOf(const ros::NodeHandle& private_nh, const std::atomic<bool>& ends) {
  Config config = loadConfig(private_nh);
  config.model.stop = &ends;
  return config;
}

}  // namespace

ProximityNode::ProximityNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh,
                             const std::atomic<bool>& ends)
    : ProximityNode(nh, private_nh, ends, std::make_shared<const Robot>(nh, configOf(private_nh, ends))) {}

ProximityNode::ProximityNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh,
                             const std::atomic<bool>& ends, const std::shared_ptr<const Robot>& robot)
    : nh_(nh),
      private_nh_(private_nh),
      ends_(ends),
      robot_(robot),
      tf_listener_(tf_, *robot),
      recorder_(robot->config(), private_nh.getNamespace()),
      objects_(
          robot, ros::WallTime::now().toNSec(), frameFinder(tf_),
          [this](const Robot& changed) {
            recorder_.know(objects_.recorded());
            monitor_.takeObjects(changed);
          },
          ObjectLimits(), objectsAtStart(robot->config())),
      object_keeper_(robot->config().objects_file, objects_),
      monitor_(nh, private_nh, tf_, tracked_ages_, robot->config(), recorder_),
      diagnostics_(
          nh, tf_, [this] { return monitor_.health(); }, [this] { return this->robot(); },
          [this] { return recorder_.outcome(); }, [this] { return object_keeper_.problem(); }),
      change_stream_(objects_,
                     [](const std::string& reason) {
                       ROS_WARN_STREAM_THROTTLE(
                           1.0, "a message of ~apply_objects is left out: " << system::readable(reason));
                     }),
      tracked_sources_(nh, private_nh, tf_, objects_, tracked_ages_) {
  if (service_port_.isSeparate()) runPollThreadInRealTime(robot->config().realtime_priority);
  recorder_.know(objects_.recorded());
  tf_.watch(*robot);
  tracked_ages_.follow(*robot);
  monitor_.start(robot);
  model_info_pub_ = private_nh_.advertise<ModelInfo>("model_info", 1, /*latch=*/true);
  objects_pub_ = private_nh_.advertise<ObjectList>("objects", 1, /*latch=*/true);
  object_markers_pub_ = private_nh_.advertise<visualization_msgs::MarkerArray>("object_markers", 1, /*latch=*/true);
  // These publish the objects, and a reload needs them.
  settings_server_ =
      std::make_unique<SettingsServer>(private_nh_, [this](const MonitorSettings& settings) { onSettings(settings); });
  advertiseServices();
  apply_objects_sub_ = withQueue(private_nh_, arrivals_)
                           .subscribe("apply_objects", kTopicQueueSize, &ChangeStream::enqueue, &change_stream_,
                                      ros::TransportHints().tcpNoDelay());
  registration_ = std::make_unique<Registration>(service_port_.address());
  objects_timer_ = private_nh_.createWallTimer(ros::WallDuration(kObjectsPeriod),
                                               [this](const ros::WallTimerEvent&) { publishChangedObjects(); });
  announce(*robot);
  arrivals_spinner_.start();
  tracked_sources_.follow(*robot);
}

void ProximityNode::advertiseServices() {
  advertise<MinimumDistance>("minimum_distance", requests_);
  advertise<SeparationAxis>("separation_axis", requests_);
  advertise<PenetrationDepth>("penetration_depth", requests_);
  advertise<QueryPairs>("query_pairs", long_requests_);
  advertise<QueryPoints>("query_points", long_requests_);
  advertise<QueryRays>("query_rays", long_requests_);
  advertise<QueryConfiguration>("query_configuration", long_requests_);
  advertise<FirstContact>("time_of_contact", long_requests_);
  advertise<QueryTrajectory>("query_trajectory", long_requests_);
  advertise<ProveJointBox>("prove_joint_box", long_requests_);
  advertise("apply_objects", changes_, &ProximityNode::onApplyObjects);
  advertise("reload", long_requests_, &ProximityNode::onReload);
  advertise("enable_monitor", requests_, &ProximityNode::onEnableMonitor);
  advertise("save_record", long_requests_, &ProximityNode::onSaveRecord);
}

bool ProximityNode::onApplyObjects(ApplyObjects::Request& request, ApplyObjects::Response& response) {
  response = answer(objects_, request);
  return true;
}

void ProximityNode::publishChangedObjects() {
  const ros::WallTime start = ros::WallTime::now();
  const bool is_new = objects_.revision() != published_revision_ || robot() != published_robot_.lock();
  if (!is_new || start < publish_objects_after_) return;
  publishObjects();
  const ros::WallTime end = ros::WallTime::now();
  publish_objects_after_ = end + (end - start) * kPauseFactor;
}

void ProximityNode::publishObjects() {
  const ObjectStore::CurrentObjects now = objects_.current();
  ObjectList list = objects_.list(now);
  list.header.stamp = ros::Time::now();
  published_revision_ = now.listed;
  published_robot_ = now.robot;
  object_keeper_.keep();
  publishLatched(objects_pub_, list);
  publishLatched(object_markers_pub_, object_markers_ ? objectMarkers(*now.robot, *now.objects.all) : noMarkers());
}

bool ProximityNode::onReload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  // Two reloads must not run at the same time: the monitor and the services could end with different robots.
  const std::lock_guard<std::mutex> lock(reload_mutex_);
  try {
    Config config = configOf(private_nh_, ends_);
    const MonitorSettings settings = settings_server_->settings();
    const std::string ignored = differences(settings, config.monitor);
    config.monitor = settings;
    const auto loaded = std::make_shared<const Robot>(nh_, config);
    // The settings may have changed while the robot was read, which takes seconds.
    settings_server_->withSettingsLocked([&](const MonitorSettings& current) {
      loaded->useDefaults(current);
      objects_.follow(loaded, [&] {
        std::atomic_store(&robot_, loaded);
        recorder_.know(objects_.recorded());
        tracked_ages_.follow(*loaded);
        monitor_.follow(loaded);
      });
    });
    tf_.watch(*loaded);
    tf_listener_.follow(*loaded);
    tracked_sources_.follow(*loaded);
    announce(*loaded);
    response.success = true;
    response.message = description(*loaded);
    if (!ignored.empty())
      response.message += "; live parameters stay as they are, unlike on the parameter server: " + ignored +
                          "; the service set_parameters (dynamic_reconfigure) changes them";
  } catch (const std::exception& error) {
    response.message = system::readable(std::string("the model stays as it was: ") + error.what());
    ROS_ERROR_STREAM("reload: " << response.message);
  }
  system::giveBackFreeMemory();  // loading needs many times the memory of the model
  return true;
}

bool ProximityNode::onEnableMonitor(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  request.data ? monitor_.enable() : monitor_.disable();
  response.success = true;
  response.message = request.data ? "the monitor runs" : "the monitor is silent";
  return true;
}

bool ProximityNode::onSaveRecord(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  if (!monitor_.beginRecord()) {
    response.message = "record_seconds is 0: nothing is recorded";
    return true;
  }
  const RequestWait request_wait;
  const Recorder::Outcome outcome = recorder_.await();
  response.success = outcome.problem.empty();
  response.message = response.success ? outcome.file : outcome.problem;
  return true;
}

void ProximityNode::onSettings(const MonitorSettings& settings) {
  robot()->useDefaults(settings);
  monitor_.configure(settings);
  object_markers_ = settings.markers;
  publishObjects();  // the settings may have switched the markers of objects on or off
}

void ProximityNode::announce(const Robot& robot) {
  ROS_INFO_STREAM("loaded " << description(robot));
  const ModelInfo info = toMessage(robot, ros::Time::now());
  for (const std::string& warning : info.warnings) ROS_WARN_STREAM(system::readable(warning));
  publishLatched(model_info_pub_, info);
}

}  // namespace proximity_server::node
