// ./dev stress scenes: as many scenes as asked for, each answer held against all pairs of convex parts.
#include "stress/scene_run.h"
#include "stress/stress_main.h"

namespace proximity_server::scene {
namespace {

using narrowphase::RecordedLine;

struct SceneStress {
  using Run = SceneRun;
  using Summary = SceneFamilySummary;
  static constexpr const char* kName = "scene_stress";
  static constexpr const char* kAbout = "Looks for scenes of a robot with objects whose answers are wrong.";
  static constexpr const char* kUnit = "scenes";
  static constexpr const char* kRecordFile = "recorded_scenes.jsonl";

  static std::int64_t& count(Run& run) { return run.scenes; }
  static std::vector<Summary> runAll(const Run& run, std::atomic<std::int64_t>& done) { return runScenes(run, done); }

  static void addOptions(CLI::App& app, Run& run) {
    app.add_option("--scenes", run.scenes, "how many scenes, of all families together")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--cells-per-oracle", run.cells_per_oracle,
                   "in one of so many cells, of ten scenes each, the slow oracle is asked too")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
  }

  static void print(const std::vector<Summary>& summaries) {
    std::printf("%-20s %8s %10s %9s %9s %8s %8s %8s %8s %7s %7s %8s %8s %8s %8s %7s %8s\n", "family", "scenes", "pairs",
                "questions", "answers", "minima", "overlap", "object", "unknown", "oracle", "others", "off", "motions",
                "contacts", "open", "ms", "failures");
    for (const Summary& summary : summaries) {
      const SceneObservation& s = summary.seen;
      const auto number = [](std::int64_t value) { return static_cast<long long>(value); };
      std::printf(
          "%-20s %8d %10lld %9lld %9lld %8lld %8lld %8lld %8lld %7lld %7lld %8lld %8lld %8lld %8lld %7.1f %8lld\n",
          summary.name.c_str(), s.scenes, number(s.pairs), number(s.questions), number(s.answers), number(s.minima),
          number(s.overlaps), number(s.with_object), number(s.unknown), number(s.with_oracle), number(s.others),
          number(s.others_off), number(s.motions), number(s.contacts), number(s.motions_open),
          1e3 * summary.seconds / std::max(1, s.scenes), number(summary.failed));
    }
    std::printf(
        "answers: pairs that were held against the truth; minima: nearest pairs of a scene; overlap, object: those\n"
        "that overlap, or have an object; oracle, others: nearest parts that the slow oracle, FCL and Bullet were\n"
        "asked about; off: FCL or Bullet is off by more than 1e-4, and the slow oracle has decided; motions: that "
        "begin in\n"
        "some of the scenes; contacts, open: motions with a first contact, and motions with an answer that did not\n"
        "converge; ms: time of a scene. A failure ends its cell.\n");
  }

  static nlohmann::json toJson(const Summary& summary) {
    const SceneObservation& s = summary.seen;
    return {{"family", summary.name},       {"scenes", s.scenes},           {"pairs", s.pairs},
            {"questions", s.questions},     {"answers", s.answers},         {"minima", s.minima},
            {"overlaps", s.overlaps},       {"with_object", s.with_object}, {"unknown", s.unknown},
            {"with_oracle", s.with_oracle}, {"others", s.others},           {"others_off", s.others_off},
            {"motions", s.motions},         {"contacts", s.contacts},       {"motions_open", s.motions_open},
            {"failures", summary.failed}};
  }

  static std::vector<RecordedLine> lines(const Summary& summary, unsigned seed) {
    std::vector<RecordedLine> lines;
    for (const SceneFailure& failure : summary.failures) {
      const std::string name = summary.name + ", seed " + std::to_string(seed) + ", cell " +
                               std::to_string(failure.number) + ", state " + std::to_string(failure.state) + ": " +
                               failure.sentence;
      const nlohmann::json line = {
          {"name", name}, {"family", summary.name}, {"seed", seed}, {"number", failure.number}};
      lines.push_back({name, line.dump()});
    }
    return lines;
  }
};

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  return proximity_server::narrowphase::stressMain<proximity_server::scene::SceneStress>(argc, argv);
}
