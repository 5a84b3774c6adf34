// Run time against error: the same pairs for ours, FCL, libccd and Bullet, interleaved round by round. The median of
// the rounds and the 99th percentile of the pairs go into a JSON file, with the error against the oracle of the tests.
// ./dev bench narrowphase runs it pinned.
#include <algorithm>
#include <chrono>
#include <deque>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>

#include "benchmark/benchmark_main.h"
#include "oracle/oracle.h"
#include "peers/libraries.h"
#include "peers/solids.h"

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace peers;
namespace {

using nlohmann::json;
using Make = std::function<Solid(Random&)>;
using Clock = std::chrono::steady_clock;

constexpr int kRounds = 9;
constexpr double kRoundNs = 4e6;         // of one library in one round, at most; fewer pairs where that takes longer
constexpr double kGrossError = 1e-3;     // [m] of solids of size 1: counted as a failure
constexpr double kOracleVertices = 4e4;  // the oracle's time grows with the vertices; so many, summed over its pairs

/// Pairs of one row, the same on every run.
struct Row {
  std::string name;
  Question question;
  bool coherent;  ///< the pairs are steps of one motion: warm starts and polytopes are kept
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

/// The answer to one pair, or nothing where the library throws or aborts.
std::optional<Answer> tryToAsk(const Library& library, const Row& row, const SolidPair& pair, double tolerance,
                               WarmStart& warm) {
  return answerOf([&] { return library.ask(pair, row.question, tolerance, warm); });
}

/// The pairs that a library answers at all: only they are timed.
std::vector<SolidPair> answeredBy(const Library& library, const Row& row, double tolerance) {
  std::vector<SolidPair> answered;
  for (const SolidPair& pair : row.pairs) {
    WarmStart cold;
    if (tryToAsk(library, row, pair, tolerance, cold)) answered.push_back(pair);
  }
  return answered;
}

/// Largest and mean error over the pairs with a known answer; a boolean that is wrong is an error of what it missed.
json errorsOf(const Library& library, const Row& row, double tolerance) {
  double largest = 0.0, sum = 0.0, iterations = 0.0;
  int failures = 0;
  WarmPolytope polytope;
  WarmStart warm;
  warm.polytope = &polytope;
  for (std::size_t i = 0; i < row.truth.size(); ++i) {
    if (!row.coherent) warm = {};
    const std::optional<Answer> answer = tryToAsk(library, row, row.pairs[i], tolerance, warm);
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

double nanoseconds(Clock::duration duration) { return std::chrono::duration<double, std::nano>(duration).count(); }

/// [ns] per query over the first `count` pairs.
double timeOf(const Library& library, const Row& row, const std::vector<SolidPair>& pairs, double tolerance,
              std::size_t count) {
  WarmPolytope polytope;
  WarmStart warm;
  warm.polytope = &polytope;
  volatile double sink = 0.0;
  const auto start = Clock::now();
  for (std::size_t i = 0; i < count; ++i) {
    if (!row.coherent) warm = {};
    sink = sink + library.ask(pairs[i], row.question, tolerance, warm).distance;
  }
  return nanoseconds(Clock::now() - start) / static_cast<double>(count);
}

double percentileOf(std::vector<double> values, double part) {
  const auto place = static_cast<std::size_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place), values.end());
  return values[place];
}

double medianOf(const std::vector<double>& values) { return percentileOf(values, 0.5); }

/// [ns] What it takes to read the clock, which is part of each query that is timed by itself.
double clockTime() {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) {
    const auto start = Clock::now();
    times.push_back(nanoseconds(Clock::now() - start));
  }
  return medianOf(times);
}

/// [ns] The 99th percentile over the first `count` pairs, each timed by itself: its median over the rounds counts.
double slowestOf(const Library& library, const Row& row, const std::vector<SolidPair>& pairs, double tolerance,
                 std::size_t count) {
  std::vector<std::vector<double>> of_pair(count);
  volatile double sink = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    WarmPolytope polytope;
    WarmStart warm;
    warm.polytope = &polytope;
    for (std::size_t i = 0; i < count; ++i) {
      if (!row.coherent) warm = {};
      const auto start = Clock::now();
      sink = sink + library.ask(pairs[i], row.question, tolerance, warm).distance;
      of_pair[i].push_back(nanoseconds(Clock::now() - start));
    }
  }
  std::vector<double> medians;
  for (const std::vector<double>& times : of_pair) medians.push_back(medianOf(times));
  return std::max(percentileOf(medians, 0.99) - clockTime(), 0.0);
}

