#include "node/tf/joint_jumps.h"

#include "node/tf/edge_transforms.h"
#include "node/tf/joint_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr double kStampJitter = 0.02;   // [s] largest error of the stamps of one publisher
constexpr double kCrossingTime = 0.05;  // [s] no joint without a velocity limit crosses half of its range faster
constexpr double kQuarterTurn =
    M_PI_2;                          // [rad] replaces half of a large range, because a pose does not show full turns
constexpr double kLongestGap = 1.0;  // [s] largest difference of the stamps of two transforms that are compared
constexpr double kLongestStepBack = 0.1;  // [s] by which the stamps of two publishers that alternate may go back

constexpr std::chrono::seconds kLongestReturn{2};  // longest time between a jump and the jump back
constexpr std::chrono::seconds kReportPeriod{5};   // a jump back is reported for this time

/// Returns the frame name without the leading slash that tf1 allowed.
std::string_view frameName(std::string_view name) {
  return !name.empty() && name.front() == '/' ? name.substr(1) : name;
}

bool isRotation(scene::Joint::Type type) {
  return type == scene::Joint::Type::Revolute || type == scene::Joint::Type::Continuous;
}

std::string sentence(const std::string& joint, double step, const char* unit, double time) {
  char text[96];
  std::snprintf(text, sizeof text, ": transforms jump by %.3g %s within %.3g s: two publishers?", step, unit, time);
  return joint + text;
}

}  // namespace

void JointJumps::watch(const Robot& robot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  joints_.clear();
  by_child_.clear();
  for (std::size_t i = 0; i < robot.robotModel().joints.size(); ++i) {
    const scene::Joint& joint = robot.robotModel().joints[i];
    const TfEdge& edge = (*robot.tfEdges())[i];
    if (joint.type == scene::Joint::Type::Floating || joint.type == scene::Joint::Type::Planar) continue;
    by_child_[edge.child] = joints_.size();
    joints_.push_back({joint.type, joint.max_velocity, joint.upper - joint.lower, edge.parent, edge.name, {}, {}, {}});
  }
}

void JointJumps::add(const geometry_msgs::TransformStamped& transform, Clock::time_point now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto hit = by_child_.find(frameName(transform.child_frame_id));
  if (hit == by_child_.end()) return;
  TrackedJoint& joint = joints_[hit->second];
  if (frameName(transform.header.frame_id) != joint.parent) return;
  const std::optional<Eigen::Isometry3d> pose = rigidMotion(transform.transform);
  if (!pose) return;

  const Sample sample{static_cast<std::int64_t>(transform.header.stamp.toNSec()), *pose};
  const std::optional<Sample> before = std::exchange(joint.last, sample);
  if (!before) return;
  const double time = 1e-9 * static_cast<double>(sample.stamp - before->stamp);
  const double step = stepBetween(joint, before->pose, sample.pose);
  if (time > kLongestGap || time < -kLongestStepBack || !isJump(joint, step, std::abs(time))) return;

  const std::optional<Jump> first = std::exchange(joint.jump, Jump{now, before->pose, step, std::abs(time)});
  if (!first || now - first->when > kLongestReturn) return;
  if (stepBetween(joint, first->from, sample.pose) < 0.5 * first->step) joint.confirmed = now;
}

void JointJumps::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (TrackedJoint& joint : joints_) {
    joint.last.reset();
    joint.jump.reset();
  }
}

std::vector<std::string> JointJumps::recent(Clock::time_point now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> sentences;
  for (const TrackedJoint& joint : joints_) {
    if (!joint.confirmed || !joint.jump || now - *joint.confirmed > kReportPeriod) continue;
    sentences.push_back(sentence(joint.name, joint.jump->step, isRotation(joint.type) ? "rad" : "m", joint.jump->time));
  }
  return sentences;
}

double JointJumps::stepBetween(const TrackedJoint& joint, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  if (!isRotation(joint.type)) return (b.translation() - a.translation()).norm();
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

bool JointJumps::isJump(const TrackedJoint& joint, double step, double time) {
  if (std::isfinite(joint.max_velocity)) return step > kVelocityFactor * joint.max_velocity * (time + kStampJitter);
  if (time >= kCrossingTime || !std::isfinite(joint.range)) return false;
  const double longest = isRotation(joint.type) ? std::min(0.5 * joint.range, kQuarterTurn) : 0.5 * joint.range;
  return step > longest;
}

}  // namespace proximity_server::node
