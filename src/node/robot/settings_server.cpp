#include "node/robot/settings_server.h"

#include "node/robot/load_config.h"
#include "node/threads/latched_topic.h"
#include "system/number_text.h"

#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/console.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

using dynamic_reconfigure::Reconfigure;

/// Makes the text of an std::invalid_argument, which the callback of a service throws, the error that the client gets.
/// roscpp cannot do that: if call() returns false, it sends an empty error, and if call() returns true, it sends the
/// response as it is. So call() returns true here, with a response whose first byte says that the call has failed.
class ReasonAsReply : public ros::ServiceCallbackHelper {
 public:
  explicit ReasonAsReply(ros::ServiceCallbackHelperPtr callback) : callback_(std::move(callback)) {}

  bool call(ros::ServiceCallbackHelperCallParams& params) override {
    try {
      return callback_->call(params);
    } catch (const std::invalid_argument& refusal) {
      params.response = ros::serialization::serializeServiceResponse(false, system::readable(refusal.what()));
      return true;
    }
  }

 private:
  ros::ServiceCallbackHelperPtr callback_;
};

/// Throws std::invalid_argument naming the first entry that is no live parameter of this type. The generated code would
/// only log it.
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
  publishLatched(descriptions_pub_, ProximityConfig::__getDescriptionMessage__());
  publishSettings();
  ros::AdvertiseServiceOptions options;
  options.init<Reconfigure::Request, Reconfigure::Response>(
      "set_parameters",
      [this](Reconfigure::Request& request, Reconfigure::Response& response) { return onSet(request, response); });
  options.helper = boost::make_shared<ReasonAsReply>(options.helper);
  set_srv_ = private_nh_.advertiseService(options);
}

MonitorSettings SettingsServer::settings() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settingsOf(values_);
}

void SettingsServer::withSettingsLocked(const std::function<void(const MonitorSettings& settings)>& function) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  function(settingsOf(values_));
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
  ProximityConfig requested = values_;
  try {
    requireKnown(request.config.doubles, known.doubles);
    requireKnown(request.config.ints, known.ints);
    requireKnown(request.config.bools, known.bools);
    requireKnown(request.config.strs, known.strs);
    requested.__fromMessage__(request.config);
    apply_(settingsOf(requested));
  } catch (const std::invalid_argument& refusal) {
    ROS_ERROR_STREAM("the settings stay as they were: " << system::readable(refusal.what()));
    publishLatched(updates_pub_, known);  // graphical clients then show the settings in force again
    throw;
  }
  values_ = requested;
  values_.__toMessage__(response.config);
  publishSettings();
  return true;
}

/// Sends the settings in force to the parameter server and to all clients.
void SettingsServer::publishSettings() {
  values_.__toServer__(private_nh_);
  dynamic_reconfigure::Config message;
  values_.__toMessage__(message);
  publishLatched(updates_pub_, message);
}

}  // namespace proximity_server::node
