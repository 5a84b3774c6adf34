#pragma once

#include <atomic>
#include <chrono>

namespace proximity_server::scene {

/// The end of a search that is not done by then: a point of time, or the moment at which a flag is set. Searches read it
/// in their inner loops, so that they end within milliseconds.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;

  /// Never.
  Deadline() = default;
  Deadline(Clock::time_point time) : time_(time) {}  // NOLINT(google-explicit-constructor)
  /// `stop`, which must outlive the search, may be set by another thread, or by the handler of a signal.
  explicit Deadline(const std::atomic<bool>& stop, Clock::time_point time = Clock::time_point::max())
      : time_(time), stop_(&stop) {}

  /// Once true, it stays true, unless the flag is cleared.
  bool hasPassed() const {
    if (stop_ && stop_->load(std::memory_order_relaxed)) return true;
    return time_ != Clock::time_point::max() && Clock::now() >= time_;
  }

  /// A deadline with this flag, but without the point of time.
  Deadline withoutTime() const { return stop_ ? Deadline(*stop_) : Deadline(); }

 private:
  Clock::time_point time_ = Clock::time_point::max();
  const std::atomic<bool>* stop_ = nullptr;
};

}  // namespace proximity_server::scene
