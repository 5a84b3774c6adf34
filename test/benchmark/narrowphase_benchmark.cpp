// Signed distance with witness points of two solids: ours beside FCL (libccd solver) and Bullet, the same pairs for
// all. Names are solids/placement/library. ./dev bench runs it interleaved on one core and shows the medians.
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <benchmark/benchmark.h>
#include <fcl/narrowphase/distance.h>

#include <deque>
#include <functional>
#include <string>

#include "benchmark/solids.h"
#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server {
namespace {

constexpr int kSolids = 20;
constexpr int kPairs = 2000;

using Make = std::function<Solid(Random&)>;

/// Random pairs of one row, the same on every run.
struct Row {
  std::string name;
  std::deque<Solid> a, b;
  std::vector<SolidPair> pairs;
};

Row makeRow(const std::string& name, const Make& make_a, const Make& make_b, Placement placement) {
  Row row{name, {}, {}, {}};
  Random random(7);
  for (int i = 0; i < kSolids; ++i) {
    row.a.push_back(make_a(random));
    row.b.push_back(make_b(random));
  }
  for (std::size_t i = 0; i < kPairs; ++i) {
    row.pairs.push_back(place(row.a[i % kSolids], row.b[i / kSolids % kSolids], placement, random));
  }
  return row;
}

struct Ours {
  static constexpr const char* kName = "ours";
  explicit Ours(const SolidPair& pair) : pair_(pair) {}
  double operator()() const { return signedDistance(pair_.a->ours, pair_.b->ours, pair_.a_T_b).distance; }

 private:
  SolidPair pair_;
};

struct Fcl {
  static constexpr const char* kName = "fcl";
  explicit Fcl(const SolidPair& pair) : pair_(pair) {}
  double operator()() const {
    // Asked for the depth, FCL leaves its closed forms; so it is asked where there is one only.
    fcl::DistanceRequestd request;
    request.enable_nearest_points = true;
    request.enable_signed_distance = pair_.placement != Placement::Apart;
    request.gjk_solver_type = fcl::GST_LIBCCD;
    fcl::DistanceResultd result;
    return fcl::distance(pair_.a->fcl.get(), fcl::Transform3d::Identity(), pair_.b->fcl.get(), pair_.a_T_b, request,
                         result);
  }

 private:
  SolidPair pair_;
};

struct Bullet {
  static constexpr const char* kName = "bullet";
  explicit Bullet(const SolidPair& pair) : a_(pair.a->bullet.get()), b_(pair.b->bullet.get()) {
    input_.m_transformA.setIdentity();
    const Eigen::Matrix<btScalar, 4, 4> pose = pair.a_T_b.matrix().cast<btScalar>();
    input_.m_transformB.setFromOpenGLMatrix(pose.data());
  }
  double operator()() const {
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver epa;
    btGjkPairDetector detector(a_, b_, &simplex, &epa);
    btPointCollector result;
    detector.getClosestPoints(input_, result, nullptr);
    return static_cast<double>(result.m_distance);
  }

 private:
  const btConvexShape* a_;
  const btConvexShape* b_;
  btGjkPairDetector::ClosestPointInput input_;
};

template <typename Library>
void registerRow(const Row& row) {
  benchmark::RegisterBenchmark((row.name + "/" + Library::kName).c_str(), [&row](benchmark::State& state) {
    const std::vector<Library> queries(row.pairs.begin(), row.pairs.end());
    std::size_t i = 0, exceptions = 0;
    for (auto iteration : state) {
      try {
        benchmark::DoNotOptimize(queries[i]());
      } catch (const std::exception&) {
        ++exceptions;
      }
      if (++i == queries.size()) i = 0;
    }
    if (exceptions > 0) state.counters["exceptions"] = static_cast<double>(exceptions);
  });
}

std::deque<Row> makeRows() {
  const auto hull = [](int vertices) { return [vertices](Random& random) { return randomHull(random, vertices); }; };
  std::deque<Row> rows;
  const auto add = [&](const std::string& name, const Make& a, const Make& b) {
    rows.push_back(makeRow(name + "/apart", a, b, Placement::Apart));
    rows.push_back(makeRow(name + "/shallow", a, b, Placement::Shallow));
    rows.push_back(makeRow(name + "/deep", a, b, Placement::Deep));
  };
  add("box", randomBox, randomBox);
  add("capsule", randomCapsule, randomCapsule);
  add("sphere-box", randomSphere, randomBox);
  add("cylinder", randomCylinder, randomCylinder);
  add("hull32", hull(32), hull(32));
  add("hull200", hull(200), hull(200));
  add("hull1000", hull(1000), hull(1000));
  return rows;
}

}  // namespace
}  // namespace proximity_server

int main(int argc, char** argv) {
  using namespace proximity_server;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  const std::deque<Row> rows = makeRows();
  for (const Row& row : rows) {
    registerRow<Ours>(row);
    registerRow<Fcl>(row);
    registerRow<Bullet>(row);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
