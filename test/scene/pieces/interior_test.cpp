#include "scene/pieces/interior.h"

#include "scene/pieces/mesh_parts.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::scene::interior_test {

using Eigen::Vector3d;

std::vector<Triangle> trianglesOfMesh(const TriangleMesh& mesh) { return trianglesOf(mesh.vertices, mesh.triangles); }

Interior interiorOf(const TriangleMesh& mesh) { return Interior(trianglesOfMesh(mesh)); }

void expectDistance(const Interior::Place& place, double expected) {
  EXPECT_LE(place.lower_bound, expected + 1e-15);
  EXPECT_GE(place.upper_bound, expected - 1e-15);
  EXPECT_LE(place.upper_bound - place.lower_bound, 1e-14);
}

TEST(Interior, HasTheDistanceFromTheSurfaceWithTheShortestWayOut) {
  const Interior interior = interiorOf(bracket());
  const Interior::Place inside = interior.placeOf({1.9, 0.5, 0.5});
  expectDistance(inside, -0.1);
  EXPECT_TRUE(inside.nearest.isApprox(Vector3d(2.0, 0.5, 0.5), 1e-14));
  EXPECT_TRUE(inside.outwards.isApprox(Vector3d::UnitX(), 1e-14));
  const Interior::Place outside = interior.placeOf({2.5, 0.5, 0.5});
  expectDistance(outside, 0.5);
  EXPECT_TRUE(outside.outwards.isApprox(Vector3d::UnitX(), 1e-14));
  const Interior::Place in_the_corner = interior.placeOf({1.3, 1.4, 0.5});
  expectDistance(in_the_corner, 0.3);
  EXPECT_TRUE(in_the_corner.outwards.isApprox(Vector3d::UnitX(), 1e-14));
}

TEST(Interior, IsLeftOutBeyondTheReachOfAPointOutside) {
  const Interior interior = interiorOf(bracket());
  expectDistance(interior.placeOf({2.5, 0.5, 0.5}, 0.51), 0.5);
  const Interior::Place beyond = interior.placeOf({2.5, 0.5, 0.5}, 0.49);
  EXPECT_NEAR(beyond.lower_bound, 0.49, 1e-12);
  EXPECT_GT(beyond.upper_bound, 1e9);
  expectDistance(interior.placeOf({0.5, 0.5, 0.5}, 0.1), -0.5);
}

TEST(Interior, FindsItsSurfaceFromBothSides) {
  const Interior interior = interiorOf(thickShell());
  for (const Vector3d& half_a_metre_away : {Vector3d(1.0, 0.1, 0.2), Vector3d(0, 0, 0), Vector3d(0.1, 2.0, 0.0)}) {
    EXPECT_TRUE(interior.hasSurfaceWithin(half_a_metre_away, 0.5 + 1e-12));
    EXPECT_FALSE(interior.hasSurfaceWithin(half_a_metre_away, 0.5 - 1e-12));
    for (const double nowhere : {0.0, -1.0, std::nan("")})
      EXPECT_FALSE(interior.hasSurfaceWithin(half_a_metre_away, nowhere));
  }
}

TEST(Interior, EndsAtTheWallOfACavity) {
  const Interior interior = interiorOf(thickShell());
  expectDistance(interior.placeOf({0.9, 0.1, 0.2}), -0.4);
  expectDistance(interior.placeOf({0.3, 0.1, 0.0}), 0.2);
  expectDistance(interior.placeOf({2.0, 0.1, 0.0}), 0.5);
}

TEST(Interior, BeginsAgainInASolidWithinACavity) {
  const Interior interior =
      interiorOf(together({thickShell(), boxMesh(Vector3d::Constant(-0.2), Vector3d::Constant(0.4))}));
  expectDistance(interior.placeOf({0.05, 0, 0}), -0.15);
  expectDistance(interior.placeOf({0.3, 0.0, 0.0}), 0.1);
  expectDistance(interior.placeOf({1.0, 0.0, 0.0}), -0.5);
}

TEST(Interior, IsWhereTheWindingNumberIsNotZero) {
  for (const TriangleMesh& mesh : {bracket(), thickShell(), scaled(dentedBall(), 4.0)}) {
    const Interior interior = interiorOf(mesh);
    Chance chance(31);
    int inside = 0, outside = 0;
    for (int i = 0; i < 1500; ++i) {
      const Vector3d p = interior.box().center() + interior.box().sizes().cwiseProduct(chance.pose(0.6).translation());
      const double expected = distanceFromSolid(mesh, p);
      const Interior::Place place = interior.placeOf(p);
      EXPECT_NEAR(place.lower_bound, expected, 1e-12) << p.transpose();
      EXPECT_NEAR(place.upper_bound, expected, 1e-12) << p.transpose();
      EXPECT_NEAR((p - place.nearest).norm(), std::abs(expected), 1e-12);
      EXPECT_TRUE(interior.hasSurfaceWithin(p, std::abs(expected) + 1e-12));
      EXPECT_FALSE(interior.hasSurfaceWithin(p, std::abs(expected) - 1e-12));
      (expected < 0.0 ? inside : outside) += 1;
    }
    EXPECT_GT(inside, 200);
    EXPECT_GT(outside, 200);
  }
}

TEST(Interior, LeavesOutNoTriangleThatIsTheNearest) {
  for (const TriangleMesh& mesh : {bracket(), thickShell(), together({thickShell(), scaled(dentedBall(), 0.2)})}) {
    const std::vector<Triangle> triangles = trianglesOfMesh(mesh);
    const Interior interior(triangles);
    Chance chance(37);
    for (int i = 0; i < 1500; ++i) {
      const Vector3d p = interior.box().center() + interior.box().sizes().cwiseProduct(chance.pose(0.6).translation());
      double nearest = std::numeric_limits<double>::infinity();
      for (const Triangle& triangle : triangles)
        nearest = std::min(nearest, (nearestCombination(triangle, p) - p).norm());
      const Interior::Place place = interior.placeOf(p);
      EXPECT_EQ((p - place.nearest).norm(), nearest) << p.transpose();
      EXPECT_EQ(std::max(place.upper_bound, -place.lower_bound), nearest) << p.transpose();
      EXPECT_TRUE(interior.hasSurfaceWithin(p, nearest + 1e-14)) << p.transpose();
    }
  }
}

TEST(Interior, ProvesItsBoundsAtSlivers) {
  // Each side of a box is cut into triangles as thin as 1e-9 of their length.
  TriangleMesh mesh;
  const TriangleMesh box = boxMesh(Vector3d::Zero(), Vector3d::Ones());
  for (const auto& [a, b, c] : box.triangles) {
    const Vector3d &p = box.vertices[a], &q = box.vertices[b], &r = box.vertices[c];
    const Vector3d near_q = q + 1e-9 * (r - q);
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {p, q, near_q, r});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  const Interior interior = interiorOf(mesh);
  Chance chance(5);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = Vector3d::Constant(0.5) + chance.pose(0.5).translation();
    const double expected = -std::min(p.minCoeff(), 1.0 - p.maxCoeff());
    const Interior::Place place = interior.placeOf(p);
    EXPECT_LE(place.lower_bound, expected + 1e-15) << p.transpose();
    EXPECT_GE(place.upper_bound, expected - 1e-15) << p.transpose();
    EXPECT_LE(place.upper_bound - place.lower_bound, 1e-8) << p.transpose();
  }
}

}  // namespace proximity_server::scene::interior_test
