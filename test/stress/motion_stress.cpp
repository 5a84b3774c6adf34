// ./dev stress motions: as many motions as asked for, each answer held against an independent search.
#include "stress/motion_run.h"
#include "stress/recorded_motions.h"
#include "stress/stress_main.h"

namespace proximity_server::narrowphase {
namespace {

double mean(double sum, std::int64_t count) { return sum / static_cast<double>(std::max<std::int64_t>(count, 1)); }

struct MotionStress {
  using Run = MotionRun;
  using Summary = MotionFamilySummary;
  static constexpr const char* kName = "motion_stress";
  static constexpr const char* kAbout = "Looks for motions whose time of contact or smallest distance is wrong.";
  static constexpr const char* kUnit = "motions";
  static constexpr const char* kRecordFile = "recorded_motions.jsonl";

  static std::int64_t& count(Run& run) { return run.motions; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) { return runMotions(run, done); }

  static void addOptions(CLI::App& app, Run& run) {
    run.motions = 100000;
    app.add_option("--pairs", run.motions, "how many pairs in motion, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--motions-per-oracle", run.motions_per_oracle,
                   "one in so many of a family is compared with the slow oracle")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<MotionFamilySummary>& summaries) {
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

  static nlohmann::json toJson(const MotionFamilySummary& s) {
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

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    std::vector<RecordedLine> lines;
    for (const MotionFailure& failure : summary.failures) {
      const std::string name = summary.name + ", seed " + std::to_string(seed) + ", motion " +
                               std::to_string(failure.number) + ": " + failure.sentence;
      lines.push_back({name, toJsonLine(RecordedMotion{name, failure.motion})});
    }
    return lines;
  }
};

}  // namespace
}  // namespace proximity_server::narrowphase

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::narrowphase::MotionStress>(argc, argv);
}
