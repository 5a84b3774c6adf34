#include "node/record/record_messages.h"

#include "node/answers/conversions.h"
#include "node/answers/gradients.h"
#include "node/objects/change_fields.h"
#include "node/robot/parameter_table.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace proximity_server::node {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr double kLongestPause = 1.0;  ///< [s] positions that are farther apart give no velocity

geometry_msgs::TransformStamped transformOf(const std_msgs::Header& header, const std::string& child,
                                            const Eigen::Isometry3d& pose) {
  geometry_msgs::TransformStamped transform;
  transform.header = header;
  transform.child_frame_id = child;
  const geometry_msgs::Pose message = toMessage(pose);
  transform.transform.translation.x = message.position.x;
  transform.transform.translation.y = message.position.y;
  transform.transform.translation.z = message.position.z;
  transform.transform.rotation = message.orientation;
  return transform;
}

Eigen::Isometry3d poseOf(const geometry_msgs::Transform& transform) {
  const auto& [x, y, z] = std::tie(transform.translation.x, transform.translation.y, transform.translation.z);
  const geometry_msgs::Quaternion& q = transform.rotation;
  return Eigen::Translation3d(x, y, z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

const std::string& frameOfBody(const Robot& robot, std::size_t body) {
  return robot.frameOf(robot.robotModel().bodies[body].link);
}

}  // namespace

Record recordOf(const Robot& robot, const std::string& event, const ros::Time& stamp) {
  Record record;
  record.version = PROXIMITY_VERSION;
  record.event = event;
  record.event_stamp = stamp;
  record.parameters = robot.config().parameters;
  record.reference_frame = robot.referenceFrame();
  for (const RobotTexts& texts : robot.texts()) {
    record.robot_descriptions.push_back(texts.urdf);
    record.semantic_descriptions.push_back(texts.srdf);
  }
  return record;
}

tf2_msgs::TFMessage posesOf(const Robot& robot, const std::vector<std::string>& frames, const RecordedCycle& cycle) {
  tf2_msgs::TFMessage message;
  std_msgs::Header header;
  header.stamp = cycle.clearance.header.stamp;
  header.frame_id = robot.referenceFrame();
  for (std::size_t body = 0; body < cycle.poses.size(); ++body)
    if (cycle.poses[body])
      message.transforms.push_back(transformOf(header, frameOfBody(robot, body), *cycle.poses[body]));
  for (std::size_t frame = 0; frame < std::min(frames.size(), cycle.frames.size()); ++frame)
    if (cycle.frames[frame]) message.transforms.push_back(transformOf(header, frames[frame], *cycle.frames[frame]));
  return message;
}

void placePoses(const tf2_msgs::TFMessage& message, const Robot& robot, const std::vector<std::string>& frames,
                RecordedCycle& cycle) {
  cycle.poses.assign(robot.robotModel().bodies.size(), std::nullopt);
  cycle.frames.assign(frames.size(), std::nullopt);
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    for (std::size_t body = 0; body < cycle.poses.size(); ++body)
      if (frameOfBody(robot, body) == transform.child_frame_id) cycle.poses[body] = poseOf(transform.transform);
    for (std::size_t frame = 0; frame < frames.size(); ++frame)
      if (frames[frame] == transform.child_frame_id) cycle.frames[frame] = poseOf(transform.transform);
  }
}

sensor_msgs::JointState jointsOf(const Robot& robot, const RecordedCycle& cycle,
                                 const sensor_msgs::JointState& before) {
  sensor_msgs::JointState state;
  state.header.stamp = cycle.clearance.header.stamp;
  std::vector<bool> turns;
  for (const scene::Joint& joint : robot.robotModel().joints) {
    const double position = joint.mimic ? kNaN : jointPositionAt(robot.robotModel(), joint, cycle.poses);
    if (!std::isfinite(position)) continue;
    state.name.push_back(joint.name);
    state.position.push_back(position);
    turns.push_back(joint.type != scene::Joint::Type::Prismatic);
  }
  const double elapsed = state.header.stamp.toSec() - before.header.stamp.toSec();
  if (elapsed <= 0.0 || elapsed > kLongestPause || before.name != state.name) return state;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const double way = state.position[i] - before.position[i];
    state.velocity.push_back((turns[i] ? std::remainder(way, kTurn) : way) / elapsed);
  }
  return state;
}

dynamic_reconfigure::Config toMessage(const MonitorSettings& settings) {
  Config config;
  config.monitor = settings;
  dynamic_reconfigure::Config message;
  const auto named = [](auto entry, const std::string& name, auto value) {
    entry.name = name;
    entry.value = value;
    return entry;
  };
  for (const scene::Parameter& parameter : parameterTable(config)) {
    if (parameter.change != scene::Parameter::Change::Live) continue;
    if (const auto* const* number = std::get_if<double*>(&parameter.field))
      message.doubles.push_back(named(dynamic_reconfigure::DoubleParameter(), parameter.name, **number));
    if (const auto* const* count = std::get_if<int*>(&parameter.field))
      message.ints.push_back(named(dynamic_reconfigure::IntParameter(), parameter.name, **count));
    if (const auto* const* flag = std::get_if<bool*>(&parameter.field))
      message.bools.push_back(named(dynamic_reconfigure::BoolParameter(), parameter.name, **flag));
  }
  return message;
}

}  // namespace proximity_server::node
