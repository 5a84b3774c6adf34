// ./dev stress: as many pairs as asked for, each checked against every promise of the narrowphase.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

#include "benchmark/machine.h"
#include "stress/progress_bar.h"
#include "stress/recorded_pairs.h"
#include "stress/run.h"

namespace proximity_server::narrowphase {
namespace {

void print(const std::vector<FamilySummary>& summaries) {
  std::printf("%-34s %11s %9s %9s %9s %6s %9s %11s %9s\n", "family", "pairs", "oracle", "error", "gap", "iter", "us",
              "unconverged", "failures");
  for (const FamilySummary& s : summaries)
    std::printf("%-34s %11lld %9lld %9.1e %9.1e %6d %9.1f %11lld %9lld\n", s.name.c_str(),
                static_cast<long long>(s.pairs), static_cast<long long>(s.pairs_with_oracle), s.worst_error,
                s.worst_gap, s.most_iterations, s.worst_microseconds, static_cast<long long>(s.not_converged),
                static_cast<long long>(s.failed));
  std::printf("Worst of each family. error and gap as part of the size, where converged; us: time of one query.\n");
}

nlohmann::json toJson(const FamilySummary& s) {
  return {{"family", s.name},
          {"pairs", s.pairs},
          {"with_oracle", s.pairs_with_oracle},
          {"worst_error", s.worst_error},
          {"worst_gap", s.worst_gap},
          {"most_iterations", s.most_iterations},
          {"not_converged", s.not_converged},
          {"failures", s.failed}};
}

/// Each failure as a line of the file, which the tests replay.
void record(const FamilySummary& summary, unsigned seed, const std::string& path) {
  std::ofstream file(path, std::ios::app);
  for (const auto& [number, failure] : summary.failures) {
    const std::string name =
        summary.name + ", seed " + std::to_string(seed) + ", pair " + std::to_string(number) + ": " + failure.sentence;
    std::printf("%s\n", name.c_str());
    file << toJsonLine({name, failure.pair, {}}) << "\n";
  }
  if (!file) throw std::runtime_error("cannot write " + path);
}

void write(const nlohmann::json& result, const std::string& path) {
  std::ofstream file(path);
  if (!(file << result.dump(1) << "\n")) throw std::runtime_error("cannot write " + path);
}

int run(const StressRun& asked, const std::string& record_path, const std::string& json_path) {
  std::atomic<std::int64_t> done{0};
  const auto start = std::chrono::steady_clock::now();
  std::vector<FamilySummary> summaries;
  {
    const ProgressBar bar(done, asked.pairs);
    summaries = runStress(asked, done);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  print(summaries);
  std::int64_t failed = 0;
  nlohmann::json result = benchmark::machine();
  result.update(
      {{"pairs", done.load()}, {"seed", asked.seed}, {"threads", asked.threads}, {"seconds", seconds.count()}});
  for (const FamilySummary& summary : summaries) {
    failed += summary.failed;
    result["families"].push_back(toJson(summary));
    if (!summary.failures.empty()) record(summary, asked.seed, record_path);
  }
  if (!json_path.empty()) write(result, json_path);
  std::printf("%lld pairs, seed %u: %lld failures in %.0f s on %u threads\n", static_cast<long long>(done), asked.seed,
              static_cast<long long>(failed), seconds.count(), asked.threads);
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace proximity_server::narrowphase

int main(int argc, char** argv) {
  using namespace proximity_server::narrowphase;
  StressRun asked;
  asked.pairs = 1000000;
  asked.threads = std::max(1u, std::thread::hardware_concurrency());
  std::string json_path, record_path = std::string(PROXIMITY_SOURCE_DIR) + "/test/data/recorded_pairs.jsonl";

  CLI::App app("Looks for pairs of shapes that the narrowphase gets wrong.", "stress");
  app.add_option("--pairs", asked.pairs, "how many, of all families together")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", asked.seed, "the same seed gives the same pairs")->capture_default_str();
  app.add_option("--family", asked.family, "one family only, by its name in the table");
  app.add_option("--threads", asked.threads, "default: one for each core")->check(CLI::PositiveNumber);
  app.add_option("--pairs-per-oracle", asked.pairs_per_oracle,
                 "one in so many pairs of each family is compared with the slow oracle")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--json", json_path, "where the table goes for ./dev plot");
  app.add_option("--record", record_path, "where failing pairs go, one line each");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(asked, record_path, json_path);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stress: %s\n", error.what());
    return 2;
  }
}
