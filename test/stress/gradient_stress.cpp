// ./dev stress gradients: gradients of as many random states as asked for, against differences of the distance.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "peers/aborts.h"
#include "peers/witnesses.h"
#include "scene/objects/placed_object.h"
#include "stress/gradient_checks.h"

namespace proximity_server::scene {
namespace {

using Kind = GradientObservation::Kind;

/// Errors of one way to a gradient.
class Errors {
 public:
  void add(double error) { errors_.push_back(error); }
  std::size_t size() const { return errors_.size(); }

  /// The error that a share of all does not exceed.
  double quantile(double share) {
    if (errors_.empty()) return 0.0;
    std::sort(errors_.begin(), errors_.end());
    return errors_[static_cast<std::size_t>(share * static_cast<double>(errors_.size() - 1))];
  }

 private:
  std::vector<double> errors_;
};

struct Summary {
  std::map<Kind, int> kinds;
  int overlaps = 0, wrong = 0;
  Errors errors;
  std::map<std::string, Errors> of_others;
};

/// How the other libraries would have answered the last question of an observer.
class Others {
 public:
  explicit Others(const GradientFamily& family) : family_(family) {
    if (!family.is_pair_of_solids) return;
    a_ = peers::solidOf(pieceOf("a").shape);
    b_ = peers::solidOf(pieceOf("b").shape);
  }

  void ask(GradientObserver& observer, Summary& summary) const {
    if (!a_ || !b_) return;
    const Eigen::Isometry3d pose_a = poseOf("a", observer), pose_b = poseOf("b", observer);
    const Eigen::Isometry3d a_T_b = pose_a.inverse(Eigen::Isometry) * pose_b;
    for (const peers::WitnessLibrary& library : peers::witnessLibraries()) {
      const auto witnesses = library.ask(*a_, *b_, a_T_b, observer.lastPair().result.distance > 0.0);
      if (!witnesses) continue;
      const double error = observer.errorWith(pose_a * witnesses->point_a, pose_a * witnesses->point_b,
                                              pose_a.linear() * witnesses->normal);
      summary.of_others[library.name].add(error);
    }
  }

 private:
  const PlacedObject& placed(const char* id) const { return *family_.objects->placed(family_.objects->find(id)); }
  const Piece& pieceOf(const char* id) const { return placed(id).geometry->pieces().front(); }
  Eigen::Isometry3d poseOf(const char* id, const GradientObserver& observer) const {
    return *observer.lastPoses()[static_cast<std::size_t>(placed(id).body)] * pieceOf(id).body_T_piece;
  }

  const GradientFamily& family_;
  std::optional<peers::Solid> a_, b_;
};

void print(const GradientFamily& family, unsigned seed, const GradientObservation& seen) {
  std::printf("%s, sample %u: distance %.9g, error %.3g, of the differences %.3g\n", family.name.c_str(), seed,
              seen.distance, seen.error, seen.allowed);
}

Summary run(const GradientFamily& family, double tolerance, unsigned first_seed, int samples) {
  Summary summary;
  GradientObserver observer(family, tolerance);
  const Others others(family);
  for (int i = 0; i < samples; ++i) {
    const unsigned seed = first_seed + static_cast<unsigned>(i);
    const GradientObservation seen = observer.observe(seed);
    ++summary.kinds[seen.kind];
    if (seen.kind != Kind::Judged && seen.kind != Kind::Unresolved) continue;
    if (seen.error > kGradientError + seen.allowed && ++summary.wrong <= 3) print(family, seed, seen);
    if (seen.kind == Kind::Unresolved) continue;
    summary.overlaps += static_cast<int>(seen.distance < 0.0);
    summary.errors.add(seen.error);
    others.ask(observer, summary);
  }
  return summary;
}

void printHead() {
  std::printf("%-28s %8s %8s %8s %8s %8s %8s %9s %9s %9s %6s\n", "family", "judged", "overlap", "kink", "choice",
              "coarse", "at rest", "half", "99 %", "worst", "wrong");
}

void print(const std::string& name, Summary& summary) {
  std::printf("%-28s %8zu %8d %8d %8d %8d %8d %9.1e %9.1e %9.1e %6d\n", name.c_str(), summary.errors.size(),
              summary.overlaps, summary.kinds[Kind::Kink], summary.kinds[Kind::NotUnique],
              summary.kinds[Kind::Unresolved], summary.kinds[Kind::Unmoved], summary.errors.quantile(0.5),
              summary.errors.quantile(0.99), summary.errors.quantile(1.0), summary.wrong);
  for (auto& [library, errors] : summary.of_others)
    std::printf("  %-26s %8zu %53s %9.1e %9.1e %9.1e\n", library.c_str(), errors.size(), "", errors.quantile(0.5),
                errors.quantile(0.99), errors.quantile(1.0));
  std::fflush(stdout);
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
  CLI::App app("Holds the gradients of distances against differences of distances.", "gradient_stress");
  app.add_option("--states", states, "how many, of all families together")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "the same seed gives the same states")->capture_default_str();
  app.add_option("--tolerance", tolerance, "[m] of the questions")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--family", only, "one family only, by its name in the table");
  CLI11_PARSE(app, argc, argv);
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
  int wrong = 0;
  printHead();
  for (const GradientFamily& family : families) {
    const auto alike = static_cast<double>(family.is_pair_of_solids ? pairs : robots);
    const auto samples = static_cast<int>(std::ceil(share * static_cast<double>(states) / alike));
    Summary summary = run(family, tolerance, seed * 10000000, samples);
    print(family.name, summary);
    wrong += summary.wrong;
  }
  std::printf(
      "judged: answers that were held against differences of the distance, two-sided and extrapolated; overlap: of\n"
      "these; kink: the distance is not smooth within the steps; choice: the answer is not unique, as it says; "
      "coarse:\n"
      "the differences are not good enough; at rest: nothing moves one against the other. Errors are relative to the\n"
      "speed of the points against each other. wrong: more than %.0e off. Indented: the same formula with the points\n"
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
