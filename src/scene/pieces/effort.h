#pragma once

#include "scene/mesh/stop_flag.h"

#include <algorithm>
#include <cstddef>

namespace proximity_server::scene {

/// The remaining budget of steps for one mesh. Steps are counted instead of time, so that every machine computes the
/// same result. Some meshes would need hours to become convex pieces.
class Effort {
 public:
  struct Exceeded {};

  /// `seconds`: the approximate time of one core of 2020; infinity is legal. `stop`: see MeshOptions::stop.
  explicit Effort(double seconds, const std::atomic<bool>* stop = nullptr)
      : left_(seconds * kStepsPerSecond), stop_(stop) {}

  /// Throws Exceeded when nothing is left, and as requireNoStop() does. `steps`: each stands for about 3 ns.
  void spend(std::size_t steps) {
    requireNoStop(stop_);
    left_ -= static_cast<double>(steps);
    if (left_ < 0.0) throw Exceeded();
  }

  /// Removes half of the remaining effort and returns the other half, for a later step.
  Effort half() {
    left_ = std::max(0.0, 0.5 * left_);
    return *this;
  }
  void add(const Effort& other) { left_ = std::max(0.0, left_) + other.left_; }

  bool isSpent() const { return left_ < 0.0; }
  double secondsLeft() const { return left_ / kStepsPerSecond; }

 private:
  static constexpr double kStepsPerSecond = 3e8;
  double left_;
  const std::atomic<bool>* stop_;
};

}  // namespace proximity_server::scene
