#include "scene/pieces/mesh_parts.h"

#include "scene/pieces/boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace proximity_server::scene::mesh_parts_test {

using Eigen::Vector3d;
using Numbers = std::vector<int>;

const Vector3d kNoScale = Vector3d::Ones();

std::size_t verticesInUse(const TriangleMesh& mesh) {
  std::set<int> used;
  for (const auto& triangle : mesh.triangles) used.insert(triangle.begin(), triangle.end());
  return used.size();
}

/// Two triangles with one corner in common, by its coordinates, and one that stands apart.
const TriangleMesh kThree{
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 0, 0}, {9, 1, 0}, {9, 0, 1}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}},
    {{{0, 1, 2}}, {{3, 4, 5}}, {{6, 7, 8}}}};

// --- welding

TEST(Welded, MakesVerticesAtTheSamePlaceOne) {
  EXPECT_EQ(verticesInUse(boxMesh({1, 2, 3}, kNoScale)), 36u);
  EXPECT_EQ(verticesInUse(welded(boxMesh({1, 2, 3}, kNoScale))), 8u);
}

TEST(Welded, KeepsTheTrianglesAndTheirPlaces) {
  const TriangleMesh mesh = boxMesh({1, 2, 3}, kNoScale), result = welded(mesh);
  ASSERT_EQ(result.triangles.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(result.vertices[result.triangles[t][i]], mesh.vertices[mesh.triangles[t][i]]);
}

TEST(Welded, DoesNotJoinVerticesThatDifferInOneCoordinate) {
  const TriangleMesh mesh{{{0, 0, 0}, {0, 0, 1e-300}, {0, 1, 0}}, {{{0, 1, 2}}}};
  EXPECT_EQ(verticesInUse(welded(mesh)), 3u);
}

// --- components

TEST(ComponentNumbers, ConnectTrianglesThatShareOneVertex) {
  EXPECT_EQ(componentNumbers(welded(kThree)), (Numbers{0, 1, 0}));
}

TEST(ComponentNumbers, CountInTheOrderOfTheFirstTriangles) {
  const TriangleMesh boxes =
      welded(together({boxMesh({5, 0, 0}, kNoScale), boxMesh({0, 0, 0}, kNoScale), boxMesh({9, 0, 0}, kNoScale)}));
  Numbers expected;
  for (int box = 0; box < 3; ++box) expected.insert(expected.end(), 12, box);
  EXPECT_EQ(componentNumbers(boxes), expected);
}

TEST(ComponentNumbers, ConnectChainsWhoseLastTriangleClosesThem) {
  const TriangleMesh chain{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {6, 0, 0}},
                           {{{0, 1, 2}}, {{4, 5, 6}}, {{2, 3, 4}}}};
  EXPECT_EQ(componentNumbers(chain), (Numbers{0, 0, 0}));
}

// --- parts

TEST(PartsOf, HaveTheirTrianglesAndOnlyTheVerticesThatTheyNeed) {
  const std::vector<TriangleMesh> parts = partsOf(welded(kThree), {0, 1, 0});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].triangles.size(), 2u);
  EXPECT_EQ(parts[0].vertices.size(), 5u);
  EXPECT_EQ(parts[1].triangles.size(), 1u);
  EXPECT_EQ(parts[1].vertices.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(parts[0].vertices[parts[0].triangles[1][i]], kThree.vertices[6 + i]);
    EXPECT_EQ(parts[1].vertices[parts[1].triangles[0][i]], kThree.vertices[3 + i]);
  }
}

// The corner that the first and the last triangle have in common is a vertex of either part.
TEST(PartsOf, MayShareAVertex) {
  const std::vector<TriangleMesh> parts = partsOf(welded(kThree), {0, 0, 1});
  EXPECT_EQ(parts[0].vertices.size(), 6u);
  ASSERT_EQ(parts[1].vertices.size(), 3u);
  EXPECT_EQ(parts[1].vertices[parts[1].triangles[0][0]], Vector3d(0, 0, 0));
}

// --- closed components

TEST(IsClosed, ABoxIsAndWithoutATriangleIsNot) {
  TriangleMesh mesh = welded(boxMesh({0, 0, 0}, kNoScale));
  EXPECT_TRUE(isClosed(mesh));
  mesh.triangles.pop_back();
  EXPECT_FALSE(isClosed(mesh));
}

TEST(IsClosed, ABoxWithATriangleThatFacesInwardsIsNot) {
  TriangleMesh mesh = welded(boxMesh({0, 0, 0}, kNoScale));
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_FALSE(isClosed(mesh));
}

TEST(IsClosed, TrianglesWithACornerTwiceDoNotCount) {
  TriangleMesh mesh = welded(boxMesh({0, 0, 0}, kNoScale));
  const auto [a, b, c] = mesh.triangles[0];
  mesh.triangles.push_back({a, a, b});
  mesh.triangles.push_back({b, c, c});
  mesh.triangles.push_back({c, a, c});
  EXPECT_TRUE(isClosed(mesh));
  mesh.triangles = {{a, a, b}};
  EXPECT_FALSE(isClosed(mesh));
}

TEST(IsClosed, TwoSidesOfOneTriangleAre) {
  EXPECT_TRUE(isClosed({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 1}}}}));
}

// --- volume

TEST(EnclosedVolume, IsPositiveWhereTheTrianglesFaceOutwards) {
  EXPECT_NEAR(enclosedVolume(boxMesh({5, 6, 7}, {1, 2, 3})), 6.0, 1e-12);
  EXPECT_NEAR(enclosedVolume(boxMesh({5, 6, 7}, {-1, 2, 3})), -6.0, 1e-12);
}

TEST(EnclosedVolume, LosesNothingFarFromTheOrigin) {
  const double far = std::ldexp(1.0, 30);
  EXPECT_NEAR(enclosedVolume(boxMesh({far, -far, far}, {1, 2, 3})), 6.0, 1e-12);
}

TEST(TrianglesOf, HaveTheCornersOfTheirVertices) {
  const std::vector<Triangle> triangles = trianglesOf(kThree.vertices, kThree.triangles);
  ASSERT_EQ(triangles.size(), 3u);
  EXPECT_EQ(triangles[1][2], Vector3d(9, 0, 1));
  EXPECT_EQ(triangles[2][1], Vector3d(-1, 0, 0));
}

}  // namespace proximity_server::scene::mesh_parts_test
