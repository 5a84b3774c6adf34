// The pair near the origins has the distances of the pair that is far from them.
#include "narrowphase/shape/near_origin.h"

#include "chance.h"
#include "proximity_server/narrowphase/cso/cso.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::near_origin_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Vector3l = Eigen::Matrix<long double, 3, 1>;

constexpr double kEps = std::numeric_limits<double>::epsilon();

std::vector<Vector3d> tetrahedronAt(const Vector3d& corner) {
  return {corner, corner + Vector3d(1, 0, 0), corner + Vector3d(0, 1, 0), corner + Vector3d(0, 0, 1)};
}

Shape farTetrahedron(const Vector3d& corner) { return ConvexHull(tetrahedronAt(corner)); }

TEST(ShapeNearOrigin, IsAHullThousandsOfItsSizesAway) {
  EXPECT_TRUE(farTetrahedron({1e4, 0, 0}).isFarFromOrigin());
  EXPECT_FALSE(farTetrahedron({1e3, 0, 0}).isFarFromOrigin());
  EXPECT_FALSE(Shape(Box{{1, 1, 1}}).isFarFromOrigin());
  EXPECT_FALSE(farTetrahedron({1e4, 0, 0}).sweptTo(Isometry3d::Identity()).isFarFromOrigin());
}

TEST(ShapeNearOrigin, KeepsNumbersSizeAndMargin) {
  const Shape far = farTetrahedron({65536, -32768, 16384}).padded(0.25), near = far.nearOrigin();
  EXPECT_EQ(near.margin(), 0.25);
  EXPECT_FALSE(near.isFarFromOrigin());
  EXPECT_LE(near.coreReach(), 3.0 * far.coreRadius());
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(near.hull().vertices()[i], far.hull().vertices()[i] - far.hull().vertices().front()) << i;
  EXPECT_EQ(near.hull().triangles(), far.hull().triangles());
}

// A point is as far away as it is from the origin, however near that is.
TEST(ShapeNearOrigin, OfOnePointIsTheOrigin) {
  const Shape near = Shape(ConvexHull({{1e-3, 2, 3}})).nearOrigin();
  EXPECT_EQ(near.hull().vertices().front(), Vector3d(0, 0, 0));
  EXPECT_EQ(near.coreReach(), 0.0);
}

/// A multiple of 2^-20 below 2^exponent, so that sums of such products are exact in long double.
double dyadic(Chance& random, int exponent) {
  std::uniform_int_distribution<long> parts(-(1L << (exponent + 20)), 1L << (exponent + 20));
  return std::ldexp(static_cast<double>(parts(random)), -20);
}

Vector3d dyadicVector(Chance& random, int exponent) {
  return {dyadic(random, exponent), dyadic(random, exponent), dyadic(random, exponent)};
}

TEST(NearOrigin, OffsetIsWithinItsError) {
  Chance random(61);
  int worse = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d corner_a = dyadicVector(random, 20), corner_b = dyadicVector(random, 20);
    Isometry3d pose = Isometry3d::Identity();
    for (int row = 0; row < 3; ++row) pose.linear().row(row) = dyadicVector(random, 0);
    // Both corners are nearly in one place, so that nearly all digits cancel. Of those that are left a double has room
    // for all, or not.
    const int exponent = i % 2 == 0 ? 0 : 16;
    for (int row = 0; row < 3; ++row)
      pose.translation()[row] =
          std::round(corner_a[row] - pose.linear().row(row).dot(corner_b)) + dyadic(random, exponent);
    const Shape a = farTetrahedron(corner_a), b = farTetrahedron(corner_b);
    const Vector3l p = a.hull().vertices().front().cast<long double>(),
                   q = b.hull().vertices().front().cast<long double>();
    const Vector3l exact = pose.linear().cast<long double>() * q + (pose.translation().cast<long double>() - p);
    const NearOrigin near(a, b, pose);
    EXPECT_LE((near.pose().translation().cast<long double>() - exact).norm(), near.error());
    const Vector3d plain = pose * Vector3d(q.cast<double>()) - p.cast<double>();
    if (exponent == 0 && (plain.cast<long double>() - exact).norm() > 100.0L * near.error()) ++worse;
  }
  EXPECT_GT(worse, 450) << "sums in double would do";
}

TEST(NearOrigin, RoundsByTheSizesAlone) {
  const Vector3d corner(1e7, -2e7, 3e7);
  const Shape a = farTetrahedron(corner), b = Box{{1, 1, 1}};
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.translation() = corner - Vector3d(0, 0, 0.5);
  const NearOrigin near(a, b, a_T_b);
  EXPECT_LT(near.error(), 8.0 * kEps);
  EXPECT_LT(csoRounding(near.a(), near.b(), near.pose()), 64.0 * kEps);
}

/// A hull on the top of a box, its frame `far` from both.
struct OnABox {
  Shape hull, box = Box{{2, 2, 2}};
  Isometry3d box_T_hull = Isometry3d::Identity();
  Isometry3d hull_T_box = Isometry3d::Identity();

  OnABox(const Vector3d& far, double gap) : hull(farTetrahedron(far)) {
    box_T_hull.translation() = Vector3d(-0.25, -0.25, 1.0 + gap) - far;
    hull_T_box.translation() = -box_T_hull.translation();
  }
};

// Regression: from 8e4 m on, the rounding of the coordinates filled the tolerance, and shapes that touch or are deep
// were Degenerate. All numbers are multiples of 2^-10, so that the distances are exact.
TEST(SignedDistance, OfAHullFarFromItsOriginConverges) {
  for (const double far : {65536.0, 1048576.0, 1073741824.0})
    for (const double gap : {-0.5, -0.0009765625, 0.0, 0.0009765625, 2.0}) {
      const OnABox pair({far, -3.0 * far, 0.5 * far}, gap);
      for (const SignedDistance& result : {signedDistance(pair.box, pair.hull, pair.box_T_hull),
                                           signedDistance(pair.hull, pair.box, pair.hull_T_box)}) {
        EXPECT_EQ(result.status, Status::Converged) << far << " " << gap;
        EXPECT_LE(result.lower_bound, gap);
        EXPECT_GE(result.upper_bound, gap);
        EXPECT_NEAR(result.distance, gap, 1e-9);
      }
    }
}

TEST(SignedDistance, OfPaddedHullsFarFromTheirOriginsCountsTheMargins) {
  const Vector3d far(1048576.0, 2097152.0, -524288.0);
  const Shape a = farTetrahedron(far).padded(0.25), b = farTetrahedron(-far).padded(0.5);
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.translation() = 2.0 * far + Vector3d(0, 0, 4);
  const SignedDistance result = signedDistance(a, b, a_T_b);
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.distance, 3.0 - 0.75, 1e-12);
  EXPECT_NEAR((result.point_a - far).z(), 1.25, 1e-9) << "in the frame of a";
}

// The thresholds are decided by the bounds of the search near the origins, which are the narrower ones.
TEST(SignedDistance, OfAHullFarFromItsOriginDecidesThresholds) {
  const double far = 1073741824.0, gap = 0.0009765625;
  const OnABox pair({far, far, far}, gap);
  EXPECT_GT(signedDistance(pair.box, pair.hull, pair.box_T_hull, Options::above(gap - 1e-9)).lower_bound, gap - 1e-9);
  EXPECT_LE(signedDistance(pair.box, pair.hull, pair.box_T_hull, Options::above(gap + 1e-9)).upper_bound, gap + 1e-9);
}

}  // namespace proximity_server::narrowphase::near_origin_test
