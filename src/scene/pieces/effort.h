#pragma once

#include <algorithm>
#include <cstddef>

namespace proximity_server::scene {

/// The remaining budget of steps for one mesh. Steps are counted instead of time, so that every machine computes the
/// same result. Some meshes would need hours to become convex pieces.
class Effort {
 public:
  struct Exceeded {};

  /// `seconds`: of one core of 2020, roughly; infinity is legal.
  explicit Effort(double seconds) : left_(seconds * kStepsPerSecond) {}

  /// Throws Exceeded when nothing is left. `steps`: of about 3 ns each.
  void spend(std::size_t steps) {
    left_ -= static_cast<double>(steps);
    if (left_ < 0.0) throw Exceeded();
  }

  /// Gives up half of what is left, and returns as much, for a later step.
  Effort half() {
    left_ = std::max(0.0, 0.5 * left_);
    return *this;
  }
  void add(const Effort& other) { left_ = std::max(0.0, left_) + other.left_; }

  double secondsLeft() const { return left_ / kStepsPerSecond; }

 private:
  static constexpr double kStepsPerSecond = 3e8;
  double left_;
};

}  // namespace proximity_server::scene
