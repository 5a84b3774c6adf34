#pragma once

#include "node/robot/config.h"

#include <dynamic_reconfigure/Config.h>
#include <ros/node_handle.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// The robots that the parameters describe; there is at least one.
std::vector<RobotSource> robotSources(const Config& config);

/// Reads the parameters in the namespace of `private_nh`. A parameter that is not set keeps its default. tf_prefix is
/// searched upwards from that namespace, as robot_state_publisher does.
///
/// Failure: throws std::invalid_argument naming the parameter that has the wrong type, lies outside its range or
///          contradicts another one. An unknown name is logged as a warning, with the parameter of the nearest name.
Config loadConfig(const ros::NodeHandle& private_nh);

/// Makes the configuration from the values of a namespace. `values` is a struct; any other type means that nothing is
/// set. It fails like loadConfig().
Config configFrom(const XmlRpc::XmlRpcValue& values, const std::string& name_space);

/// Reads the live parameters from a message of dynamic_reconfigure, with the checks and failures of loadConfig().
MonitorSettings monitorSettingsFrom(const dynamic_reconfigure::Config& values, const std::string& name_space);

/// Returns why ~constraints cannot have rows with these settings ("influence_distance is ..."), or "" if it can. The
/// node starts nevertheless, because most users have no controller. The
/// sources are those of `config`.
std::string problemOfInfluenceDistance(const MonitorSettings& settings, const Config& config);

/// Names the settings that differ between `in_force` and `others`, with both values: "threshold is 0.3, there it is
/// 0.5". Returns "" if they are equal.
std::string differences(const MonitorSettings& in_force, const MonitorSettings& others);

}  // namespace proximity_server::node
