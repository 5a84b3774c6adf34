#include "narrowphase/gjk_epa/epa.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/edge_to_edge.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace proximity_server::narrowphase::epa_test {

using Eigen::Vector3d;

Shape octahedron() { return hullOf({{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 2}, {0, 0, -2}}); }

/// The simplex that GJK leaves for EPA.
Simplex simplexHoldingTheOrigin(TwoCores& cores) {
  const Vector3d guess = Vector3d(1, 2, -1).normalized();
  const GjkResult result = gjk(cores.cso, guess, cores.cso.vertex(guess), {});
  EXPECT_EQ(result.outcome, GjkResult::Outcome::Overlap);
  return result.simplex;
}

EpaResult depthOf(TwoCores& cores, const Options& options = {}) {
  return epa(cores.cso, simplexHoldingTheOrigin(cores), options);
}

/// The one way out, with both points: point_a lies `depth` ahead of point_b along the normal.
void expectDepth(TwoCores& cores, double depth, const Vector3d& normal, double tolerance = 1e-14) {
  const EpaResult result = depthOf(cores);
  EXPECT_EQ(result.status, Status::Converged);
  ASSERT_TRUE(result.has_normal);
  ASSERT_TRUE(result.has_points);
  EXPECT_NEAR(result.depth, depth, tolerance);
  EXPECT_LE(result.lower_bound, depth);
  EXPECT_GE(result.lower_bound, result.depth - 1e-9);
  EXPECT_TRUE(isNear(result.normal, normal, tolerance));
  EXPECT_TRUE(isNear(result.point_a - result.point_b, depth * normal, 10.0 * tolerance));
  EXPECT_TRUE(result.unique);
}

TEST(Epa, FindsTheShortestWayOutOfACube) {
  TwoCores cores(cube(), cube(), Vector3d(1.5, 0.25, 0.5));
  expectDepth(cores, 0.5, Vector3d::UnitX());
  const EpaResult result = depthOf(cores);
  EXPECT_NEAR(result.point_a.x(), 1.0, 1e-14);
  for (int axis = 1; axis < 3; ++axis) {  // within both faces
    EXPECT_LE(result.point_a[axis], 1.0 + 1e-14);
    EXPECT_GE(result.point_a[axis], cores.a_T_b.translation()[axis] - 1.0 - 1e-14);
  }
}

TEST(Epa, FindsTheWayOutToTheNegativeSide) {
  TwoCores cores(cube(), cube(), Vector3d(0.25, 0.5, -1.75));
  expectDepth(cores, 0.25, -Vector3d::UnitZ());
}

TEST(Epa, FindsTheDepthOfATurnedCube) {
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  a_T_b.linear() = Eigen::AngleAxisd(M_PI / 4.0, Vector3d::UnitZ()).toRotationMatrix();
  a_T_b.translation() = Vector3d(2, 0, 0.125);
  TwoCores cores(cube(), cube(), a_T_b);
  expectDepth(cores, std::sqrt(2.0) - 1.0, Vector3d::UnitX());
  const EpaResult result = depthOf(cores);
  EXPECT_NEAR(result.point_a.x(), 1.0, 1e-14);
  EXPECT_NEAR(result.point_a.y(), 0.0, 1e-14);
}

TEST(Epa, FindsTheDepthOfCrossingEdges) {
  TwoCores cores(cube(), cube(), edgeToEdge(-0.25));
  expectDepth(cores, 0.25, Vector3d(1, 1, 0).normalized());
  EXPECT_TRUE(isNear(depthOf(cores).point_a, {1, 1, 0.3}, 1e-13));
}

