// Run time against error: the same pairs for ours, FCL, libccd and Bullet, interleaved round by round. The median of
// the rounds and the 99th percentile of the pairs go into a JSON file, with the error against the oracle of the tests.
// ./dev bench narrowphase runs it pinned.
#include "benchmark/benchmark_main.h"
#include "benchmark/timing.h"
#include "oracle/oracle.h"
#include "peers/aborts.h"
#include "peers/libraries.h"
#include "peers/solids.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace peers;
namespace {

using nlohmann::json;
using Make = std::function<Solid(Random&)>;

constexpr int kRounds = 9;
constexpr double kRoundNs = 4e6;         // of one library in one round, at most; fewer pairs if that takes longer
constexpr double kGrossError = 1e-3;     // [m] of solids of size 1: counted as a failure
constexpr double kOracleVertices = 4e4;  // the oracle's time grows with the vertices; so many, summed over its pairs

/// Pairs of one row, the same on every run.
struct Row {
  std::string name;
  Question question = Question::Distance;
  bool coherent = false;  ///< the pairs are steps of one motion: warm starts and polytopes are kept
  std::deque<Solid> a, b;
  std::vector<SolidPair> pairs;
  std::vector<double> truth;  ///< of the first pairs
};

int verticesOf(const Solid& solid) { return solid.ours.kind() == Shape::Kind::Hull ? solid.ours.hull().size() : 8; }

double truthOf(const SolidPair& pair) {
  return static_cast<double>(signedDistanceOracle({pair.a->ours, pair.b->ours, pair.a_T_b}).distance);
}

void addTruth(Row& row) {
  const double vertices = verticesOf(row.a.front()) + verticesOf(row.b.front());
  const auto count = static_cast<std::size_t>(std::clamp(kOracleVertices / vertices, 4.0, 100.0));
  for (std::size_t i = 0; i < std::min(count, row.pairs.size()); ++i) row.truth.push_back(truthOf(row.pairs[i]));
}

/// The warm starts of the queries of a row, and room for a polytope.
class Warmth {
 public:
  explicit Warmth(const Row& row) : keeps_(row.coherent) { warm_.polytope = &polytope_; }

  /// Returns the start of the next query.
  WarmStart& next() {
    if (!keeps_) warm_ = {};
    return warm_;
  }

 private:
  bool keeps_;
  WarmPolytope polytope_;
  WarmStart warm_;
};

/// Returns the answer to one pair, or nullopt if the library throws or aborts.
std::optional<Answer> tryToAsk(const Library& library, const Row& row, const SolidPair& pair, double tolerance,
                               WarmStart& warm) {
  return answerOf([&] { return library.ask(pair, row.question, tolerance, warm); });
}

/// Returns the pairs that a library answers at all: only they are timed.
std::vector<SolidPair> answeredBy(const Library& library, const Row& row, double tolerance) {
  std::vector<SolidPair> answered;
  for (const SolidPair& pair : row.pairs) {
    WarmStart cold;
    if (tryToAsk(library, row, pair, tolerance, cold)) answered.push_back(pair);
  }
  return answered;
}

/// Returns the largest and the mean error over the pairs with a known answer. The error of a wrong boolean is the
/// distance.
json errorsOf(const Library& library, const Row& row, double tolerance) {
  double largest = 0.0, sum = 0.0, iterations = 0.0;
  int failures = 0;
  Warmth warmth(row);
  for (std::size_t i = 0; i < row.truth.size(); ++i) {
    const std::optional<Answer> answer = tryToAsk(library, row, row.pairs[i], tolerance, warmth.next());
    double error = answer ? std::abs(answer->distance - row.truth[i]) : std::numeric_limits<double>::quiet_NaN();
    if (answer && row.question == Question::Boolean)
      error = answer->distance * row.truth[i] < 0.0 ? std::abs(row.truth[i]) : 0.0;
    if (answer) iterations += answer->iterations;
    if (!(error <= kGrossError)) ++failures;
    if (std::isnan(error)) continue;
    largest = std::max(largest, error);
    sum += error;
  }
  const auto count = static_cast<double>(row.truth.size());
  return {{"max_error", largest},
          {"mean_error", sum / count},
          {"iterations", iterations / count},
          {"failures", failures},
          {"checked", row.truth.size()}};
}

/// Returns the time [ns] per query over the first `count` pairs.
double timePerQuery(const Library& library, const Row& row, const std::vector<SolidPair>& pairs, double tolerance,
                    std::size_t count) {
  Warmth warmth(row);
  volatile double sink = 0.0;
  const double all = timeOf<std::nano>([&] {
    for (std::size_t i = 0; i < count; ++i)
      sink = sink + library.ask(pairs[i], row.question, tolerance, warmth.next()).distance;
  });
  return all / static_cast<double>(count);
}

/// Returns the time [ns] to read the clock, which is part of each query that is timed by itself.
double clockTime() {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) times.push_back(timeOf<std::nano>([] {}));
  return medianOf(times);
}

