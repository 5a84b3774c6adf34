#include "proximity_server/narrowphase/shape/convex_hull.h"

#include "chance.h"
#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

namespace proximity_server::narrowphase::convex_hull_test {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Points onEllipsoid(int count, unsigned seed) {
  Chance random(seed);
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(Vector3d(0.5, 0.4, 0.3).cwiseProduct(randomDirection(random)));
  return points;
}

Points inCube(int count, unsigned seed) {
  Chance random(seed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  Points points;
  for (int i = 0; i < count; ++i) points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  return points;
}

/// n^3 points of a lattice of spacing 1: most of them inside, on faces or on edges.
Points lattice(int n) {
  Points points;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) points.emplace_back(x, y, z);
  return points;
}

Points prism(int sides) {
  Points points;
  for (int i = 0; i < sides; ++i)
    for (const double z : {-0.5, 0.5})
      points.emplace_back(std::cos(2.0 * M_PI * i / sides), std::sin(2.0 * M_PI * i / sides), z);
  return points;
}

Points scaledBy(double factor, Points points) {
  for (Vector3d& point : points) point *= factor;
  return points;
}

Points movedBy(const Eigen::Isometry3d& motion, Points points) {
  for (Vector3d& point : points) point = motion * point;
  return points;
}

Points withNearDuplicates(Points points, double offset) {
  Chance random(2);
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) points.push_back(points[i] + offset * randomDirection(random));
  return points;
}

Points flattened(Points points) {
  for (Vector3d& point : points) point.z() = 0.0;
  return points;
}

struct Cloud {
  std::string name;
  Points points;
};

std::vector<Cloud> solidClouds() {
  Chance random(3);
  const Eigen::Isometry3d turned = randomPose(random, 1.0), far_away = randomPose(random, 1e4);
  return {{"tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
          {"ellipsoid of 32", onEllipsoid(32, 4)},
          {"ellipsoid of 1000", onEllipsoid(1000, 5)},
          {"cube of 2000", inCube(2000, 6)},
          {"lattice", lattice(6)},
          {"turned lattice", movedBy(turned, lattice(6))},
          {"prism of 100 sides", prism(100)},
          {"turned prism", movedBy(turned, prism(37))},
          {"small prism", scaledBy(1e-4, prism(12))},
          {"large prism", scaledBy(1e4, prism(12))},
          {"far prism", movedBy(far_away, prism(12))},
          {"duplicates", withNearDuplicates(onEllipsoid(50, 7), 0.0)},
          {"near duplicates 1e-16", withNearDuplicates(onEllipsoid(50, 7), 1e-16)},
          {"near duplicates 1e-12", withNearDuplicates(onEllipsoid(50, 7), 1e-12)},
          {"near duplicates 1e-6", withNearDuplicates(onEllipsoid(50, 7), 1e-6)},
          {"thin plate",
           {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1e-5}, {1, 0, 1e-5}, {1, 1, 1e-5}, {0, 1, 1e-5}}}};
}

std::vector<Cloud> allClouds() {
  Chance random(8);
  const Eigen::Isometry3d turned = randomPose(random, 1.0);
  std::vector<Cloud> clouds = solidClouds();
  const std::vector<Cloud> degenerate = {
      {"point", {{1, 2, 3}}},
      {"point twelve times", Points(12, Vector3d(1, 2, 3))},
      {"segment", {{1, 2, 3}, {4, 5, 6}}},
      {"points on a segment", {{0, 0, 0}, {3, 3, 3}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}},
      {"triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
      {"flat square with its middle", {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0.5, 0.5, 1}, {0.5, 0, 1}}},
      {"flat cloud", flattened(inCube(300, 9))},
      {"turned flat cloud", movedBy(turned, flattened(inCube(300, 9)))},
      {"turned points on a segment", movedBy(turned, {{0, 0, 0}, {1, 0, 0}, {0.3, 0, 0}, {0.7, 0, 0}})}};
  clouds.insert(clouds.end(), degenerate.begin(), degenerate.end());
  return clouds;
}

/// Rounding of a cloud: its coordinates carry it already.
double roundingOf(const Points& points) {
  double reach = 0.0;
  for (const Vector3d& point : points) reach = std::max(reach, point.norm());
  return 8.0 * std::numeric_limits<double>::epsilon() * reach;
}

