#pragma once

namespace proximity_server::node {

/// Gives this thread, but none that it starts, the real-time policy SCHED_FIFO with this priority; 0 changes nothing.
/// If the system refuses, one warning is logged.
void runInRealTime(int priority);

}  // namespace proximity_server::node
