#include "proximity_server/narrowphase/shape/hull_support.h"

#include "chance.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::narrowphase::hull_support_test {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Points onEllipsoid(int count, const Vector3d& radii, Chance& random) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(radii.cwiseProduct(random.direction()));
  return points;
}

/// Points of a dome z = 0.4 - curvature (x^2 + y^2) over a wide base.
Points dome(int count, double curvature, Chance& random) {
  Points points{{-0.4, -0.4, -0.4}, {0.4, -0.4, -0.4}, {0, 0.4, -0.4}};
  for (int i = 0; i < count; ++i) {
    const double x = random.between(-0.4, 0.4), y = random.between(-0.4, 0.4);
    points.emplace_back(x, y, 0.4 - curvature * (x * x + y * y));
  }
  return points;
}

/// The greatest height of a vertex, one by one.
double greatestHeight(const ConvexHull& hull, const Vector3d& direction) {
  double height = -std::numeric_limits<double>::infinity();
  for (const Vector3d& vertex : hull.vertices()) height = std::max(height, vertex.dot(direction));
  return height;
}

double heightFound(const HullSupport& support, const Vector3d& direction) {
  return support.hull().vertices()[support.farthestVertex(direction)].dot(direction);
}

void expectFarthestEverywhere(const HullSupport& support, int directions, Chance& random) {
  for (int i = 0; i < directions; ++i) {
    const Vector3d direction = random.direction();
    ASSERT_EQ(heightFound(support, direction), greatestHeight(support.hull(), direction)) << direction.transpose();
  }
}

/// Directions through the corners of all cells of a table with as many cells, through their edges, and an ulp to each
/// side.
std::vector<Vector3d> borders(int cells) {
  std::vector<Vector3d> directions;
  for (int i = 0; i <= 2 * cells; ++i)
    for (int j = 0; j <= 2 * cells; ++j)
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          const double u = static_cast<double>(i) / cells - 1.0, v = static_cast<double>(j) / cells - 1.0;
          Vector3d d;
          d[axis] = sign;
          d[(axis + 2) % 3] = v;
          for (const double at : {u, std::nextafter(u, -2.0), std::nextafter(u, 2.0)}) {
            d[(axis + 1) % 3] = at;
            directions.push_back(d);
          }
        }
  return directions;
}

TEST(HullSupport, FindsTheFarthestVertexOfHullsOfEverySize) {
  Chance random(1);
  for (int count = 1; count <= 120; ++count)
    expectFarthestEverywhere(HullSupport(ConvexHull(onEllipsoid(count, {0.5, 0.4, 0.3}, random))), 200, random);
  expectFarthestEverywhere(HullSupport(ConvexHull(onEllipsoid(3000, {0.5, 0.4, 0.3}, random))), 2000, random);
}

TEST(HullSupport, FindsTheFarthestVertexOfPlatesAndNeedles) {
  Chance random(2);
  for (const double thin : {1e-2, 1e-5, 1e-8}) {
    expectFarthestEverywhere(HullSupport(ConvexHull(onEllipsoid(80, {1.0, 0.7, thin}, random))), 1000, random);
    expectFarthestEverywhere(HullSupport(ConvexHull(onEllipsoid(80, {1.0, thin, thin}, random))), 1000, random);
    expectFarthestEverywhere(HullSupport(ConvexHull(onEllipsoid(80, {thin, thin, 1.0}, random))), 1000, random);
  }
}

TEST(HullSupport, FindsTheFarthestVertexFarFromTheOrigin) {
  Chance random(3);
  Points points = onEllipsoid(60, {0.5, 0.4, 0.3}, random);
  for (Vector3d& p : points) p += Vector3d(1e3, -2e3, 5e2);
  expectFarthestEverywhere(HullSupport(ConvexHull(points)), 2000, random);
}

TEST(HullSupport, FindsTheFarthestVertexOnTheBordersOfTheCells) {
  Chance random(4);
  for (const int count : {17, 32, 100, 200}) {
    const HullSupport support(ConvexHull(onEllipsoid(count, {0.5, 0.4, 0.3}, random)));
    for (const Vector3d& direction : borders(32))
      ASSERT_EQ(heightFound(support, direction), greatestHeight(support.hull(), direction)) << direction.transpose();
  }
}

// Many vertices of a finely divided cylinder are as far along its axis: the list of that cell is long.
TEST(HullSupport, FindsTheFarthestVertexOfAPrismAlongAndAcrossItsAxis) {
  Points points;
  for (int i = 0; i < 100; ++i)
    for (const double z : {-1.0, 1.0}) points.emplace_back(std::cos(0.02 * M_PI * i), std::sin(0.02 * M_PI * i), z);
  const HullSupport support{ConvexHull(points)};
  Chance random(5);
  expectFarthestEverywhere(support, 2000, random);
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) EXPECT_EQ(heightFound(support, sign * Vector3d::Unit(axis)), 1.0) << axis;
}

