#include "stress/run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace proximity_server {
namespace {

constexpr std::size_t kFailuresKept = 20;

std::vector<std::size_t> familiesOf(const StressRun& run) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < stressFamilies().size(); ++i)
    if (run.family.empty() || run.family == stressFamilies()[i].name) chosen.push_back(i);
  if (chosen.empty()) throw std::invalid_argument("no family is called " + run.family);
  return chosen;
}

/// A round is one block of each family that is not too rare for it.
std::int64_t roundsOf(const StressRun& run) {
  double pairs_of_a_round = 0.0;
  for (const std::size_t family : familiesOf(run))
    pairs_of_a_round += static_cast<double>(kPairsPerBlock) / stressFamilies()[family].rarity;
  return static_cast<std::int64_t>(std::ceil(static_cast<double>(run.pairs) / pairs_of_a_round));
}

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

void add(FamilySummary& summary, const FamilySummary& other) {
  summary.pairs += other.pairs;
  summary.pairs_with_oracle += other.pairs_with_oracle;
  summary.worst_error = std::max(summary.worst_error, other.worst_error);
  summary.worst_gap = std::max(summary.worst_gap, other.worst_gap);
  summary.most_iterations = std::max(summary.most_iterations, other.most_iterations);
  summary.worst_microseconds = std::max(summary.worst_microseconds, other.worst_microseconds);
  summary.not_converged += other.not_converged;
  summary.failed += other.failed;
  summary.failures.insert(summary.failures.end(), other.failures.begin(), other.failures.end());
}

/// What one thread has seen, one summary for each chosen family.
class Worker {
 public:
  Worker(const StressRun& run, const std::vector<std::size_t>& families)
      : run_(run), families_(families), summaries_(families.size()) {}

  void work(std::atomic<std::int64_t>& next, std::atomic<std::int64_t>& done) {
    const std::int64_t families = static_cast<std::int64_t>(families_.size());
    const std::int64_t end = families * roundsOf(run_);
    for (std::int64_t i = next++; i < end; i = next++) {
      const std::size_t chosen = static_cast<std::size_t>(i % families);
      const std::int64_t round = i / families, rarity = stressFamilies()[families_[chosen]].rarity;
      if (round % rarity != 0) continue;
      observeBlock(chosen, round / rarity);
      done += kPairsPerBlock;
    }
  }

  const std::vector<FamilySummary>& summaries() const { return summaries_; }

 private:
  void observeBlock(std::size_t chosen, std::int64_t block) {
    const std::vector<StressPair> pairs = stressBlock(families_[chosen], run_.seed, block);
    const bool with_oracle = block % run_.blocks_per_oracle == 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Observation seen = with_oracle && i == 0 ? observeWithOracle(pairs[i]) : observe(pairs[i]);
      add(summaries_[chosen], seen, kPairsPerBlock * block + static_cast<std::int64_t>(i));
    }
  }

  StressRun run_;
  std::vector<std::size_t> families_;
  std::vector<FamilySummary> summaries_;
};

}  // namespace

std::vector<FamilySummary> runStress(const StressRun& run, std::atomic<std::int64_t>& done) {
  const std::vector<std::size_t> families = familiesOf(run);
  std::vector<Worker> workers(std::max(run.threads, 1u), Worker(run, families));
  std::atomic<std::int64_t> next{0};
  std::vector<std::thread> threads;
  for (Worker& worker : workers) threads.emplace_back([&] { worker.work(next, done); });
  for (std::thread& thread : threads) thread.join();

  std::vector<FamilySummary> total(families.size());
  for (std::size_t i = 0; i < families.size(); ++i) {
    total[i].name = stressFamilies()[families[i]].name;
    for (const Worker& worker : workers) add(total[i], worker.summaries()[i]);
    std::sort(total[i].failures.begin(), total[i].failures.end(),
              [](const StressFailure& x, const StressFailure& y) { return x.number < y.number; });
    if (total[i].failures.size() > kFailuresKept)
      total[i].failures.erase(total[i].failures.begin() + kFailuresKept, total[i].failures.end());
  }
  return total;
}

}  // namespace proximity_server
