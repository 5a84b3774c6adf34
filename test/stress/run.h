#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "stress/checks.h"

namespace proximity_server::narrowphase {

struct StressFailure {
  std::int64_t number;  ///< of the pair in its family
  Failure failure;
};

/// The worst that a family's pairs showed.
struct FamilySummary {
  std::string name;
  std::int64_t pairs = 0;
  std::int64_t pairs_with_oracle = 0;
  double worst_error = 0.0;  ///< distance - truth, as part of the size; of the pairs with oracle
  double worst_gap = 0.0;    ///< upper - lower bound, as part of the size; of all that converged
  int most_iterations = 0;
  double worst_microseconds = 0.0;
  std::int64_t not_converged = 0;
  std::int64_t failed = 0;
  std::vector<StressFailure> failures;  ///< the first ones only: a broken family would fill the memory

  void merge(const FamilySummary& other);
};

struct StressRun {
  std::int64_t pairs = 0;  ///< of all families together, rounded up to whole blocks
  unsigned seed = 1;
  std::string family;  ///< one only; empty: all
  unsigned threads = 1;
  int pairs_per_oracle = 192;  ///< one in so many pairs of each family is compared with the slow oracle
};

/// Every pair depends on seed, family and number only, not on the threads. `done` counts the pairs while it runs.
/// Throws std::invalid_argument for an unknown family.
std::vector<FamilySummary> runStress(const StressRun& run, std::atomic<std::int64_t>& done);

}  // namespace proximity_server::narrowphase