// Regression: the neighbours of vertices that are in one plane but for some roundings led the climb to a vertex that
// was not the farthest, and the bound of a query was wrong by 5e-15 m.
TEST(HullSupport, FindsTheFarthestOfManyVerticesInOnePlaneButForRounding) {
  Chance random(9);
  const auto rounding = [&] { return random.between(-5e-14, 5e-14); };
  for (int round = 0; round < 20; ++round) {
    Points points;
    for (int x = -2; x <= 2; ++x)
      for (int y = -2; y <= 2; ++y)
        for (int z = -2; z <= 2; ++z)
          if (std::max({std::abs(x), std::abs(y), std::abs(z)}) == 2)
            points.push_back(0.2 * Vector3d(x, y, z) + Vector3d(rounding(), rounding(), rounding()));
    const HullSupport support{ConvexHull(points)};
    ASSERT_GT(support.hull().size(), 20);
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 200; ++i) {
        const Vector3d direction = Vector3d::Unit(axis) + 1e-12 * Vector3d(rounding(), rounding(), rounding()) / 5e-14;
        ASSERT_EQ(heightFound(support, direction), greatestHeight(support.hull(), direction));
      }
    expectFarthestEverywhere(support, 200, random);
  }
}

// Regression: from some number of vertices on the search climbed, and ended up to 1e-12 m below the farthest.
TEST(HullSupport, FindsTheFarthestOfManyVerticesInOneCell) {
  Chance random(6);
  for (const double curvature : {1e-2, 1e-10, 1e-11}) {
    const HullSupport support(ConvexHull(dome(600, curvature, random)));
    ASSERT_GT(support.hull().size(), 200);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d direction =
          Vector3d::UnitZ() + curvature * Vector3d(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0);
      ASSERT_EQ(heightFound(support, direction), greatestHeight(support.hull(), direction)) << curvature;
    }
  }
}

TEST(HullSupport, HasMoreVerticesThanACellCanNumber) {
  Chance random(7);
  const HullSupport support(ConvexHull(onEllipsoid(70000, {0.5, 0.5, 0.5}, random)));
  ASSERT_GT(support.hull().size(), 0xffff);
  for (int i = 0; i < repeats(1000); ++i) {
    const Vector3d direction = random.direction();
    ASSERT_EQ(heightFound(support, direction), greatestHeight(support.hull(), direction));
  }
}

TEST(HullSupport, DoesNotDependOnTheLengthOfTheDirection) {
  Chance random(8);
  const HullSupport support(ConvexHull(onEllipsoid(100, {0.5, 0.4, 0.3}, random)));
  for (const double length : {1e-200, 1e-30, 1e30, 1e200})
    for (int i = 0; i < 100; ++i) {
      const Vector3d direction = random.direction();
      ASSERT_EQ(support.farthestVertex(length * direction), support.farthestVertex(direction)) << length;
    }
}

// Which vertex it is, nothing says; but with a height, it is its own.
TEST(HullSupport, GivesSomeVertexForADirectionThatIsNone) {
  Chance random(10);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  for (const Points& points : {onEllipsoid(10, {0.5, 0.4, 0.3}, random), onEllipsoid(100, {0.5, 0.4, 0.3}, random),
                               dome(600, 1e-10, random)}) {  // scanned, from a table, and with many vertices in a cell
    const HullSupport support{ConvexHull(points)};
    for (const double x : {0.0, kNaN, kInfinity, -kInfinity, 1e-310})
      for (const double y : {0.0, kNaN, kInfinity, 1e-310})
        for (const double z : {0.0, 1.0, 1e-310, kNaN}) {
          const Vector3d direction(x, y, z);
          const HullSupport::Farthest found = support.farthest(direction);
          ASSERT_GE(found.vertex, 0);
          ASSERT_LT(found.vertex, support.hull().size());
          if (!direction.allFinite()) continue;
          EXPECT_EQ(found.height, support.hull().vertices()[found.vertex].dot(direction)) << direction.transpose();
        }
  }
}

TEST(HullSupport, NamesTheFirstOfTheVerticesThatAreAsFar) {
  Points points;
  for (int i = 0; i < 40; ++i) points.emplace_back(std::cos(0.05 * M_PI * i), std::sin(0.05 * M_PI * i), 0.0);
  const HullSupport support{ConvexHull(points)};  // a polygon: along its axis all vertices are as far
  EXPECT_EQ(support.farthestVertex(Vector3d::UnitZ()), 0);
  EXPECT_EQ(support.farthestVertex(-Vector3d::UnitZ()), 0);
  const HullSupport cube(
      ConvexHull({{-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {1, 1, 1}}));
  EXPECT_EQ(cube.farthestVertex(Vector3d::UnitX()), 4);
  EXPECT_EQ(cube.farthestVertex(-Vector3d::UnitX()), 0);
}

}  // namespace proximity_server::narrowphase::hull_support_test
