#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/object_rules.h"

namespace proximity_server::node {

/// The parameters that may change while the node runs (dynamic_reconfigure). parameter_table.cpp explains each.
struct MonitorSettings {
  double rate = 50.0;                  ///< [Hz]; 0: on every new set of transforms
  double threshold = 0.3;              ///< [m] pairs at or below it are listed
  double warn_distance = 0.05;         ///< [m]
  double stop_distance = 0.02;         ///< [m]
  double object_warn_distance = 0.05;  ///< [m] of pairs with an object, as the next
  double object_stop_distance = 0.02;  ///< [m]
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

/// Where the node finds one robot.
struct RobotSource {
  std::string name;            ///< "left"; "" for the only robot of a node without the parameter `robots`
  std::string description;     ///< name of the parameter with the URDF, searched upwards
  std::string semantic;        ///< the same of the SRDF; "": there is none
  bool needs_semantic = true;  ///< whether it is an error if that parameter does not exist
  std::string tf_prefix;       ///< of the robot's frames, see tfFrame()
  std::string joint_states = "joint_states";  ///< topic of its velocities

  /// The parameter that sets the prefix: "tf_prefix", "robots/left/tf_prefix".
  std::string prefixParameter() const { return name.empty() ? "tf_prefix" : "robots/" + name + "/tf_prefix"; }
};

/// How hard joints can brake [rad/s^2] or [m/s^2].
struct MaxDeceleration {
  std::optional<double> of_all;            ///< one number for all joints
  std::map<std::string, double> of_joint;  ///< or that of each; a joint that is not named has none
};

struct Config {
  std::vector<RobotSource> robots;  ///< by name; empty: there is one, which the next two and tf_prefix describe
  std::string robot_description = "robot_description";              ///< name of a parameter, searched upwards
  std::string semantic_description = "robot_description_semantic";  ///< the same; it may be missing
  std::string reference_frame;                                      ///< "": the robot's root link
  std::string tf_prefix;                                            ///< of the robot's frames, see tfFrame()
  std::vector<std::string> allowed_mesh_roots;                      ///< empty: meshes may lie anywhere
  std::vector<std::string> mesh_roots;                              ///< searched for packages before ROS_PACKAGE_PATH
  std::string mesh_cache = "user";  ///< as it is given; configFrom() sets that of `model`
  scene::ModelOptions model;
  scene::PairFilterOptions filter;
  double tolerance = 1e-9;          ///< [m] accepted gap between the bounds of a distance
  double max_tf_age = 0.2;          ///< [s]
  double max_tf_skew = 0.05;        ///< [s]
  double tf_timeout = 0.1;          ///< [s] of wall time
  int max_batch = 10000;            ///< the most pairs, or points, of one request
  double max_request_time = 30.0;   ///< [s] of wall time, for one request
  double motion_time_budget = 1.0;  ///< [s] of wall time, for one search along a motion
  int realtime_priority = 0;        ///< SCHED_FIFO priority of the threads of monitor and tf; 0: none
  scene::ObjectRules::FreeObjects free_objects = scene::ObjectRules::FreeObjects::NotChecked;
  scene::ObjectFile objects;                   ///< what stands there from the start
  std::string objects_file;                    ///< an absolute path; "": objects are not kept
  std::vector<std::string> constraint_joints;  ///< that the controller of ~constraints moves; empty: all
  MaxDeceleration max_deceleration;
  scene::ThresholdRules thresholds;  ///< of single pairs, links and groups, in place of those of `monitor`
  MonitorSettings monitor;
};

}  // namespace proximity_server::node
