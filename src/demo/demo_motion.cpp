// Moves a robot for ./dev demo: it publishes joint_states at 100 Hz. The motion is the script in ~joints and
// ~keyframes. If there is no script, every joint moves slowly between its limits. With ~boxes there are objects around
// the robot, see DemoObjects.
#include "demo/demo_objects.h"
#include "node/log_fatal.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/robot_model.h"
#include "system/version.h"

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using proximity_server::demo::DemoObjects;
using proximity_server::scene::Joint;

using Keyframe = std::vector<double>;  // the time [s], and behind it the positions

/// The time within the script, which is repeated. `time` may be negative, because a simulated clock may jump back.
double timeOfScript(const std::vector<Keyframe>& script, double time) {
  return std::fmod(std::max(0.0, time), script.back().front());
}

/// The position of the joint with this column in the script, interpolated between two keyframes.
double positionInScript(const std::vector<Keyframe>& script, std::size_t column, double time) {
  const double t = timeOfScript(script, time);
  const auto is_later = [](double moment, const Keyframe& keyframe) { return moment < keyframe.front(); };
  const auto next = std::upper_bound(script.begin(), script.end(), t, is_later);
  const Keyframe &from = *(next - 1), &to = *next;
  const double blend = 0.5 - 0.5 * std::cos(M_PI * (t - from[0]) / (to[0] - from[0]));
  return from[column] + blend * (to[column] - from[column]);
}

/// The position of a joint that moves by a sine between its limits, or within half a radian or metre of 0 if it has
/// none. It is never faster than half of its velocity limit. `number` gives each joint a period of its own, so that the
/// motion of the whole robot repeats itself only after a long time.
double sweep(const Joint& joint, std::size_t number, double time) {
  const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
  const double middle = limited ? 0.5 * (joint.lower + joint.upper) : 0.0;
  const double half_range = limited ? 0.5 * (joint.upper - joint.lower) : 0.5;
  if (!(half_range > 0.0)) return middle;
  const double speed = std::min(half_range / (2.0 + 0.31 * static_cast<double>(number)), 0.5 * joint.max_velocity);
  return middle + half_range * std::sin(speed / half_range * time);
}

bool canBeDriven(const Joint& joint) { return !joint.mimic && proximity_server::scene::hasOnePosition(joint); }

std::vector<Joint> drivenJoints(const ros::NodeHandle& nh) {
  std::string urdf;
  if (!nh.getParam("robot_description", urdf)) throw std::invalid_argument("there is no parameter robot_description");
  // No mesh is read, because only the joints are needed.
  const auto no_mesh = [](const std::string& uri) -> std::string { throw std::invalid_argument(uri); };
  proximity_server::scene::ModelOptions options;
  options.allow_missing_meshes = true;
  options.allow_broken_mimics = true;  // the node decides whether these are an error
  auto joints = proximity_server::scene::loadRobotModel(urdf, no_mesh, options).joints;
  joints.erase(std::remove_if(joints.begin(), joints.end(), [](const Joint& j) { return !canBeDriven(j); }),
               joints.end());
  return joints;
}

double number(XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt ? static_cast<int>(value) : static_cast<double>(value);
}

/// Reads the rows of ~keyframes; returns none if there is no such parameter.
std::vector<Keyframe> keyframes(const ros::NodeHandle& nh, std::size_t joints) {
  std::vector<Keyframe> script;
  XmlRpc::XmlRpcValue rows;
  if (!nh.getParam("keyframes", rows)) return script;
  for (int i = 0; i < rows.size(); ++i) {
    const std::string row = "row " + std::to_string(i + 1) + " of ~keyframes";
    if (rows[i].size() != static_cast<int>(joints) + 1) {
      throw std::invalid_argument(row + " has not a time and a position for each of ~joints");
    }
    Keyframe keyframe;
    for (int k = 0; k < rows[i].size(); ++k) keyframe.push_back(number(rows[i][k]));
    if (script.empty() ? keyframe[0] != 0.0 : !(keyframe[0] > script.back()[0])) {
      throw std::invalid_argument("the time of " + row + " is not 0 for the first, or not later than the one before");
    }
    script.push_back(keyframe);
  }
  if (script.size() < 2) throw std::invalid_argument("~keyframes has less than two rows");
  return script;
}

/// Throws std::invalid_argument naming the first of ~joints that the robot does not have, or that cannot be driven.
void requireJoints(const std::vector<Joint>& joints, const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const Joint& joint : joints) known.push_back(joint.name);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw std::invalid_argument("~joints: '" + name + "' is no joint of the robot that can be driven" +
                                proximity_server::scene::didYouMean(name, known));
  }
}

