#pragma once

#include <sys/types.h>

#include <string>

namespace proximity_server::node {

/// The process of a node that the master knows; 0 where there is none or it does not answer.
pid_t processOf(const std::string& node);

}  // namespace proximity_server::node