/// Returns the 99th percentile [ns] over the first `count` pairs, each timed by itself: its median over the rounds
/// counts.
double slowestOf(const Library& library, const Row& row, const std::vector<SolidPair>& pairs, double tolerance,
                 std::size_t count) {
  Rounds times(count);
  volatile double sink = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    Warmth warmth(row);
    for (std::size_t i = 0; i < count; ++i) {
      WarmStart& warm = warmth.next();
      times.add(
          i, timeOf<std::nano>([&] { sink = sink + library.ask(pairs[i], row.question, tolerance, warm).distance; }));
    }
  }
  return std::max(quantile(times.medians(), 0.99) - clockTime(), 0.0);
}

/// One library on one row.
struct Run {
  const Library* library;
  std::vector<SolidPair> pairs;
  std::size_t count;  ///< of pairs in a round
  std::vector<double> ns;
};

/// Returns one entry a library: median time, and errors.
json measure(const Row& row, const std::vector<Library>& libraries, double tolerance) {
  std::vector<Run> runs;
  for (const Library& library : libraries) {
    if (!library.answers(row.question, row.pairs.front().placement != Placement::Apart)) continue;
    Run run{&library, answeredBy(library, row, tolerance), 0, {}};
    if (run.pairs.empty()) continue;
    const std::size_t few = std::min<std::size_t>(run.pairs.size(), 20);
    const double ns = timePerQuery(library, row, run.pairs, tolerance, few);
    run.count = std::clamp(static_cast<std::size_t>(kRoundNs / ns), few, run.pairs.size());
    runs.push_back(run);
  }
  for (int round = 0; round < kRounds; ++round)
    for (Run& run : runs) run.ns.push_back(timePerQuery(*run.library, row, run.pairs, tolerance, run.count));
  json entries = json::array();
  for (const Run& run : runs) {
    json entry = errorsOf(*run.library, row, tolerance);
    entry.update({{"row", row.name},
                  {"library", run.library->name},
                  {"ns", medianOf(run.ns)},
                  {"p99_ns", slowestOf(*run.library, row, run.pairs, tolerance, run.count)},
                  {"unanswered", row.pairs.size() - run.pairs.size()},
                  {"pairs", row.pairs.size()}});
    entries.push_back(entry);
  }
  return entries;
}

Row solidsOf(const std::string& name, const Make& make_a, const Make& make_b, int solids) {
  Row row;
  row.name = name;
  Random random(7);
  for (int i = 0; i < solids; ++i) {
    row.a.push_back(make_a(random));
    row.b.push_back(make_b(random));
  }
  return row;
}

/// Adds random pairs of every solid with every other, in one placement.
void placeAll(Row& row, Placement placement, int pairs) {
  Random random(8);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs); ++i)
    row.pairs.push_back(place(row.a[i % row.a.size()], row.b[i / row.a.size() % row.b.size()], placement, random));
}

