// ./dev stress stops: as many stops of robots as asked for, each with the velocity scale that it is given.
#include <algorithm>

#include "stress/stop_run.h"
#include "stress/stress_main.h"

namespace proximity_server::scene {
namespace {

using narrowphase::RecordedLine;

struct StopStress {
  using Run = StopRun;
  using Summary = StopSummary;
  static constexpr const char* kName = "stop_stress";
  static constexpr const char* kAbout = "Looks for velocity scales that end too near, and for retreats that they slow.";
  static constexpr const char* kUnit = "stops";
  static constexpr const char* kRecordFile = "recorded_stops.jsonl";

  static std::int64_t& count(Run& run) { return run.stops; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) { return runStops(run, done); }

  static void addOptions(CLI::App& app, Run& run) {
    app.add_option("--stops", run.stops, "how many stops, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<Summary>& summaries) {
    std::printf("%-24s %9s %9s %9s %9s %8s %9s %9s %8s %8s\n", "family", "stops", "slowed", "halted", "retreats",
                "open", "unneeded", "us/scale", "us", "failures");
    for (const Summary& s : summaries) {
      const auto stops = static_cast<double>(std::max<std::int64_t>(1, s.stops));
      std::printf("%-24s %9lld %9lld %9lld %9lld %8lld %9lld %9.1f %8.1f %8lld\n", s.name.c_str(),
                  static_cast<long long>(s.stops), static_cast<long long>(s.slowed), static_cast<long long>(s.halted),
                  static_cast<long long>(s.retreats), static_cast<long long>(s.open),
                  static_cast<long long>(s.unneeded), s.microseconds / stops, 1e6 * s.seconds / stops,
                  static_cast<long long>(s.failed));
    }
    std::printf(
        "slowed, halted: with a scale below 1, of 0; retreats: from pairs that are too near; open: not Converged; "
        "unneeded: of\n"
        "these, slowed retreats with stop distances of at least 0; us/scale: time of the answer; us: with all checks. "
        "A failure ends its cell.\n");
  }

  static nlohmann::json toJson(const Summary& s) {
    return {{"family", s.name},       {"stops", s.stops}, {"slowed", s.slowed},     {"halted", s.halted},
            {"retreats", s.retreats}, {"open", s.open},   {"unneeded", s.unneeded}, {"failures", s.failed}};
  }

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    return narrowphase::linesOfCells(summary, seed);
  }
};

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::scene::StopStress>(argc, argv);
}
