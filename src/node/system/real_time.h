#pragma once

namespace proximity_server::node {

/// Lets this thread, but none that it starts, go before all that is not real-time (SCHED_FIFO), whenever it has
/// something to do. 0: nothing changes. Where the system does not grant it, one warning says so.
void runInRealTime(int priority);

}  // namespace proximity_server::node
