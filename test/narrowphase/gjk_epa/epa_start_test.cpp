#include "narrowphase/gjk_epa/epa_start.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace proximity_server::narrowphase::epa_start_test {

using Eigen::Vector3d;

double volumeOf(const std::array<CsoVertex, 4>& vertices) {
  const Vector3d& o = vertices[0].point;
  return std::abs((vertices[1].point - o).dot((vertices[2].point - o).cross(vertices[3].point - o))) / 6.0;
}

Shape square() { return hullOf({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}); }
Shape alongX() { return hullOf({{-1, 0, 0}, {1, 0, 0}}); }

TEST(EpaStart, GrowsASimplexOfAnyDimensionToATetrahedron) {
  TwoCores cores(cube(), cube(), Vector3d::Zero());  // the CSO is the cube of half edge 2
  const CsoVertex up = cores.cso.vertex({1, 1, 1}), down = cores.cso.vertex({-1, -1, -1});
  const CsoVertex right = cores.cso.vertex({1, -1, 1}), left = cores.cso.vertex({-1, 1, 1});
  for (const Simplex& simplex : {simplexOf({up}), simplexOf({up, down}), simplexOf({up, down, right})}) {
    const EpaStart start = epaStart(cores.cso, simplex);
    EXPECT_FALSE(start.plane.has_value());
    EXPECT_GE(volumeOf(start.vertices), 1.0);
    for (const CsoVertex& vertex : start.vertices) EXPECT_EQ(vertex.point.cwiseAbs(), Vector3d(2, 2, 2));
  }
  const EpaStart whole = epaStart(cores.cso, simplexOf({up, down, right, left}));
  EXPECT_FALSE(whole.plane.has_value());
  EXPECT_EQ(whole.vertices[3].point, left.point);
}

TEST(EpaStart, KeepsTheEndsOfATriangleWithoutArea) {
  TwoCores cores(cube(), cube(), Vector3d::Zero());
  const Vector3d up(2, 2, 2), down(-2, -2, -2), middle(0.5, 0.5, 0.5);
  std::array<Vector3d, 3> order{down, middle, up};
  const auto lessX = [](const Vector3d& p, const Vector3d& q) { return p.x() < q.x(); };
  do {
    const EpaStart start = epaStart(cores.cso, simplexOf({vertexAt(order[0]), vertexAt(order[1]), vertexAt(order[2])}));
    EXPECT_FALSE(start.plane.has_value());
    EXPECT_GE(volumeOf(start.vertices), 1.0);
    for (const Vector3d& end : {up, down})
      EXPECT_TRUE(std::any_of(start.vertices.begin(), start.vertices.begin() + 2,
                              [&](const CsoVertex& v) { return v.point == end; }));
  } while (std::next_permutation(order.begin(), order.end(), lessX));
}

// The CSO is the cube of half edge 2 about (-1.5, 0, 0): it reaches 0.5 m to one side of x = 0, and 3.5 m to the other.
TEST(EpaStart, TakesTheVertexOnTheDeeperSideOfATriangle) {
  TwoCores cores(cube(), cube(), Vector3d(1.5, 0, 0));
  const CsoVertex corners[] = {vertexAt({0, 1, 1}), vertexAt({0, -1, 1}), vertexAt({0, 0, -1})};
  for (const Simplex& simplex :
       {simplexOf({corners[0], corners[1], corners[2]}), simplexOf({corners[1], corners[0], corners[2]})}) {
    const EpaStart start = epaStart(cores.cso, simplex);
    EXPECT_FALSE(start.plane.has_value());
    EXPECT_EQ(start.vertices[3].point.x(), -3.5);
  }
}

TEST(EpaStart, AnswersWithThePlaneOfTheFaceThatTheOriginLiesOn) {
  for (const double side : {1.0, -1.0}) {
    TwoCores cores(cube(), cube(), Vector3d(2.0 * side, 0, 0));  // the CSO ends at x = 0
    const EpaStart start =
        epaStart(cores.cso, simplexOf({vertexAt({0, 2, 2}), vertexAt({0, -2, 2}), vertexAt({0, 0, -2})}));
    ASSERT_TRUE(start.plane.has_value());
    EXPECT_EQ(start.plane->normal, side * Vector3d::UnitX());
    EXPECT_EQ(start.plane->depth, 0.0);
    EXPECT_FALSE(start.plane->two_sided);
  }
}

TEST(EpaStart, AnswersWithBothSidesOfAFlatCso) {
  TwoCores cores(square(), square(), Vector3d::Zero());
  for (const Simplex& simplex :
       {simplexOf({cores.cso.vertex({1, 1, 0}), cores.cso.vertex({-1, -1, 0})}),
        simplexOf({cores.cso.vertex({1, 1, 0}), cores.cso.vertex({-1, -1, 0}), cores.cso.vertex({1, -1, 0})})}) {
    const EpaStart start = epaStart(cores.cso, simplex);
    ASSERT_TRUE(start.plane.has_value());
    EXPECT_NEAR(std::abs(start.plane->normal.z()), 1.0, 1e-15);
    EXPECT_NEAR(start.plane->depth, 0.0, 1e-15);
    EXPECT_TRUE(start.plane->two_sided);
  }
}

TEST(EpaStart, AnswersWithAPlaneThroughACsoThatIsASegment) {
  TwoCores cores(alongX(), alongX(), Vector3d(0.5, 0, 0));
  const EpaStart start =
      epaStart(cores.cso, simplexOf({cores.cso.vertex(Vector3d::UnitX()), cores.cso.vertex(-Vector3d::UnitX())}));
  ASSERT_TRUE(start.plane.has_value());
  EXPECT_NEAR(start.plane->normal.x(), 0.0, 1e-15);
  EXPECT_NEAR(start.plane->normal.norm(), 1.0, 1e-15);
  EXPECT_NEAR(start.plane->depth, 0.0, 1e-15);
  EXPECT_TRUE(start.plane->two_sided);
}

// b is a hundred roundings farther along y: so it is apart, along y, by less than any tolerance.
TEST(EpaStart, PointsFromASegmentToTheOriginThatLiesBesideIt) {
  const double gap = 1e-12;
  TwoCores cores(alongX(), alongX(), Vector3d(0.5, gap, 0));
  const EpaStart start =
      epaStart(cores.cso, simplexOf({cores.cso.vertex(Vector3d::UnitX()), cores.cso.vertex(-Vector3d::UnitX())}));
  ASSERT_TRUE(start.plane.has_value());
  EXPECT_TRUE(isNear(start.plane->normal, Vector3d::UnitY(), 1e-15));
  EXPECT_NEAR(start.plane->depth, -gap, 1e-15);
  EXPECT_FALSE(start.plane->two_sided);
}

TEST(EpaStart, AnswersWithAnyPlaneThroughACsoThatIsAPoint) {
  TwoCores cores(pointAt({1, 2, 3}), pointAt({1, 2, 3}), Vector3d::Zero());
  const EpaStart start = epaStart(cores.cso, simplexOf({cores.cso.vertex(Vector3d::UnitX())}));
  ASSERT_TRUE(start.plane.has_value());
  EXPECT_NEAR(start.plane->normal.norm(), 1.0, 1e-15);
  EXPECT_EQ(start.plane->depth, 0.0);
  EXPECT_TRUE(start.plane->two_sided);
}

}  // namespace proximity_server::narrowphase::epa_start_test