/// One library on one row.
struct Run {
  const Library* library;
  std::vector<SolidPair> pairs;
  std::size_t count;  ///< of pairs in a round
  std::vector<double> ns;
};

/// One entry a library: median time, and errors.
json measure(const Row& row, const std::vector<Library>& libraries, double tolerance) {
  std::vector<Run> runs;
  for (const Library& library : libraries) {
    if (!library.answers(row.question, row.pairs.front().placement != Placement::Apart)) continue;
    Run run{&library, answeredBy(library, row, tolerance), 0, {}};
    if (run.pairs.empty()) continue;
    const std::size_t few = std::min<std::size_t>(run.pairs.size(), 20);
    const double ns = timeOf(library, row, run.pairs, tolerance, few);
    run.count = std::clamp(static_cast<std::size_t>(kRoundNs / ns), few, run.pairs.size());
    runs.push_back(run);
  }
  for (int round = 0; round < kRounds; ++round)
    for (Run& run : runs) run.ns.push_back(timeOf(*run.library, row, run.pairs, tolerance, run.count));
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
  Row row{name, Question::Distance, false, {}, {}, {}, {}};
  Random random(7);
  for (int i = 0; i < solids; ++i) {
    row.a.push_back(make_a(random));
    row.b.push_back(make_b(random));
  }
  return row;
}

/// Random pairs of every solid with every other, in one placement.
void placeAll(Row& row, Placement placement, int pairs) {
  Random random(8);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs); ++i)
    row.pairs.push_back(place(row.a[i % row.a.size()], row.b[i / row.a.size() % row.b.size()], placement, random));
}

/// One pair in steps of 2 mm and 5 mrad about it: what a moving link does in 2 ms.
void moveOne(Row& row, Placement placement, int steps) {
  Random random(9);
  SolidPair pair = place(row.a.front(), row.b.front(), placement, random);
  const Eigen::Isometry3d step =
      Eigen::Translation3d(0.0, 0.0, 0.0) * Eigen::AngleAxisd(0.005, Eigen::Vector3d(0.4, -0.2, 0.9).normalized());
  for (int i = 0; i < steps; ++i) {
    row.pairs.push_back(pair);
    pair.a_T_b = step * pair.a_T_b * step;
    pair.a_T_b.translation() += 0.002 * std::sin(0.05 * i) * Eigen::Vector3d::UnitX();
  }
  row.coherent = true;
}

struct Pairing {
  std::string name;
  Make a, b;
  int solids, pairs;
};

Make hullOf(int vertices) {
  return [vertices](Random& random) { return randomHull(random, vertices); };
}

std::vector<Pairing> pairings() {
  return {{"sphere-box", randomSphere, randomBox, 20, 1000},
          {"capsule", randomCapsule, randomCapsule, 20, 1000},
          {"box", randomBox, randomBox, 20, 1000},
          {"cylinder", randomCylinder, randomCylinder, 20, 1000},
          {"hull 8", hullOf(8), hullOf(8), 20, 1000},
          {"hull 32", hullOf(32), hullOf(32), 20, 1000},
          {"hull 200", hullOf(200), hullOf(200), 20, 1000},
          {"hull 1000", hullOf(1000), hullOf(1000), 10, 400},
          {"hull 10000", hullOf(10000), hullOf(10000), 2, 40}};
}

const std::vector<std::pair<std::string, Placement>> kPlacements = {{"apart", Placement::Apart},
                                                                    {"touching", Placement::Touching},
                                                                    {"shallow", Placement::Shallow},
                                                                    {"deep", Placement::Deep}};

/// The rows whose name matches, made and measured one after the other.
class Suite {
 public:
  Suite(std::regex wanted, std::vector<Library> libraries)
      : wanted_(std::move(wanted)), libraries_(std::move(libraries)) {}

  json rows() const {
    json result = json::array();
    for (const Pairing& p : pairings())
      for (const auto& [placement_name, placement] : kPlacements) {
        addRow(result, p, p.name + ", " + placement_name, Question::Distance, placement);
        if (placement != Placement::Touching)
          addRow(result, p, p.name + ", " + placement_name + "?", Question::Boolean, placement);
      }
    for (const Question question : {Question::Distance, Question::Boolean})
      for (const auto& [placement_name, placement] : {kPlacements[0], kPlacements[2], kPlacements[3]}) {
        const std::string name =
            "hull 200, " + placement_name + (question == Question::Boolean ? "?" : "") + ", coherent";
        if (!std::regex_search(name, wanted_)) continue;
        Row row = solidsOf(name, hullOf(200), hullOf(200), 1);
        row.question = question;
        moveOne(row, placement, 1000);
        add(result, row, kDefaultTolerance);
      }
    return result;
  }

