// The distance subalgorithms of the benchmark against the exact answer.
#include "benchmark/subalgorithms.h"

#include "oracle/exact_oracle.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

namespace proximity_server::benchmark::subalgorithms_test {

using namespace narrowphase;

using Eigen::Vector3d;

/// Returns points about a random centre near the origin.
PointSet randomSet(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  PointSet set;
  const Vector3d centre = 0.5 * vector();
  for (; set.size < size; ++set.size) set.points[set.size] = centre + vector();
  return set;
}

/// Returns the points with one of the nearest part's in the last place, as PointSet promises.
PointSet withNewestInPart(PointSet set) {
  const unsigned members = nearestByExplicitSolve(set).members;
  std::size_t place = 0;
  while ((members >> place & 1u) == 0) ++place;
  std::swap(set.points[place], set.points[static_cast<std::size_t>(set.size) - 1]);
  return set;
}

TEST(Subalgorithms, AgreeWithTheExactDistanceOnOrdinarySimplices) {
  std::mt19937 random(81);
  int enclosing = 0, edges = 0;
  for (int i = 0; i < 4000; ++i) {
    const PointSet set = withNewestInPart(randomSet(1 + i % 4, random));
    const double expected =
        static_cast<double>(exactDistanceToOrigin({set.points.begin(), set.points.begin() + set.size}));
    for (const auto nearest :
         {nearestByJohnson, nearestByExplicitSolve, nearestByVoronoiRegions, nearestBySignedVolumes})
      EXPECT_NEAR(nearest(set).point.norm(), expected, 1e-12);
    enclosing += expected == 0.0 ? 1 : 0;
    const unsigned members = nearestByVoronoiRegions(set).members;
    edges += set.size == 4 && (members & (members - 1)) != 0 && members != 15u ? 1 : 0;
  }
  EXPECT_GT(enclosing, 30);
  EXPECT_GT(edges, 200);
}

TEST(Subalgorithms, AgreeOnThePartThatHasTheNearestPoint) {
  std::mt19937 random(82);
  for (int i = 0; i < 4000; ++i) {
    const PointSet set = withNewestInPart(randomSet(1 + i % 4, random));
    const unsigned members = nearestByExplicitSolve(set).members;
    for (const auto nearest : {nearestByJohnson, nearestByVoronoiRegions, nearestBySignedVolumes})
      EXPECT_EQ(nearest(set).members, members);
  }
}

}  // namespace proximity_server::benchmark::subalgorithms_test
