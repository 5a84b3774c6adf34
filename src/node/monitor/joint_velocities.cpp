#include "node/monitor/joint_velocities.h"

#include "proximity_server/scene/model/names.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace proximity_server::node {
namespace {

/// The robot of a joint, as an index into RobotModel::robots.
int robotOf(const scene::RobotModel& robots, const scene::Joint& joint) {
  return robots.bodies[robots.links[joint.child_link].body].robot;
}

/// Returns whether another robot on the same topic has a joint that its URDF calls `own_name`, too.
bool isAmbiguous(const scene::RobotModel& robots, const std::vector<std::string>& topics, int member,
                 const std::string& own_name) {
  for (int other = 0; other < static_cast<int>(robots.robots.size()); ++other) {
    if (other == member || topics[other] != topics[member]) continue;
    if (scene::findNamed(robots.joints, robots.robots[other].nameInModel(own_name)) >= 0) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> JointVelocities::topicsOf(const Robot& robot) const {
  std::vector<std::string> topics;
  for (const RobotSource& source : robot.sources()) topics.push_back(nh_.resolveName(source.joint_states));
  return topics;
}

void JointVelocities::listen(const Robot& robot) {
  std::map<std::string, std::string> topics;  // the names in the parameters, by full name
  const std::vector<std::string> whole_names = topicsOf(robot);
  for (std::size_t i = 0; i < whole_names.size(); ++i) topics[whole_names[i]] = robot.sources()[i].joint_states;
  for (auto known = subscribers_.begin(); known != subscribers_.end();)
    known = topics.count(known->first) ? std::next(known) : subscribers_.erase(known);
  for (const auto& [topic, named] : topics) {
    if (subscribers_.count(topic)) continue;
    subscribers_[topic] = nh_.subscribe<sensor_msgs::JointState>(
        named, 10, [this, name = topic](const sensor_msgs::JointState::ConstPtr& state) { onJointState(*state, name); },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());  // TfListener's constructor tells why
  }
}

void JointVelocities::stopListening() {
  subscribers_.clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  latest_.clear();
}

void JointVelocities::onJointState(const sensor_msgs::JointState& state, const std::string& topic) {
  if (state.velocity.size() != state.name.size()) return;  // many publishers leave the velocities empty
  const bool has_positions = state.position.size() == state.name.size();
  const std::lock_guard<std::mutex> lock(mutex_);
  Entries& entries = latest_[topic];
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const bool is_known = has_positions && std::isfinite(state.position[i]);
    entries[state.name[i]] = {state.velocity[i], is_known ? std::optional<double>(state.position[i]) : std::nullopt,
                              state.header.stamp};
  }
}

VelocitySnapshot JointVelocities::lookUp(const Robot& robot, const std::vector<int>& joints,
                                         const ros::Time& now) const {
  VelocitySnapshot snapshot;
  snapshot.velocities.assign(robot.robotModel().joints.size(), 0.0);
  snapshot.positions.assign(robot.robotModel().joints.size(), std::nullopt);
  snapshot.stamps.assign(robot.robotModel().joints.size(), ros::Time());
  const std::vector<std::string> topics = topicsOf(robot);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const int index : joints) {
    const scene::Joint& joint = robot.robotModel().joints[index];
    const std::string& topic = robot.sources()[robotOf(robot.robotModel(), joint)].joint_states;
    const Entry* entry = find(robot.robotModel(), topics, index);
    const std::string problem = problemOf(joint, topic, entry, now, robot.config().max_tf_age);
    if (problem.empty()) {
      snapshot.velocities[index] = entry->velocity;
      snapshot.positions[index] = entry->position;
      snapshot.stamps[index] = entry->stamp;
      continue;
    }
    snapshot.velocities[index] = std::numeric_limits<double>::quiet_NaN();
    if (snapshot.status.code != QueryStatus::OK) continue;
    snapshot.status.code = QueryStatus::NO_VELOCITY;
    snapshot.status.message = "joint '" + joint.name + "': " + problem;
  }
  return snapshot;
}

const JointVelocities::Entry* JointVelocities::find(const scene::RobotModel& robots,
                                                    const std::vector<std::string>& topics, int joint) const {
  const std::string& name = robots.joints[joint].name;
  const int member = robotOf(robots, robots.joints[joint]);
  const auto entries = latest_.find(topics[member]);
  if (entries == latest_.end()) return nullptr;
  auto hit = entries->second.find(name);
  const std::string own = robots.robots[member].ownName(name);
  if (hit == entries->second.end() && !isAmbiguous(robots, topics, member, own)) hit = entries->second.find(own);
  return hit == entries->second.end() ? nullptr : &hit->second;
}

std::string JointVelocities::problemOf(const scene::Joint& joint, const std::string& topic, const Entry* entry,
                                       const ros::Time& now, double max_age) {
  if (joint.type == scene::Joint::Type::Floating || joint.type == scene::Joint::Type::Planar) {
    return "it is floating or planar, it has not one velocity";
  }
  if (!entry || !std::isfinite(entry->velocity)) return topic + " has no velocity of it";
  // Computed in double, because ros::Duration throws for stamps that are decades apart.
  const double age = now.toSec() - entry->stamp.toSec();
  if (std::abs(age) <= max_age) return {};
  return "its latest velocity is " + std::to_string(age) + " s old, max_tf_age is " + std::to_string(max_age) + " s";
}

}  // namespace proximity_server::node
