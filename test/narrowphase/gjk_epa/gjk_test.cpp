#include "narrowphase/gjk_epa/gjk.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/edge_to_edge.h"
#include "narrowphase/near.h"
#include "narrowphase/rotation_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace proximity_server::narrowphase::gjk_test {

using Eigen::Vector3d;
using Outcome = GjkResult::Outcome;

GjkResult search(TwoCores& cores, const Vector3d& guess, const Options& options = {}) {
  const Vector3d normal = guess.normalized();
  return gjk(cores.cso, normal, cores.cso.vertex(normal), options);
}

// Good ones, bad ones and the opposite of the right one.
const Vector3d kGuesses[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},  {0, -1, 0},   {0, 0, 1},
                             {0, 0, -1}, {1, 1, 1},  {-1, 2, 0}, {-3, -4, -6}, {0.1, -1, 5}};

/// Checks both points, the distance and the normal for several first guesses.
void expectApart(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, const Vector3d& point_a,
                 const Vector3d& point_b) {
  const double distance = (point_b - point_a).norm();
  for (const Vector3d& guess : kGuesses) {
    SCOPED_TRACE(guess.transpose());
    TwoCores cores(a, b, a_T_b);
    const GjkResult result = search(cores, guess);
    EXPECT_EQ(result.outcome, Outcome::Apart);
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_NEAR(result.distance, distance, 1e-14);
    EXPECT_LE(result.lower_bound, distance);
    EXPECT_NEAR(result.lower_bound, distance, 1e-13);
    EXPECT_TRUE(isNear(result.normal, (point_b - point_a) / distance, 1e-14));
    EXPECT_TRUE(isNear(result.points.on_a, point_a, 1e-14));
    EXPECT_TRUE(isNear(result.points.on_b, point_b, 1e-14));
  }
}

void expectApart(const Shape& a, const Shape& b, const Vector3d& offset, const Vector3d& point_a,
                 const Vector3d& point_b) {
  expectApart(a, b, Eigen::Isometry3d(Eigen::Translation3d(offset)), point_a, point_b);
}

TEST(Gjk, FindsTheCornersOfTwoCubes) { expectApart(cube(), cube(), {5, 6, 8}, {1, 1, 1}, {4, 5, 7}); }

TEST(Gjk, FindsTheOppositeCornersOfTwoCubes) { expectApart(cube(), cube(), {-5, -6, -8}, {-1, -1, -1}, {-4, -5, -7}); }

TEST(Gjk, FindsTheCornerAboveAFace) {
  expectApart(cube(), pointAt({0.25, -0.5, 3}), Vector3d::Zero(), {0.25, -0.5, 1}, {0.25, -0.5, 3});
}

TEST(Gjk, FindsTheCornerBesideAnEdge) {
  expectApart(cube(), pointAt({4, 0.5, 5}), Vector3d::Zero(), {1, 0.5, 1}, {4, 0.5, 5});
}

TEST(Gjk, FindsTheCommonPerpendicularOfCrossedSegments) {
  const Shape along_x = hullOf({{-1, 0, 0}, {1, 0, 0}}), along_y = hullOf({{0, -1, 0}, {0, 1, 0}});
  expectApart(along_x, along_y, {0.25, 0.5, 2}, {0.25, 0, 0}, {0.25, 0, 2});
}

TEST(Gjk, FindsTheEndOfASegmentBesideAnother) {
  const Shape along_x = hullOf({{-1, 0, 0}, {1, 0, 0}}), along_y = hullOf({{0, -1, 0}, {0, 1, 0}});
  expectApart(along_x, along_y, {0.25, 3, 0}, {0.25, 0, 0}, {0.25, 2, 0});
}

TEST(Gjk, FindsTheCornerOfATurnedCubeAboveAFace) {
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  a_T_b.translation() = Vector3d(0.25, 0.5, 3);
  a_T_b.linear() = rotationBetween(Vector3d(1, 1, 1), -Vector3d::UnitZ());
  const double corner = 3.0 - std::sqrt(3.0);
  expectApart(cube(), cube(), a_T_b, {0.25, 0.5, 1}, {0.25, 0.5, corner});
}

TEST(Gjk, FindsTheCrossingEdgesOfTwoCubes) {
  const double gap = 0.25;
  expectApart(cube(), cube(), edgeToEdge(gap), {1, 1, 0.3}, Vector3d(1, 1, 0.3) + gap * Vector3d(1, 1, 0).normalized());
}

