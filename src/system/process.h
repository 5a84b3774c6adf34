#pragma once

// Settings of the process that the node requests from the operating system.

namespace proximity_server::system {

/// Requests short time slices for this thread and all that it starts later, so that a thread that wakes up need not
/// wait for the end of a long time slice of another program. Call it before other threads start. Linux supports this
/// for every user from version 6.12 on. Otherwise, and if the process was started with another scheduling policy,
/// nothing changes.
void requestShortTimeSlices();

/// Lets malloc return large blocks to the system as soon as they are freed, so that the memory of a huge request is not
/// kept after its answer; by default glibc keeps it for each thread that had such a request. Call it before other
/// threads start.
void giveBackLargeMemory();

/// Leaves SIGINT, from this thread and from all that it starts later, to the threads that run already.
void leaveCtrlCToOtherThreads();

/// Returns all memory that is free now to the system; otherwise glibc keeps it for the threads that allocated it.
void giveBackFreeMemory();

}  // namespace proximity_server::system
