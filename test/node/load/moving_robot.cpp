#include "node/load/moving_robot.h"

#include "proximity_server/scene/model/kinematics.h"

#include <cmath>

namespace proximity_server::node {

using namespace scene;
namespace {

/// [rad] or [m] on either side of the middle: so much of the range, or so much where there is none.
constexpr double kSwing = 0.4, kSwingWithoutLimits = 0.5;

/// A sine of 3 s or more. Its argument repeats every day, so that it stays exact.
double swing(const Joint& joint, std::size_t number, const ros::Time& time) {
  constexpr std::uint32_t kDay = 86400;  // [s]
  const double seconds = time.sec % kDay + 1e-9 * time.nsec;
  const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
  const double middle = limited ? 0.5 * (joint.lower + joint.upper) : 0.0;
  const double amplitude = limited ? kSwing * (joint.upper - joint.lower) : kSwingWithoutLimits;
  return middle + amplitude * std::sin(2.0 * M_PI * seconds / (3.0 + 0.7 * static_cast<double>(number)));
}

geometry_msgs::TransformStamped toMessage(const Eigen::Isometry3d& pose) {
  geometry_msgs::TransformStamped message;
  message.transform.translation.x = pose.translation().x();
  message.transform.translation.y = pose.translation().y();
  message.transform.translation.z = pose.translation().z();
  const Eigen::Quaterniond rotation(pose.linear());
  message.transform.rotation.x = rotation.x();
  message.transform.rotation.y = rotation.y();
  message.transform.rotation.z = rotation.z();
  message.transform.rotation.w = rotation.w();
  return message;
}

}  // namespace

bool isSettable(const Joint& joint) {
  return !joint.mimic && joint.type != Joint::Type::Floating && joint.type != Joint::Type::Planar;
}

std::vector<double> MovingRobot::positionsAt(const ros::Time& time) const {
  std::vector<double> positions(robot_.joints.size(), 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (isSettable(robot_.joints[i])) positions[i] = swing(robot_.joints[i], i, time);
  }
  return positions;
}

std::vector<geometry_msgs::TransformStamped> MovingRobot::transformsAt(const ros::Time& time) const {
  const std::vector<double> positions = positionsAt(time);
  const auto name = [this](int link) { return robot_.links[link].name; };
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Joint& joint = robot_.joints[i];
    const Joint::Mimic leader = robot_.leaderOf(static_cast<int>(i));
    const double position = leader.offset + leader.multiplier * positions[leader.joint];
    transforms.push_back(toMessage(joint.parent_T_joint * jointMotion(joint, position)));
    transforms.back().header.stamp = time;
    transforms.back().header.frame_id = name(joint.parent_link);
    transforms.back().child_frame_id = name(joint.child_link);
  }
  return transforms;
}

sensor_msgs::JointState MovingRobot::jointStateAt(const ros::Time& time) const {
  const std::vector<double> positions = positionsAt(time);
  sensor_msgs::JointState state;
  state.header.stamp = time;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!isSettable(robot_.joints[i])) continue;
    state.name.push_back(robot_.joints[i].name);
    state.position.push_back(positions[i]);
  }
  return state;
}

}  // namespace proximity_server::node
