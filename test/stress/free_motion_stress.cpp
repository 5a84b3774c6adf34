// ./dev stress free-motions: as many motions to the border of their bubbles as asked for.
#include <algorithm>

#include "stress/free_motion_run.h"
#include "stress/stress_main.h"

namespace proximity_server::scene {
namespace {

using narrowphase::RecordedLine;

/// The middle of them; 0 if there are none.
double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct FreeMotionStress {
  using Run = FreeMotionRun;
  using Summary = FreeMotionSummary;
  static constexpr const char* kName = "free_motion_stress";
  static constexpr const char* kAbout = "Looks for free motions that are not free.";
  static constexpr const char* kUnit = "motions";
  static constexpr const char* kRecordFile = "recorded_free_motions.jsonl";

  static std::int64_t& count(Run& run) { return run.motions; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) {
    return runFreeMotions(run, done);
  }

  static void addOptions(CLI::App& app, Run& run) {
    app.add_option("--motions", run.motions, "how many motions, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<Summary>& summaries) {
    std::printf("%-24s %10s %10s %10s %9s %9s %9s %8s %8s\n", "family", "motions", "overlaps", "of scenes", "most used",
                "gradient", "of reach", "us", "failures");
    for (const Summary& s : summaries)
      std::printf("%-24s %10lld %10lld %10lld %9.6f %9.3f %9.3f %8.2f %8lld\n", s.name.c_str(),
                  static_cast<long long>(s.motions), static_cast<long long>(s.overlaps),
                  static_cast<long long>(s.of_scenes), s.most_used,
                  s.used / static_cast<double>(std::max<std::int64_t>(1, s.along_gradient)), median(s.reaches),
                  1e6 * s.seconds / static_cast<double>(std::max<std::int64_t>(1, s.motions)),
                  static_cast<long long>(s.failed));
    std::printf(
        "most used: the largest part of the free distance by which a pair came nearer; gradient: its mean of motions "
        "along\n"
        "the gradient; of reach: the median of the guaranteed over the true reach of a motion; us: time of a motion.\n"
        "A failure ends its cell.\n");
  }

  static nlohmann::json toJson(const Summary& s) {
    return {{"family", s.name},         {"motions", s.motions},     {"overlaps", s.overlaps},
            {"of_scenes", s.of_scenes}, {"most_used", s.most_used}, {"reach", median(s.reaches)},
            {"failures", s.failed}};
  }

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    return narrowphase::linesOfCells(summary, seed);
  }
};

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::scene::FreeMotionStress>(argc, argv);
}
