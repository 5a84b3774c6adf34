#include "node/tf/stated_joints.h"

#include "node/tf/joint_frames.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/posed_position.h"
#include "system/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

namespace proximity_server::node {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;
constexpr double kDegree = kTurn / 360.0;
constexpr double kAgreement = 0.05;  // [rad] by which positions of two programs may differ, such as by a calibration

/// The robot of a joint, as an index into RobotModel::robots.
int memberOf(const scene::RobotModel& model, int joint) {
  return model.bodies[model.links[model.joints[joint].child_link].body].robot;
}

/// Returns whether another robot on the same topic has a joint that its URDF calls `own_name`, too.
bool isAmbiguous(const Robot& robot, int member, const std::string& own_name) {
  const scene::RobotModel& model = robot.robotModel();
  for (int other = 0; other < static_cast<int>(model.robots.size()); ++other) {
    if (other == member || robot.sources()[other].joint_states != robot.sources()[member].joint_states) continue;
    if (scene::findNamed(model.joints, model.robots[other].nameInModel(own_name)) >= 0) return true;
  }
  return false;
}

/// Computed in double, because ros::Duration throws for stamps that are decades apart.
double secondsBetween(const ros::Time& a, const ros::Time& b) { return std::abs(a.toSec() - b.toSec()); }

/// [rad] or [m] Negative or 0 within the limits.
double excessOf(const scene::Joint& joint, double position) {
  return scene::PositionLimits{joint.lower, joint.upper}.excess(position);
}

bool seemsInDegrees(const scene::Joint& joint, double position) {
  return joint.type == scene::Joint::Type::Revolute && std::abs(position) > kTurn &&
         excessOf(joint, position * kDegree) <= scene::kBeyondLimit;
}

}  // namespace

bool StatedJoints::Number::isFresh(const ros::Time& time, double max_age) const {
  return std::isfinite(value) && secondsBetween(time, stamp) <= max_age;
}

void StatedJoints::add(const sensor_msgs::JointState& state, const std::string& topic) {
  const bool has_positions = state.position.size() == state.name.size();
  const bool has_velocities = state.velocity.size() == state.name.size();
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = latest_.find(topic);
  if (known == latest_.end()) return;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const auto entry = known->second.find(state.name[i]);
    if (entry == known->second.end()) continue;
    if (has_positions) entry->second->position = {state.position[i], state.header.stamp};
    if (has_velocities) entry->second->velocity = {state.velocity[i], state.header.stamp};
  }
}

void StatedJoints::follow(const Robot& robot) {
  const scene::RobotModel& model = robot.robotModel();
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<std::string, Entries> next;
  for (std::size_t joint = 0; joint < model.joints.size(); ++joint) {
    const std::string &topic = topicOf(robot, static_cast<int>(joint)), &name = model.joints[joint].name;
    const auto known = latest_.find(topic);
    const bool is_known = known != latest_.end() && known->second.count(name) > 0;
    std::shared_ptr<Entry> entry = is_known ? known->second[name] : std::make_shared<Entry>();
    const int member = memberOf(model, static_cast<int>(joint));
    const std::string own = model.robots[member].ownName(name);
    if (!isAmbiguous(robot, member, own)) next[topic].emplace(own, entry);
    next[topic][name] = std::move(entry);
  }
  latest_ = std::move(next);
}

const StatedJoints::Entry* StatedJoints::View::find(const Robot& robot, int joint) const {
  const auto entries = latest_.find(topicOf(robot, joint));
  if (entries == latest_.end()) return nullptr;
  const auto hit = entries->second.find(robot.robotModel().joints[joint].name);
  return hit == entries->second.end() ? nullptr : hit->second.get();
}

const std::string& topicOf(const Robot& robot, int joint) {
  return robot.sources()[memberOf(robot.robotModel(), joint)].joint_states;
}

std::optional<double> onStatedTurn(const Robot& robot, int index, const Eigen::Isometry3d& parent_T_child,
                                   const ros::Time& stamp, const StatedJoints::Entry& entry) {
  const scene::Joint& joint = robot.robotModel().joints[index];
  const bool turns = joint.type == scene::Joint::Type::Revolute || joint.type == scene::Joint::Type::Continuous;
  if (!turns || joint.mimic || !entry.position.isFresh(stamp, robot.config().max_tf_age)) return std::nullopt;
  const double stated = entry.position.value;
  const double position =
      scene::PosedPosition{positionAt(robot.robotModel(), index, parent_T_child), kTurn}.nearestTo(stated);
  const double time = secondsBetween(stamp, entry.position.stamp);
  const double meanwhile = time > 0.0 ? kVelocityFactor * joint.max_velocity * time : 0.0;  // the limit may be infinite
  if (std::abs(stated - position) > std::min(kAgreement + meanwhile, 0.25 * kTurn)) return std::nullopt;
  if (excessOf(joint, position) > 0.5 * kTurn) return std::nullopt;
  return position;
}

std::optional<JointBeyond> farthestBeyond(const Robot& robot, const StatedJoints& stated, const ros::Time& now) {
  std::optional<JointBeyond> farthest;
  double largest = scene::kBeyondLimit;
  const StatedJoints::View view = stated.view();
  const std::vector<scene::Joint>& joints = robot.robotModel().joints;
  for (int index = 0; index < static_cast<int>(joints.size()); ++index) {
    if (joints[index].mimic || !scene::hasOnePosition(joints[index])) continue;
    const StatedJoints::Entry* const entry = view.find(robot, index);
    if (!entry || !entry->position.isFresh(now, robot.config().max_tf_age)) continue;
    const double excess = excessOf(joints[index], entry->position.value);
    if (!(excess > largest)) continue;
    largest = excess;
    farthest = JointBeyond{index, entry->position.value};
  }
  return farthest;
}

void append(std::string& text, const Robot& robot, const JointBeyond& beyond) {
  const scene::Joint& joint = robot.robotModel().joints[beyond.joint];
  text += "joint '";
  text += joint.name;
  text += "' is at ";
  system::appendRounded(text, beyond.position, 4);
  text += joint.type == scene::Joint::Type::Prismatic ? " m" : " rad";
  text += " in joint_states, beyond its limits of ";
  system::appendRounded(text, joint.lower, 4);
  text += " and ";
  system::appendRounded(text, joint.upper, 4);
  if (seemsInDegrees(joint, beyond.position)) text += ": in degrees?";
}

}  // namespace proximity_server::node
