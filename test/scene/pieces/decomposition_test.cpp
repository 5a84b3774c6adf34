#include "scene/pieces/decomposition.h"

#include "scene/pieces/boxes.h"
#include "scene/pieces/mesh_deviation.h"
#include "scene/pieces/mesh_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace proximity_server::scene::decomposition_test {

using namespace narrowphase;

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Vector3d kOnes = Vector3d::Ones();

// --- effort

TEST(Effort, EndsWhenMoreIsSpentThanThereIs) {
  Effort effort(1e-6);  // 300 steps
  effort.spend(299);
  EXPECT_THROW(effort.spend(2), Effort::Exceeded);
}

TEST(Effort, KeepsAHalfForLater) {
  Effort effort(8.0);
  Effort later = effort.half();
  EXPECT_EQ(effort.secondsLeft(), 4.0);
  EXPECT_EQ(later.secondsLeft(), 4.0);
  effort.add(later);
  EXPECT_EQ(effort.secondsLeft(), 8.0);
}

TEST(Effort, ThatWasOverspentTakesNothingFromWhatIsAdded) {
  Effort effort(1e-6);
  EXPECT_THROW(effort.spend(3000), Effort::Exceeded);
  effort.add(Effort(2.0));
  EXPECT_EQ(effort.secondsLeft(), 2.0);
}

// --- distance from a mesh

/// Two unit cubes, 1 apart, in one mesh.
struct TwoCubes {
  const TriangleMesh mesh = welded(together({boxMesh({0, 0, 0}, kOnes), boxMesh({2, 0, 0}, kOnes)}));
  const std::vector<Triangle> triangles = trianglesOf(mesh.vertices, mesh.triangles);
  Effort effort{kInfinity};
  const MeshSolid solid{triangles, triangles, effort};
};

TEST(MeshSolid, HasAPositiveDistanceOutsideAndANegativeOneInside) {
  const TwoCubes cubes;
  EXPECT_NEAR(cubes.solid.distance({1.25, 0.5, 0.5}), 0.25, 1e-14);
  EXPECT_NEAR(cubes.solid.distance({0.5, 4, 5}), 5.0, 1e-14);  // 3 and 4 from the edge
  EXPECT_NEAR(cubes.solid.distance({2.5, 0.5, 0.375}), -0.375, 1e-14);
  EXPECT_NEAR(cubes.solid.distance({1, 0.5, 0.5}), 0.0, 1e-14);
}

// The hull of both fills the gap, in the middle of which a point is 0.5 from either cube. What is nearly as much as the
// tolerance, by 2 %, may be refused.
TEST(MeshSolid, HullOverAGapDeviatesByHalfOfIt) {
  const TwoCubes cubes;
  const ConvexHull hull(cubes.mesh.vertices);
  EXPECT_NEAR(cubes.solid.deviationOf({{hull, cubes.mesh.vertices}}), 0.5, 1e-3);
  EXPECT_FALSE(cubes.solid.isSurfaceWithin(0.49, {hull, {}}));
  EXPECT_TRUE(cubes.solid.isSurfaceWithin(0.52, {hull, {}}));
}

TEST(MeshSolid, HullOfACubeDoesNotDeviate) {
  const TwoCubes cubes;
  const ConvexHull hull(boxMesh({2, 0, 0}, kOnes).vertices);
  EXPECT_LE(cubes.solid.deviationOf({{hull, hull.vertices()}}), kMeshRounding);
  EXPECT_TRUE(cubes.solid.isSurfaceWithin(kMeshRounding, {hull, {}}));
}

// Its triangles lie in the planes of other triangles of the mesh, or cut through the solid from face to face; each was
// divided along its whole border, in a second for each piece.
TEST(MeshSolid, PieceOfACubeIsProvenToBeInsideInFewSteps) {
  const std::vector<Triangle> cube =
      trianglesOf(boxMesh({0, 0, 0}, kOnes).vertices, boxMesh({0, 0, 0}, kOnes).triangles);
  Effort effort(1e-4);
  const MeshSolid solid(cube, cube, effort);
  const ConvexHull half(
      {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {0.3, 0, 0}, {0.7, 1, 0}, {0.3, 0, 1}, {0.7, 1, 1}});
  EXPECT_LE(solid.deviationOf({{half, {}}}), kMeshRounding);
  EXPECT_TRUE(solid.isSurfaceWithin(kMeshRounding, {half, {}}));
}

// 1e-5 m of it are outside.
TEST(MeshSolid, PieceThatPeersOutOfACubeDeviates) {
  const TwoCubes cubes;
  const ConvexHull piece({{0.2, 0.2, 0.2}, {0.8, 0.2, 0.2}, {0.2, 0.8, 0.2}, {0.3, 0.3, 1.00001}});
  EXPECT_NEAR(cubes.solid.deviationOf({{piece, {}}}), 1e-5, kMeshRounding);
  EXPECT_FALSE(cubes.solid.isSurfaceWithin(0.5e-5, {piece, {}}));
}

