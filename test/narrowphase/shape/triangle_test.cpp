#include "narrowphase/shape/triangle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::triangle_test {

using Eigen::Vector3d;

Vector3d areaOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return areaVector(b - a, c - b, a - c); }

// Whichever of the edges is the longest.
TEST(AreaVector, IsTwiceTheAreaCounterClockwise) {
  const Vector3d a(0, 0, 0), b(4, 0, 0), c(0, 3, 0);
  EXPECT_EQ(areaOf(a, b, c), Vector3d(0, 0, 12));
  EXPECT_EQ(areaOf(b, c, a), Vector3d(0, 0, 12));
  EXPECT_EQ(areaOf(c, a, b), Vector3d(0, 0, 12));
  EXPECT_EQ(areaOf(a, c, b), Vector3d(0, 0, -12));
}

// The middle corner lies 1 mm beside the long edge: the rounding of two edges of 190 m leaves 1e-11 of the area along
// it.
TEST(AreaVector, OfANeedleIsPerpendicularToItsLongestEdge) {
  const Vector3d a(0, 0, 0), c(1e3 / 3.0, 1e3 / 7.0, 1e3 / 11.0);
  for (const double part : {0.3, 0.5, 0.6}) {
    const Vector3d b = part * c + 1e-3 * c.cross(Vector3d(1, 2, 3)).normalized();
    for (const Vector3d& area : {areaOf(a, b, c), areaOf(b, c, a), areaOf(c, a, b)}) {
      EXPECT_LE(std::abs(area.dot(c - a)), 1e-15 * area.norm() * (c - a).norm());
      EXPECT_NEAR(area.norm(), 1e-3 * c.norm(), 1e-9);
    }
  }
}

TEST(AreaVector, OfAnEdgeIsZero) { EXPECT_EQ(areaOf({1, 2, 3}, {2, 4, 6}, {3, 6, 9}), Vector3d(0, 0, 0)); }

}  // namespace proximity_server::narrowphase::triangle_test
