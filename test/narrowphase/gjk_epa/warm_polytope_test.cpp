#include "narrowphase/cso/observer.h"
#include "narrowphase/cso/polytope.h"
#include "narrowphase/cso/two_cores.h"
#include "proximity_server/narrowphase/cso/query_trace.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::warm_polytope_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Face = Polytope::Face;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// A cube of 2 m as a hull: the closed form of two boxes does not apply to it.
Shape cubeHull() {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return hullOf(corners);
}

/// The CSO of a hull and a point at the origin of b is the hull itself, moved by minus the offset.
TwoCores cubeAbout(const Vector3d& origin) { return {cubeHull(), pointAt({0, 0, 0}), origin}; }

std::unique_ptr<Polytope> empty(const Cso& cso) { return std::make_unique<Polytope>(cso.rounding()); }

std::vector<double> distancesOf(const Polytope& polytope) {
  std::vector<double> distances;
  polytope.forEachFace([&](const Face& face) { distances.push_back(face.distance()); });
  std::sort(distances.begin(), distances.end());
  return distances;
}

/// A tetrahedron of four corners of the cube that do not share an edge: its faces are 1/sqrt(3) m from the centre.
std::unique_ptr<Polytope> tetrahedronIn(TwoCores& cores) {
  std::array<CsoVertex, 4> corners;
  const std::array<Vector3d, 4> directions{Vector3d(1, 1, 1), {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  for (std::size_t i = 0; i < 4; ++i) corners[i] = cores.cso.vertex(directions[i]);
  return std::make_unique<Polytope>(corners, cores.cso.rounding());
}

WarmPolytope keptTetrahedron() {
  TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope kept;
  tetrahedronIn(cores)->keep(kept);
  return kept;
}

TEST(WarmPolytope, IsKeptAndRecalledInAnotherPose) {
  const WarmPolytope kept = keptTetrahedron();
  ASSERT_EQ(kept.face_count, 4);
  ASSERT_EQ(kept.vertex_count, 4);
  const Vector3d origin(0.1, 0.2, 0.05);
  const TwoCores cores = cubeAbout(origin);
  const auto polytope = empty(cores.cso);
  ASSERT_TRUE(polytope->recall(kept, cores.cso, kUnlimited));
  EXPECT_EQ(polytope->checkTopology(), "");
  // The outer normals are (-1, -1, -1), (-1, 1, 1), (1, -1, 1) and (1, 1, -1), by sqrt(3).
  const std::vector<double> expected{(1.0 - 0.25) / std::sqrt(3.0), (1.0 - 0.15) / std::sqrt(3.0),
                                     (1.0 + 0.05) / std::sqrt(3.0), (1.0 + 0.35) / std::sqrt(3.0)};
  const std::vector<double> distances = distancesOf(*polytope);
  ASSERT_EQ(distances.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(distances[i], expected[i], 1e-15);
  EXPECT_NEAR(polytope->closest()->distance(), expected[0], 1e-15);
  EXPECT_TRUE(polytope->surroundsOrigin(expected[0]));
}

TEST(WarmPolytope, DoesNotAskForRecalledFacesBeyondTheCeiling) {
  const TwoCores cores = cubeAbout({0.1, 0.2, 0.05});
  const auto polytope = empty(cores.cso);
  ASSERT_TRUE(polytope->recall(keptTetrahedron(), cores.cso, 0.45));
  polytope->setAside(*polytope->closest());
  EXPECT_EQ(polytope->closest(), nullptr);
}

TEST(WarmPolytope, IsNotRecalledAroundAnOriginOutside) {
  const TwoCores cores = cubeAbout({-0.9, -0.9, -0.9});
  EXPECT_FALSE(empty(cores.cso)->recall(keptTetrahedron(), cores.cso, kUnlimited));
}

// The plane of one face is x + y + z = -1.
TEST(WarmPolytope, DoesNotSurroundAnOriginWithinRoundingOfAFace) {
  const auto surrounds = [](double roundings) {
    TwoCores cores = cubeAbout({-1.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0});
    const double rounding = 1e-6;
    cores.a_T_b.translation().array() += roundings * rounding / std::sqrt(3.0);
    Polytope polytope(rounding);
    return polytope.recall(keptTetrahedron(), cores.cso, kUnlimited) &&
           polytope.surroundsOrigin(polytope.closest()->distance());
  };
  EXPECT_TRUE(surrounds(100.0));
  EXPECT_FALSE(surrounds(1.5));
  EXPECT_FALSE(surrounds(0.5));
  EXPECT_FALSE(surrounds(-0.5));

  const TwoCores cores = cubeAbout({0, 0, 0});
  const auto polytope = empty(cores.cso);
  ASSERT_TRUE(polytope->recall(keptTetrahedron(), cores.cso, kUnlimited));
  EXPECT_FALSE(polytope->surroundsOrigin(2.0 * cores.cso.rounding()));
  EXPECT_TRUE(polytope->surroundsOrigin(3.0 * cores.cso.rounding()));
}

// A face of the cone may be narrower than rounding if w lies far out, nearly on the line of an edge of the horizon:
// here 5 roundings below the face that stays, whose normal is (1, -1, 1), on the line through the corners (1, 1, 1) and
// (1, -1, -1).
TEST(WarmPolytope, SurroundsNothingForCertainOnceItHasAFaceWithoutNormal) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  const double rounding = 1e-3;
  const Vector3d beyond = Vector3d(1, -1, -1) + 1e3 * Vector3d(0, -1, -1);
  for (const double below : {5.0, 5e5}) {
    const auto polytope = std::make_unique<Polytope>(rounding);
    ASSERT_TRUE(polytope->recall(keptTetrahedron(), cores.cso, kUnlimited));
    const Face* seen = nullptr;
    polytope->forEachFace([&](const Face& face) { seen = face.normal().dot(Vector3d(1, 1, -1)) > 1.7 ? &face : seen; });
    const Vector3d w = beyond - below * rounding * Vector3d(1, -1, 1).normalized();
    ASSERT_TRUE(polytope->expand(*seen, vertexAt(w), kUnlimited));
    EXPECT_EQ(polytope->surroundsOrigin(1.0), below > 5.0);
  }
}

// Each number is replaced by others, so that an edge loses its twin or a number leaves its range.
TEST(WarmPolytope, IsNotRecalledIfItIsNotClosed) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  const WarmPolytope kept = keptTetrahedron();
  int wrong = 0;
  const auto expectRefused = [&](const WarmPolytope& changed) {
    EXPECT_FALSE(empty(cores.cso)->recall(changed, cores.cso, kUnlimited));
    ++wrong;
  };
  for (int f = 0; f < 4; ++f)
    for (int i = 0; i < 3; ++i)
      for (const int value : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 400, 65535}) {
        WarmPolytope changed = kept;
        changed.faces[f].vertices[i] = static_cast<std::uint16_t>(value);
        if (changed.faces[f].vertices != kept.faces[f].vertices) expectRefused(changed);
        changed = kept;
        changed.faces[f].twins[i] = static_cast<std::uint16_t>(value);
        if (changed.faces[f].twins != kept.faces[f].twins) expectRefused(changed);
      }
  for (const int count : {-1, 0, 2, 3, 5, 1000000}) {
    WarmPolytope changed = kept;
    changed.face_count = count;
    expectRefused(changed);
    changed = kept;
    changed.vertex_count = count;
    if (count < 4 || count > 1000) expectRefused(changed);
  }
  EXPECT_GT(wrong, 300);
}

