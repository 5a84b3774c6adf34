#include "proximity_server/narrowphase/cso/cso.h"

#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::narrowphase::cso_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Shape kPoint = Sphere{0.5};
const Shape kBox = Box{{2.0, 4.0, 6.0}};
const Shape kCone = Cone{1.0, 2.0};

TEST(Cso, VertexIsThePointOnAMinusThatOnB) {
  // The other box is turned by 90 degrees about z: it reaches 2 m along x, 1 m along y.
  const Isometry3d a_T_b = Eigen::Translation3d(10, 20, 30) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  WarmStart warm_start;
  Cso cso(kBox, kBox, a_T_b, 0.0, warm_start);
  const CsoVertex vertex = cso.vertex({1, -1, 1});
  EXPECT_EQ(vertex.on_a, Vector3d(1, -2, 3));
  EXPECT_TRUE(isNear(vertex.onB(), {10 - 2, 20 + 1, 30 - 3}, 1e-14));
  EXPECT_TRUE(isNear(vertex.point, {-7, -23, -24}, 1e-14));
}

TEST(Cso, KnowsTheWayBetweenTheCentres) {
  const Shape hull = ConvexHull({{1, 1, 1}, {3, 1, 1}});  // its centre is (2, 1, 1)
  WarmStart warm_start;
  const Isometry3d a_T_b = Eigen::Translation3d(0, 0, 5) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  const Cso cso(kBox, hull, a_T_b, 0.0, warm_start);
  EXPECT_TRUE(isNear(cso.centreDifference(), {-1, 2, 6}, 1e-15));
}

// The box reaches |(1, 2, 3)| from its origin, the sphere only its margin of 0.5, and |t|_1 is 6.
TEST(CsoRounding, IsEightEpsilonOfAllThatIsAdded) {
  const Isometry3d a_T_b(Eigen::Translation3d(1, -2, 3));
  const double expected = 8.0 * std::numeric_limits<double>::epsilon() * (std::sqrt(14.0) + 0.5 + 6.0);
  EXPECT_NEAR(csoRounding(kBox, kPoint, a_T_b), expected, 1e-29);
  EXPECT_NEAR(csoRounding(kPoint, kBox, a_T_b), expected, 1e-29);
}

TEST(Cso, EndsASearchAtSomeRoundingsButNeverBelowThree) {
  const double rounding = 1e-12;
  WarmStart warm_start;
  const Isometry3d a_T_b = Isometry3d::Identity();
  const Cso cso(kBox, kCone, a_T_b, rounding, warm_start);
  EXPECT_EQ(cso.finalWidth(1e-9), 4.0 * rounding);
  EXPECT_EQ(cso.finalWidth(3.5e-12), 3.5e-12);
  EXPECT_EQ(cso.finalWidth(1e-14), 3.0 * rounding);
}

}  // namespace proximity_server::narrowphase::cso_test
