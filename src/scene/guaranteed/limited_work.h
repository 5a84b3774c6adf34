#pragma once

#include "proximity_server/scene/guaranteed/guarantee_limits.h"

#include <algorithm>
#include <cstdint>

namespace proximity_server::scene {

/// Counts the steps of guaranteed distances, and tells when their limits end them.
class LimitedWork {
 public:
  void begin(const GuaranteeLimits& limits) {
    limits_ = limits;
    share_ = limits_.most_steps;
    steps_ = next_look_ = 0;
    end_ = GuaranteeEnd::None;
  }

  /// Begins with a pair. It may take half of the steps that are left, so that no pair takes the steps of all others.
  void beginPair() { share_ = steps_ + std::max<std::int64_t>(0, limits_.most_steps - steps_) / 2; }

  /// After the end of the time nothing is counted, so that steps() tells when that was.
  void count(std::int64_t steps) {
    if (end_ != GuaranteeEnd::Time) steps_ += steps;
  }

  /// True if the share of the pair, or the time, is over.
  bool isOver() { return isOverAt(share_); }

  /// True if all steps, or the time, are over.
  bool isSpent() { return isOverAt(limits_.most_steps); }

  std::int64_t steps() const { return steps_; }
  GuaranteeEnd end() const { return end_; }

 private:
  /// The deadline is looked at after so many steps, about 10 microseconds; in the same states after the same steps.
  static constexpr std::int64_t kStepsBetweenLooks = 3000;

  bool isOverAt(std::int64_t most) {
    if (end_ == GuaranteeEnd::Time || isTimeOver()) {
      end_ = GuaranteeEnd::Time;
      return true;
    }
    if (steps_ < most) return false;
    end_ = GuaranteeEnd::Steps;
    return true;
  }

  bool isTimeOver() {
    if (steps_ < next_look_) return false;
    next_look_ = steps_ + kStepsBetweenLooks;
    return steps_ >= limits_.steps_to_deadline || limits_.deadline.hasPassed();
  }

  GuaranteeLimits limits_;
  std::int64_t share_ = limits_.most_steps, steps_ = 0, next_look_ = 0;
  GuaranteeEnd end_ = GuaranteeEnd::None;
};

}  // namespace proximity_server::scene
