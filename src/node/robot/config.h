#pragma once

#include "proximity_server/scene/configuration/robot_config.h"

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace proximity_server::node {

/// The parameters that may change while the node runs (dynamic_reconfigure). parameter_table.cpp explains each.
struct MonitorSettings : scene::LevelDistances {
  double rate = 50.0;         ///< [Hz] of the cycles; 0: a cycle on every new set of transforms
  double threshold = 0.3;     ///< [m] pairs at or below this distance are listed
  double hysteresis = 0.002;  ///< [m]
  int max_reported_pairs = 10;
  bool markers = true;
  double lookahead = 0.0;  ///< [s]; 0: off
  bool gradients = false;
  double influence_distance = 0.1;  ///< [m]
  double damping_gain = 0.5;        ///< [m/s]
  int max_constraints = 8;
  double stop_latency = 0.1;     ///< [s]
  double sensed_debounce = 0.0;  ///< [s]
};

/// The parameters and topics from which the node gets one robot.
struct RobotSource {
  std::string name;            ///< "left"; "" for the only robot of a node without the parameter `robots`
  std::string description;     ///< name of the parameter with the URDF, searched upwards
  std::string semantic;        ///< name of the parameter with the SRDF, searched upwards; "" if the robot has no SRDF
  bool needs_semantic = true;  ///< true if it is an error that the parameter `semantic` does not exist
  std::string tf_prefix;       ///< prefix of the robot's frames, see tfFrame()
  std::string joint_states = "joint_states";  ///< topic with the positions and velocities of its joints
  std::vector<std::string> trajectories;      ///< see Config::trajectories

  /// The parameter that sets the prefix: "tf_prefix" or, for example, "robots/left/tf_prefix".
  std::string prefixParameter() const { return name.empty() ? "tf_prefix" : "robots/" + name + "/tf_prefix"; }
};

/// How the monitor bounds the motion since the time of the poses.
enum class PoseLatency : unsigned char {
  Off,       ///< not at all
  Velocity,  ///< by the velocity of each joint and its largest acceleration; where one is missing by its limit
  Limit      ///< by the velocity limit of each joint in the URDF
};
const char* toString(PoseLatency latency);  ///< "velocity"

/// How a sensed source makes boxes of its points.
struct Sensing {
  double resolution = 0.02;                        ///< [m] the edge of a voxel
  double self_padding = 0.02;                      ///< [m] points so near to a link, or to what it holds, are its own
  std::map<std::string, double> link_padding;      ///< [m] the same of single links
  double range = 100.0;                            ///< [m] farther from the sensor points are left out
  double persistence = 0.0;                        ///< [s] how long a voxel stays that the latest cloud has not
  bool clearing = true;                            ///< whether it leaves where a ray passes through it
  int max_points = 1000000;                        ///< of a larger cloud, every second, third ... point counts
  std::map<std::string, double> object_padding{};  ///< [m] points so near to these objects do not count

  bool operator==(const Sensing& other) const {
    const auto values = [](const Sensing& of) {
      return std::tie(of.resolution, of.self_padding, of.link_padding, of.range, of.persistence, of.clearing,
                      of.max_points, of.object_padding);
    };
    return values(*this) == values(other);
  }
};

/// An entry of the parameter `tracked`, people or things whose points come by a topic, or of `sensed`, what a camera sees.
/// In each scene it is an object with this name: of one ball around each point, or of the voxels that have points.
struct TrackedSource {
  enum class Type : unsigned char { PoseArray, PointCloud2, Octomap };

  std::string name, topic;
  Type type = Type::PoseArray;
  double radius = 0.0;               ///< [m] of each ball
  double max_age = 0.5;              ///< [s] of the latest message; beyond it the source is stale
  double speed = 1.6;                ///< [m/s] the fastest that the points move; EN ISO 13855: a person
  double near_speed = 2.0;           ///< [m/s] the same nearer than 0.5 m
  double intrusion = 0.0;            ///< [m] how far a part of a person may be before it is seen
  double uncertainty = 0.0;          ///< [m] how far a point may be off
  std::optional<Sensing> sensing{};  ///< of a sensed source; of what is above, max_age counts for clouds

  /// Whether its messages are maps: the latest one counts, however old it is.
  bool isMap() const { return type == Type::Octomap; }

  std::string kind() const { return sensing ? "sensed" : "tracked"; }  ///< its parameter
  std::string text() const { return kind() + " source '" + name + "'"; }

  bool operator==(const TrackedSource& other) const { return values() == other.values(); }

 private:
  std::tuple<const std::string&, const std::string&, Type, double, double, double, double, double, double,
             const std::optional<Sensing>&>
  values() const {
    return {name, topic, type, radius, max_age, speed, near_speed, intrusion, uncertainty, sensing};
  }
};

struct Config : scene::RobotConfig {
  /// Sorted by name. If it is empty there is one robot, which robot_description, semantic_description and tf_prefix
  /// describe.
  std::vector<RobotSource> robots;
  scene::FileValue robots_value{scene::FileValue::Map()};  ///< the parameter, of which configFrom() makes `robots`
  std::string robot_description = "robot_description";     ///< name of the parameter with the URDF, searched upwards
  /// Name of the parameter with the SRDF, searched upwards. The parameter may be missing.
  std::string semantic_description = "robot_description_semantic";
  std::string reference_frame;         ///< "": the robot's root link
  std::string tf_prefix;               ///< prefix of the robot's frames, see tfFrame()
  double max_tf_age = 0.2;             ///< [s]
  double max_tf_skew = 0.05;           ///< [s]
  double tf_timeout = 0.1;             ///< [s] of wall time
  int max_batch = 10000;               ///< largest number of pairs, or of points, of one request
  double max_request_time = 30.0;      ///< [s] of wall time, for one request
  double motion_time_budget = 1.0;     ///< [s] of wall time, for one search along a motion
  int realtime_priority = 0;           ///< SCHED_FIFO priority of the threads between tf and ~clearance; 0: none
  std::string objects_file;            ///< an absolute path; "": objects are not kept for the next start
  double record_seconds = 10.0;        ///< [s] before an event; 0: nothing is recorded
  std::string record_directory;        ///< an absolute path; "": only the service writes, into ROS_HOME
  int record_count = 20;               ///< the number of records that are kept
  double record_memory = 8.0;          ///< [MB]
  std::vector<std::string> record_on;  ///< stop, collision, invalid; empty: all
  std::string parameters;              ///< all parameters that are set, as XML-RPC
  std::vector<std::string> constraint_joints;  ///< joints that the controller of ~constraints moves; empty: all
  scene::JointLimits max_deceleration;
  /// Topics from which the robot's controllers take trajectories, or "/goal" topics of their actions.
  std::vector<std::string> trajectories;
  scene::JointLimits tracking_error{0.01, {}};          ///< [rad] or [m] how far each joint may be off its trajectory
  scene::JointLimits tracking_velocity_error{0.1, {}};  ///< [rad/s] or [m/s] how far its velocity may be off
  PoseLatency pose_latency = PoseLatency::Off;
  scene::FileValue pose_latency_value{std::string("off")};  ///< the parameter, of which configFrom() makes it
  double message_latency = 0.0;  ///< [s] from a cycle of the monitor until its message is used
  scene::JointLimits max_acceleration;
  scene::FileValue base_speed{scene::FileValue::Map()}, object_speed{scene::FileValue::Map()};
  std::vector<TrackedSource> tracked;  ///< and sensed, after those that are tracked
  /// The parameters `tracked` and `sensed`, of which configFrom() makes it.
  scene::FileValue tracked_value{scene::FileValue::List()}, sensed_value{scene::FileValue::List()};
  MonitorSettings monitor;

  /// nullptr if no tracked or sensed source has this name.
  const TrackedSource* findTracked(const std::string& source) const;

  bool isTracking() const;  ///< true if there are tracked sources
  bool isSensing() const;   ///< true if there are sensed sources
};

}  // namespace proximity_server::node