TEST(Gjk, GivesTheDistanceOfParallelFaces) {
  for (const Vector3d& guess : kGuesses) {
    TwoCores cores(cube(), cube(), Vector3d(5, 0.5, -0.25));
    const GjkResult result = search(cores, guess);
    EXPECT_EQ(result.outcome, Outcome::Apart);
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_EQ(result.distance, 3.0);
    EXPECT_TRUE(isNear(result.normal, Vector3d::UnitX(), 1e-15));
    EXPECT_TRUE(isNear(result.points.on_b - result.points.on_a, {3, 0, 0}, 1e-14));
  }
}

// On the way to the corner the search reaches the face around it, where the bounds differ by 1e-11 m: more than the
// roundings at which it may end, which are 4e-14 m here, see Cso::finalWidth().
TEST(Gjk, TakesTheLastStepToACornerThatIsHardlyHigherThanTheFaceAroundIt) {
  const Vector3d corner(0.1, 0.2, 1.0 + 1e-11);
  const Shape roof = hullOf(
      {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, corner});
  expectApart(roof, pointAt({0.1, 0.2, 3}), Vector3d::Zero(), corner, {0.1, 0.2, 3});
}

// Regression of other libraries: a plate of 3 mm beside a point was "overlapping", as the end of the search weighed a
// cubic quantity against a length.
TEST(Gjk, KeepsAThinPlateBesideAPointApart) {
  const Shape plate = hullOf({{-1.5e-3, -1.5e-3, 0}, {1.5e-3, -1.5e-3, 0}, {1.5e-3, 1.5e-3, 0}, {-1.5e-3, 1.5e-3, 0}});
  expectApart(plate, pointAt({5e-4, 2e-4, 1e-5}), Vector3d::Zero(), {5e-4, 2e-4, 0}, {5e-4, 2e-4, 1e-5});
}

TEST(Gjk, EndsOnTheCurveOfAnEllipsoid) {
  for (const Vector3d& guess : kGuesses) {
    SCOPED_TRACE(guess.transpose());
    TwoCores cores(Ellipsoid{{1, 2, 3}}, cube(), Vector3d(5, 0, 0));
    const GjkResult result = search(cores, guess);
    EXPECT_EQ(result.outcome, Outcome::Apart);
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_NEAR(result.distance, 3.0, 1e-9);
    EXPECT_LE(result.lower_bound, 3.0);
    EXPECT_GE(result.lower_bound, 3.0 - 1e-9);
    EXPECT_TRUE(isNear(result.points.on_a, {1, 0, 0}, 1e-4));
  }
}

// On a curve the points of a search that ends at a gap of 1e-9 m are off by its root. Newton's method doubles the
// digits.
TEST(Gjk, FindsThePointsOnACurveByNewtonsMethod) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_a = Vector3d(2, 8, 9) / std::sqrt(29.0);  // r^2 n / |r n|
  for (const Vector3d& guess : kGuesses) {
    SCOPED_TRACE(guess.transpose());
    TwoCores cores(Ellipsoid{{1, 2, 3}}, pointAt(on_a + 0.7 * normal), Vector3d::Zero());
    const GjkResult result = search(cores, guess);
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_NEAR(result.distance, 0.7, 1e-14);
    EXPECT_TRUE(isNear(result.points.on_a, on_a, 1e-12));
    EXPECT_TRUE(isNear(result.normal, normal, 1e-12));
  }
}

TEST(Gjk, SeesThatCubesOverlap) {
  for (const Vector3d& offset : {Vector3d(1.5, 0.25, 0.5), Vector3d(-1.9, 1.9, 1.9), Vector3d(0.1, -0.2, 1.0)})
    for (const Vector3d& guess : kGuesses) {
      TwoCores cores(cube(), cube(), offset);
      const GjkResult result = search(cores, guess);
      EXPECT_EQ(result.outcome, Outcome::Overlap);
      EXPECT_LE(result.lower_bound, 0.0);
    }
}

// Touching is where distances go wrong: neither outcome is, but what it says of the distance has to be 0.
TEST(Gjk, GivesNoDistanceWhereCubesTouch) {
  for (const Vector3d& offset : {Vector3d(2, 0.5, 0.25), Vector3d(2, 2, 0.25), Vector3d(2, -2, 2)})
    for (const Vector3d& guess : kGuesses) {
      TwoCores cores(cube(), cube(), offset);
      const GjkResult result = search(cores, guess);
      EXPECT_LE(result.distance, 2.0 * cores.cso.rounding());
      EXPECT_LE(result.lower_bound, 0.0);
    }
}

TEST(Gjk, LeavesSegmentsThatCrossToTheDepth) {
  TwoCores cores(hullOf({{-1, 0, 0}, {1, 0, 0}}), hullOf({{0, -1, 0}, {0, 1, 0}}), Vector3d(0.25, 0.5, 0));
  EXPECT_EQ(search(cores, {1, 1, 1}).outcome, Outcome::Overlap);
}