double highest(const Points& points, const Vector3d& direction) {
  double height = -std::numeric_limits<double>::infinity();
  for (const Vector3d& point : points) height = std::max(height, direction.dot(point));
  return height;
}

/// Points about a segment of length 2 along a random direction, up to `thickness` beside it.
Points needle(int count, double thickness, Chance& random) {
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const Vector3d along = randomDirection(random);
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(place(random) * along + thickness * randomDirection(random));
  return points;
}

// Regression: a cloud of thickness 1e-11 and length 1.84 had a hull of length 0.44. The second axis of its affine frame
// was not perpendicular to the first.
TEST(ConvexHull, OfANeedleIsAsLongAsItsPoints) {
  Chance random(17);
  std::uniform_real_distribution<double> exponent(-15.0, -6.0);
  for (int i = 0; i < 3000; ++i) {
    const double thickness = std::pow(10.0, exponent(random));
    const Points points = needle(4 + i % 16, thickness, random);
    const ConvexHull hull(points);
    const Vector3d along = (points[1] - points[0]).normalized();
    const auto height = [&](const Vector3d& p, const Vector3d& q) { return along.dot(p) < along.dot(q); };
    const Vector3d farthest = *std::max_element(points.begin(), points.end(), height);
    const Vector3d kept = *std::max_element(hull.vertices().begin(), hull.vertices().end(), height);
    EXPECT_LE(along.dot(farthest - kept), 2e-14) << "thickness " << thickness;
  }
}

TEST(ConvexHull, VerticesAreInputPointsBitForBit) {
  for (const Cloud& cloud : allClouds()) {
    const ConvexHull hull(cloud.points);
    for (const Vector3d& vertex : hull.vertices())
      EXPECT_NE(std::find(cloud.points.begin(), cloud.points.end(), vertex), cloud.points.end()) << cloud.name;
  }
}

TEST(ConvexHull, ReachesAsFarAsTheCloudInEveryDirection) {
  Chance random(10);
  for (const Cloud& cloud : allClouds()) {
    const ConvexHull hull(cloud.points);
    for (int i = 0; i < 300; ++i) {
      const Vector3d direction = randomDirection(random);
      EXPECT_GE(highest(hull.vertices(), direction), highest(cloud.points, direction) - roundingOf(cloud.points))
          << cloud.name;
    }
  }
}

TEST(ConvexHull, HasNoVertexTwice) {
  for (const Cloud& cloud : allClouds()) {
    const Points vertices = ConvexHull(cloud.points).vertices();
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) EXPECT_NE(vertices[i], vertices[j]) << cloud.name;
  }
}

TEST(ConvexHull, DropsWhatIsNotACorner) { EXPECT_EQ(ConvexHull(lattice(5)).size(), 8); }

TEST(ConvexHull, KeepsEveryCornerOfAPrism) { EXPECT_EQ(ConvexHull(prism(100)).size(), 200); }

TEST(ConvexHull, LocalMaximaOverTheAdjacencyAreGlobal) {
  Chance random(11);
  for (const Cloud& cloud : allClouds()) {
    const ConvexHull hull(cloud.points);
    const auto height = [&hull](int vertex, const Vector3d& n) { return n.dot(hull.vertices()[vertex]); };
    for (int i = 0; i < 200; ++i) {
      const Vector3d n = randomDirection(random);
      const double top = highest(hull.vertices(), n);
      for (int vertex = 0; vertex < hull.size(); ++vertex) {
        bool is_local_maximum = true;
        for (const int neighbour : hull.neighbours(vertex))
          is_local_maximum = is_local_maximum && height(neighbour, n) <= height(vertex, n);
        if (is_local_maximum) {
          EXPECT_GE(height(vertex, n), top - roundingOf(cloud.points)) << cloud.name;
        }
      }
    }
  }
}

TEST(ConvexHull, AdjacencyIsSymmetricAscendingAndWithoutLoops) {
  for (const Cloud& cloud : allClouds()) {
    const ConvexHull hull(cloud.points);
    std::set<std::pair<int, int>> edges;
    for (int vertex = 0; vertex < hull.size(); ++vertex) {
      EXPECT_TRUE(std::is_sorted(hull.neighbours(vertex).begin(), hull.neighbours(vertex).end())) << cloud.name;
      for (const int neighbour : hull.neighbours(vertex)) {
        EXPECT_NE(vertex, neighbour) << cloud.name;
        EXPECT_TRUE(edges.insert({vertex, neighbour}).second) << "edge twice: " << cloud.name;
      }
    }
    for (const auto& [from, to] : edges) EXPECT_TRUE(edges.count({to, from})) << cloud.name;
  }
}

