#pragma once

#include <dynamic_reconfigure/Config.h>
#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "node/robot/config.h"

namespace proximity_server::node {

/// The robots of the parameters, at least one.
std::vector<RobotSource> robotSources(const Config& config);

/// Reads the parameters in the namespace of `private_nh`; what is not set keeps its default. tf_prefix is searched
/// upwards from there, as robot_state_publisher does.
///
/// Failure: throws std::invalid_argument naming the parameter that has the wrong type, lies outside its range or contradicts
///          another one. A name that is no parameter of ours is logged as a warning, with the nearest one that is.
Config loadConfig(const ros::NodeHandle& private_nh);

/// The same for the values of a namespace: a struct, or any other value if nothing is set there.
Config configFrom(const XmlRpc::XmlRpcValue& values, const std::string& name_space);

/// The live ones, of a message of dynamic_reconfigure, with the same checks and failures.
MonitorSettings monitorSettingsFrom(const dynamic_reconfigure::Config& values, const std::string& name_space);

/// Returns why ~constraints has no rows with these settings ("influence_distance is ..."), or "". That is no reason for the
/// node not to start, as most users have no controller.
std::string problemOfDamper(const MonitorSettings& settings);

/// Names the settings in which others differ from those in force, with both values: "threshold is 0.3, there it is 0.5"; "" if none
/// does.
std::string differences(const MonitorSettings& in_force, const MonitorSettings& others);

}  // namespace proximity_server::node
