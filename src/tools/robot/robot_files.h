#pragma once

#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

class ProgramOptions;

/// Whether warnings, and the steps of loading that take long, are printed on standard error.
enum class Warnings : unsigned char { Shown, Hidden };

/// The files of a robot, and how to read them.
struct RobotFiles {
  std::string urdf;
  std::string srdf;                      ///< "": none
  std::string config;                    ///< the node's parameters, see scene::configFrom(); "": none
  std::optional<double> mesh_tolerance;  ///< [m]; nullopt: the default of the library
  bool allow_missing_meshes = false;     ///< see scene::ModelOptions, as the next
  bool allow_broken_mimics = false;
  std::string joint_inequalities;  ///< see scene::readJointInequalities(); "": none
  Warnings warnings = Warnings::Shown;
};

/// Adds --config, --mesh-tolerance, --allow-missing-meshes and --allow-broken-mimics; `needs` as in Option.
void addRobotOptions(ProgramOptions& program, RobotFiles& files, const std::string& needs = "");

/// Adds --joint-inequalities.
void addJointInequalities(ProgramOptions& program, RobotFiles& files);

/// Adds --quiet.
void addQuiet(ProgramOptions& program, Warnings& warnings);

/// The text of the SRDF; "" if there is none.
std::string srdfOf(const RobotFiles& files);

/// The whole text of a file. Throws std::invalid_argument with its name and the reason if it cannot be read.
std::string readTextFile(const std::string& path);

/// Finds the meshes of a robot or of objects as RobotConfig::meshResolver() does. Each is an input of the process.
/// Failure: throws system::FileConflict if it is an output, too.
scene::MeshResolver meshResolver(const scene::RobotConfig& config, const std::string& folder = "");

/// The parameters of the file of --config, replaced by the other options; the defaults of the node without a file.
scene::ConfigFile configOf(const RobotFiles& files);

/// Loads the same robot and pairs as the node would. Mesh packages are searched on ROS_PACKAGE_PATH; relative paths
/// start at the folder of the URDF. Throws std::invalid_argument naming file and link.
std::shared_ptr<const scene::SceneModel> loadSceneModel(const RobotFiles& files);

/// The links and joints alone: no mesh is read, and what is odd is not told.
scene::RobotModel loadJoints(const RobotFiles& files);

/// Prints sentences on standard error, each as a line "warning: ...", unless warnings are hidden. "" is none.
void printWarnings(const std::vector<std::string>& sentences, Warnings warnings);

/// Prints all warnings about robot and SRDF so, with the text that the node logs.
void printWarningsOf(const scene::SceneModel& model, Warnings warnings);

}  // namespace proximity_server::tools
