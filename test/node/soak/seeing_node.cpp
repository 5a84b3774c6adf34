#include "node/soak/seeing_node.h"

#include "node/load/programs.h"

#include <ros/service.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <std_srvs/Trigger.h>

#include <stdexcept>
#include <thread>
#include <vector>

namespace proximity_server::node {
namespace {

const std::string kName = "/seeing";
const std::string kTopic = "clearance of cameras";
const std::array<std::string, 2> kCameras{"/seeing/left", "/seeing/right"};
const char* const kWayNames[] = {"stops",         "jumps ahead", "jumps back",
                                 "comes twice",   "is nowhere",  "lies about its size",
                                 "has no fields", "is empty",    "is reloaded"};

constexpr double kRate = 50.0, kCameraRate = 15.0;      // [Hz]
constexpr double kMaxAge = 0.5;                         // [s] of a cloud
constexpr double kStopDistance = 0.5, kSpacing = 0.15;  // [m] each link has points nearer than that
constexpr double kStart = 20.0;                         // [s] that the node has to start

void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// Points on a grid about the robot.
sensor_msgs::PointCloud2 pointsAround() {
  std::vector<std::array<float, 3>> points;
  for (double z = 0.0; z < 1.5; z += kSpacing)
    for (double y = -1.2; y < 1.2; y += kSpacing)
      for (double x = -1.2; x < 1.2; x += kSpacing)
        points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  sensor_msgs::PointCloud2 cloud;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(points.size());
  sensor_msgs::PointCloud2Iterator<float> out(cloud, "x");
  for (const auto& point : points) {
    for (int axis = 0; axis < 3; ++axis) out[axis] = point[axis];
    ++out;
  }
  return cloud;
}

XmlRpc::XmlRpcValue sensedSources() {
  XmlRpc::XmlRpcValue sources;
  for (int i = 0; i < 2; ++i) {
    sources[i]["topic"] = kCameras[i];
    sources[i]["max_age"] = kMaxAge;
  }
  return sources;
}

}  // namespace

SeeingNode::SeeingNode(SoakRecord& record) : record_(record) {
  ros::NodeHandle nh;
  for (std::size_t i = 0; i < kCameras.size(); ++i)
    publishers_[i] = nh.advertise<sensor_msgs::PointCloud2>(kCameras[i], 10);
  node_ = startNode({{"rate", kRate},
                     {"max_tf_age", 0.5},
                     {"mesh_cache", "user"},
                     {"sensed", sensedSources()},
                     {"sensed_warn_distance", kStopDistance},
                     {"sensed_stop_distance", kStopDistance}},
                    kName);
  if (!awaitService(kName + "/enable_monitor", kStart))
    throw std::runtime_error("the node with cameras does not start");
  clearance_sub_ = nh.subscribe(kName + "/clearance", 1000, &SeeingNode::onClearance, this);
}

SeeingNode::~SeeingNode() {
  clearance_sub_.shutdown();
  stopProgram(*node_);
}

void SeeingNode::onClearance(const Clearance& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message.level == Clearance::INVALID) return record_.count(kTopic, SoakRecord::Outcome::Refused);
  if (message.level >= Clearance::STOP) {
    ++stops_;
    decided_by_ = message.deciding.b.link;
    arrived_.notify_all();
    return record_.count(kTopic, SoakRecord::Outcome::Right);
  }
  if (!must_stop_) return record_.count(kTopic, SoakRecord::Outcome::Misled);
  record_.countWrong(kTopic, "level " + std::to_string(message.level) + ", and a camera " + way_);
}

bool SeeingNode::awaitStop(double patience) {
  for (const auto start = std::chrono::steady_clock::now();;) {
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint64_t before = stops_;
    lock.unlock();
    seeFor(0.2, kCameras.size(), Way::Stops);
    lock.lock();
    if (stops_ > before) return true;
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > patience) return false;
  }
}

/// While a camera fails, the other one sees nothing: only the one that fails can tell that the robot has to stop. Beside an
/// empty cloud, which is empty space, it is the other one that sees the points.
void SeeingNode::seeFor(double seconds, std::size_t failing, Way way) {
  static const sensor_msgs::PointCloud2 around = pointsAround();
  for (double passed = 0.0; passed < seconds; passed += 1.0 / kCameraRate) {
    for (std::size_t camera = 0; camera < kCameras.size(); ++camera) {
      sensor_msgs::PointCloud2 cloud = around;
      cloud.header.frame_id = "base_link";
      cloud.header.stamp = ros::Time::now();
      const bool fails = camera == failing, is_other = failing < kCameras.size() && !fails;
      if (is_other && way != Way::Empty) sensor_msgs::PointCloud2Modifier(cloud).resize(0);
      if (fails && way == Way::Stops) continue;
      if (fails && way == Way::JumpsAhead) cloud.header.stamp += ros::Duration(1000.0);
      if (fails && way == Way::JumpsBack) cloud.header.stamp -= ros::Duration(1000.0);
      if (fails && way == Way::Nowhere) cloud.header.frame_id = "nowhere";
      if (fails && way == Way::LiesAboutSize) cloud.width = cloud.height = 0xffffffff;
      if (fails && way == Way::NoFields) cloud.fields.clear();
      if (fails && way == Way::Empty) sensor_msgs::PointCloud2Modifier(cloud).resize(0);
      see(camera, cloud);
      if (fails && way == Way::Twice) see(camera, cloud);
    }
    pause(1.0 / kCameraRate);
  }
}

/// Only this camera sees the points, until it decides a level: the node may leave out a cloud that another one follows, and
/// has this one's points then.
bool SeeingNode::sees(std::size_t camera, double patience) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    must_stop_ = false;
  }
  seeFor(2.0 * kMaxAge, camera, Way::Twice);
  for (double passed = 0.0; passed < patience; passed += 0.1) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      decided_by_.clear();
    }
    seeFor(0.1, camera, Way::Twice);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (decided_by_ == kCameras[camera].substr(1)) return true;
  }
  return false;
}

bool SeeingNode::fail(Chance& chance, double patience) {
  const int way = chance.below(kWays);
  const std::size_t camera = chance.below(2);
  if (!sees(camera, patience)) return false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    way_ = kWayNames[way];
    must_stop_ = true;
  }
  if (static_cast<Way>(way) == Way::Reload) {
    std_srvs::Trigger trigger;
    if (!ros::service::call(kName + "/reload", trigger) || !trigger.response.success)
      record_.countWrong(kTopic, "the reload fails: " + trigger.response.message);
  }
  seeFor(chance.between(0.1, 3.0 * kMaxAge), camera, static_cast<Way>(way));
  return awaitStop(patience);
}

}  // namespace proximity_server::node
