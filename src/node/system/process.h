#pragma once

// Settings of the process that the node asks the system for.

namespace proximity_server::node {

/// Before there are other threads: asks the system to let this one, and all that it starts later, run in many short
/// turns: when one of them has something to do it need not wait for the end of the long turn of another program. Linux
/// grants that to everybody from 6.12 on; before, nothing changes, and nothing does under a policy that somebody chose.
void askForShortTurns();

/// Before there are other threads: memory of a huge request goes back to the system with its answer. By itself glibc
/// keeps ever more of it, in every thread that has seen one.
void giveBackLargeMemory();

/// What is free by now goes back to the system: glibc keeps it for each thread that ever asked for as much.
void giveBackFreeMemory();

}  // namespace proximity_server::node
