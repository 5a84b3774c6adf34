// ./dev stress gradients: gradients of as many random states as asked for, against differences of the distance.
#include "peers/aborts.h"
#include "peers/witnesses.h"
#include "scene/objects/placed_object.h"
#include "stress/campaign.h"
#include "stress/gradient_checks.h"
#include "tools/program/options.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {
namespace {

using Kind = GradientObservation::Kind;
using namespace stress;

constexpr int kNameWidth = 28;

/// How the other libraries would have answered the last question of an observer.
class Others {
 public:
  explicit Others(const GradientFamily& family) : family_(family) {
    if (!family.is_pair_of_solids) return;
    a_ = peers::solidOf(pieceOf("a").shape);
    b_ = peers::solidOf(pieceOf("b").shape);
  }

  void ask(GradientObserver& observer, std::map<std::string, Tally>& tallies) const {
    if (!a_ || !b_) return;
    const Eigen::Isometry3d pose_a = poseOf("a", observer), pose_b = poseOf("b", observer);
    const Eigen::Isometry3d a_T_b = pose_a.inverse(Eigen::Isometry) * pose_b;
    for (const peers::WitnessLibrary& library : peers::witnessLibraries()) {
      const auto witnesses = library.ask(*a_, *b_, a_T_b, observer.lastPair().result.distance > 0.0);
      if (!witnesses) continue;
      const double error = observer.errorWith(pose_a * witnesses->point_a, pose_a * witnesses->point_b,
                                              pose_a.linear() * witnesses->normal);
      Tally& tally = tallies[library.name];
      tally.family = "  " + library.name;
      tally.add("judged");
      tally.sample("errors", error);
    }
  }

 private:
  const PlacedObject& placed(const char* id) const { return *family_.objects->placed(family_.objects->find(id)); }
  const Piece& pieceOf(const char* id) const { return placed(id).geometry->pieces().front(); }
  Eigen::Isometry3d poseOf(const char* id, const GradientObserver& observer) const {
    return *observer.lastPoses()[placed(id).body] * pieceOf(id).body_T_piece;
  }

  const GradientFamily& family_;
  std::optional<peers::Solid> a_, b_;
};

Column quantile(const char* head, int width, double share) {
  return {head, width, "%*.1e", [share](const Tally& tally) { return tally.quantile("errors", share); }};
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{count("judged", 8, "judged"), count("overlap", 8, "overlaps"),
                                       count("kink", 8, "kinks"),    count("choice", 8, "not_unique"),
                                       count("coarse", 8, "coarse"), count("at rest", 8, "at_rest"),
                                       quantile("half", 9, 0.5),     quantile("99 %", 9, 0.99),
                                       quantile("worst", 9, 1.0),    failures(6)};
  return all;
}

/// The columns of another library: the number of its answers, and its errors under those of ours.
const std::vector<Column>& columnsOfOthers() {
  static const std::vector<Column> all{count("judged", 8, "judged"), quantile("half", 63, 0.5),
                                       quantile("99 %", 9, 0.99), quantile("worst", 9, 1.0)};
  return all;
}

const char* nameOf(Kind kind) {
  switch (kind) {
    case Kind::Unmoved:
      return "at_rest";
    case Kind::NotUnique:
      return "not_unique";
    case Kind::Kink:
      return "kinks";
    case Kind::Unresolved:
      return "coarse";
    case Kind::Judged:
      return "judged";
  }
  return "";
}

/// Asks so many samples of a family, prints their row, and returns how many answers were wrong.
std::int64_t run(const GradientFamily& family, double tolerance, unsigned first_seed, int samples) {
  Tally tally;
  tally.family = family.name;
  std::map<std::string, Tally> of_others;
  GradientObserver observer(family, tolerance);
  const Others others(family);
  for (int i = 0; i < samples; ++i) {
    const unsigned seed = first_seed + static_cast<unsigned>(i);
    const GradientObservation seen = observer.observe(seed);
    tally.add(nameOf(seen.kind));
    if (seen.kind != Kind::Judged && seen.kind != Kind::Unresolved) continue;
    if (seen.error > kGradientError + seen.allowed) {
      tally.fail({seed, "", {}});
      if (tally.failed() <= 3)
        std::printf("%s, sample %u: distance %.9g, error %.3g, of the differences %.3g\n", family.name.c_str(), seed,
                    seen.distance, seen.error, seen.allowed);
    }
    if (seen.kind == Kind::Unresolved) continue;
    tally.add("overlaps", seen.distance < 0.0);
    tally.sample("errors", seen.error);
    others.ask(observer, of_others);
  }
  printRow(kNameWidth, columns(), tally);
  for (const auto& [library, of_library] : of_others) printRow(kNameWidth, columnsOfOthers(), of_library);
  std::fflush(stdout);
  return tally.failed();
}

std::vector<GradientFamily> allFamilies() {
  std::vector<GradientFamily> families = pairsOfShapes();
  for (GradientFamily& family : demoRobots()) families.push_back(std::move(family));
  for (GradientFamily& family : exampleRobots()) families.push_back(std::move(family));
  return families;
}

int main(int argc, char** argv) {
  std::int64_t states = 100000;
  unsigned seed = 1;
  double tolerance = Question().tolerance;
  std::string only;
  tools::ProgramOptions program("gradient_stress",
                                "Holds the gradients of distances against differences of distances.");
  addPositive(program, "--states", states, "how many, of all families together");
  addCount(program, "--seed", seed, 0, std::numeric_limits<unsigned>::max(),
           "the same seed gives the same states (default: 1)");
  addPositive(program, "--tolerance", tolerance, "[m] of the questions");
  program.addText("--family", "NAME", only, "one family only, by its name in the table");
  if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
  peers::surviveAborts();

  std::vector<GradientFamily> families = allFamilies();
  if (!only.empty()) {
    const auto isOther = [&](const GradientFamily& family) { return family.name != only; };
    families.erase(std::remove_if(families.begin(), families.end(), isOther), families.end());
  }
  if (families.empty()) {
    std::fprintf(stderr, "gradient_stress: no family is called %s\n", only.c_str());
    return 2;
  }
  // Half of the states are those of robots, which are few families.
  const auto robots =
      std::count_if(families.begin(), families.end(), [](const auto& f) { return !f.is_pair_of_solids; });
  const auto pairs = static_cast<std::ptrdiff_t>(families.size()) - robots;
  const double share = robots > 0 && pairs > 0 ? 0.5 : 1.0;
  std::int64_t wrong = 0;
  printHead("family", kNameWidth, columns());
  for (const GradientFamily& family : families) {
    const auto alike = static_cast<double>(family.is_pair_of_solids ? pairs : robots);
    const auto samples = static_cast<int>(std::ceil(share * static_cast<double>(states) / alike));
    wrong += run(family, tolerance, seed * 10000000, samples);
  }
  std::printf(
      "judged: answers that were held against differences of the distance, two-sided and extrapolated; overlap: of\n"
      "these; kink: the distance is not smooth within the steps; choice: the answer is not unique, as it says; "
      "coarse:\n"
      "the differences are not good enough; at rest: nothing moves one against the other. Errors are relative to the\n"
      "speed of the points against each other. failures: more than %.0e off. Indented: the same formula with the "
      "points\n"
      "and normals of other libraries.\n",
      kGradientError);
  return wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace proximity_server::scene

int main(int argc, char** argv) {
  try {
    return proximity_server::scene::main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gradient_stress: %s\n", error.what());
    return 2;
  }
}
