#pragma once

#include "node/faults/child_process.h"

#include <memory>
#include <string>
#include <vector>

// The programs that a benchmark or a long run needs besides itself. Each ends with us, however we end, and Ctrl-C is
// ours alone: we end them in order. What they say goes to our standard error.

namespace proximity_server::node {

std::unique_ptr<ChildProcess> startProgram(const std::vector<std::string>& command);

/// This program again, with other arguments.
std::unique_ptr<ChildProcess> startOurselves(const std::vector<std::string>& arguments);

/// Asks it to end, and insists after five seconds.
void stopProgram(ChildProcess& program);

/// A port of this machine that nobody listens to.
int freePort();

/// Waits until something listens to a port of this machine; false where nothing does within ten seconds.
bool awaitListener(int port);

/// From now on the ROS master of this program, and of all that it starts later, is one on this port of this machine.
/// Before ros::init().
void useMasterAt(int port);

/// A ROS master with an empty memory.
/// Failure: throws std::runtime_error where it does not start.
std::unique_ptr<ChildProcess> startMasterAt(int port);

}  // namespace proximity_server::node
