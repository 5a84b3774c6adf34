#pragma once

#include "node/inbox.h"

#include <diagnostic_msgs/DiagnosticArray.h>

#include <optional>
#include <string>

namespace proximity_server::node {

/// The diagnostics of a part of a node: "proximity_server: tf".
class Diagnosis {
 public:
  using Status = diagnostic_msgs::DiagnosticStatus;

  explicit Diagnosis(std::string part) : part_(std::move(part)) {}

  /// The next one that `accept` likes, or nothing in time.
  template <class Accept>
  std::optional<Status> next(Accept accept) {
    std::optional<Status> found;
    inbox_.next([&](const diagnostic_msgs::DiagnosticArray& message) {
      for (const Status& status : message.status) {
        if (status.name == part_ && accept(status)) found = status;
      }
      return found.has_value();
    });
    return found;
  }
  std::optional<Status> next() {
    return next([](const Status&) { return true; });
  }

 private:
  std::string part_;
  Inbox<diagnostic_msgs::DiagnosticArray> inbox_{ros::NodeHandle(), "/diagnostics"};
};

}  // namespace proximity_server::node
