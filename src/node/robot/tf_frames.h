#pragma once

#include <tf2/buffer_core.h>

#include <string>
#include <vector>

namespace proximity_server::node {

/// The frame that robot_state_publisher gives a link where its parameter tf_prefix is `prefix`: "prefix/link". A slash
/// in front of the prefix is left out, as tf2 does not know it.
std::string tfFrame(const std::string& prefix, const std::string& link);

/// Why tf does not know the frames of `links`, where the prefix seems to be the reason: what frames of these links
/// there are, and what tf_prefix they want. "" where tf has none of other prefixes.
std::string prefixHint(const tf2::BufferCore& buffer, const std::string& prefix, const std::vector<std::string>& links);

}  // namespace proximity_server::node
