#pragma once

#include "node/robot/config.h"

#include <tf2/buffer_core.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// The frame that robot_state_publisher gives a link if its parameter tf_prefix is `prefix`: "prefix/link". A slash in
/// front of the prefix is left out, because tf2 has no leading slashes.
std::string tfFrame(const std::string& prefix, const std::string& link);

/// A hint for the user in case tf does not know the frames of these links of a robot, but knows frames of them with
/// another prefix. It names these frames and the prefix that fits. Returns "" if there are none.
std::string prefixHint(const tf2::BufferCore& buffer, const RobotSource& robot, const std::vector<std::string>& links);

}  // namespace proximity_server::node
