#pragma once

// What the node asks of the system, before it starts threads.

namespace proximity_server {

/// Asks the system to let this thread, and all that it starts later, run in many short turns: when one of them has
/// something to do it need not wait for the end of the long turn of another program. Linux grants that to everybody
/// from 6.12 on; before, nothing changes.
void askForShortTurns();

/// Memory of a huge request goes back to the system with its answer. By itself glibc keeps ever more of it, in every
/// thread that has seen one.
void giveBackLargeMemory();

}  // namespace proximity_server
