// ./dev stress motions: as many motions as asked for, each answer held against an independent search.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "benchmark/machine.h"
#include "stress/motion_run.h"
#include "stress/progress_bar.h"
#include "stress/recorded_motions.h"

namespace proximity_server::narrowphase {
namespace {

double mean(double sum, std::int64_t count) { return sum / static_cast<double>(std::max<std::int64_t>(count, 1)); }

void print(const std::vector<MotionFamilySummary>& summaries) {
  std::printf("%-22s %9s %7s %9s %9s %9s %7s %6s %7s %8s %8s %8s %8s\n", "family", "motions", "oracle", "contacts",
              "undecided", "open min", "q toc", "most", "q min", "us toc", "us min", "gap", "failures");
  for (const MotionFamilySummary& s : summaries)
    std::printf("%-22s %9lld %7lld %9lld %9lld %9lld %7.1f %6d %7.1f %8.1f %8.1f %8.1e %8lld\n", s.name.c_str(),
                static_cast<long long>(s.motions), static_cast<long long>(s.with_oracle),
                static_cast<long long>(s.contacts), static_cast<long long>(s.undecided),
                static_cast<long long>(s.open_minima), mean(static_cast<double>(s.contact_queries), s.motions),
                s.most_contact_queries, mean(static_cast<double>(s.minimum_queries), s.motions),
                mean(s.contact_microseconds, s.motions), mean(s.minimum_microseconds, s.motions), s.worst_gap,
                static_cast<long long>(s.failed));
  std::printf(
      "toc: first contact, min: smallest distance; q: queries of the distance, us: time, both in the mean.\n"
      "undecided, open min: not converged. gap: the largest distance at t_free above the contact distance, where in "
      "contact.\n");
}

nlohmann::json toJson(const MotionFamilySummary& s) {
  return {{"family", s.name},
          {"motions", s.motions},
          {"with_oracle", s.with_oracle},
          {"contacts", s.contacts},
          {"undecided", s.undecided},
          {"open_minima", s.open_minima},
          {"contact_queries", s.contact_queries},
          {"minimum_queries", s.minimum_queries},
          {"most_contact_queries", s.most_contact_queries},
          {"worst_gap", s.worst_gap},
          {"failures", s.failed}};
}

/// Each failure as a line of the file, which the tests replay.
void record(const MotionFamilySummary& summary, unsigned seed, const std::string& path) {
  std::ofstream file(path, std::ios::app);
  for (const MotionFailure& failure : summary.failures) {
    const std::string name = summary.name + ", seed " + std::to_string(seed) + ", motion " +
                             std::to_string(failure.number) + ": " + failure.sentence;
    std::printf("%s\n", name.c_str());
    file << toJsonLine(RecordedMotion{name, failure.motion}) << "\n";
  }
  if (!file) throw std::runtime_error("cannot write " + path);
}

void write(const nlohmann::json& result, const std::string& path) {
  std::ofstream file(path);
  if (!(file << result.dump(1) << "\n")) throw std::runtime_error("cannot write " + path);
}

int run(const MotionRun& asked, const std::string& record_path, const std::string& json_path) {
  std::atomic<std::int64_t> done{0};
  const auto start = std::chrono::steady_clock::now();
  std::vector<MotionFamilySummary> summaries;
  {
    const ProgressBar bar(done, asked.motions);
    summaries = runMotions(asked, done);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  print(summaries);
  std::int64_t failed = 0;
  nlohmann::json result = benchmark::machine();
  result.update(
      {{"motions", done.load()}, {"seed", asked.seed}, {"threads", asked.threads}, {"seconds", seconds.count()}});
  for (const MotionFamilySummary& summary : summaries) {
    failed += summary.failed;
    result["families"].push_back(toJson(summary));
    if (!summary.failures.empty()) record(summary, asked.seed, record_path);
  }
  if (!json_path.empty()) write(result, json_path);
  std::printf("%lld motions, seed %u: %lld failures in %.0f s on %u threads\n", static_cast<long long>(done),
              asked.seed, static_cast<long long>(failed), seconds.count(), asked.threads);
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace proximity_server::narrowphase

int main(int argc, char** argv) {
  using namespace proximity_server::narrowphase;
  MotionRun asked;
  asked.motions = 100000;
  asked.threads = std::max(1u, std::thread::hardware_concurrency());
  std::string json_path, record_path = std::string(PROXIMITY_SOURCE_DIR) + "/test/data/recorded_motions.jsonl";

  CLI::App app("Looks for motions whose time of contact or smallest distance is wrong.", "motion_stress");
  app.add_option("--pairs", asked.motions, "how many pairs in motion, of all families together")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", asked.seed, "the same seed gives the same motions")->capture_default_str();
  app.add_option("--family", asked.family, "one family only, by its name in the table");
  app.add_option("--threads", asked.threads, "default: one for each core")->check(CLI::PositiveNumber);
  app.add_option("--motions-per-oracle", asked.motions_per_oracle,
                 "one in so many of a family is compared with the slow oracle")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--json", json_path, "where the table goes as JSON");
  app.add_option("--record", record_path, "where failing motions go, one line each");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(asked, record_path, json_path);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "motion_stress: %s\n", error.what());
    return 2;
  }
}
