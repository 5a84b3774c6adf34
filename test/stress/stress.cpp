// ./dev stress: as many pairs as asked for, each checked against every promise of the narrowphase.
#include "stress/recorded_pairs.h"
#include "stress/run.h"
#include "stress/stress_main.h"

namespace proximity_server::narrowphase {
namespace {

struct PairStress {
  using Run = StressRun;
  using Summary = FamilySummary;
  static constexpr const char* kName = "stress";
  static constexpr const char* kAbout = "Looks for pairs of shapes that the narrowphase gets wrong.";
  static constexpr const char* kUnit = "pairs";
  static constexpr const char* kRecordFile = "recorded_pairs.jsonl";

  static std::int64_t& count(Run& run) { return run.pairs; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) { return runStress(run, done); }

  static void addOptions(CLI::App& app, Run& run) {
    run.pairs = 1000000;
    app.add_option("--pairs", run.pairs, "how many, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--pairs-per-oracle", run.pairs_per_oracle,
                   "one in so many pairs of each family is compared with the slow oracle")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<FamilySummary>& summaries) {
    std::printf("%-34s %11s %9s %9s %9s %6s %9s %11s %9s\n", "family", "pairs", "oracle", "error", "gap", "iter", "us",
                "unconverged", "failures");
    for (const FamilySummary& s : summaries)
      std::printf("%-34s %11lld %9lld %9.1e %9.1e %6d %9.1f %11lld %9lld\n", s.name.c_str(),
                  static_cast<long long>(s.pairs), static_cast<long long>(s.pairs_with_oracle), s.worst_error,
                  s.worst_gap, s.most_iterations, s.worst_microseconds, static_cast<long long>(s.not_converged),
                  static_cast<long long>(s.failed));
    std::printf("Worst of each family. error and gap as part of the size, where converged; us: time of one query.\n");
  }

  static nlohmann::json toJson(const FamilySummary& s) {
    return {{"family", s.name},
            {"pairs", s.pairs},
            {"with_oracle", s.pairs_with_oracle},
            {"worst_error", s.worst_error},
            {"worst_gap", s.worst_gap},
            {"most_iterations", s.most_iterations},
            {"not_converged", s.not_converged},
            {"failures", s.failed}};
  }

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    std::vector<RecordedLine> lines;
    for (const auto& [number, failure] : summary.failures) {
      const std::string name = summary.name + ", seed " + std::to_string(seed) + ", pair " + std::to_string(number) +
                               ": " + failure.sentence;
      lines.push_back({name, toJsonLine({name, failure.pair, {}, {}})});
    }
    return lines;
  }
};

}  // namespace
}  // namespace proximity_server::narrowphase

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::narrowphase::PairStress>(argc, argv);
}
