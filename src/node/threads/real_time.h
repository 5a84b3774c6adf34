#pragma once

namespace proximity_server::node {

/// Gives this thread the real-time policy SCHED_FIFO with this priority; a priority of 0 changes nothing. Threads that
/// this thread starts do not inherit it. If the system refuses, one warning is logged.
void runInRealTime(int priority);

}  // namespace proximity_server::node
