// ./dev stress drives: as many drives of robots as asked for, each to a random target, as the example of a controller does it.
#include <algorithm>

#include "stress/drive_run.h"
#include "stress/stress_main.h"

namespace proximity_server::scene {
namespace {

using narrowphase::RecordedLine;

struct DriveStress {
  using Run = DriveRun;
  using Summary = DriveSummary;
  static constexpr const char* kName = "drive_stress";
  static constexpr const char* kAbout = "Looks for drives with ~constraints that come too near, race, tremble or rest.";
  static constexpr const char* kUnit = "drives";
  static constexpr const char* kRecordFile = "recorded_drives.jsonl";

  static std::int64_t& count(Run& run) { return run.drives; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) { return runDrives(run, done); }

  static void addOptions(CLI::App& app, Run& run) {
    app.add_option("--drives", run.drives, "how many drives, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<Summary>& summaries) {
    std::printf("%-16s %7s %8s %7s %7s %8s %10s %8s %8s %9s %8s\n", "family", "drives", "arrived", "held", "moving",
                "fastest", "nearest mm", "turns/s", "unsolved", "ms/step", "failures");
    for (const Summary& s : summaries)
      std::printf("%-16s %7lld %8lld %7lld %7lld %8.3f %10.3f %8.2f %8lld %9.3f %8lld\n", s.name.c_str(),
                  static_cast<long long>(s.drives), static_cast<long long>(s.arrived), static_cast<long long>(s.held),
                  static_cast<long long>(s.moving), s.fastest, 1e3 * s.nearest, s.sign_changes,
                  static_cast<long long>(s.not_solved),
                  1e3 * s.seconds / static_cast<double>(std::max<std::int64_t>(1, s.steps)),
                  static_cast<long long>(s.failed));
    std::printf(
        "held: rests before the target, and the pairs that hold it are named; moving: the time was over; fastest: "
        "velocity "
        "of a joint,\nas a part of the URDF's limit; nearest: smallest distance less the stop distance, or less that "
        "at the "
        "start, if it is below;\nturns/s: changes of direction of one joint. A failure ends its drive.\n");
  }

  static nlohmann::json toJson(const Summary& s) {
    return {{"family", s.name},     {"drives", s.drives},      {"arrived", s.arrived},
            {"held", s.held},       {"moving", s.moving},      {"fastest", s.fastest},
            {"nearest", s.nearest}, {"turns", s.sign_changes}, {"failures", s.failed}};
  }

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    return narrowphase::linesOfCells(summary, seed);
  }
};

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::scene::DriveStress>(argc, argv);
}
