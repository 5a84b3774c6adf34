#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "stress/controlled_robots.h"

namespace proximity_server::scene {

/// What a family's motions showed.
struct FreeMotionSummary {
  std::string name;
  std::int64_t motions = 0;
  std::int64_t overlaps = 0;   ///< of these from a pair that overlaps
  std::int64_t of_scenes = 0;  ///< of these motions of a whole scene
  double most_used = 0.0;      ///< the largest part of the free distance by which a pair came nearer
  double used = 0.0;           ///< the sum of these parts, of motions along the gradient
  std::int64_t along_gradient = 0;
  std::vector<double> reaches;  ///< guaranteed over true reach, of some motions
  double seconds = 0.0;
  std::int64_t failed = 0;
  std::vector<CellFailure> failures;  ///< the first ones only

  void merge(const FreeMotionSummary& other);
};

struct FreeMotionRun {
  std::int64_t motions = 1000000;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
};

/// A cell is a robot in some states, with so many motions.
constexpr int kMotionsOfCell = 2000;

/// Moves robots to the border of their bubbles, and measures the distance on the way there.
///
/// 1. Of a random pair: take any threshold below its lower bound, and go to the border of its bubble in random directions, along one
///    degree of freedom, along the gradient of the distance, and along the one that brings the two together fastest for its weight.
/// 2. Of a whole scene: find the bubbles, and go to their border in random directions.
/// 3. At the border, or at a random place on the straight way there, no upper bound of a distance may be below its threshold.
///
/// Every cell depends on seed, family and number only. `done` counts the motions while it runs. Throws std::invalid_argument
/// for an unknown family.
std::vector<FreeMotionSummary> runFreeMotions(const FreeMotionRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::scene
