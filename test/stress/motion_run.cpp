#include "stress/motion_run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace proximity_server {
namespace {

constexpr std::size_t kFailuresKept = 20;

std::vector<std::size_t> familiesOf(const MotionRun& run) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < motionFamilies().size(); ++i)
    if (run.family.empty() || run.family == motionFamilies()[i].name) chosen.push_back(i);
  if (chosen.empty()) throw std::invalid_argument("no family is called " + run.family);
  return chosen;
}

/// A round is one motion of each family that is not too rare for it.
std::int64_t roundsOf(const MotionRun& run, const std::vector<std::size_t>& families) {
  double motions_of_a_round = 0.0;
  for (const std::size_t family : families) motions_of_a_round += 1.0 / motionFamilies()[family].rarity;
  return static_cast<std::int64_t>(std::ceil(static_cast<double>(run.motions) / motions_of_a_round));
}

void add(MotionFamilySummary& summary, const MotionObservation& seen) {
  ++summary.motions;
  summary.contacts += seen.contact.contact ? 1 : 0;
  summary.undecided += seen.contact.status != Status::Converged ? 1 : 0;
  summary.open_minima += seen.minimum.status != Status::Converged ? 1 : 0;
  summary.contact_queries += seen.contact.queries;
  summary.minimum_queries += seen.minimum.queries;
  summary.most_contact_queries = std::max(summary.most_contact_queries, seen.contact.queries);
  summary.worst_gap = std::max(summary.worst_gap, seen.gap);
  summary.contact_microseconds += seen.contact_microseconds;
  summary.minimum_microseconds += seen.minimum_microseconds;
  summary.failed += seen.failure ? 1 : 0;
}

void add(MotionFamilySummary& summary, const MotionFamilySummary& other) {
  summary.motions += other.motions;
  summary.with_oracle += other.with_oracle;
  summary.contacts += other.contacts;
  summary.undecided += other.undecided;
  summary.open_minima += other.open_minima;
  summary.contact_queries += other.contact_queries;
  summary.minimum_queries += other.minimum_queries;
  summary.most_contact_queries = std::max(summary.most_contact_queries, other.most_contact_queries);
  summary.worst_gap = std::max(summary.worst_gap, other.worst_gap);
  summary.contact_microseconds += other.contact_microseconds;
  summary.minimum_microseconds += other.minimum_microseconds;
  summary.failed += other.failed;
  summary.failures.insert(summary.failures.end(), other.failures.begin(), other.failures.end());
}

/// What one thread has seen, one summary for each chosen family.
class Worker {
 public:
  Worker(const MotionRun& run, const std::vector<std::size_t>& families)
      : run_(run), families_(families), summaries_(families.size()) {}

  void work(std::atomic<std::int64_t>& next, std::atomic<std::int64_t>& done) {
    const std::int64_t families = static_cast<std::int64_t>(families_.size());
    const std::int64_t end = families * roundsOf(run_, families_);
    for (std::int64_t i = next++; i < end; i = next++) {
      const std::size_t chosen = static_cast<std::size_t>(i % families);
      const std::int64_t round = i / families, rarity = motionFamilies()[families_[chosen]].rarity;
      if (round % rarity != 0) continue;
      observe(chosen, round / rarity);
      ++done;
    }
  }

  const std::vector<MotionFamilySummary>& summaries() const { return summaries_; }

 private:
  void observe(std::size_t chosen, std::int64_t number) {
    const StressMotion motion = stressMotion(families_[chosen], run_.seed, number);
    const bool with_oracle = number % run_.motions_per_oracle == 0;
    const MotionObservation seen = with_oracle ? observeMotionWithOracle(motion) : observeMotion(motion);
    MotionFamilySummary& summary = summaries_[chosen];
    add(summary, seen);
    summary.with_oracle += with_oracle ? 1 : 0;
    if (seen.failure && summary.failures.size() < kFailuresKept)
      summary.failures.push_back({number, *seen.failure, motion});
  }

  MotionRun run_;
  std::vector<std::size_t> families_;
  std::vector<MotionFamilySummary> summaries_;
};

}  // namespace

std::vector<MotionFamilySummary> runMotions(const MotionRun& run, std::atomic<std::int64_t>& done) {
  const std::vector<std::size_t> families = familiesOf(run);
  std::vector<Worker> workers(std::max(run.threads, 1u), Worker(run, families));
  std::atomic<std::int64_t> next{0};
  std::vector<std::thread> threads;
  for (Worker& worker : workers) threads.emplace_back([&] { worker.work(next, done); });
  for (std::thread& thread : threads) thread.join();

  std::vector<MotionFamilySummary> total(families.size());
  for (std::size_t i = 0; i < families.size(); ++i) {
    total[i].name = motionFamilies()[families[i]].name;
    for (const Worker& worker : workers) add(total[i], worker.summaries()[i]);
    std::sort(total[i].failures.begin(), total[i].failures.end(),
              [](const MotionFailure& x, const MotionFailure& y) { return x.number < y.number; });
    if (total[i].failures.size() > kFailuresKept)
      total[i].failures.erase(total[i].failures.begin() + kFailuresKept, total[i].failures.end());
  }
  return total;
}

}  // namespace proximity_server
