#include "node/robot/settings_server.h"
#include "node/robot/load_config.h"

#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/console.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

using dynamic_reconfigure::Reconfigure;

/// A service whose callback may throw std::invalid_argument: the client gets its text as the error of the call, for which roscpp has no
/// way of its own. It sends nothing but an empty text where call() returns false, and the response as it is where it returns true: so
/// this returns true, and the response says by its first byte that the call has failed.
class ReasonToClient : public ros::ServiceCallbackHelper {
 public:
  explicit ReasonToClient(ros::ServiceCallbackHelperPtr callback) : callback_(std::move(callback)) {}

  bool call(ros::ServiceCallbackHelperCallParams& params) override {
    try {
      return callback_->call(params);
    } catch (const std::invalid_argument& refusal) {
      params.response = ros::serialization::serializeServiceResponse(false, std::string(refusal.what()));
      return true;
    }
  }

 private:
  ros::ServiceCallbackHelperPtr callback_;
};

/// Throws std::invalid_argument naming the first entry that is no live parameter of this type: the generated code only logs that.
template <class Entries>
void requireKnown(const Entries& entries, const Entries& known) {
  for (const auto& entry : entries) {
    const auto is_it = [&](const auto& other) { return other.name == entry.name; };
    if (std::none_of(known.begin(), known.end(), is_it))
      throw std::invalid_argument("'" + entry.name + "' is no live parameter of this type");
  }
}

}  // namespace

SettingsServer::SettingsServer(const ros::NodeHandle& private_nh, Apply apply)
    : private_nh_(private_nh),
      apply_(std::move(apply)),
      descriptions_pub_(
          private_nh_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, /*latch=*/true)),
      updates_pub_(private_nh_.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, /*latch=*/true)) {
  values_.__fromServer__(private_nh_);
  apply_(settingsOf(values_));
  descriptions_pub_.publish(ProximityConfig::__getDescriptionMessage__());
  tell();
  ros::AdvertiseServiceOptions options;
  options.init<Reconfigure::Request, Reconfigure::Response>(
      "set_parameters",
      [this](Reconfigure::Request& request, Reconfigure::Response& response) { return onSet(request, response); });
  options.helper = boost::make_shared<ReasonToClient>(options.helper);
  set_srv_ = private_nh_.advertiseService(options);
}

MonitorSettings SettingsServer::settings() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settingsOf(values_);
}

void SettingsServer::whileTheyStay(const std::function<void(const MonitorSettings& settings)>& act) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  act(settingsOf(values_));
}

MonitorSettings SettingsServer::settingsOf(const ProximityConfig& values) const {
  dynamic_reconfigure::Config message;
  values.__toMessage__(message);
  return monitorSettingsFrom(message, private_nh_.getNamespace());
}

bool SettingsServer::onSet(Reconfigure::Request& request, Reconfigure::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  dynamic_reconfigure::Config known;
  values_.__toMessage__(known);
  ProximityConfig asked = values_;
  try {
    requireKnown(request.config.doubles, known.doubles);
    requireKnown(request.config.ints, known.ints);
    requireKnown(request.config.bools, known.bools);
    requireKnown(request.config.strs, known.strs);
    asked.__fromMessage__(request.config);
    apply_(settingsOf(asked));
  } catch (const std::invalid_argument& refusal) {
    ROS_ERROR_STREAM("the settings stay as they were: " << refusal.what());
    updates_pub_.publish(known);  // so that graphical clients show what is in force
    throw;
  }
  values_ = asked;
  values_.__toMessage__(response.config);
  tell();
  return true;
}

/// To the parameter server and to all clients.
void SettingsServer::tell() {
  values_.__toServer__(private_nh_);
  dynamic_reconfigure::Config message;
  values_.__toMessage__(message);
  updates_pub_.publish(message);
}

}  // namespace proximity_server::node
