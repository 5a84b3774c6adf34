#pragma once

#include <chrono>
#include <thread>

namespace proximity_server::node {

/// Nothing that a test waits for takes this long unless it is broken.
constexpr std::chrono::seconds kPatience{20};

/// Looks again and again until `condition` holds; false if it does not in time.
template <class Condition>
bool holdsWithin(std::chrono::duration<double> patience, Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace proximity_server::node
