#pragma once

#include <cstddef>

namespace proximity_server {

/// What a mesh has cost so far, counted and not timed, so that every machine comes to the same end. Meshes come from
/// strangers, and some need hours to become convex pieces.
class Effort {
 public:
  struct Exceeded {};

  /// Throws Exceeded when the sum is more than about a minute. `steps`: of 2 to 10 ns each.
  void spend(std::size_t steps) {
    spent_ += static_cast<double>(steps);
    if (spent_ > kMostSteps) throw Exceeded();
  }

 private:
  static constexpr double kMostSteps = 5e9;
  double spent_ = 0.0;
};

}  // namespace proximity_server
