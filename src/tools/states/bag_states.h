#pragma once

#include "tools/states/state_source.h"

#include <memory>
#include <optional>
#include <string>

namespace proximity_server::tools {

/// The options of a bag.
struct BagOptions {
  std::string file;
  std::string topic = "/joint_states";
  std::optional<double> rate;  ///< [Hz] nullopt: every message
};

/// The states of the messages of type sensor_msgs/JointState in a rosbag, see RecordedStates. The time of a message is
/// its stamp, or when it was recorded if the stamp is 0. Needs no ROS master.
/// Failure: throws std::invalid_argument naming the file: no bag, one that is truncated, not indexed or encrypted, no
///          such topic (naming those that are there), another type, a message that JointRecording refuses; and in a
///          build without rosbag.
std::unique_ptr<StateSource> openBag(const BagOptions& options, const scene::RobotModel& robot);

}  // namespace proximity_server::tools
