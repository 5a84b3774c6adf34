#pragma once

namespace proximity_server::node {

/// Gives this thread the real-time policy SCHED_FIFO with this priority; a priority of 0 changes nothing. Threads that
/// this thread starts do not inherit it. If the system refuses, one warning is logged.
void runInRealTime(int priority);

/// Does the same with the poll thread of roscpp, which receives transforms and sends levels. Only for a process whose
/// services have a ServicePort: otherwise this thread waits for those that answer requests, and they for a processor.
void runPollThreadInRealTime(int priority);

}  // namespace proximity_server::node