TEST(ConvexHull, TrianglesOfASolidCloseUp) {
  for (const Cloud& cloud : solidClouds()) {
    const ConvexHull hull(cloud.points);
    std::map<std::pair<int, int>, int> directed_edges;
    for (const auto& [i, j, k] : hull.triangles())
      for (const auto& edge : {std::pair(i, j), std::pair(j, k), std::pair(k, i)}) ++directed_edges[edge];
    for (const auto& [edge, count] : directed_edges) {
      EXPECT_EQ(count, 1) << cloud.name;
      EXPECT_TRUE(directed_edges.count({edge.second, edge.first})) << cloud.name;
    }
  }
}

TEST(ConvexHull, TrianglesOfASolidSatisfyEuler) {
  for (const Cloud& cloud : solidClouds()) {
    const ConvexHull hull(cloud.points);
    EXPECT_EQ(hull.triangles().size(), 2 * static_cast<std::size_t>(hull.size()) - 4) << cloud.name;
  }
}

TEST(ConvexHull, NoVertexLiesOutsideOfATriangle) {
  for (const Cloud& cloud : solidClouds()) {
    const ConvexHull hull(cloud.points);
    const auto corner = [&hull](int i) { return hull.vertices()[i]; };
    for (const auto& [i, j, k] : hull.triangles()) {
      const Vector3d normal = (corner(j) - corner(i)).cross(corner(k) - corner(i));
      // Triangles that cut a flat face may be slivers; their normal says nothing beyond their rounding.
      const double longest =
          std::max({(corner(j) - corner(i)).norm(), (corner(k) - corner(i)).norm(), (corner(k) - corner(j)).norm()});
      const double reach = highest(cloud.points, normal.normalized()) - normal.normalized().dot(corner(i));
      EXPECT_LE(reach * normal.norm(), 4.0 * roundingOf(cloud.points) * longest * longest) << cloud.name;
    }
  }
}

struct KnownHull {
  const char* name;
  Points points;
  int dimension;
  double volume;
};

TEST(ConvexHull, KnowsDimensionAndVolume) {
  const KnownHull known[] = {
      {"point", {{1, 2, 3}}, 0, 0.0},
      {"duplicates of a point", Points(9, Vector3d(0.1, 0.2, 0.3)), 0, 0.0},
      {"segment", {{0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}}, 1, 0.0},
      {"square", {{0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}}, 2, 0.0},
      {"tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 3, 1.0 / 6.0},
      {"lattice", lattice(4), 3, 27.0},
      {"thin plate", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 3e-6}}, 3, 1e-6},
      {"octahedron", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, 3, 4.0 / 3.0},
  };
  for (const KnownHull& k : known) {
    EXPECT_EQ(ConvexHull(k.points).dimension(), k.dimension) << k.name;
    EXPECT_NEAR(ConvexHull(k.points).volume(), k.volume, 1e-14 * std::max(k.volume, 1e-6)) << k.name;
  }
}

TEST(ConvexHull, VolumeDoesNotDependOnThePose) {
  Chance random(12);
  for (int i = 0; i < 20; ++i)
    EXPECT_NEAR(ConvexHull(movedBy(randomPose(random, 10.0), lattice(3))).volume(), 8.0, 1e-12);
}

TEST(ConvexHull, TurnedPolygonKeepsItsDimension) {
  Chance random(13);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(ConvexHull(movedBy(randomPose(random, 1.0), flattened(lattice(4)))).dimension(), 2);
}

TEST(ConvexHull, PolygonHasTheTrianglesOfOneSide) {
  const ConvexHull square({{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0.5, 0.5, 1}});
  EXPECT_EQ(square.triangles().size(), 2u);
}

TEST(ConvexHull, RefusesAnEmptyCloud) { EXPECT_THROW(ConvexHull({}), std::invalid_argument); }

TEST(ConvexHull, RefusesACoordinateThatIsNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int axis = 0; axis < 3; ++axis) {
      Points points = lattice(2);
      points[3][axis] = bad;
      EXPECT_THROW(ConvexHull{points}, std::invalid_argument) << bad;
    }
}

}  // namespace proximity_server::narrowphase::convex_hull_test