// The corner of one face is another vertex at the same place, so that only the numbers tell that two edges are open.
TEST(WarmPolytope, IsNotRecalledIfTwoEdgesDoNotShareTheirVertices) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  for (int f = 0; f < 4; ++f)
    for (int i = 0; i < 3; ++i) {
      WarmPolytope open = keptTetrahedron();
      open.vertex_count = 5;
      open.vertices[4] = open.vertices[open.faces[f].vertices[i]];
      open.faces[f].vertices[i] = 4;
      EXPECT_FALSE(empty(cores.cso)->recall(open, cores.cso, kUnlimited));
    }
}

TEST(WarmPolytope, IsNotRecalledIfAnEdgeIsTheTwinOfTwo) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope doubled = keptTetrahedron();
  doubled.face_count = 6;
  doubled.faces[4] = doubled.faces[5] = doubled.faces[0];
  EXPECT_FALSE(empty(cores.cso)->recall(doubled, cores.cso, kUnlimited));
}

TEST(WarmPolytope, IsNotRecalledIfItsNumbersReachBeyondItsCounts) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope kept = keptTetrahedron();
  for (int f = 0; f < 4; ++f)
    for (std::uint16_t& v : kept.faces[f].vertices) v = v == 3 ? 5 : v;
  kept.vertices[5] = kept.vertices[4] = kept.vertices[3];
  EXPECT_FALSE(empty(cores.cso)->recall(kept, cores.cso, kUnlimited));
  kept.vertex_count = 6;
  EXPECT_TRUE(empty(cores.cso)->recall(kept, cores.cso, kUnlimited));

  // Two tetrahedra, each with its last face behind the first six.
  const WarmPolytope single = keptTetrahedron();
  WarmPolytope twice = single;
  const std::array<std::array<int, 4>, 2> places{{{0, 1, 2, 6}, {3, 4, 5, 7}}};
  for (int copy = 0; copy < 2; ++copy)
    for (int f = 0; f < 4; ++f) {
      const int place = places[copy][f];
      for (int i = 0; i < 3; ++i) {
        const int vertex = single.faces[f].vertices[i], twin = single.faces[f].twins[i];
        twice.vertices[4 * copy + vertex] = single.vertices[vertex];
        twice.faces[place].vertices[i] = static_cast<std::uint16_t>(4 * copy + vertex);
        twice.faces[place].twins[i] = static_cast<std::uint16_t>(4 * places[copy][twin / 4] + twin % 4);
      }
    }
  twice.vertex_count = 8;
  twice.face_count = 6;
  EXPECT_FALSE(empty(cores.cso)->recall(twice, cores.cso, kUnlimited));
  twice.face_count = 8;
  EXPECT_TRUE(empty(cores.cso)->recall(twice, cores.cso, kUnlimited));

  // On four vertices both are closed, but a polytope that begins so may grow beyond its storage.
  for (WarmPolytope::Triangle& face : twice.faces)
    for (std::uint16_t& v : face.vertices) v = static_cast<std::uint16_t>(v % 4);
  twice.vertex_count = 4;
  EXPECT_FALSE(empty(cores.cso)->recall(twice, cores.cso, kUnlimited));
}

