#include "node/tf/tf_tree.h"

#include "node/threads/real_time.h"
#include "node/threads/request_queue.h"

#include <ros/console.h>

#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr std::uint32_t kQueueSize = 100;  // [messages] as in tf2_ros

constexpr double kWarningPeriod = 5.0;  // [s] shortest time between two equal warnings

const std::string kAuthority = "tf";  // the publisher of all transforms; tf2 names it in its warnings only

/// Returns the frame name without the leading slash that tf1 allowed. tf2 compares names in the same way.
std::string frameName(const std::string& name) { return !name.empty() && name.front() == '/' ? name.substr(1) : name; }

void warnAboutBoth(const std::string& child) {
  ROS_WARN_STREAM("frame '" << child << "' is on /tf and on /tf_static: it counts as one that moves");
}

}  // namespace

TfTree::TfTree(int realtime_priority, OnMoving on_moving, std::function<void()> on_change)
    : on_moving_(std::move(on_moving)),
      on_change_(std::move(on_change)),
      buffer_(std::make_shared<tf2::BufferCore>()),
      spinner_(1, &queue_) {
  nh_.setCallbackQueue(&queue_);
  // Without this option the publisher's kernel delays small messages by tens of milliseconds (Nagle's algorithm).
  const ros::TransportHints at_once = ros::TransportHints().tcpNoDelay();
  moving_sub_ = nh_.subscribe("/tf", kQueueSize, &TfTree::onMoving, this, at_once);
  static_sub_ = nh_.subscribe("/tf_static", kQueueSize, &TfTree::onStatic, this, at_once);
  queue_.addCallback(callbackOf([realtime_priority] { runInRealTime(realtime_priority); }));
  spinner_.start();
}

TfTree::~TfTree() {
  queue_.disable();
  spinner_.stop();
}

TfTree::View TfTree::view() const {
  std::unique_lock<std::mutex> lock(mutex_);
  return {std::move(lock), buffer_, changes_};
}

void TfTree::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  forgetAllThatMoves();
}

void TfTree::forgetAllThatMoves() {
  buffer_ = std::make_shared<tf2::BufferCore>();
  ++changes_;
  for (const auto& [child, transform] : static_) keep(transform, Kind::Static);
}

void TfTree::onMoving(const Message& message) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const geometry_msgs::TransformStamped& transform : message.transforms) keepMoving(transform);
    ++changes_;
  }
  on_change_();
}

void TfTree::onStatic(const Message& message) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const geometry_msgs::TransformStamped& transform : message.transforms) keepStatic(transform);
    ++changes_;
  }
  on_change_();
}

void TfTree::keepMoving(const geometry_msgs::TransformStamped& transform) {
  const std::string child = frameName(transform.child_frame_id);
  if (transform.header.stamp.isZero()) {
    // tf2 would return it as the latest transform at every time.
    ROS_WARN_STREAM_THROTTLE(kWarningPeriod, "frame '" << child << "' comes on /tf without a stamp: ignored");
    return;
  }
  on_moving_(transform);
  if (moving_.insert(child).second && static_.erase(child) > 0) {
    warnAboutBoth(child);
    forgetAllThatMoves();
  }
  keep(transform, Kind::Moving);
}

void TfTree::keepStatic(const geometry_msgs::TransformStamped& transform) {
  const std::string child = frameName(transform.child_frame_id);
  if (moving_.count(child) > 0) {
    warnAboutBoth(child);
    return;
  }
  static_[child] = transform;
  keep(transform, Kind::Static);
}

void TfTree::keep(const geometry_msgs::TransformStamped& transform, Kind kind) {
  try {
    buffer_->setTransform(transform, kAuthority, kind == Kind::Static);
  } catch (const std::runtime_error& error) {  // thrown by ros::Time for an overflow, which tf does not handle
    ROS_WARN_STREAM_THROTTLE(kWarningPeriod, "frame '" << transform.child_frame_id << "' is ignored: " << error.what());
  }
}

}  // namespace proximity_server::node
