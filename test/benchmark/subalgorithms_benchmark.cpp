// The distance subalgorithms inside of one GJK loop, and alone on the simplices that such a loop meets.
#include "benchmark/benchmark_main.h"
#include "benchmark/subalgorithms.h"
#include "benchmark/timing.h"
#include "chance.h"
#include "oracle/exact_oracle.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <string>
#include <vector>

namespace proximity_server::benchmark {

using namespace narrowphase;
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Subalgorithm = NearestInSet (*)(const PointSet&);

struct NamedAlgorithm {
  const char* name;
  Subalgorithm nearest;
};

constexpr NamedAlgorithm kAlgorithms[] = {{"johnson", nearestByJohnson},
                                          {"explicit solve", nearestByExplicitSolve},
                                          {"voronoi regions", nearestByVoronoiRegions},
                                          {"signed volumes", nearestBySignedVolumes}};

// ---- pairs of hulls

struct HullPair {
  Points a, b;
  double truth = 0.0;  ///< [m] exact distance
  double scale = 1.0;  ///< [m] of ShapePair
};

struct Family {
  std::string name;
  std::vector<HullPair> pairs;
};

HullPair withTruth(const Shape& a, const Shape& b) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  const ShapePair pair{a, b, identity};
  const ExactDistance exact = exactDistance(pair);
  const double truth = exact.overlap ? 0.0 : static_cast<double>(exact.withMargins(pair));
  return {a.hull().vertices(), b.hull().vertices(), truth, pair.scale()};
}

/// Returns 16 points on an ellipsoid, each repeated `offset` away if that is not 0.
Points cloud(Chance& random, const Vector3d& half_axes, double offset) {
  Points points;
  for (int i = 0; i < 16; ++i) {
    points.push_back(half_axes.cwiseProduct(randomDirection(random)));
    if (offset > 0.0) points.push_back(points.back() + offset * randomDirection(random));
  }
  return points;
}

struct Recipe {
  std::string name;
  Vector3d half_axes;
  double duplicates;  ///< [m] how far each vertex's near-duplicate lies; 0: none
  double gap;         ///< [m]
};

Family makeFamily(const Recipe& recipe) {
  Chance random(91);
  Family family{recipe.name, {}};
  while (family.pairs.size() < 500) {
    const Shape a = ConvexHull(cloud(random, recipe.half_axes, recipe.duplicates));
    const Points local = cloud(random, recipe.half_axes, recipe.duplicates);
    Eigen::Isometry3d pose = randomPose(random, 2.0);
    const SignedDistance now = signedDistance(a, ConvexHull(local), pose);
    pose.pretranslate((recipe.gap - now.distance) * now.normal);
    Points b;
    for (const Vector3d& p : local) b.push_back(pose * p);
    const HullPair pair = withTruth(a, ConvexHull(b));
    if (pair.truth > 0.0) family.pairs.push_back(pair);
  }
  return family;
}

std::vector<Recipe> recipes() {
  const Vector3d round(0.5, 0.4, 0.3);
  return {{"ordinary", round, 0.0, 0.3},
          {"touching", round, 0.0, 1e-10},
          {"far", round, 0.0, 1e4},
          {"flat", {0.5, 0.4, 1e-6}, 0.0, 0.01},
          {"slivers", {0.5, 1e-5, 1e-5}, 0.0, 0.01},
          {"near-duplicates", round, 1e-9, 0.01}};
}

// ---- one GJK loop for all

const Vector3d& farthest(const Points& points, const Vector3d& direction) {
  return *std::max_element(points.begin(), points.end(),
                           [&](const Vector3d& p, const Vector3d& q) { return p.dot(direction) < q.dot(direction); });
}

void keepMembers(PointSet& set, unsigned members) {
  int kept = 0;
  for (int i = 0; i < set.size; ++i)
    if ((members >> i & 1u) != 0) set.points[kept++] = set.points[i];
  set.size = kept;
}

struct GjkRun {
  double distance = 0.0;
  int iterations = 0;
};

