// Moves a robot for ./dev demo: publishes joint_states at 100 Hz. The motion is the script in ~times and ~positions,
// or, if there is none, a slow sweep of every joint between its limits.
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/model/robot_model.h"

namespace {

using proximity_server::scene::Joint;

/// The position between the keyframes of one joint at a time; the motion is repeated. There are as many positions as
/// times.
double follow(const std::vector<double>& times, const std::vector<double>& positions, double time) {
  const double t = std::fmod(time, times.back());
  const auto next = std::upper_bound(times.begin(), times.end(), t);
  const auto i = static_cast<std::size_t>(next - times.begin());
  const double blend = 0.5 - 0.5 * std::cos(M_PI * (t - times[i - 1]) / (times[i] - times[i - 1]));
  return positions[i - 1] + blend * (positions[i] - positions[i - 1]);
}

/// A sine between the limits, or half a radian or metre about zero if there are none, at most at half of the velocity
/// limit. `number` gives each joint a period of its own, so that the motion of the robot does not repeat itself soon.
double sweep(const Joint& joint, std::size_t number, double time) {
  const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
  const double middle = limited ? 0.5 * (joint.lower + joint.upper) : 0.0;
  const double half_range = limited ? 0.5 * (joint.upper - joint.lower) : 0.5;
  if (!(half_range > 0.0)) return middle;
  const double speed = std::min(half_range / (2.0 + 0.31 * static_cast<double>(number)), 0.5 * joint.max_velocity);
  return middle + half_range * std::sin(speed / half_range * time);
}

bool isDriven(const Joint& joint) {
  return !joint.mimic && joint.type != Joint::Type::Floating && joint.type != Joint::Type::Planar;
}

std::vector<Joint> drivenJoints(const ros::NodeHandle& nh) {
  std::string urdf;
  if (!nh.getParam("robot_description", urdf)) throw std::invalid_argument("there is no parameter robot_description");
  // Only the joints are needed, so no mesh is read.
  const auto no_mesh = [](const std::string& uri) -> std::string { throw std::invalid_argument(uri); };
  proximity_server::scene::ModelOptions options;
  options.allow_missing_meshes = true;
  auto joints = proximity_server::scene::loadRobotModel(urdf, no_mesh, options).joints;
  joints.erase(std::remove_if(joints.begin(), joints.end(), [](const Joint& j) { return !isDriven(j); }), joints.end());
  return joints;
}

/// The keyframes of a joint in ~positions, as many as `times`; all are 0 if the joint has none. ~positions is one map
/// of all joints, because not every name of a joint is a legal name of a parameter.
std::vector<double> keyframes(XmlRpc::XmlRpcValue& positions, const std::string& joint,
                              const std::vector<double>& times) {
  std::vector<double> result(times.size(), 0.0);
  if (positions.getType() != XmlRpc::XmlRpcValue::TypeStruct || !positions.hasMember(joint)) return result;
  XmlRpc::XmlRpcValue& values = positions[joint];
  if (values.getType() != XmlRpc::XmlRpcValue::TypeArray || values.size() != static_cast<int>(times.size())) {
    throw std::invalid_argument("~positions/" + joint + " has not as many entries as ~times");
  }
  for (int i = 0; i < values.size(); ++i) {
    const bool is_int = values[i].getType() == XmlRpc::XmlRpcValue::TypeInt;
    result[i] = is_int ? static_cast<int>(values[i]) : static_cast<double>(values[i]);
  }
  return result;
}

void move(ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  const std::vector<Joint> joints = drivenJoints(nh);
  const auto times = private_nh.param("times", std::vector<double>());
  XmlRpc::XmlRpcValue positions;
  private_nh.getParam("positions", positions);
  std::vector<std::vector<double>> script(joints.size());
  sensor_msgs::JointState state;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    state.name.push_back(joints[i].name);
    script[i] = keyframes(positions, joints[i].name, times);
  }
  state.position.resize(joints.size());
  state.velocity.resize(joints.size());
  const auto position = [&](std::size_t i, double time) {
    return times.empty() ? sweep(joints[i], i, time) : follow(times, script[i], time);
  };

  ros::Publisher publisher = nh.advertise<sensor_msgs::JointState>("joint_states", 1);
  const ros::Time start = ros::Time::now();
  for (ros::Rate rate(100.0); ros::ok(); rate.sleep()) {
    state.header.stamp = ros::Time::now();
    const double time = (state.header.stamp - start).toSec();
    for (std::size_t i = 0; i < joints.size(); ++i) {
      constexpr double kMoment = 1e-3;  // [s]
      state.position[i] = position(i, time);
      state.velocity[i] = (position(i, time + kMoment) - state.position[i]) / kMoment;
    }
    publisher.publish(state);
  }
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "demo_motion");
  ros::NodeHandle nh, private_nh("~");
  try {
    move(nh, private_nh);
  } catch (const XmlRpc::XmlRpcException& error) {  // not derived from std::exception
    ROS_FATAL("~positions: %s", error.getMessage().c_str());
    return 1;
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