  /// A few rows at each tolerance, for the libraries that take one.
  json tolerances() const {
    json result = json::array();
    for (const Pairing& p : pairings())
      for (const auto& [placement_name, placement] : {kPlacements[0], kPlacements[3]}) {
        const std::string name = p.name + ", " + placement_name;
        if (!std::regex_search(name, wanted_)) continue;
        if (p.name != "box" && p.name != "cylinder" && p.name != "hull 32" && p.name != "hull 200") continue;
        Row row = solidsOf(name, p.a, p.b, p.solids);
        placeAll(row, placement, 200);
        addTruth(row);
        for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14}) {
          std::vector<Library> tunable;
          for (const Library& library : libraries_)
            if (library.has_tolerance) tunable.push_back(library);
          for (json entry : measure(row, tunable, tolerance)) {
            entry["tolerance"] = tolerance;
            result.push_back(entry);
          }
        }
      }
    return result;
  }

  /// What ours saves where less is asked.
  json questions() const {
    json result = json::array();
    for (const Pairing& p : pairings())
      for (const auto& [placement_name, placement] : kPlacements) {
        const std::string name = p.name + ", " + placement_name;
        if (!std::regex_search(name, wanted_)) continue;
        if (p.name != "box" && p.name != "cylinder" && p.name != "hull 32" && p.name != "hull 200") continue;
        Row row = solidsOf(name, p.a, p.b, p.solids);
        placeAll(row, placement, 400);
        for (const json& entry : measure(row, oursAskedLess(), kDefaultTolerance))
          result.push_back({{"row", name}, {"question", entry["library"]}, {"ns", entry["ns"]}});
      }
    return result;
  }

  /// Distance of two hulls, and their support mapping alone beside a plain scan, by the number of vertices.
  json vertices() const {
    json result = json::array();
    if (!std::regex_search("vertices", wanted_)) return result;
    for (const int count : {8, 16, 32, 64, 128, 256, 512, 1000, 3000, 10000, 30000, 100000}) {
      Row row = solidsOf("hulls by vertices", hullOf(count), hullOf(count), count > 10000 ? 1 : 4);
      placeAll(row, Placement::Apart, count > 1000 ? 40 : 400);
      for (json entry : measure(row, libraries_, kDefaultTolerance)) {
        entry["vertices"] = count;
        result.push_back(entry);
      }
      result.push_back(supportTimes(row.a.front().ours.hullSupport(), count));
      std::cerr << "." << std::flush;
    }
    std::cerr << "\n";
    return result;
  }

 private:
  void addRow(json& result, const Pairing& p, const std::string& name, Question question, Placement placement) const {
    if (!std::regex_search(name, wanted_)) return;
    Row row = solidsOf(name, p.a, p.b, p.solids);
    row.question = question;
    placeAll(row, placement, p.pairs);
    add(result, row, kDefaultTolerance);
  }

  void add(json& result, Row& row, double tolerance) const {
    addTruth(row);
    for (const json& entry : measure(row, libraries_, tolerance)) result.push_back(entry);
    std::cerr << "." << std::flush;
  }

  static json supportTimes(const HullSupport& support, int vertices) {
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
        const auto start = Clock::now();
        for (const Eigen::Vector3d& d : directions) sink = sink + find(d);
        times.push_back(nanoseconds(Clock::now() - start) / kDirections);
      }
      return medianOf(times);
    };
    const double ours = nsOf([&](const Eigen::Vector3d& d) { return support.farthestVertex(d); });
    const double scan = nsOf([&](const Eigen::Vector3d& d) {
      int best = 0;
      double farthest = -std::numeric_limits<double>::infinity();
      for (int i = 0; i < hull.size(); ++i) {
        const double height = hull.vertices()[static_cast<std::size_t>(i)].dot(d);
        if (height > farthest) farthest = height, best = i;
      }
      return best;
    });
    return {
        {"row", "support by vertices"}, {"library", "ours"}, {"vertices", vertices}, {"ns", ours}, {"scan_ns", scan}};
  }

  std::regex wanted_;
  std::vector<Library> libraries_;
};

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  CLI::App app{"Time per query and error beside FCL, libccd and Bullet"};
  return benchmarkMain(app, argc, argv, [](const std::regex& wanted) {
    const Suite suite(wanted, allLibraries());
    return json{{"rows", suite.rows()},
                {"tolerances", suite.tolerances()},
                {"vertices", suite.vertices()},
                {"questions", suite.questions()}};
  });
}