/// Adds one pair in steps of 2 mm and 5 mrad about it: a link moves so in 2 ms.
void moveOne(Row& row, Placement placement, int steps) {
  Random random(9);
  SolidPair pair = place(row.a.front(), row.b.front(), placement, random);
  const Eigen::Isometry3d step =
      Eigen::Translation3d(0.0, 0.0, 0.0) * Eigen::AngleAxisd(0.005, Eigen::Vector3d(0.4, -0.2, 0.9).normalized());
  for (int i = 0; i < steps; ++i) {
    row.pairs.push_back(pair);
    pair.a_T_b = step * pair.a_T_b * step;
    // a product of a thousand steps is no longer a rotation, which costs us a step of its own
    pair.a_T_b.linear() = Eigen::Quaterniond(pair.a_T_b.linear()).normalized().toRotationMatrix();
    pair.a_T_b.translation() += 0.002 * std::sin(0.05 * i) * Eigen::Vector3d::UnitX();
  }
  row.coherent = true;
}

struct Pairing {
  std::string name;
  Make make_a, make_b;
  int solids, pairs;
};

Make hullOf(int vertices) {
  return [vertices](Random& random) { return randomHull(random, vertices); };
}

std::vector<Pairing> pairings() {
  std::vector<Pairing> pairings = {{"sphere-box", randomSphere, randomBox, 20, 1000},
                                   {"capsule", randomCapsule, randomCapsule, 20, 1000},
                                   {"box", randomBox, randomBox, 20, 1000},
                                   {"cylinder", randomCylinder, randomCylinder, 20, 1000}};
  for (const int vertices : {8, 32, 200, 1000, 10000}) {
    const int solids = vertices == 10000 ? 2 : vertices == 1000 ? 10 : 20;
    const int pairs = vertices == 10000 ? 40 : vertices == 1000 ? 400 : 1000;
    pairings.push_back({"hull " + std::to_string(vertices), hullOf(vertices), hullOf(vertices), solids, pairs});
  }
  return pairings;
}

/// Fewer pairings, for what is asked in many ways.
std::vector<Pairing> fewPairings() {
  std::vector<Pairing> few;
  for (const Pairing& pairing : pairings())
    for (const char* name : {"box", "cylinder", "hull 32", "hull 200"})
      if (pairing.name == name) few.push_back(pairing);
  return few;
}

using NamedPlacement = std::pair<const char*, Placement>;
const NamedPlacement kPlacements[] = {{"apart", Placement::Apart},
                                      {"touching", Placement::Touching},
                                      {"shallow", Placement::Shallow},
                                      {"deep", Placement::Deep}};

Row rowOf(const Pairing& pairing, const std::string& name, Placement placement, int pairs) {
  Row row = solidsOf(name, pairing.make_a, pairing.make_b, pairing.solids);
  placeAll(row, placement, pairs);
  return row;
}

void measureInto(json& result, Row& row) {
  addTruth(row);
  append(result, measure(row, allLibraries(), kDefaultTolerance));
  showProgress();
}

json measureRows(const Wanted& wanted) {
  json result = json::array();
  for (const Pairing& pairing : pairings())
    for (const auto& [placement_name, placement] : kPlacements)
      for (const Question question : {Question::Distance, Question::Boolean}) {
        if (question == Question::Boolean && placement == Placement::Touching) continue;
        const std::string name = pairing.name + ", " + placement_name + (question == Question::Boolean ? "?" : "");
        if (!wanted(name)) continue;
        Row row = rowOf(pairing, name, placement, pairing.pairs);
        row.question = question;
        measureInto(result, row);
      }
  for (const Question question : {Question::Distance, Question::Boolean})
    for (const auto& [placement_name, placement] : {kPlacements[0], kPlacements[2], kPlacements[3]}) {
      const std::string name =
          std::string("hull 200, ") + placement_name + (question == Question::Boolean ? "?" : "") + ", coherent";
      if (!wanted(name)) continue;
      Row row = solidsOf(name, hullOf(200), hullOf(200), 1);
      row.question = question;
      moveOne(row, placement, 1000);
      measureInto(result, row);
    }
  return result;
}