TEST(Epa, LeadsAPointOutOfTheNearestFaceOfATetrahedron) {
  const Shape tetrahedron = hullOf({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}});
  const struct {
    Vector3d point;
    double depth;
    Vector3d normal;
  } cases[] = {
      {{0.5, 0.7, 0.4}, 0.4, -Vector3d::UnitZ()},
      {{0.5, 0.25, 0.4}, 0.25, -Vector3d::UnitY()},
      {{0.125, 0.7, 0.4}, 0.125, -Vector3d::UnitX()},
      {{0.9, 0.9, 0.9}, 0.3 / std::sqrt(3.0), Vector3d(1, 1, 1).normalized()},
  };
  for (const auto& [point, depth, normal] : cases) {
    TwoCores cores(tetrahedron, pointAt(point), Vector3d::Zero());
    expectDepth(cores, depth, normal);
    const EpaResult result = depthOf(cores);
    EXPECT_TRUE(isNear(result.point_b, point, 1e-14));
    EXPECT_TRUE(isNear(result.point_a, point + depth * normal, 1e-14));
  }
}

TEST(Epa, SaysThatConcentricCubesHaveSeveralWaysOut) {
  TwoCores cores(cube(), Box{{1.0, 1.0, 1.0}}, Vector3d::Zero());
  const EpaResult result = depthOf(cores);
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.depth, 1.5, 1e-14);
  EXPECT_NEAR(result.normal.lpNorm<Eigen::Infinity>(), 1.0, 1e-14);
  EXPECT_FALSE(result.unique);
}

// The origin is the middle of the diagonal from `up` to `down`.
TEST(Epa, BeginsWithASimplexOfAnyDimension) {
  TwoCores cores(cube(), Box{{1.0, 1.0, 1.0}}, Vector3d::Zero());
  const CsoVertex up = cores.cso.vertex({1, 1, 1}), down = cores.cso.vertex({-1, -1, -1});
  const CsoVertex right = cores.cso.vertex({1, -1, 1});
  for (const Simplex& simplex : {simplexOf({up, down}), simplexOf({right, up, down})})
    EXPECT_NEAR(epa(cores.cso, simplex, {}).depth, 1.5, 1e-14);
}

TEST(Epa, GivesADepthOfZeroWhereFacesTouch) {
  TwoCores cores(cube(), cube(), Vector3d(2, 0.5, 0.25));
  const EpaResult result = depthOf(cores);
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.depth, 0.0, 2.0 * cores.cso.rounding());
  EXPECT_TRUE(isNear(result.normal, Vector3d::UnitX(), 1e-14));
  EXPECT_TRUE(result.unique);
}

