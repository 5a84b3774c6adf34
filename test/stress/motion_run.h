#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "stress/motion_checks.h"

namespace proximity_server::narrowphase {

struct MotionFailure {
  std::int64_t number;  ///< of the motion in its family
  std::string sentence;
  StressMotion motion;
};

/// What a family's motions showed.
struct MotionFamilySummary {
  std::string name;
  std::int64_t motions = 0;
  std::int64_t with_oracle = 0;
  std::int64_t contacts = 0;
  std::int64_t undecided = 0;        ///< first contact not Converged; its t_free is checked all the same
  std::int64_t open_minima = 0;      ///< smallest distance not Converged; its bounds are checked all the same
  std::int64_t contact_queries = 0;  ///< of all together
  std::int64_t minimum_queries = 0;
  int most_contact_queries = 0;
  double worst_gap = 0.0;  ///< [m] of the distance at t_free above the contact distance, where there is contact
  double contact_microseconds = 0.0;  ///< of all together
  double minimum_microseconds = 0.0;
  std::int64_t failed = 0;
  std::vector<MotionFailure> failures;  ///< the first ones only: a broken family would fill the memory

  void merge(const MotionFamilySummary& other);
};

struct MotionRun {
  std::int64_t motions = 0;  ///< of all families together, rounded up to whole rounds
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
  int motions_per_oracle = 500;  ///< one in so many of a family is compared with the slow oracle
};

/// Every motion depends on seed, family and number only, not on the threads. `done` counts the motions while it runs.
/// Throws std::invalid_argument for an unknown family.
std::vector<MotionFamilySummary> runMotions(const MotionRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::narrowphase
