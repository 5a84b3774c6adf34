#include "stress/scene_run.h"

#include <chrono>

#include "stress/rounds.h"

namespace proximity_server::scene {
namespace {

void add(const SceneObservation& other, SceneObservation& sum) {
  sum.scenes += other.scenes;
  sum.pairs += other.pairs;
  sum.questions += other.questions;
  sum.answers += other.answers;
  sum.minima += other.minima;
  sum.overlaps += other.overlaps;
  sum.with_object += other.with_object;
  sum.unknown += other.unknown;
  sum.skipped += other.skipped;
  sum.with_oracle += other.with_oracle;
  sum.others += other.others;
  sum.others_off += other.others_off;
  sum.motions += other.motions;
  sum.contacts += other.contacts;
  sum.motions_open += other.motions_open;
}

}  // namespace

void SceneFamilySummary::merge(const SceneFamilySummary& other) {
  add(other.seen, seen);
  seconds += other.seconds;
  failed += other.failed;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

std::vector<SceneFamilySummary> runScenes(const SceneRun& run, std::atomic<std::int64_t>& done) {
  const double cells = static_cast<double>(run.scenes) / kStatesOfCell;
  const narrowphase::Rounds rounds(sceneFamilies(), run.family, cells);
  return rounds.observe<SceneFamilySummary>(
      run.threads, [&](std::size_t family, std::int64_t number, SceneFamilySummary& summary) {
        const auto start = std::chrono::steady_clock::now();
        const bool with_oracle = number % run.cells_per_oracle == 0;
        const SceneObservation seen = observeScenes(family, run.seed, number, kStatesOfCell, with_oracle);
        summary.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        add(seen, summary.seen);
        summary.failed += seen.failure ? 1 : 0;
        if (seen.failure && summary.failures.size() < narrowphase::kFailuresKept)
          summary.failures.push_back({number, seen.failed_state, *seen.failure});
        done += kStatesOfCell;
      });
}

}  // namespace proximity_server::scene