// The centre of an equilateral triangle is as far from its corners, to which three needles point, as any point is that
// corners can prove to be near.
TEST(MeshSolid, TriangleBetweenThreePointsDeviatesInItsCentre) {
  const double height = std::sqrt(0.75);
  const Points tips{{0, 0, 0}, {1, 0, 0}, {0.5, height, 0}};
  TriangleMesh needles;
  for (const Vector3d& tip : tips) {
    const int first = static_cast<int>(needles.vertices.size());
    for (const double width : {0.0, -0.01, 0.01}) needles.vertices.push_back(tip + Vector3d(width, 0, width != 0.0));
    needles.triangles.push_back({first, first + 1, first + 2});
  }
  Effort effort(kInfinity);
  const MeshSolid solid(trianglesOf(needles.vertices, needles.triangles), {}, effort);
  const Cover cover{ConvexHull(tips), tips};
  EXPECT_NEAR(solid.deviationOf({cover}), 2.0 / 3.0 * height, 1e-3);
  EXPECT_FALSE(solid.isSurfaceWithin(0.57, cover));
  EXPECT_TRUE(solid.isSurfaceWithin(0.6, cover));
}

// --- hulls

TEST(SurfaceOf, AHullHasItsTriangles) {
  EXPECT_EQ(surfaceOf(ConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})).size(), 4u);
}

TEST(SurfaceOf, ASegmentOrAPointIsATriangleWithoutArea) {
  const std::vector<Triangle> segment = surfaceOf(ConvexHull({{0, 0, 0}, {1, 0, 0}}));
  ASSERT_EQ(segment.size(), 1u);
  EXPECT_LE((nearestPoint(segment[0], {0.5, 2, 0}) - Vector3d(0.5, 0, 0)).norm(), 1e-15);
  const std::vector<Triangle> point = surfaceOf(ConvexHull({{1, 2, 3}}));
  ASSERT_EQ(point.size(), 1u);
  EXPECT_EQ(nearestPoint(point[0], {9, 9, 9}), Vector3d(1, 2, 3));
}

TEST(PointsBelow, AHullAreThoseThatAreNotItsVertices) {
  Points points = boxMesh({0, 0, 0}, kOnes).vertices;
  const ConvexHull hull(points);
  EXPECT_TRUE(pointsBelow(hull, points).empty());
  points.insert(points.begin() + 3, Vector3d(0.5, 0.5, 0.5));
  EXPECT_EQ(pointsBelow(hull, points), (Points{{0.5, 0.5, 0.5}}));
}

// 3 and 4 from an edge of the cube; the others are in it.
TEST(FarthestOutside, IsTheLargestDistanceOfAPointFromTheHull) {
  Effort effort(kInfinity);
  const ConvexHull hull(boxMesh({0, 0, 0}, kOnes).vertices);
  EXPECT_NEAR(farthestOutside({hull, {{0.5, 0.5, 0.5}, {0.5, 4, 5}, {1.5, 0.5, 0.5}}}, effort), 5.0, 1e-8);
  EXPECT_NEAR(farthestOutside({hull, {{0.5, 0.5, 0.5}, {0, 1, 1}}}, effort), 0.0, 1e-8);
}

// --- clusters

TEST(ClusterPoints, AreThoseOfTheirTrianglesOnce) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {5, 5, 5}},
                          {{{0, 1, 2}}, {{1, 3, 2}}, {{4, 3, 1}}}};
  const std::vector<Points> clusters = clusterPoints(mesh, {1, 1, 0});
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_EQ(clusters[0], (Points{{1, 0, 0}, {1, 1, 0}, {5, 5, 5}}));
  EXPECT_EQ(clusters[1], (Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
}

TEST(ClusterPoints, LeaveOutNumbersWithoutTriangles) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}};
  EXPECT_EQ(clusterPoints(mesh, {3}).size(), 1u);
}

/// Sets of triangles, whatever their numbers.
std::set<std::set<int>> clustersOf(const Partition& partition) {
  std::map<int, std::set<int>> by_number;
  for (std::size_t t = 0; t < partition.size(); ++t) by_number[partition[t]].insert(static_cast<int>(t));
  std::set<std::set<int>> clusters;
  for (const auto& [number, triangles] : by_number) clusters.insert(triangles);
  return clusters;
}

std::set<int> numbers(int begin, int end) {
  std::set<int> result;
  for (int i = begin; i < end; ++i) result.insert(i);
  return result;
}

TEST(Decompose, LeavesConvexComponentsAsTheyAre) {
  const TwoCubes cubes;
  const Decomposition result = decompose(cubes.mesh, componentNumbers(cubes.mesh), cubes.solid, 0.1);
  EXPECT_TRUE(result.is_complete);
  EXPECT_EQ(clustersOf(result.partition), (std::set<std::set<int>>{numbers(0, 12), numbers(12, 24)}));
}

