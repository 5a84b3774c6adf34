#include "node/tf/tf_tree.h"

#include <ros/console.h>

#include <stdexcept>
#include <utility>

#include "node/system/real_time.h"
#include "node/system/request_queue.h"

namespace proximity_server::node {
namespace {

constexpr std::uint32_t kQueue = 100;  // messages, as tf2_ros has it

constexpr double kQuiet = 5.0;  // [s] between two warnings

const std::string kAuthority = "tf";  // of all transforms: tf2 tells it in its own warnings only

/// As tf2 compares names: without the leading slash of tf1.
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
  // Else the publisher's kernel holds small messages back until the last one is acknowledged: tens of milliseconds.
  const ros::TransportHints at_once = ros::TransportHints().tcpNoDelay();
  moving_sub_ = nh_.subscribe("/tf", kQueue, &TfTree::onMoving, this, at_once);
  static_sub_ = nh_.subscribe("/tf_static", kQueue, &TfTree::onStatic, this, at_once);
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
    // tf2 would call it the latest one at every time.
    ROS_WARN_STREAM_THROTTLE(kQuiet, "frame '" << child << "' comes on /tf without a stamp: ignored");
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
  } catch (const std::runtime_error& error) {  // of the arithmetic of ros::Time, which tf does not expect
    ROS_WARN_STREAM_THROTTLE(kQuiet, "frame '" << transform.child_frame_id << "' is ignored: " << error.what());
  }
}

}  // namespace proximity_server::node
