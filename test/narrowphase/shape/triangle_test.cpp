#include "narrowphase/shape/triangle.h"

#include <gtest/gtest.h>

#include "narrowphase/near.h"

namespace proximity_server::narrowphase {
namespace {

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

// The corner far away is rounded to 2^-22 m: the part of the area along the long edge that this leaves is dropped.
TEST(AreaVector, OfANeedleIsPerpendicularToItsLongestEdge) {
  const Vector3d a(0, 0, 0), b(0.125, 1e-3, 0.7e-3), c(1e3 / 3.0, 1e3 / 7.0, 1e3 / 11.0);
  for (const Vector3d& area : {areaOf(a, b, c), areaOf(b, c, a), areaOf(c, a, b)}) {
    EXPECT_LE(std::abs(area.dot(c - a)), 1e-15 * area.norm() * (c - a).norm());
    EXPECT_TRUE(isNear(area / area.norm(), b.cross(c).normalized(), 1e-12));
  }
}

TEST(AreaVector, OfAnEdgeIsZero) { EXPECT_EQ(areaOf({1, 2, 3}, {2, 4, 6}, {3, 6, 9}), Vector3d(0, 0, 0)); }

}  // namespace
}  // namespace proximity_server::narrowphase
