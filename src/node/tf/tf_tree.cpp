#include "node/tf/tf_tree.h"

#include "system/number_text.h"

#include <ros/console.h>

#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr double kWarningPeriod = 5.0;  // [s] shortest time between two equal warnings

const std::string kAuthority = "tf";  // the publisher of all transforms; tf2 names it in its warnings only

/// Returns the frame name without the leading slash that tf1 allowed. tf2 compares names in the same way.
std::string frameName(const std::string& name) { return !name.empty() && name.front() == '/' ? name.substr(1) : name; }

void warnAboutBoth(const std::string& child) {
  ROS_WARN_STREAM("frame '" << system::readable(child) << "' is on /tf and on /tf_static: it counts as one that moves");
}

}  // namespace

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

void TfTree::add(const tf2_msgs::TFMessage& message, Kind kind) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : message.transforms)
    kind == Kind::Moving ? keepMoving(transform) : keepStatic(transform);
  ++changes_;
}

void TfTree::keepMoving(const geometry_msgs::TransformStamped& transform) {
  const std::string child = frameName(transform.child_frame_id);
  if (transform.header.stamp.isZero()) {
    // tf2 would return it as the latest transform at every time.
    ROS_WARN_STREAM_THROTTLE(kWarningPeriod,
                             "frame '" << system::readable(child) << "' comes on /tf without a stamp: ignored");
    return;
  }
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
    ROS_WARN_STREAM_THROTTLE(
        kWarningPeriod, "frame '" << system::readable(transform.child_frame_id) << "' is ignored: " << error.what());
  }
}

}  // namespace proximity_server::node
