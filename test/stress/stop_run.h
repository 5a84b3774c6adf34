#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "stress/controlled_robots.h"

namespace proximity_server::scene {

/// What a family's stops showed.
struct StopSummary {
  std::string name;
  std::int64_t stops = 0;
  std::int64_t slowed = 0;    ///< of these with a scale below 1, but above 0
  std::int64_t halted = 0;    ///< with the scale 0
  std::int64_t retreats = 0;  ///< of these where all pairs that are too near go away, and no other comes near
  std::int64_t open = 0;      ///< not Converged
  std::int64_t unneeded = 0;  ///< of these, slowed retreats with stop distances of at least 0
  double microseconds = 0.0;  ///< of all questions together
  double seconds = 0.0;
  std::int64_t failed = 0;
  std::vector<CellFailure> failures;  ///< the first ones only

  void merge(const StopSummary& other);
};

struct StopRun {
  std::int64_t stops = 20000;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
};

/// A cell is a robot with so many stops.
constexpr int kStopsOfCell = 100;

/// Stops robots, and looks at them on the way.
///
/// 1. Take a random state, random velocities, brakes and latency, and stop distances near the distance of the closest pair.
/// 2. Move the robot with its scaled velocities for the latency, and brake, in fine steps of time. No pair may be below its stop
///    distance or, if it is too near at the start, nearer than at the start; both less than the stated tolerance.
/// 3. If the scale is below 1, look at the stop from the unscaled velocities in the same way: if every pair that is too near
///    moves away all the time, and no other one comes near, the retreat was slowed.
///
/// Every cell depends on seed, family and number only. `done` counts the stops while it runs. Throws std::invalid_argument for an
/// unknown family.
std::vector<StopSummary> runStops(const StopRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::scene