// With this rounding the determinants of the corners are 4 m^3, with an error of 6.4 m^3 or 0.64 m^3.
TEST(WarmPolytope, IsNotRecalledIfRoundingMayTurnAFace) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  EXPECT_FALSE(std::make_unique<Polytope>(0.1)->recall(keptTetrahedron(), cores.cso, kUnlimited));
  EXPECT_TRUE(std::make_unique<Polytope>(0.01)->recall(keptTetrahedron(), cores.cso, kUnlimited));
}

// All triangles in the opposite order: closed, but its outer sides look inwards.
TEST(WarmPolytope, IsNotRecalledInsideOut) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope turned = keptTetrahedron();
  for (int v = 0; v < 4; ++v) turned.vertices[v] = {7 - turned.vertices[v].a, turned.vertices[v].b};
  EXPECT_FALSE(empty(cores.cso)->recall(turned, cores.cso, kUnlimited));
}

// Two triangles with the same corners, one in the opposite order, are closed and do not surround anything.
TEST(WarmPolytope, IsNotRecalledIfItHasNoVolume) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope flat = keptTetrahedron();
  flat.vertices[3] = flat.vertices[2];
  EXPECT_FALSE(empty(cores.cso)->recall(flat, cores.cso, kUnlimited));
}

// Numbers of a larger hull are no numbers of the cube.
TEST(WarmPolytope, MayComeFromOtherShapes) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  WarmPolytope kept = keptTetrahedron();
  for (const int number : {8, 1000, -1, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
    for (WarmStart::Pair& pair : kept.vertices) pair = {number, number};
    EXPECT_FALSE(empty(cores.cso)->recall(kept, cores.cso, kUnlimited));
  }
}

