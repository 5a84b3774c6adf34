#include "node/faults/tf_faults.h"

#include <tf2_msgs/TFMessage.h>

#include <limits>
#include <utility>

namespace proximity_server::node {
namespace {

using geometry_msgs::TransformStamped;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHuge = 1e300;            // [m]
constexpr double kBetweenMessages = 1e-3;  // [s] less than the period of any stream

TransformStamped identity(const TransformStamped& like, const std::string& parent, const std::string& child) {
  TransformStamped result = like;
  result.header.frame_id = parent;
  result.child_frame_id = child;
  result.transform = geometry_msgs::Transform();
  result.transform.rotation.w = 1.0;
  return result;
}

TransformStamped withX(TransformStamped transform, double x) {
  transform.transform.translation.x = x;
  return transform;
}

TransformStamped withRotationTimes(TransformStamped transform, double factor) {
  geometry_msgs::Quaternion& rotation = transform.transform.rotation;
  for (double* part : {&rotation.x, &rotation.y, &rotation.z, &rotation.w}) *part *= factor;
  return transform;
}

TransformStamped delayed(TransformStamped transform, double seconds) {
  transform.header.stamp += ros::Duration(seconds);
  return transform;
}

TransformStamped withParent(TransformStamped transform, const std::string& parent) {
  transform.header.frame_id = parent;
  return transform;
}

TransformStamped withChild(TransformStamped transform, const std::string& child) {
  transform.child_frame_id = child;
  return transform;
}

TransformStamped displaced(const TransformStamped& transform) {
  return withX(transform, transform.transform.translation.x + kDisplacement);
}

}  // namespace

const std::vector<TfFaultKind>& tfFaults() {
  static const std::vector<TfFaultKind> kinds = {
      {TfFault::Silence, "Silence", TfEffect::Blinds},
      {TfFault::FrozenStamp, "FrozenStamp", TfEffect::Blinds},
      {TfFault::StampsOfThePast, "StampsOfThePast", TfEffect::Blinds},
      {TfFault::StampsAhead, "StampsAhead", TfEffect::Blinds},
      {TfFault::NoStamp, "NoStamp", TfEffect::Blinds},
      {TfFault::EndOfTime, "EndOfTime", TfEffect::Blinds},
      {TfFault::OutOfOrder, "OutOfOrder", TfEffect::None},
      {TfFault::NanPosition, "NanPosition", TfEffect::Blinds},
      {TfFault::NanRotation, "NanRotation", TfEffect::Blinds},
      {TfFault::InfinitePosition, "InfinitePosition", TfEffect::Blinds},
      {TfFault::HugePosition, "HugePosition", TfEffect::Blinds},
      {TfFault::ZeroQuaternion, "ZeroQuaternion", TfEffect::Blinds},
      {TfFault::LongQuaternion, "LongQuaternion", TfEffect::Blinds},
      {TfFault::Loop, "Loop", TfEffect::Blinds},
      {TfFault::OtherTree, "OtherTree", TfEffect::Blinds},
      {TfFault::FrameBetween, "FrameBetween", TfEffect::None},
      {TfFault::Renamed, "Renamed", TfEffect::Blinds},
      {TfFault::Jump, "Jump", TfEffect::Misleads},
      {TfFault::TwoPublishers, "TwoPublishers", TfEffect::Misleads},
  };
  return kinds;
}

FaultyTf::FaultyTf(ros::NodeHandle nh, const std::string& topic)
    : publisher_(nh.advertise<tf2_msgs::TFMessage>(topic, 100)) {}

void FaultyTf::apply(TfFault fault, const std::string& child_frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  fault_ = fault;
  victim_ = child_frame;
  first_.clear();
  held_.clear();
}

void FaultyTf::send(const std::vector<TransformStamped>& transforms) {
  const std::lock_guard<std::mutex> lock(mutex_);
  tf2_msgs::TFMessage message;
  for (const TransformStamped& healthy : transforms) {
    const bool is_victim = victim_.empty() || healthy.child_frame_id == victim_;
    const Transforms sent = is_victim ? spoiled(healthy) : Transforms{healthy};
    message.transforms.insert(message.transforms.end(), sent.begin(), sent.end());
  }
  if (!message.transforms.empty()) publisher_.publish(message);
}

FaultyTf::Transforms FaultyTf::spoiled(const TransformStamped& healthy) {
  const std::string& parent = healthy.header.frame_id;
  const std::string& child = healthy.child_frame_id;
  const std::string other = child + "_of_a_fault";
  const TransformStamped& first = first_.try_emplace(child, healthy).first->second;
  TransformStamped wrong = healthy;
  switch (fault_) {
    case TfFault::None:
      return {healthy};
    case TfFault::Silence:
      return {};
    case TfFault::FrozenStamp:
      wrong.header.stamp = first.header.stamp;
      return {wrong};
    case TfFault::StampsOfThePast:
      return {delayed(healthy, -kFarTime)};
    case TfFault::StampsAhead:
      return {delayed(healthy, kFarTime)};
    case TfFault::NoStamp:
      wrong.header.stamp = ros::Time();
      return {wrong};
    case TfFault::EndOfTime:
      wrong.header.stamp = ros::TIME_MAX;
      return {wrong};
    case TfFault::OutOfOrder:
      return swapped(healthy);
    case TfFault::NanPosition:
      return {withX(healthy, kNaN)};
    case TfFault::NanRotation:
      return {withRotationTimes(healthy, kNaN)};
    case TfFault::InfinitePosition:
      return {withX(healthy, kInfinity)};
    case TfFault::HugePosition:
      return {withX(healthy, kHuge)};
    case TfFault::ZeroQuaternion:
      return {withRotationTimes(healthy, 0.0)};
    case TfFault::LongQuaternion:
      return {withRotationTimes(healthy, 2.0)};
    case TfFault::Loop:
      return {withParent(healthy, other), identity(healthy, child, other)};
    case TfFault::OtherTree:
      return {withParent(healthy, other)};
    case TfFault::FrameBetween:
      return {withParent(healthy, other), identity(healthy, parent, other)};
    case TfFault::Renamed:
      return {withChild(healthy, other)};
    case TfFault::Jump:
      return {displaced(healthy)};
    case TfFault::TwoPublishers:
      return {healthy, delayed(displaced(healthy), kBetweenMessages)};
  }
  return {};
}

FaultyTf::Transforms FaultyTf::swapped(const TransformStamped& healthy) {
  const auto [held, is_first] = held_.try_emplace(healthy.child_frame_id, healthy);
  if (is_first) return {};
  const TransformStamped earlier = held->second;
  held_.erase(held);
  return {healthy, earlier};
}

TfStream::TfStream(const ros::NodeHandle& nh, double rate, Source transforms, const std::string& topic)
    : tf_(nh, topic),
      transforms_(std::move(transforms)),
      ticker_(nh, rate, [this] { tf_.send(transforms_(ros::Time::now())); }) {
  ticker_.start();
}

}  // namespace proximity_server::node
