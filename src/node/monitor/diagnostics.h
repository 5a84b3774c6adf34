#pragma once

#include "node/monitor/monitor_loop.h"
#include "node/robot/robot.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

/// Publishes on /diagnostics once per second. This is wall time, so that a simulated clock that stands still is
/// reported, too.
class Diagnostics {
 public:
  /// `tf` must outlive it.
  Diagnostics(const ros::NodeHandle& nh, TfPoses& tf, std::function<MonitorHealth()> health,
              std::function<std::shared_ptr<const Robot>()> robot, std::function<Recorder::Outcome()> record,
              std::function<std::string()> keeping);

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void update();
  void reportTf(Status& status);
  void reportJumps(Status& status);
  void reportModel(Status& status);
  void reportClearance(Status& status);
  void reportTiming(Status& status);
  void reportRecord(Status& status);
  void reportObjects(Status& status);

  TfPoses& tf_;
  std::function<MonitorHealth()> current_health_;
  std::function<std::shared_ptr<const Robot>()> current_robot_;
  std::function<Recorder::Outcome()> current_record_;
  std::function<std::string()> current_keeping_;  // see ObjectKeeper::problem()
  std::shared_ptr<const Robot> robot_;
  MonitorHealth health_{};
  std::uint64_t cycles_before_ = 0;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace proximity_server::node
