#include "stress/run.h"

#include <algorithm>

#include "stress/rounds.h"

namespace proximity_server::narrowphase {
namespace {

void add(FamilySummary& summary, const Observation& seen, std::int64_t number) {
  ++summary.pairs;
  const SignedDistance& result = seen.result;
  if (result.status == Status::Converged)
    summary.worst_gap = std::max(summary.worst_gap, (result.upper_bound - result.lower_bound) / seen.size);
  else
    ++summary.not_converged;
  summary.most_iterations = std::max(summary.most_iterations, result.iterations);
  summary.worst_microseconds = std::max(summary.worst_microseconds, seen.microseconds);
  if (seen.error) {
    ++summary.pairs_with_oracle;
    if (result.status == Status::Converged)
      summary.worst_error = std::max(summary.worst_error, *seen.error / seen.size);
  }
  if (!seen.failure) return;
  ++summary.failed;
  if (summary.failures.size() < kFailuresKept) summary.failures.push_back({number, *seen.failure});
}

}  // namespace

void FamilySummary::merge(const FamilySummary& other) {
  pairs += other.pairs;
  pairs_with_oracle += other.pairs_with_oracle;
  worst_error = std::max(worst_error, other.worst_error);
  worst_gap = std::max(worst_gap, other.worst_gap);
  most_iterations = std::max(most_iterations, other.most_iterations);
  worst_microseconds = std::max(worst_microseconds, other.worst_microseconds);
  not_converged += other.not_converged;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<FamilySummary> runStress(const StressRun& run, std::atomic<std::int64_t>& done) {
  const Rounds rounds(stressFamilies(), run.family, static_cast<double>(run.pairs) / kPairsPerBlock);
  return rounds.observe<FamilySummary>(
      run.threads, [&](std::size_t family, std::int64_t block, FamilySummary& summary) {
        const std::vector<StressPair> pairs = stressBlock(family, run.seed, block);
        for (std::size_t i = 0; i < pairs.size(); ++i) {
          const std::int64_t number = kPairsPerBlock * block + static_cast<std::int64_t>(i);
          const bool with_oracle = number % run.pairs_per_oracle == 0;
          add(summary, with_oracle ? observeWithOracle(pairs[i]) : observe(pairs[i]), number);
        }
        done += kPairsPerBlock;
      });
}

}  // namespace proximity_server::narrowphase