// The gap is 1, and the common hull deviates by half of it. Regression: the tolerance had to be as large as the gap.
TEST(Decompose, JoinsComponentsWhoseCommonHullIsWithinTolerance) {
  const TwoCubes cubes;
  const Decomposition result = decompose(cubes.mesh, componentNumbers(cubes.mesh), cubes.solid, 0.52);
  EXPECT_EQ(clustersOf(result.partition), (std::set<std::set<int>>{numbers(0, 24)}));
}

TEST(Decompose, LeavesOutWhatIsKnownToBeInARoom) {
  const TwoCubes cubes;
  const std::vector<Vector3d> rooms{{1.5, 0.5, 0.5}};  // between the two
  const Decomposition result =
      decompose(cubes.mesh, componentNumbers(cubes.mesh), cubes.solid, 1.01, PartsOfHulls::AreTested, rooms);
  EXPECT_EQ(clustersOf(result.partition), (std::set<std::set<int>>{numbers(0, 12), numbers(12, 24)}));
}

// Two walls of two triangles each that meet in an edge at a right angle. The middle of the hull's third side is 0.5
// from either of them.
TEST(Decompose, CutsAnAngleIntoItsWalls) {
  const TriangleMesh angle{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0, 1}, {0, 1, 0}, {0, 1, 1}},
                           {{{0, 2, 1}}, {{2, 3, 1}}, {{0, 1, 4}}, {{4, 1, 5}}}};
  const std::vector<Triangle> triangles = trianglesOf(angle.vertices, angle.triangles);
  Effort effort(kInfinity);
  const MeshSolid solid(triangles, {}, effort);
  const Partition whole(4, 0);
  EXPECT_EQ(clustersOf(decompose(angle, whole, solid, 0.01).partition), (std::set<std::set<int>>{{0, 1}, {2, 3}}));
  EXPECT_EQ(clustersOf(decompose(angle, whole, solid, 0.52).partition), (std::set<std::set<int>>{{0, 1, 2, 3}}));
}

/// A body with a waist, 0.3 m long, with quadrangles of about 2 mm.
TriangleMesh densePeanut() {
  constexpr int kAround = 180, kAlong = 180;
  TriangleMesh mesh;
  for (int i = 0; i <= kAlong; ++i) {
    const double polar = M_PI * i / kAlong, radius = 0.1 + 0.05 * std::cos(2.0 * polar);
    for (int j = 0; j < kAround; ++j) {
      const double around = 2.0 * M_PI * j / kAround, across = radius * std::sin(polar);
      mesh.vertices.emplace_back(across * std::cos(around), across * std::sin(around), radius * std::cos(polar));
    }
  }
  for (int i = 0; i < kAlong; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const auto corner = [&](int di, int dj) { return (i + di) * kAround + (j + dj) % kAround; };
      mesh.triangles.push_back({corner(0, 0), corner(1, 0), corner(1, 1)});
      mesh.triangles.push_back({corner(0, 0), corner(1, 1), corner(0, 1)});
    }
  }
  return mesh;
}

// The outermost vertices of its parts tell which parts may be merged, and with far fewer steps than all of them.
TEST(Decompose, MergesDensePartsByTheirOutermostVertices) {
  constexpr double kTolerance = 0.005, kBudget = 100.0;
  const TriangleMesh peanut = densePeanut();
  const std::vector<Triangle> triangles = trianglesOf(peanut.vertices, peanut.triangles);
  Effort effort(kBudget);
  const MeshSolid solid(triangles, triangles, effort);
  const Partition partition = decompose(peanut, componentNumbers(peanut), solid, kTolerance).partition;
  EXPECT_LE(kBudget - effort.secondsLeft(), 0.57);  // 0.64 with all vertices
  const std::vector<Points> clusters = clusterPoints(peanut, partition);
  EXPECT_EQ(clusters.size(), 2u);
  for (const Points& points : clusters) EXPECT_TRUE(solid.isSurfaceWithin(kTolerance, coverOf(points, effort)));
}

TEST(Decompose, CoversEveryTriangleWhereTheEffortIsSpent) {
  const TriangleMesh mesh = welded(together({boxMesh({0, 0, 0}, kOnes), boxMesh({2, 0, 0}, kOnes)}));
  const std::vector<Triangle> triangles = trianglesOf(mesh.vertices, mesh.triangles);
  Effort little(1e-5);
  const MeshSolid solid(triangles, triangles, little);
  const Decomposition result = decompose(mesh, componentNumbers(mesh), solid, 0.1);
  EXPECT_FALSE(result.is_complete);
  ASSERT_EQ(result.partition.size(), 24u);
  EXPECT_GE(*std::min_element(result.partition.begin(), result.partition.end()), 0);
}

}  // namespace proximity_server::scene::decomposition_test
