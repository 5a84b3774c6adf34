#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace proximity_server::node {

/// Calls a function at a steady rate of wall time, in a thread of its own. Ticks that come a period late are left out.
///
/// A ros::WallTimer would do, but roscpp sleeps whole milliseconds and hands each tick to another thread: too coarse
/// for a kilohertz. Thread-safe.
class SteadyTimer {
 public:
  /// Calls `tick` in a thread with this priority, see runInRealTime, once start() was called.
  SteadyTimer(int realtime_priority, std::function<void()> tick);
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
  std::mutex mutex_;  // guards all that follows
  std::condition_variable changed_;
  Clock::duration period_{};  // 0: stopped
  Clock::time_point next_;
  bool ends_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace proximity_server::node
