#pragma once

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <functional>
#include <mutex>

#include "node/robot/config.h"
#include "proximity_server/ProximityConfig.h"

namespace proximity_server::node {

/// The live parameters for clients of dynamic_reconfigure, in place of its own server, which cannot refuse a change: the call of
/// `set_parameters` fails with the reason, and no parameter changes.
class SettingsServer {
 public:
  /// Takes new settings; throws std::invalid_argument with the reason why it does not.
  using Apply = std::function<void(const MonitorSettings& settings)>;

  /// Begins with the values of the parameter server, which `apply` gets at once, and offers the service afterwards.
  /// Failure: throws what `apply` throws.
  SettingsServer(const ros::NodeHandle& private_nh, Apply apply);

  /// Those in force.
  MonitorSettings settings() const;

  /// Calls `act` with those in force, which do not change meanwhile.
  void whileTheyStay(const std::function<void(const MonitorSettings& settings)>& act) const;

 private:
  bool onSet(dynamic_reconfigure::Reconfigure::Request& request, dynamic_reconfigure::Reconfigure::Response& response);
  MonitorSettings settingsOf(const ProximityConfig& values) const;
  void tell();

  ros::NodeHandle private_nh_;
  Apply apply_;
  mutable std::mutex mutex_;  // guards the next
  ProximityConfig values_ = ProximityConfig::__getDefault__();
  ros::Publisher descriptions_pub_;
  ros::Publisher updates_pub_;
  ros::ServiceServer set_srv_;
};

}  // namespace proximity_server::node
