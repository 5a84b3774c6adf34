#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace proximity_server::system {

/// Calls a function at a steady rate of wall time, in a thread of its own. A call that is a period late is skipped.
///
/// It replaces ros::WallTimer, which sleeps for whole milliseconds and passes each event to another thread: that is too
/// coarse for 1 kHz. Thread-safe.
class SteadyTimer {
 public:
  /// In a thread of its own, calls `begin` at once, and `tick` as soon as start() has been called.
  SteadyTimer(std::function<void()> begin, std::function<void()> tick);
  ~SteadyTimer();
  SteadyTimer(const SteadyTimer&) = delete;
  SteadyTimer& operator=(const SteadyTimer&) = delete;

  /// Calls the function every `period` [s] from now on.
  void start(double period);
  /// Ends the calls. Does not wait for one that is running.
  void stop();

 private:
  using Clock = std::chrono::steady_clock;
  void run();

  const std::function<void()> tick_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  Clock::duration period_{};  // 0 if stopped
  Clock::time_point next_;
  bool ends_ = false;
  std::thread thread_;  // the last member, because it uses the members above
};

}  // namespace proximity_server::system