// The vertex w is in the hull here, and the face that it lies above is the closest.
TEST(WarmPolytope, IsGivenUpWhereAFaceLosesItsNormal) {
  const double rounding = 1e-3;
  for (const double below : {5.0, 5e5}) {
    const Vector3d beyond = Vector3d(1, -1, -1) + 1e3 * Vector3d(0, -1, -1);
    const Vector3d w = beyond - below * rounding * Vector3d(1, -1, 1).normalized();
    const Shape hull = hullOf({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, w});
    TwoCores cores(hull, pointAt({0, 0, 0}), Vector3d(0.2, 0.2, -0.2));
    std::array<CsoVertex, 4> corners;
    for (int i = 0, count = 0; i < 5; ++i) {
      const CsoVertex vertex = cores.cso.recalled({i, 0});
      if (vertex.on_a.norm() < 2.0) corners[count++] = vertex;
    }
    WarmPolytope memory;
    Polytope(corners, cores.cso.rounding()).keep(memory);
    cores.warm_start.polytope = &memory;
    Options options;
    options.distance_tolerance = 3.2 * rounding;
    Cso cso(cores.a, cores.b, cores.a_T_b, rounding, cores.warm_start);
    const Vector3d normal(0.0, 0.6, -0.8);
    const bool is_answered = epaRecalled(cso, normal, cso.vertex(normal), options, {}).has_value();
    EXPECT_EQ(is_answered, below > 5.0);
    EXPECT_EQ(memory.face_count > 0, is_answered);
  }
}

/// A hull of points all over the unit sphere.
Shape roundHull(int count) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, radius = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * i;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return hullOf(points);
}

TEST(WarmPolytope, IsKeptAsLongAsThereIsRoom) {
  TwoCores cores(roundHull(200), pointAt({0, 0, 0}), Vector3d(0, 0, 0));
  const auto polytope = tetrahedronIn(cores);
  WarmPolytope kept;
  for (int vertices = 5; vertices <= WarmPolytope::kMaxVertices + 4; ++vertices) {
    const Face& face = *polytope->closest();
    ASSERT_TRUE(polytope->expand(face, cores.cso.vertex(face.area), kUnlimited));
    polytope->keep(kept);
    const bool has_room = vertices <= WarmPolytope::kMaxVertices;
    EXPECT_EQ(kept.vertex_count, has_room ? vertices : 0);
    EXPECT_EQ(kept.face_count, has_room ? 2 * vertices - 4 : 0);
  }
}

TEST(WarmPolytope, IsNotKeptOnceItHasGrownMuchSinceItWasBegun) {
  TwoCores cores(roundHull(100), pointAt({0, 0, 0}), Vector3d(0, 0, 0));
  WarmPolytope kept;
  tetrahedronIn(cores)->keep(kept);
  ASSERT_EQ(kept.cold_vertices, 4);
  const auto polytope = empty(cores.cso);
  ASSERT_TRUE(polytope->recall(kept, cores.cso, kUnlimited));
  for (int vertices = 5; vertices <= 12; ++vertices) {
    const Face& face = *polytope->closest();
    ASSERT_TRUE(polytope->expand(face, cores.cso.vertex(face.area), kUnlimited));
    polytope->keep(kept);
    EXPECT_EQ(kept.face_count > 0, vertices <= 10) << vertices;  // 1.5 times 4, plus 4
    EXPECT_EQ(kept.cold_vertices, 4);
  }
}

/// Random hulls of 4 to 80 points, about 1 m large.
class RandomHulls {
 public:
  explicit RandomHulls(unsigned seed) : random_(seed) {}

