#pragma once

#include "node/monitor/monitor.h"
#include "node/record/record_messages.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace rosbag {
class MessageInstance;
}

namespace proximity_server::node {

/// The differences of a robot that is loaded anew from the robot of the record.
struct RobotVariant {
  std::optional<double> mesh_tolerance;
  bool has_padding = true;
};

/// Reads a record, and calls a function with the robot, its objects and each cycle.
class RecordReader {
 public:
  using OnCycle = std::function<void(const RecordedCycle& cycle)>;

  RecordReader(std::string file, const RobotVariant& variant) : file_(std::move(file)), variant_(variant) {}

  /// Failure: throws std::invalid_argument naming the file: no bag, no record, or a model that cannot be loaded.
  void read(const OnCycle& on_cycle);

  Record record;  ///< the latest one, as the next three
  std::shared_ptr<const Robot> robot;
  MonitoredObjects objects;
  std::string objects_text;  ///< YAML; "" before there are some
  bool is_new = false;       ///< true if robot or objects have changed since the last cycle

 private:
  void take(const rosbag::MessageInstance& message, const OnCycle& on_cycle);
  void useObjects(const std::string& text);

  const std::string file_;
  const RobotVariant variant_;
  RobotObjects none_;
  RecordedCycle cycle_;
};

}  // namespace proximity_server::node