TEST(Epa, GivesADepthOfZeroAcrossAFlatCso) {
  const Shape square = hullOf({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
  for (const Shape& other : {square, hullOf({{-3, 0, 0}, {3, 0.5, 0}}), pointAt({0.5, 0.25, 0})}) {
    TwoCores cores(square, other, Vector3d(0.125, 0.25, 0));
    const EpaResult result = depthOf(cores);
    EXPECT_EQ(result.status, Status::Converged);
    EXPECT_NEAR(result.depth, 0.0, cores.cso.rounding());
    EXPECT_NEAR(std::abs(result.normal.z()), 1.0, 1e-14);
    EXPECT_TRUE(isNear(result.point_a, result.point_b, 1e-14));
    EXPECT_FALSE(result.unique);
  }
}

TEST(Epa, StopsWhereTheSimplexProvesTheDepthThatWasAsked) {
  // The CSO is the cube of half edge 3 about the origin.
  TwoCores cores(Box{{4.0, 4.0, 4.0}}, cube(), Vector3d::Zero());
  const Simplex simplex = simplexOf({cores.cso.vertex({1, 1, 1}), cores.cso.vertex({-1, -1, 1}),
                                     cores.cso.vertex({1, -1, -1}), cores.cso.vertex({-1, 1, -1})});
  // A regular tetrahedron of corners of a cube of half edge 3 holds a ball of 3 / sqrt(3).
  Options options;
  options.stop_below = -1.7;
  const EpaResult result = epa(cores.cso, simplex, options);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_FALSE(result.has_normal);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_NEAR(result.lower_bound, std::sqrt(3.0), 1e-13);
  EXPECT_LT(result.lower_bound, enclosedRadius(simplex));  // the vertices are rounded too
}

TEST(Epa, StopsWhereTheFacesProveTheDepthThatWasAsked) {
  TwoCores cores(Box{{4.0, 4.0, 4.0}}, cube(), Vector3d::Zero());
  const Simplex simplex = simplexOf({cores.cso.vertex({1, 1, 1}), cores.cso.vertex({-1, -1, 1}),
                                     cores.cso.vertex({1, -1, -1}), cores.cso.vertex({-1, 1, -1})});
  Options options;
  options.stop_below = -2.9;
  const EpaResult result = epa(cores.cso, simplex, options);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_GE(result.lower_bound, 2.9);
  EXPECT_LE(result.lower_bound, 3.0);
}

// No direction is deeper than 2 + sqrt(3) + |(0.1, 0.2, 0.3)| m, so the first one that is looked along decides.
TEST(Epa, StopsWhereADirectionProvesThatTheOverlapIsShallow) {
  TwoCores cores(octahedron(), cube(), Vector3d(0.1, 0.2, 0.3));
  Options options;
  options.stop_above = -5.0;
  const EpaResult result = depthOf(cores, options);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_EQ(result.iterations, 1);
  ASSERT_TRUE(result.has_normal);
  EXPECT_LT(result.depth, 5.0);
  EXPECT_GE(result.depth, 3.5 / std::sqrt(2.0) - 1e-14);
}

// The edges of a about (0, 2, 2) and of b along x meet along (0, 1, 1) / sqrt(2): there a reaches 2 / sqrt(2), and b
// begins at (0.5 - 2) / sqrt(2). All other products of edges and all faces are deeper.
TEST(Epa, FindsTheDepthOfAnOctahedronInACube) {
  TwoCores cores(octahedron(), cube(), Vector3d(0.1, 0.2, 0.3));
  expectDepth(cores, 3.5 / std::sqrt(2.0), Vector3d(0, 1, 1).normalized());
}

TEST(Epa, KeepsTheBoundsWhereTheIterationsEnd) {
  TwoCores cores(octahedron(), cube(), Vector3d(0.1, 0.2, 0.3));
  Options options;
  options.max_iterations = 1;
  const EpaResult result = depthOf(cores, options);
  const double depth = 3.5 / std::sqrt(2.0);
  EXPECT_EQ(result.status, Status::IterationLimit);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_LE(result.lower_bound, depth);
  EXPECT_GE(result.depth, depth - 1e-14);
}

TEST(Epa, EndsOnTheSideOfACylinder) {
  TwoCores cores(Cylinder{1.0, 2.0}, pointAt({0.3, 0.4, 0.1}), Vector3d::Zero());
  expectDepth(cores, 0.5, {0.6, 0.8, 0}, 1e-8);
  const EpaResult result = depthOf(cores);
  EXPECT_NEAR(result.depth, 0.5, 1e-14);
  EXPECT_TRUE(isNear(result.point_a, {0.6, 0.8, 0.1}, 1e-8));
}

TEST(Epa, EndsOnTheFlatEndOfACylinder) {
  TwoCores cores(Cylinder{1.0, 2.0}, pointAt({0.3, 0.4, -0.75}), Vector3d::Zero());
  expectDepth(cores, 0.25, -Vector3d::UnitZ());
  EXPECT_TRUE(isNear(depthOf(cores).point_a, {0.3, 0.4, -1}, 1e-14));
}

TEST(Epa, EndsOnTheShortAxisOfAnEllipsoid) {
  TwoCores cores(Ellipsoid{{1, 2, 3}}, pointAt({0.5, 0, 0}), Vector3d::Zero());
  expectDepth(cores, 0.5, Vector3d::UnitX(), 1e-8);
}

// Over the middle of the slant of a cone of radius 1 and length 2, whose normal is (2, 0, 1) / sqrt(5).
TEST(Epa, EndsOnTheSlantOfACone) {
  const Vector3d normal = Vector3d(2, 0, 1).normalized(), on_slant(0.5, 0, 0);
  TwoCores cores(Cone{1.0, 2.0}, pointAt(on_slant - 0.125 * normal), Vector3d::Zero());
  expectDepth(cores, 0.125, normal, 1e-8);
  EXPECT_TRUE(isNear(depthOf(cores).point_a, on_slant, 1e-8));
}

}  // namespace proximity_server::narrowphase::epa_test