  double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3d point() { return {normal_(random_), normal_(random_), normal_(random_)}; }
  Shape hull() {
    const Vector3d half(within(0.1, 0.5), within(0.1, 0.5), within(0.1, 0.5));
    std::vector<Vector3d> points(static_cast<std::size_t>(within(4, 80)));
    for (Vector3d& p : points) p = half.cwiseProduct(point().normalized());
    return hullOf(points);
  }
  Isometry3d pose(double offset, double angle) {
    Isometry3d pose(Eigen::AngleAxisd(angle, point().normalized()));
    pose.translation() = offset * point().normalized();
    return pose;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

void expectBothRight(const SignedDistance& warm, const SignedDistance& cold) {
  EXPECT_EQ(warm.status, Status::Converged);
  EXPECT_LE(warm.lower_bound, cold.upper_bound);
  EXPECT_GE(warm.upper_bound, cold.lower_bound);
  EXPECT_NEAR(warm.distance, cold.distance, 1e-12);
  EXPECT_TRUE(warm.has_points);
}

// Steps of 1 mm and 0.1 degrees; sometimes a jump, and sometimes other shapes in the same memory.
TEST(WarmPolytope, GivesTheColdAnswerAlongAnyMotion) {
  RandomHulls random(1);
  WarmPolytope memory;
  int overlaps = 0, jumps = 0, warm_iterations = 0, cold_iterations = 0;
  for (int pair = 0; pair < 60; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    WarmStart warm_start;
    warm_start.polytope = &memory;
    Isometry3d a_T_b = random.pose(random.within(0.0, 0.4), random.within(0.0, 3.0));
    for (int step = 0; step < 60; ++step) {
      const bool jumps_now = random.within(0.0, 1.0) < 0.05;
      jumps += jumps_now ? 1 : 0;
      a_T_b = jumps_now ? random.pose(random.within(0.0, 0.4), random.within(0.0, 3.0))
                        : a_T_b * random.pose(1e-3, 0.1 * M_PI / 180.0);
      const SignedDistance warm = signedDistance(a, b, a_T_b, {}, warm_start), cold = signedDistance(a, b, a_T_b);
      expectBothRight(warm, cold);
      if (cold.distance > 0.0) continue;
      ++overlaps;
      warm_iterations += warm.iterations;
      cold_iterations += cold.iterations;
    }
  }
  EXPECT_GT(overlaps, 2000);
  EXPECT_GT(jumps, 100);
  EXPECT_LT(5 * warm_iterations, cold_iterations);
}

// The memory is that of a query of other hulls, with some numbers replaced.
TEST(WarmPolytope, GivesTheColdAnswerWhateverItHolds) {
  RandomHulls random(6);
  const auto number = [&] {
    return static_cast<int>(random.within(0.0, 1.0) < 0.1 ? random.within(-9.0, 70000.0) : random.within(0.0, 20.0));
  };
  WarmPolytope memory;
  for (int pair = 0; pair < 1000; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    const Isometry3d a_T_b = random.pose(random.within(0.0, 0.3), 1.0);
    WarmStart warm_start;
    warm_start.polytope = &memory;
    warm_start.axis = random.point();
    for (int changes = pair % 5; changes > 0; --changes) {
      WarmPolytope::Triangle& face = memory.faces[static_cast<std::size_t>(random.within(0.0, 20.0))];
      const auto corner = static_cast<std::size_t>(random.within(0.0, 3.0));
      if (changes == 1) face.vertices[corner] = static_cast<std::uint16_t>(number());
      if (changes == 2) face.twins[corner] = static_cast<std::uint16_t>(number());
      if (changes == 3) memory.vertices[static_cast<std::size_t>(random.within(0.0, 20.0))] = {number(), number()};
      if (changes == 4) (pair % 2 == 0 ? memory.face_count : memory.vertex_count) = number();
    }
    expectBothRight(signedDistance(a, b, a_T_b, {}, warm_start), signedDistance(a, b, a_T_b));
  }
}

// The motion leads from a shallow overlap to a deep one and out again: the polytope is begun anew when it has grown or
// does not fit.
TEST(WarmPolytope, GivesTheColdAnswerOnTheWayThroughAnotherShape) {
  RandomHulls random(2);
  for (int pair = 0; pair < 20; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    WarmPolytope memory;
    WarmStart warm_start;
    warm_start.polytope = &memory;
    const Isometry3d turn = random.pose(0.0, random.within(0.0, 3.0));
    for (int step = -40; step <= 40; ++step) {
      const Isometry3d a_T_b = Eigen::Translation3d(0.03 * step, 0.01, -0.02) * turn;
      expectBothRight(signedDistance(a, b, a_T_b, {}, warm_start), signedDistance(a, b, a_T_b));
    }
  }
}

TEST(WarmPolytope, DecidesThresholdsAsAColdQueryDoes) {
  RandomHulls random(3);
  WarmPolytope memory;
  int above = 0, below = 0;
  for (int pair = 0; pair < 40; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    WarmStart warm_start;
    warm_start.polytope = &memory;
    Isometry3d a_T_b = random.pose(random.within(0.0, 0.3), random.within(0.0, 3.0));
    for (int step = 0; step < 40; ++step) {
      a_T_b = a_T_b * random.pose(1e-3, 0.1 * M_PI / 180.0);
      const double distance = signedDistance(a, b, a_T_b).distance, threshold = distance + random.within(-0.05, 0.05);
      if (step % 3 == 0) signedDistance(a, b, a_T_b, {}, warm_start);
      const SignedDistance asked = signedDistance(a, b, a_T_b, Options::above(threshold), warm_start);
      EXPECT_TRUE(distance > threshold ? asked.lower_bound > threshold : asked.upper_bound <= threshold);
      EXPECT_LE(asked.lower_bound, distance + 1e-12);
      EXPECT_GE(asked.upper_bound, distance - 1e-12);
      (distance > threshold ? above : below) += 1;
    }
  }
  EXPECT_GT(above, 500);
  EXPECT_GT(below, 500);
}

// A step of a coherent motion needs no more than the polytope of the step before, and no GJK.
TEST(WarmPolytope, AnswersWithoutGjkWhileTheShapesOverlap) {
  RandomHulls random(4);
  const Shape a = random.hull(), b = random.hull();
  WarmPolytope memory;
  WarmStart warm_start;
  warm_start.polytope = &memory;
  Isometry3d a_T_b = random.pose(0.05, 1.0);
  signedDistance(a, b, a_T_b, {}, warm_start);
  int without_gjk = 0;
  for (int step = 0; step < 100; ++step) {
    a_T_b = a_T_b * random.pose(1e-3, 0.1 * M_PI / 180.0);
    QueryTrace trace;
    const SignedDistance result = signedDistance(a, b, a_T_b, {}, warm_start, trace);
    ASSERT_LT(result.distance, 0.0);
    without_gjk += trace.gjk.empty() ? 1 : 0;
  }
  EXPECT_GE(without_gjk, 95);
}

/// Largest difference between the normal of a step of EPA and that of the corners which it names.
double worstNormal(const QueryTrace& trace) {
  double worst = 0.0;
  for (const QueryTrace::EpaStep& step : trace.epa) {
    const auto corner = [&](std::size_t i) { return trace.polytope[step.closest[i]].point; };
    const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    worst = std::max(worst, (normal - step.normal).norm());
  }
  return worst;
}

// If the recalled polytope leads to no answer, EPA begins again, with other vertices.
TEST(WarmPolytope, ThatIsGivenUpIsNotPartOfTheTrace) {
  RandomHulls random(6);
  Options few;
  few.max_iterations = 6;
  int given_up = 0;
  for (int pair = 0; pair < 200; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    WarmPolytope memory;
    WarmStart warm_start;
    warm_start.polytope = &memory;
    Isometry3d a_T_b = random.pose(0.05, 1.0);
    signedDistance(a, b, a_T_b, {}, warm_start);
    const bool is_kept = memory.face_count > 0;
    a_T_b = a_T_b * random.pose(0.03, 0.5);
    QueryTrace trace;
    signedDistance(a, b, a_T_b, few, warm_start, trace);
    given_up += is_kept && !trace.gjk.empty() && !trace.epa.empty() ? 1 : 0;
    EXPECT_LE(trace.epa.size(), 6U) << "pair " << pair;
    EXPECT_LT(worstNormal(trace), 1e-6) << "pair " << pair;
  }
  EXPECT_GT(given_up, 50);
}

// Nothing is proven about curved cores by the vertices of a polytope.
TEST(WarmPolytope, IsNotUsedForCurvedShapes) {
  const Shape cylinder = Cylinder{0.3, 0.8};
  const Isometry3d a_T_b = RandomHulls(5).pose(0.1, 1.0);
  WarmPolytope memory = keptTetrahedron();
  WarmStart warm_start;
  warm_start.polytope = &memory;
  const SignedDistance warm = signedDistance(cylinder, cylinder, a_T_b, {}, warm_start);
  EXPECT_EQ(warm.distance, signedDistance(cylinder, cylinder, a_T_b).distance);
  EXPECT_EQ(memory.face_count, 4);
}

}  // namespace proximity_server::narrowphase::warm_polytope_test