/// Ends when the bounds meet within rounding, or when a vertex brings no progress.
/// `visit` sees every simplex before it is reduced.
template <typename Visit>
GjkRun gjk(const HullPair& pair, Subalgorithm subalgorithm, const Visit& visit) {
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * pair.scale;
  PointSet set;
  GjkRun run{std::numeric_limits<double>::infinity(), 0};
  Vector3d v = pair.a.front() - pair.b.front();
  for (run.iterations = 1; run.iterations < 100; ++run.iterations) {
    const Vector3d w = farthest(pair.a, -v) - farthest(pair.b, v);
    if (run.distance - v.dot(w) / v.norm() <= rounding) break;
    set.points[set.size++] = w;
    visit(set);
    const NearestInSet nearest = subalgorithm(set);
    const double distance = nearest.point.norm();
    if (!(distance < run.distance)) break;
    run.distance = distance;
    v = nearest.point;
    keepMembers(set, nearest.members);
    if (set.size == 4 || distance <= rounding) break;
  }
  return run;
}

// ---- what is measured

/// Returns the simplices that the loop meets with the explicit solve.
std::vector<PointSet> recordedSimplices(const Family& family) {
  std::vector<PointSet> sets;
  for (const HullPair& pair : family.pairs)
    gjk(pair, nearestByExplicitSolve, [&](const PointSet& set) { sets.push_back(set); });
  return sets;
}

double errorOn(const PointSet& set, Subalgorithm subalgorithm) {
  const long double truth = exactDistanceToOrigin({set.points.begin(), set.points.begin() + set.size});
  double largest = 0.0;
  for (int i = 0; i < set.size; ++i) largest = std::max(largest, set.points[i].norm());
  const double error = static_cast<double>(std::abs(subalgorithm(set).point.norm() - truth)) / largest;
  return std::isfinite(error) ? error : std::numeric_limits<double>::max();
}

/// Returns the processor time of one pass over the sets [ns per set]: other work of the core does not count.
double passTime(const std::vector<PointSet>& sets, Subalgorithm subalgorithm) {
  constexpr int kRepeats = 10;
  Vector3d sum = Vector3d::Zero();
  const std::clock_t start = std::clock();
  for (int repeat = 0; repeat < kRepeats; ++repeat)
    for (const PointSet& set : sets) sum += subalgorithm(set).point;
  const std::clock_t end = std::clock();
  volatile double sink = sum.sum();  // else the compiler would leave the loop out
  static_cast<void>(sink);
  return 1e9 * static_cast<double>(end - start) / CLOCKS_PER_SEC / (kRepeats * static_cast<double>(sets.size()));
}

/// Returns the medians of passes of all algorithms that take turns, as the machine drifts.
std::vector<double> medianTimes(const std::vector<PointSet>& sets) {
  Rounds times(std::size(kAlgorithms));
  for (int pass = 0; pass < 21; ++pass)
    for (std::size_t i = 0; i < std::size(kAlgorithms); ++i) times.add(i, passTime(sets, kAlgorithms[i].nearest));
  return times.medians();
}

/// failures: of GJK, runs that end farther than 1e-9 of the scale from the truth.
nlohmann::json runsOfGjk(const Family& family, Subalgorithm subalgorithm) {
  int iterations = 0, failures = 0;
  for (const HullPair& pair : family.pairs) {
    const GjkRun run = gjk(pair, subalgorithm, [](const PointSet&) {});
    iterations += run.iterations;
    if (!(std::abs(run.distance - pair.truth) <= 1e-9 * pair.scale)) ++failures;
  }
  return {{"failures", failures},
          {"mean_iterations", static_cast<double>(iterations) / static_cast<double>(family.pairs.size())}};
}

/// max_error: of the distance, over the largest norm of a vertex.
nlohmann::json rowsOf(const Family& family) {
  const std::vector<PointSet> sets = recordedSimplices(family);
  const std::vector<double> times = medianTimes(sets);
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto& [name, nearest] = kAlgorithms[i];
    double max_error = 0.0;
    for (const PointSet& set : sets) max_error = std::max(max_error, errorOn(set, nearest));
    nlohmann::json row = runsOfGjk(family, nearest);
    row.update({{"algorithm", name}, {"simplices", family.name}, {"ns", times[i]}, {"max_error", max_error}});
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json measure(const Wanted& wanted) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Recipe& recipe : recipes())
    if (wanted(recipe.name)) append(rows, rowsOf(makeFamily(recipe)));
  return {{"subalgorithms", rows}};
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("subalgorithms_benchmark",
                                                  "Ways to find the nearest point of a simplex");
  return benchmarkMain(program, argc, argv, measure);
}