/// Measures a few rows at each tolerance, for the libraries that take one.
json measureTolerances(const Wanted& wanted) {
  std::vector<Library> tunable;
  for (const Library& library : allLibraries())
    if (library.has_tolerance) tunable.push_back(library);
  json result = json::array();
  for (const Pairing& pairing : fewPairings())
    for (const auto& [placement_name, placement] : {kPlacements[0], kPlacements[3]}) {
      const std::string name = pairing.name + ", " + placement_name;
      if (!wanted(name)) continue;
      Row row = rowOf(pairing, name, placement, 200);
      addTruth(row);
      for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14})
        for (json entry : measure(row, tunable, tolerance)) {
          entry["tolerance"] = tolerance;
          result.push_back(entry);
        }
    }
  return result;
}

/// Measures how much ours saves if less is asked.
json measureQuestions(const Wanted& wanted) {
  json result = json::array();
  for (const Pairing& pairing : fewPairings())
    for (const auto& [placement_name, placement] : kPlacements) {
      const std::string name = pairing.name + ", " + placement_name;
      if (!wanted(name)) continue;
      for (const json& entry : measure(rowOf(pairing, name, placement, 400), oursAskedLess(), kDefaultTolerance))
        result.push_back({{"row", name}, {"question", entry["library"]}, {"ns", entry["ns"]}});
    }
  return result;
}

json supportTimes(const HullSupport& support, int vertices) {
  const ConvexHull& hull = support.hull();
  constexpr int kDirections = 512;
  Random random(5);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kDirections; ++i) directions.emplace_back(normal(random), normal(random), normal(random));
  const auto nsOf = [&](const auto& find) {
    std::vector<double> times;
    volatile int sink = 0;
    for (int round = 0; round < kRounds; ++round) {
      const double all = timeOf<std::nano>([&] {
        for (const Eigen::Vector3d& d : directions) sink = sink + find(d);
      });
      times.push_back(all / kDirections);
    }
    return medianOf(times);
  };
  const double ours = nsOf([&](const Eigen::Vector3d& d) { return support.farthestVertex(d); });
  const double scan = nsOf([&](const Eigen::Vector3d& d) {
    int best = 0;
    double farthest = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < hull.size(); ++i) {
      const double height = hull.vertices()[i].dot(d);
      if (height > farthest) farthest = height, best = i;
    }
    return best;
  });
  return {{"row", "support by vertices"}, {"library", "ours"}, {"vertices", vertices}, {"ns", ours}, {"scan_ns", scan}};
}

/// Measures the distance of two hulls, and their support mapping alone beside a plain scan, by the number of vertices.
json measureVertices(const Wanted& wanted) {
  json result = json::array();
  if (!wanted("vertices")) return result;
  for (const int count : {8, 16, 32, 64, 128, 256, 512, 1000, 3000, 10000, 30000, 100000}) {
    Row row = solidsOf("hulls by vertices", hullOf(count), hullOf(count), count > 10000 ? 1 : 4);
    placeAll(row, Placement::Apart, count > 1000 ? 40 : 400);
    for (json entry : measure(row, allLibraries(), kDefaultTolerance)) {
      entry["vertices"] = count;
      result.push_back(entry);
    }
    result.push_back(supportTimes(row.a.front().ours.hullSupport(), count));
    showProgress();
  }
  return result;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("narrowphase_benchmark",
                                                  "Time per query and error beside FCL, libccd and Bullet");
  return benchmarkMain(program, argc, argv, [](const Wanted& wanted) {
    return json{{"rows", measureRows(wanted)},
                {"tolerances", measureTolerances(wanted)},
                {"vertices", measureVertices(wanted)},
                {"questions", measureQuestions(wanted)}};
  });
}
