#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "stress/controlled_robots.h"

namespace proximity_server::scene {

/// What a family's drives showed.
struct DriveSummary {
  std::string name;
  std::int64_t drives = 0;
  std::int64_t steps = 0;
  std::int64_t arrived = 0;
  std::int64_t held = 0;    ///< rests before the target, held back by pairs that the controller names
  std::int64_t moving = 0;  ///< still, when the time was over
  double fastest = 0.0;     ///< of all joints and steps the largest velocity, as a part of the URDF's limit
  /// [m] of all pairs and steps the smallest distance, less the stop distance; or less that at the start where this is smaller
  double nearest = std::numeric_limits<double>::infinity();
  double sign_changes = 0.0;    ///< [1/s] of the joint that changed its direction most often in one drive
  std::int64_t not_solved = 0;  ///< steps whose quadratic program rounding did not solve
  std::int64_t left_out = 0;    ///< steps with pairs that needed a row and had none
  double seconds = 0.0;
  std::int64_t failed = 0;
  std::vector<CellFailure> failures;  ///< the first ones only

  void merge(const DriveSummary& other);
};

struct DriveRun {
  std::int64_t drives = 50;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
  double duration = 20.0;  ///< [s] of a drive, at most
};

/// Drives robots from random states to random targets as the example avoiding_controller does, with its defaults and those of the node,
/// and looks at the distance of every pair after each step.
///
/// 1. Take a random state in which no pair is below its stop distance, unless it is in most states (links that are near by design), and a
///    random target.
/// 2. In each step of 10 ms take the rows of the state, the velocity of yieldingVelocity(), and move on.
///
/// A failure is a pair below its stop distance, or, where it was below it at the start, nearer than there, both by more than 0.1 mm; a
/// joint that is faster than the URDF allows; one that changes its direction more than five times a second, at more than 0.02 rad/s
/// or m/s; a rest before the target that no pair explains; a step without a velocity.
/// Limit: links that are below their stop distance by design and have no stop distance of their own may lose up to 0.25 mm of what is left,
/// and a joint may still change its direction more often where several of them have many places that are equally near. Such drives are
/// failures, too.
/// Every cell depends on seed, family and number only. `done` counts the drives while it runs. Throws std::invalid_argument for an
/// unknown family.
std::vector<DriveSummary> runDrives(const DriveRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::scene
