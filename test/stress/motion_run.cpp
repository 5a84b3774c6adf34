#include "stress/motion_run.h"

#include <algorithm>

#include "stress/rounds.h"

namespace proximity_server::narrowphase {
namespace {

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

}  // namespace

void MotionFamilySummary::merge(const MotionFamilySummary& other) {
  motions += other.motions;
  with_oracle += other.with_oracle;
  contacts += other.contacts;
  undecided += other.undecided;
  open_minima += other.open_minima;
  contact_queries += other.contact_queries;
  minimum_queries += other.minimum_queries;
  most_contact_queries = std::max(most_contact_queries, other.most_contact_queries);
  worst_gap = std::max(worst_gap, other.worst_gap);
  contact_microseconds += other.contact_microseconds;
  minimum_microseconds += other.minimum_microseconds;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<MotionFamilySummary> runMotions(const MotionRun& run, std::atomic<std::int64_t>& done) {
  const Rounds rounds(motionFamilies(), run.family, static_cast<double>(run.motions));
  return rounds.observe<MotionFamilySummary>(
      run.threads, [&](std::size_t family, std::int64_t number, MotionFamilySummary& summary) {
        const StressMotion motion = stressMotion(family, run.seed, number);
        const bool with_oracle = number % run.motions_per_oracle == 0;
        const MotionObservation seen = with_oracle ? observeMotionWithOracle(motion) : observeMotion(motion);
        add(summary, seen);
        summary.with_oracle += with_oracle ? 1 : 0;
        if (seen.failure && summary.failures.size() < kFailuresKept)
          summary.failures.push_back({number, *seen.failure, motion});
        ++done;
      });
}

}  // namespace proximity_server::narrowphase
