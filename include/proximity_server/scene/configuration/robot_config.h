#pragma once

#include "proximity_server/scene/configuration/parameter.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <string>
#include <vector>

// The parameters of the node that describe a robot: geometry, pairs, levels, uncertainty and objects. The node, the tools
// and the Python module read them by the same rows.

namespace proximity_server::scene {

/// The distances [m] at or below which pairs without a distance of their own are at a level.
struct LevelDistances {
  double warn_distance = 0.05;
  double stop_distance = 0.02;
  double object_warn_distance = 0.05;  ///< for pairs with an object
  double object_stop_distance = 0.02;  ///< for pairs with an object
  double tracked_warn_distance = 0.5;  ///< for pairs with the object of a tracked source, which only the node has
  double tracked_stop_distance = 0.2;
  double sensed_warn_distance = 0.2;  ///< for pairs with the object of a sensed source, which only the node has
  double sensed_stop_distance = 0.1;
};

/// Returns why these distances contradict each other ("stop_distance is ..."), or "" if they do not.
std::string contradictionIn(const LevelDistances& distances);

/// Sets the defaults of the thresholds; the thresholds of single pairs stay.
void assignDefaults(LevelThresholds& thresholds, const LevelDistances& distances);

/// The parameters of an Uncertainty, see uncertaintyFrom(). A robot is needed to read them.
struct UncertaintyValues {
  FileValue joint{0.0}, joint_frame{0.0}, base{0.0}, object{0.0}, link{0.0};
};

/// The values of these parameters.
struct RobotConfig {
  std::vector<std::string> mesh_roots;          ///< searched for packages before ROS_PACKAGE_PATH
  std::vector<std::string> allowed_mesh_roots;  ///< empty: meshes may lie anywhere
  std::string mesh_cache = "user";              ///< as it was given; useMeshCache() sets model.mesh_cache by it
  ModelOptions model;
  PairFilterOptions filter;
  FileValue joint_inequalities{FileValue::List()};  ///< a list for setJointInequalities(), or an absolute path
  double tolerance = 1e-9;                          ///< [m] accepted width of the bounds of a distance
  ThresholdRules thresholds;                        ///< of single pairs, links and groups
  UncertaintyValues uncertainty;
  ObjectRules::FreeObjects free_objects = ObjectRules::FreeObjects::NotChecked;
  ObjectFile objects;  ///< those at the start

  void useMeshCache();

  /// Finds the mesh files of links and objects: packages are searched below mesh_roots and then on ROS_PACKAGE_PATH,
  /// relative paths begin in `folder`, and files that are not below one of the allowed roots are refused.
  MeshResolver meshResolver(const std::string& folder = {}) const;

  /// Sets the coupled limits of a robot.
  /// Failure: throws std::invalid_argument as setJointInequalities() does, and for a path that is not absolute.
  void setInequalities(RobotModel& robot) const;

  /// The uncertainty of a robot. `source`: the name of the file of the parameters, if there is one.
  /// Failure: throws std::invalid_argument as uncertaintyFrom() does.
  Uncertainty uncertaintyOf(const RobotModel& robot, const std::string& source = "parameter") const;

  /// The thresholds of a robot, as levelThresholds() has them.
  LevelThresholds thresholdsOf(const RobotModel& robot, const std::vector<std::string>& srdf_xmls,
                               const LevelDistances& defaults) const;
};

/// The rows of these parameters.
std::vector<Parameter> robotParameters(RobotConfig& config, LevelDistances& levels);

/// The names of the node's other parameters, which mean nothing without a running node.
const std::vector<std::string>& parametersOfNode();

/// The parameters of a robot in a file.
struct ConfigFile {
  RobotConfig robot;
  LevelDistances levels;
  /// Names that are unknown, and so have no effect ('cell.yaml: parameter "link_pading" (did you mean "link_padding"?) has no effect'), and a sentence about those
  /// of parametersOfNode().
  std::vector<std::string> warnings;
};

/// Reads YAML with the node's parameters, or a dump of rosparam in which they are the members of one map, with the
/// node's name. Objects without a frame of their own are in `reference_frame`, which must be a link.
///
/// Failure: throws std::invalid_argument with `source`, the line, the name and the reason, as the node does; also for
///          `robots`, as the URDF is one robot, and for text without any parameter of the node.
ConfigFile configFrom(const std::string& yaml, const std::string& source, const std::string& folder = {});

/// Reads YAML with the parameters of levels alone: stop_distance, warn_distance, object_stop_distance,
/// object_warn_distance, pair_stop_distance: [{links: [a, b], distance: 0.01}], link_stop_distance: {link: 0.01},
/// group_stop_distance, and the same names with warn_distance. Distances that the text does not have keep their
/// defaults.
///
/// Failure: as configFrom(), and for any other name.
ConfigFile thresholdsFrom(const std::string& yaml, const std::string& source);

}  // namespace proximity_server::scene