TEST(Gjk, StopsAtTheFirstPlaneThatProvesTheThreshold) {
  TwoCores cores(cube(), cube(), Vector3d(5, 0, 0));
  Options options;
  options.stop_above = 2.5;
  const GjkResult result = search(cores, Vector3d::UnitX(), options);
  EXPECT_EQ(result.outcome, Outcome::Threshold);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_GT(result.lower_bound, 2.5);
  EXPECT_LE(result.lower_bound, 3.0);
}

TEST(Gjk, DoesNotClaimAThresholdThatTheDistanceDoesNotExceed) {
  TwoCores cores(cube(), cube(), Vector3d(5, 0, 0));
  Options options;
  options.stop_above = 3.0;
  EXPECT_EQ(search(cores, Vector3d::UnitX(), options).outcome, Outcome::Apart);
}

TEST(Gjk, StopsWhereThePointsProveThatTheShapesAreNearEnough) {
  TwoCores cores(cube(), cube(), Vector3d(5, 6, 8));
  Options options;
  options.stop_below = 20.0;
  const GjkResult result = search(cores, -Vector3d::UnitX(), options);
  EXPECT_EQ(result.outcome, Outcome::Apart);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_LE(result.distance, 20.0);
  EXPECT_GE(result.distance, std::sqrt(61.0) - 1e-14);
  EXPECT_NEAR((result.points.on_b - result.points.on_a).norm(), result.distance, 1e-14);
}

TEST(Gjk, KeepsTheBoundsWhereTheIterationsEnd) {
  for (int most = 1; most <= 2; ++most) {
    TwoCores cores(cube(), cube(), Vector3d(5, 6, 8));
    Options options;
    options.max_iterations = most;
    const GjkResult result = search(cores, -Vector3d::UnitX(), options);
    EXPECT_EQ(result.iterations, most);
    EXPECT_EQ(result.status, Status::IterationLimit);
    EXPECT_EQ(result.outcome, Outcome::Apart);
    EXPECT_LE(result.lower_bound, std::sqrt(61.0));
    EXPECT_GE(result.distance, std::sqrt(61.0) - 1e-14);
  }
}

TEST(Gjk, EndsInTwoStepsFromTheRightNormal) {
  TwoCores cores(cube(), cube(), Vector3d(5, 6, 8));
  EXPECT_EQ(search(cores, Vector3d(3, 4, 6)).iterations, 2);
}

// Regression: the number of b's corner was read before the corner was looked for, where a compiler evaluates arguments
// from the right. The corner of a that looks to b has no negative coordinate, that of b three: the numbers 0 and 7.
TEST(Gjk, RemembersTheCornersThatItEndedWith) {
  TwoCores cores(cube(), cube(), Vector3d(5, 6, 8));
  search(cores, Vector3d::UnitX());
  ASSERT_EQ(cores.warm_start.simplex_size, 1);
  EXPECT_EQ(cores.warm_start.simplex[0].a, 0);
  EXPECT_EQ(cores.warm_start.simplex[0].b, 7);
}

TEST(Gjk, IsFasterWithTheCornersOfTheLastQuery) {
  const Shape octahedron = hullOf({{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 2}, {0, 0, -2}});
  // The nearest point of the face x + y + z = 2 to a point above its corner's side: three vertices of the CSO.
  const Vector3d on_face(0.5, 1.0, 0.5);
  TwoCores cores(octahedron, pointAt(on_face + Vector3d(1, 1, 1)), Vector3d::Zero());
  const GjkResult cold = search(cores, {1.0, 1.1, 1.2});
  EXPECT_EQ(cores.warm_start.simplex_size, 3);
  const GjkResult warm = search(cores, {1.0, 1.1, 1.2});
  EXPECT_LT(warm.iterations, cold.iterations);
  for (const GjkResult* result : {&cold, &warm}) {
    EXPECT_NEAR(result->distance, std::sqrt(3.0), 1e-14);
    EXPECT_TRUE(isNear(result->points.on_a, on_face, 1e-14));
  }
}

TEST(Gjk, GivesTheSameAnswerWhateverTheWarmStartHolds) {
  for (const int size : {-3, 1, 2, 3, 77}) {
    TwoCores cores(cube(), cube(), Vector3d(5, 6, 8));
    cores.warm_start.simplex = {{{0, 7}, {-5, 99}, {7, 0}}};
    cores.warm_start.simplex_size = size;
    const GjkResult result = search(cores, -Vector3d::UnitX());
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_NEAR(result.distance, std::sqrt(61.0), 1e-14);
    EXPECT_TRUE(isNear(result.points.on_a, {1, 1, 1}, 1e-14));
  }
}

}  // namespace proximity_server::narrowphase::gjk_test
