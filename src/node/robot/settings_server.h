#pragma once

#include "node/robot/config.h"
#include "proximity_server/ProximityConfig.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <functional>
#include <mutex>

namespace proximity_server::node {

/// Offers the live parameters to clients of dynamic_reconfigure. It replaces the server of dynamic_reconfigure, which
/// cannot refuse a change: here the call of `set_parameters` fails with the reason, and no parameter changes.
class SettingsServer {
 public:
  /// Applies new settings. Throws std::invalid_argument with the reason if it refuses them.
  using Apply = std::function<void(const MonitorSettings& settings)>;

  /// Reads the values of the parameter server, calls `apply` with them, and then offers the service.
  /// Failure: throws what `apply` throws.
  SettingsServer(const ros::NodeHandle& private_nh, Apply apply);

  /// The settings in force.
  MonitorSettings settings() const;

  /// Calls `function` with the settings in force. They do not change until it returns.
  void withSettingsLocked(const std::function<void(const MonitorSettings& settings)>& function) const;

 private:
  bool onSet(dynamic_reconfigure::Reconfigure::Request& request, dynamic_reconfigure::Reconfigure::Response& response);
  MonitorSettings settingsOf(const ProximityConfig& values) const;
  void publishSettings();

  ros::NodeHandle private_nh_;
  Apply apply_;
  mutable std::mutex mutex_;  // guards values_
  ProximityConfig values_ = ProximityConfig::__getDefault__();
  ros::Publisher descriptions_pub_;
  ros::Publisher updates_pub_;
  ros::ServiceServer set_srv_;
};

}  // namespace proximity_server::node
