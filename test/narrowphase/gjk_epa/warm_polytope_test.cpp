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
  ASSERT_EQ(kept.faceCount(), 4);
  ASSERT_EQ(kept.vertexCount(), 4);
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

// With this rounding the determinants of the corners are 4 m^3, with an error of 6.4 m^3 or 0.64 m^3.
TEST(WarmPolytope, IsNotRecalledIfRoundingMayTurnAFace) {
  const TwoCores cores = cubeAbout({0, 0, 0});
  EXPECT_FALSE(std::make_unique<Polytope>(0.1)->recall(keptTetrahedron(), cores.cso, kUnlimited));
  EXPECT_TRUE(std::make_unique<Polytope>(0.01)->recall(keptTetrahedron(), cores.cso, kUnlimited));
}

// A hull numbers its corners by their places, along x first. The tetrahedron has the numbers 1, 2, 4 and 7; here they are
// those of the cube, mirrored at y = 0, so that the outer sides of all faces look inwards.
TEST(WarmPolytope, IsNotRecalledInsideOut) {
  const std::vector<Vector3d> corners{{-2, 0, 0}, {-1.1, 1, 1}, {-1, -1, -1},  {0, 0, -3},
                                      {1, 1, -1}, {1.05, 3, 0}, {1.07, -3, 0}, {1.1, -1, 1}};
  const TwoCores cores(hullOf(corners), pointAt({0, 0, 0}), Vector3d(0, 0, 0));
  ASSERT_EQ(cores.a.hull().vertices(), corners);
  EXPECT_FALSE(empty(cores.cso)->recall(keptTetrahedron(), cores.cso, kUnlimited));
}

// A number that a hull does not have means its first vertex, so that no tetrahedron is left.
TEST(WarmPolytope, MayComeFromALargerHull) {
  std::vector<Vector3d> corners = cubeHull().hull().vertices();
  corners.resize(3);
  const TwoCores cores(hullOf(corners), pointAt({0, 0, 0}), Vector3d(0, 0, 0));
  EXPECT_FALSE(empty(cores.cso)->recall(keptTetrahedron(), cores.cso, kUnlimited));
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
    EXPECT_EQ(memory.faceCount() > 0, is_answered);
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
    EXPECT_EQ(kept.vertexCount(), has_room ? vertices : 0);
    EXPECT_EQ(kept.faceCount(), has_room ? 2 * vertices - 4 : 0);
  }
}

TEST(WarmPolytope, IsNotKeptOnceItHasGrownMuchSinceItWasBegun) {
  TwoCores cores(roundHull(100), pointAt({0, 0, 0}), Vector3d(0, 0, 0));
  WarmPolytope kept;
  tetrahedronIn(cores)->keep(kept);
  const auto polytope = empty(cores.cso);
  ASSERT_TRUE(polytope->recall(kept, cores.cso, kUnlimited));
  for (int vertices = 5; vertices <= 12; ++vertices) {
    const Face& face = *polytope->closest();
    ASSERT_TRUE(polytope->expand(face, cores.cso.vertex(face.area), kUnlimited));
    polytope->keep(kept);
    EXPECT_EQ(kept.faceCount() > 0, vertices <= 10) << vertices;  // 1.5 times 4, plus 4
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

TEST(WarmPolytope, GivesTheColdAnswerWithThePolytopeOfOtherHulls) {
  RandomHulls random(6);
  WarmPolytope memory;
  for (int pair = 0; pair < 1000; ++pair) {
    const Shape a = random.hull(), b = random.hull();
    const Isometry3d a_T_b = random.pose(random.within(0.0, 0.3), 1.0);
    WarmStart warm_start;
    warm_start.polytope = &memory;
    warm_start.axis = random.point();
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
    const bool is_kept = memory.faceCount() > 0;
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
  EXPECT_EQ(memory.faceCount(), 4);
}

}  // namespace proximity_server::narrowphase::warm_polytope_test
