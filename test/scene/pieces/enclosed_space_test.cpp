#include "scene/pieces/enclosed_space.h"

#include "scene/pieces/boxes.h"
#include "scene/pieces/mesh_parts.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <limits>

namespace proximity_server::scene::enclosed_space_test {

using Eigen::Vector3d;

const Vector3d kUnscaled = Vector3d::Ones();

EnclosedSpace spaceOf(const std::vector<TriangleMesh>& meshes) {
  const TriangleMesh all = together(meshes);
  return EnclosedSpace(TriangleBoxes(trianglesOf(all.vertices, all.triangles)));
}

bool holds(const EnclosedSpace& space, const Vector3d& p) {
  Effort endless(std::numeric_limits<double>::infinity());
  return space.holds(p, endless);
}

TEST(EnclosedSpace, OfABoxHoldsThePointsWithinItsSides) {
  const EnclosedSpace space = spaceOf({boxMesh({1, 2, 3}, {4, 2, 1})});
  Chance chance(61);
  int inside = 0, outside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d place(chance.between(-0.5, 1.5), chance.between(-0.5, 1.5), chance.between(-0.5, 1.5));
    const bool expected = place.minCoeff() > 0.0 && place.maxCoeff() < 1.0;
    EXPECT_EQ(holds(space, Vector3d(1, 2, 3) + place.cwiseProduct(Vector3d(4, 2, 1))), expected) << place.transpose();
    (expected ? inside : outside) += 1;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 1000);
}

TEST(EnclosedSpace, EndsWithinRoundingOfItsSides) {
  const EnclosedSpace space = spaceOf({boxMesh({0, 0, 0}, kUnscaled)});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {0.0, 1.0}) {
      const double outwards = side == 0.0 ? -1e-9 : 1e-9;
      Vector3d p(0.3, 0.4, 0.6);
      p[axis] = side + outwards;
      EXPECT_FALSE(holds(space, p)) << p.transpose();
      p[axis] = side - outwards;
      EXPECT_TRUE(holds(space, p)) << p.transpose();
    }
  }
}

TEST(EnclosedSpace, DoesNotHoldAHollowWhoseSidesFaceIntoIt) {
  const EnclosedSpace space = spaceOf({boxMesh({0, 0, 0}, 3.0 * kUnscaled), boxMesh({2, 1, 1}, {-1, 1, 1})});
  EXPECT_FALSE(holds(space, {1.5, 1.5, 1.5}));
  EXPECT_TRUE(holds(space, {0.5, 1.5, 1.5}));
  EXPECT_TRUE(holds(space, {1.5, 1.5, 2.5}));
}

TEST(EnclosedSpace, HoldsTheOverlapOfTwoSolids) {
  const EnclosedSpace space = spaceOf({boxMesh({0, 0, 0}, 2.0 * kUnscaled), boxMesh({1, 0.1, 0.1}, 2.0 * kUnscaled)});
  EXPECT_TRUE(holds(space, {1.5, 1.0, 1.0}));
  EXPECT_TRUE(holds(space, {0.5, 1.0, 1.0}));
  EXPECT_TRUE(holds(space, {2.5, 1.0, 1.0}));
  EXPECT_FALSE(holds(space, {3.5, 1.0, 1.0}));
}

TEST(EnclosedSpace, HoldsASolidThatIsInsideOut) {
  const EnclosedSpace space = spaceOf({boxMesh({1, 0, 0}, {-1, 1, 1})});
  EXPECT_TRUE(holds(space, {0.5, 0.4, 0.3}));
  EXPECT_FALSE(holds(space, {1.5, 0.4, 0.3}));
}

// A ray along the edge of two triangles meets both or neither, as rounding will have it.
TEST(EnclosedSpace, MayHoldAPointBelowACornerOnEachOfItsRays) {
  const Vector3d rays[] = {Eigen::AngleAxisd(-0.7391, Vector3d(0.317, 0.911, -0.263).normalized()) * Vector3d::UnitZ(),
                           Eigen::AngleAxisd(-2.1731, Vector3d(-0.571, 0.337, 0.749).normalized()) * Vector3d::UnitZ()};
  // Two triangles at each edge from a corner on a ray to one of the ends of this axis, on both sides of the plane of
  // the rays.
  const Vector3d axis = rays[0].cross(rays[1]).normalized(), back = -rays[0] - rays[1];
  TriangleMesh mesh;
  mesh.vertices = {axis, -axis, rays[0], rays[1], back};
  for (int i = 0; i < 3; ++i) {
    mesh.triangles.push_back({0, 2 + i, 2 + (i + 1) % 3});
    mesh.triangles.push_back({1, 2 + (i + 1) % 3, 2 + i});
  }
  const EnclosedSpace space(TriangleBoxes(trianglesOf(mesh.vertices, mesh.triangles)));
  int lost = 0;
  for (int i = 0; i < 100; ++i) {
    // The corners are on both rays from the origin only; the points beside it are on one ray, below an edge.
    const Vector3d p = i == 0 ? Vector3d(Vector3d::Zero()) : Vector3d(0.003 * i * rays[i % 2]);
    EXPECT_TRUE(space.mayHold(p)) << i;
    lost += !holds(space, p);
  }
  EXPECT_GT(lost, 0);  // the rays do meet what rounding decides
  EXPECT_FALSE(space.mayHold(1.01 * rays[0]));
}

TEST(EnclosedSpace, OfNoTrianglesHoldsNothing) { EXPECT_FALSE(holds(EnclosedSpace(TriangleBoxes({})), {0, 0, 0})); }

TEST(EnclosedSpace, EndsWhenTheEffortIsSpent) {
  const EnclosedSpace space = spaceOf({boxMesh({0, 0, 0}, kUnscaled)});
  Effort none(0.0);
  EXPECT_THROW(space.holds({0.5, 0.5, 0.5}, none), Effort::Exceeded);
}

// Points below many thin pillars: the box of a tree's node is left out only where no ray can meet it.
TEST(EnclosedSpace, FindsEachOfManySolids) {
  std::vector<TriangleMesh> pillars;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) pillars.push_back(boxMesh({2.0 * i, 2.0 * j, 0.0}, {1, 1, 5}));
  const EnclosedSpace space = spaceOf(pillars);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      EXPECT_TRUE(holds(space, {2.0 * i + 0.4, 2.0 * j + 0.7, 2.5}));
      EXPECT_FALSE(holds(space, {2.0 * i + 1.4, 2.0 * j + 0.7, 2.5}));
      EXPECT_FALSE(holds(space, {2.0 * i + 0.4, 2.0 * j + 1.7, 2.5}));
    }
  }
}

}  // namespace proximity_server::scene::enclosed_space_test
