#pragma once

#include <functional>

namespace proximity_server::system {

/// Calls a function later in the thread that waits for the work. Thread-safe.
using CallHere = std::function<void(std::function<void()>)>;

/// Runs `work` in another thread. Functions that `work` passes to its argument are called in this thread, one after the
/// other. Returns when the work and all calls are done. If the system refuses another thread, everything runs in this
/// one.
/// Failure: throws what `work` throws. If a call throws, no other call is made, and its exception is thrown when the
///          work is done.
void runRelayed(const std::function<void(const CallHere&)>& work);

/// Runs `work` in another thread, and calls `watch` in this one every 50 ms until the work is done. If the system
/// refuses another thread, the work runs in this one, unwatched.
/// Failure: throws what `work` throws. `watch` must not throw.
void runWatched(const std::function<void()>& work, const std::function<void()>& watch);

}  // namespace proximity_server::system