/// Throws std::invalid_argument naming the first position in a column of the script that is beyond the limits of the
/// joint.
void requireWithinLimits(const Joint& joint, std::size_t column, const std::vector<Keyframe>& script) {
  using proximity_server::scene::shortest;
  constexpr double kRounding = 1e-6;  // [rad] or [m], because limits and positions may be written with six decimals
  const std::string unit = joint.type == Joint::Type::Prismatic ? " m" : " rad";
  for (std::size_t row = 0; row < script.size(); ++row) {
    const double position = script[row][column];
    // The comparison is written so that NaN counts as beyond the limits.
    if (position >= joint.lower - kRounding && position <= joint.upper + kRounding) continue;
    throw std::invalid_argument("row " + std::to_string(row + 1) + " of ~keyframes: '" + joint.name + "' is at " +
                                shortest(position) + unit + ", beyond its limits, which are " + shortest(joint.lower) +
                                " and " + shortest(joint.upper) + unit);
  }
}

/// Returns whether every row of a script has the same positions.
bool neverMoves(const std::vector<Keyframe>& script) {
  return std::all_of(script.begin(), script.end(), [&](const Keyframe& row) {
    return std::equal(row.begin() + 1, row.end(), script.front().begin() + 1);
  });
}

/// The column of a joint in ~keyframes. It is 0, the column of the time, if the joint is not in ~joints.
std::size_t columnOf(const std::string& joint, const std::vector<std::string>& joints) {
  const auto found = std::find(joints.begin(), joints.end(), joint);
  return found == joints.end() ? 0 : static_cast<std::size_t>(found - joints.begin()) + 1;
}

/// The positions of all joints at any time [s].
class Motion {
 public:
  Motion(const ros::NodeHandle& private_nh, std::vector<Joint> joints) : joints_(std::move(joints)) {
    const auto names = private_nh.param("joints", std::vector<std::string>());
    requireJoints(joints_, names);
    script_ = keyframes(private_nh, names.size());
    for (const Joint& joint : joints_) {
      columns_.push_back(columnOf(joint.name, names));
      if (columns_.back() != 0) requireWithinLimits(joint, columns_.back(), script_);
    }
    if (joints_.empty()) ROS_WARN("the robot does not move: it has no joint that can be driven");
    if (!script_.empty() && neverMoves(script_))
      ROS_WARN("the robot does not move: every row of ~keyframes has the same positions");
  }

  const std::vector<Joint>& joints() const { return joints_; }

  /// The position of a joint at a time [s]. Joints that the script does not name stay at 0, or at the limit nearest to
  /// 0.
  double position(std::size_t joint, double time) const {
    if (script_.empty()) return sweep(joints_[joint], joint, time);
    if (columns_[joint] == 0) return std::max(joints_[joint].lower, std::min(0.0, joints_[joint].upper));
    return positionInScript(script_, columns_[joint], time);
  }

  double timeInScript(double time) const { return script_.empty() ? time : timeOfScript(script_, time); }

 private:
  std::vector<Joint> joints_;
  std::vector<Keyframe> script_;
  std::vector<std::size_t> columns_;  // for each joint its column in the script
};

/// The state of the joints at a time [s] of the motion.
sensor_msgs::JointState stateAt(const Motion& motion, double time) {
  constexpr double kTimeStep = 1e-3;  // [s]
  sensor_msgs::JointState state;
  for (std::size_t i = 0; i < motion.joints().size(); ++i) {
    state.name.push_back(motion.joints()[i].name);
    state.position.push_back(motion.position(i, time));
    state.velocity.push_back((motion.position(i, time + kTimeStep) - state.position[i]) / kTimeStep);
  }
  return state;
}

void move(ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  const Motion motion(private_nh, drivenJoints(nh));
  std::optional<DemoObjects> objects;
  if (private_nh.hasParam("boxes")) objects.emplace(nh, private_nh);
  ros::Publisher publisher = nh.advertise<sensor_msgs::JointState>("joint_states", 1);

  const ros::Time start = ros::Time::now();
  const ros::Timer timer = nh.createTimer(ros::Duration(0.05), [&](const ros::TimerEvent&) {
    if (objects) objects->update(motion.timeInScript((ros::Time::now() - start).toSec()));
  });
  // Calls of the node may have to wait, so they run in another thread than the loop below. It is a single thread, so
  // that DemoObjects needs no lock.
  ros::AsyncSpinner spinner(1);
  spinner.start();
  for (ros::Rate rate(100.0); ros::ok(); rate.sleep()) {
    const ros::Time now = ros::Time::now();
    sensor_msgs::JointState state = stateAt(motion, (now - start).toSec());
    state.header.stamp = now;
    publisher.publish(state);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (proximity_server::system::tellsVersion(argc, argv, "demo_motion")) return 0;
  ros::init(argc, argv, "demo_motion");
  ros::NodeHandle nh, private_nh("~");
  try {
    move(nh, private_nh);
  } catch (const XmlRpc::XmlRpcException& error) {  // it is not derived from std::exception
    proximity_server::node::logFatal("~keyframes or ~boxes: " + error.getMessage());
    return 1;
  } catch (const std::exception& error) {
    proximity_server::node::logFatal(error.what());
    return 1;
  }
  return 0;
}
