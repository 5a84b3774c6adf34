#pragma once

#include <functional>

namespace proximity_server::system {

/// Calls a function in the thread that waits for the work, later. Thread-safe.
using CallHere = std::function<void(std::function<void()>)>;

/// Runs `work` in another thread, and in this one, one after the other, what it passes to its argument. Returns when the work and
/// all calls are done. Where the system gives no other thread, both run in this one.
/// Failure: throws what `work` throws. If a call throws, no other one is made, and its exception is thrown when the work is done.
void runRelayed(const std::function<void(const CallHere&)>& work);

}  // namespace proximity_server::system
