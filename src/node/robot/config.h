#pragma once

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/object_rules.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The parameters that may change while the node runs (dynamic_reconfigure). parameter_table.cpp explains each.
struct MonitorSettings {
  double rate = 50.0;                  ///< [Hz] of the cycles; 0: a cycle on every new set of transforms
  double threshold = 0.3;              ///< [m] pairs at or below this distance are listed
  double warn_distance = 0.05;         ///< [m]
  double stop_distance = 0.02;         ///< [m]
  double object_warn_distance = 0.05;  ///< [m] for pairs with an object
  double object_stop_distance = 0.02;  ///< [m] for pairs with an object
  double hysteresis = 0.002;           ///< [m]
  int max_reported_pairs = 10;
  bool markers = true;
  double lookahead = 0.0;  ///< [s]; 0: off
  bool gradients = false;
  double influence_distance = 0.1;  ///< [m]
  double damping_gain = 0.5;        ///< [m/s]
  int max_constraints = 8;
  double stop_latency = 0.1;  ///< [s]
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

/// The largest accelerations or decelerations of joints [rad/s^2] or [m/s^2], or their largest errors [rad] or [m].
struct JointLimits {
  std::optional<double> of_all;            ///< that of all joints which are not named; without it they have none
  std::map<std::string, double> of_joint;  ///< by name
};

/// How the monitor bounds the motion since the time of the poses.
enum class PoseLatency : unsigned char {
  Off,       ///< not at all
  Velocity,  ///< by the velocity of each joint and its largest acceleration; where one is missing by its limit
  Limit      ///< by the velocity limit of each joint in the URDF
};
const char* toString(PoseLatency latency);  ///< "velocity"

/// The parameters of a scene::Uncertainty, see scene::uncertaintyFrom(). A robot is needed to read them.
struct UncertaintyValues {
  scene::FileValue joint{0.0}, joint_frame{0.0}, base{0.0}, object{0.0}, link{0.0};
};

struct Config {
  /// Sorted by name. If it is empty there is one robot, which robot_description, semantic_description and tf_prefix
  /// describe.
  std::vector<RobotSource> robots;
  std::string robot_description = "robot_description";  ///< name of the parameter with the URDF, searched upwards
  /// Name of the parameter with the SRDF, searched upwards. The parameter may be missing.
  std::string semantic_description = "robot_description_semantic";
  std::string reference_frame;                  ///< "": the robot's root link
  std::string tf_prefix;                        ///< prefix of the robot's frames, see tfFrame()
  std::vector<std::string> allowed_mesh_roots;  ///< empty: meshes may lie anywhere
  std::vector<std::string> mesh_roots;          ///< searched for packages before ROS_PACKAGE_PATH
  std::string mesh_cache = "user";  ///< the parameter as it was given; configFrom() sets model.mesh_cache by it
  scene::ModelOptions model;
  scene::PairFilterOptions filter;
  /// a list for scene::setJointInequalities(), or an absolute path
  scene::FileValue joint_inequalities{scene::FileValue::List()};
  double tolerance = 1e-9;          ///< [m] accepted gap between the bounds of a distance
  double max_tf_age = 0.2;          ///< [s]
  double max_tf_skew = 0.05;        ///< [s]
  double tf_timeout = 0.1;          ///< [s] of wall time
  int max_batch = 10000;            ///< largest number of pairs, or of points, of one request
  double max_request_time = 30.0;   ///< [s] of wall time, for one request
  double motion_time_budget = 1.0;  ///< [s] of wall time, for one search along a motion
  int realtime_priority = 0;        ///< SCHED_FIFO priority of the threads between tf and ~clearance; 0: none
  scene::ObjectRules::FreeObjects free_objects = scene::ObjectRules::FreeObjects::NotChecked;
  scene::ObjectFile objects;                   ///< the objects at the start of the node
  std::string objects_file;                    ///< an absolute path; "": objects are not kept for the next start
  double record_seconds = 10.0;                ///< [s] before an event; 0: nothing is recorded
  std::string record_directory;                ///< an absolute path; "": only the service writes, into ROS_HOME
  int record_count = 20;                       ///< the number of records that are kept
  double record_memory = 8.0;                  ///< [MB]
  std::vector<std::string> record_on;          ///< stop, collision, invalid; empty: all
  std::string parameters;                      ///< all parameters that are set, as XML-RPC
  std::vector<std::string> constraint_joints;  ///< joints that the controller of ~constraints moves; empty: all
  JointLimits max_deceleration;
  /// Topics from which the robot's controllers take trajectories, or "/goal" topics of their actions.
  std::vector<std::string> trajectories;
  JointLimits tracking_error{0.01, {}};          ///< [rad] or [m] how far each joint may be off its trajectory
  JointLimits tracking_velocity_error{0.1, {}};  ///< [rad/s] or [m/s] how far its velocity may be off
  UncertaintyValues uncertainty;
  PoseLatency pose_latency = PoseLatency::Off;
  double message_latency = 0.0;  ///< [s] from a cycle of the monitor until its message is used
  JointLimits max_acceleration;
  scene::FileValue base_speed{scene::FileValue::Map()}, object_speed{scene::FileValue::Map()};
  scene::ThresholdRules thresholds;  ///< thresholds of single pairs, links and groups; they replace those of `monitor`
  MonitorSettings monitor;
};

}  // namespace proximity_server::node
