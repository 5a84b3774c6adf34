#include "narrowphase/closed_form/parallel_axes.h"

#include "narrowphase/near.h"
#include "proximity_server/narrowphase/cso/cso.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proximity_server::narrowphase::parallel_axes_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTolerance = 1e-9;

const Shape kWide = Cylinder{1.0, 2.0}, kNarrow = Cylinder{0.5, 1.0};
const Shape kCone = Cone{1.0, 2.0};  // apex at z = 1, slant normal (2, 0, 1) / sqrt(5) in (0.5, 0, 0)
const Shape kSegment = Capsule{0.5, 2.0}, kPoint = Sphere{0.5};
const Vector3d kSlant = Vector3d(2, 0, 1).normalized();

Isometry3d at(const Vector3d& offset) { return Isometry3d(Eigen::Translation3d(offset)); }
Isometry3d upsideDownAt(const Vector3d& offset) { return at(offset) * Eigen::AngleAxisd(M_PI, Vector3d::UnitX()); }

SignedDistance expectDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, double distance,
                              const Vector3d& normal) {
  const SignedDistance result = parallelAxesDistance(a, b, a_T_b, kTolerance);
  EXPECT_NEAR(result.distance, distance, 1e-14);
  EXPECT_TRUE(isNear(result.normal, normal, 1e-14));
  EXPECT_TRUE(isNear(result.point_b, result.point_a + distance * normal, 1e-14));
  return result;
}

TEST(ParallelAxes, MeasureCylindersAboveEachOther) {
  expectDistance(kWide, kNarrow, at({0, 0, 5}), 3.5, {0, 0, 1});
  expectDistance(kWide, kNarrow, at({0, 0, -5}), 3.5, {0, 0, -1});
  const SignedDistance beside = expectDistance(kWide, kNarrow, at({1.25, 0, 5}), 3.5, {0, 0, 1});
  EXPECT_NEAR(beside.point_a.z(), 1.0, 1e-15);
  EXPECT_LE(beside.point_a.head<2>().norm(), 1.0);
}

TEST(ParallelAxes, MeasureCylindersSideBySide) {
  const SignedDistance result = expectDistance(kWide, kNarrow, at({2.4, 3.2, 0.25}), 2.5, {0.6, 0.8, 0});
  EXPECT_NEAR(result.point_a.head<2>().norm(), 1.0, 1e-15);
  EXPECT_LE(std::abs(result.point_a.z() - 0.25), 0.5);  // over the side of the shorter one
}

// The way from the upper rim of a to the lower one of b is 3 m out and 4 m up.
TEST(ParallelAxes, MeasureTheRimsOfTwoCylinders) {
  const SignedDistance result = expectDistance(kWide, kNarrow, at({4.5, 0, 5.5}), 5.0, {0.6, 0, 0.8});
  EXPECT_TRUE(isNear(result.point_a, {1, 0, 1}, 1e-15));
}

TEST(ParallelAxes, LeadACylinderOutOfTheSideOfAnother) {
  const SignedDistance result = expectDistance(kWide, kNarrow, at({1.25, 0, 0.125}), -0.25, {1, 0, 0});
  EXPECT_TRUE(result.unique);
  EXPECT_NEAR(result.point_a.x(), 1.0, 1e-15);
}

TEST(ParallelAxes, LeadACylinderOutOfTheEndOfAnother) {
  EXPECT_TRUE(expectDistance(kWide, kNarrow, at({0.25, 0, 1.25}), -0.25, {0, 0, 1}).unique);
  EXPECT_TRUE(expectDistance(kWide, kNarrow, at({0.25, 0, -1.25}), -0.25, {0, 0, -1}).unique);
}

TEST(ParallelAxes, SayThatAllSidesOfACoaxialCylinderAreAsNear) {
  const SignedDistance result = parallelAxesDistance(Cylinder{1.0, 6.0}, kNarrow, at({0, 0, 0.25}), kTolerance);
  EXPECT_NEAR(result.distance, -1.5, 1e-15);
  EXPECT_NEAR(result.normal.z(), 0.0, 1e-15);
  EXPECT_FALSE(result.unique);
}

TEST(ParallelAxes, SayThatTwoWaysOutAreAsShort) {
  // 0.25 m to the side and 0.25 m to the end.
  EXPECT_FALSE(parallelAxesDistance(kWide, kNarrow, at({1.25, 0, 1.25}), kTolerance).unique);
  // 1.5 m to either end, and 1.5 m to a side.
  EXPECT_FALSE(parallelAxesDistance(kWide, kNarrow, at({0, 0, 0}), kTolerance).unique);
}

TEST(ParallelAxes, MeasureAConeThatStandsOverACylinder) {
  expectDistance(kWide, kCone, at({0, 0, 2.5}), 0.5, {0, 0, 1});
  expectDistance(kWide, kCone, at({0.75, 0, 1.75}), -0.25, {0, 0, 1});
}

TEST(ParallelAxes, MeasureTheApexOfAConeOverACylinder) {
  const SignedDistance result = expectDistance(kWide, kCone, upsideDownAt({0.5, 0, 2.5}), 0.5, {0, 0, 1});
  EXPECT_TRUE(isNear(result.point_a, {0.5, 0, 1}, 1e-15));
}

TEST(ParallelAxes, MeasureACylinderOverTheApexOfACone) {
  const SignedDistance result = expectDistance(kCone, kNarrow, at({0.25, 0, 2}), 0.5, {0, 0, 1});
  EXPECT_TRUE(isNear(result.point_a, {0, 0, 1}, 1e-15));
}

TEST(ParallelAxes, MeasureAPointOverTheSlantOfACone) {
  const Vector3d middle(0.5, 0, 0);
  const SignedDistance above = expectDistance(kCone, kPoint, at(middle + 2.0 * kSlant), 2.0, kSlant);
  EXPECT_TRUE(isNear(above.point_a, middle, 1e-15));
  EXPECT_TRUE(expectDistance(kCone, kPoint, at(middle - 0.125 * kSlant), -0.125, kSlant).unique);
}

TEST(ParallelAxes, MeasureAPointBesideTheRimOfACone) {
  const SignedDistance result = expectDistance(kCone, kPoint, at({4, 0, -5}), 5.0, {0.6, 0, -0.8});
  EXPECT_TRUE(isNear(result.point_a, {1, 0, -1}, 1e-15));
}

// The slant of a cone that stands on its apex is parallel to that of an upright one, half a metre out from either axis.
TEST(ParallelAxes, MeasureTheSlantsOfTwoCones) {
  const Vector3d offset = Vector3d(1, 0, 0) + 2.0 * kSlant;
  expectDistance(kCone, kCone, upsideDownAt(offset), 2.0, kSlant);
  expectDistance(kCone, kCone, upsideDownAt(Vector3d(1, 0, 0) - 0.125 * kSlant), -0.125, kSlant);
}

TEST(ParallelAxes, MeasureARimBesideTheSlantOfACone) {
  // The lower rim of the cylinder, half a metre below its centre, over the middle of the slant.
  const Vector3d offset = Vector3d(0.5, 0, 0) + 2.0 * kSlant + Vector3d(0.5, 0, 0.5);
  EXPECT_TRUE(isNear(expectDistance(kCone, kNarrow, at(offset), 2.0, kSlant).point_a, {0.5, 0, 0}, 1e-14));
}

// Regression: the slant of the cone is longer across the axis than along it, but that length is lost beside the radius
// of the disc. The cone seemed to lie over the inside of the slant, at a distance of 1e-96 m along the axis.
TEST(ParallelAxes, MeasureATinyConeBesideTheRimOfADisc) {
  expectDistance(Cylinder{1.0, 1e-300}, Cone{1e-70, 1e-160}, at({1.0 + 0x1p-20, 0, 0}), 0x1p-20, {1, 0, 0});
  expectDistance(Cone{1e-70, 1e-160}, Cylinder{1.0, 1e-300}, at({1.0 + 0x1p-20, 0, 0}), 0x1p-20, {1, 0, 0});
}

TEST(ParallelAxes, MeasureASegmentBesideACylinder) {
  expectDistance(kSegment, kNarrow, at({3, 0, 1.25}), 2.5, {1, 0, 0});
  expectDistance(kNarrow, kSegment, at({0, 3, 4.5}), std::hypot(2.5, 3.0),
                 Vector3d(0, 2.5, 3.0) / std::hypot(2.5, 3.0));
}

// A point has no axis: the other shape's counts.
TEST(ParallelAxes, MeasureACylinderFromAPointAlongItsOwnAxis) {
  const Isometry3d lying = at({4, 0, 0.25}) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY());
  expectDistance(kPoint, kNarrow, lying, 3.5, {1, 0, 0});
}

TEST(ParallelAxes, KnowTheAngleBetweenTheAxes) {
  const Isometry3d tilted = at({1, 2, 3}) * Eigen::AngleAxisd(1e-6, Vector3d(1, 1, 0).normalized());
  EXPECT_NEAR(axesTilt(kWide, kNarrow, tilted), 1e-6, 1e-15);
  EXPECT_EQ(axesTilt(kPoint, kNarrow, tilted), 0.0);
  EXPECT_EQ(axesTilt(kWide, kPoint, tilted), 0.0);
  EXPECT_NEAR(axesTilt(kWide, kCone, upsideDownAt({1, 2, 3})), 0.0, 1e-15);
}

Isometry3d tiltedAt(double tilt, const Vector3d& offset) {
  return at(offset) * Eigen::AngleAxisd(tilt, Vector3d::UnitX());
}

// The slant lies 1 / sqrt(5) from the middle of its axis, and the point is moved towards it by 0.125 m.
TEST(TiltedAxes, BoundTheDepthInAConeExactlyIfTheAxesAreParallel) {
  const double depth = (1.0 - 0.125 * 2.0) / std::sqrt(5.0);
  EXPECT_NEAR(depthOfTiltedAxes(kCone, kPoint, at({0.125, 0, 0})), depth, 1e-15);
  EXPECT_NEAR(depthOfTiltedAxes(kPoint, kCone, at({-0.125, 0, 0})), depth, 1e-15);
}

// A segment through the middle of a cone, tilted by t. The slant lies 1 / sqrt(5) from the middle; along its normal the
// end of the segment is 2 sin(u) / ..., at an angle of acos(1 / sqrt(5)) + t from the normal on one side.
TEST(TiltedAxes, BoundTheDepthOfATiltedSegmentInACone) {
  for (const double tilt : {1e-9, 1e-6, 1e-5}) {
    const double least = 1.0 / std::sqrt(5.0) + 0.25 * std::cos(std::acos(1.0 / std::sqrt(5.0)) + tilt);
    EXPECT_NEAR(depthOfTiltedAxes(kCone, Capsule{0.5, 0.5}, tiltedAt(tilt, {0, 0, 0})), least, 1e-10) << tilt;
    EXPECT_NEAR(depthOfTiltedAxes(Capsule{0.5, 0.5}, kCone, tiltedAt(tilt, {0, 0, 0})), least, 1e-10) << tilt;
  }
}

// The bound holds for tilts of any size: in no direction do the cores reach less far.
TEST(TiltedAxes, NeverBoundTheDepthByMoreThanASupportPlane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Shape shapes[] = {kWide, kNarrow, kCone, kSegment, kPoint};
  int positive = 0;
  for (int i = 0; i < 2000; ++i) {
    const Shape &a = shapes[i % 5], &b = shapes[i / 5 % 5];
    const Isometry3d a_T_b =
        at(0.3 * Vector3d(any(random), any(random), any(random))) *
        Eigen::AngleAxisd(any(random), Vector3d(any(random), any(random), any(random)).normalized());
    const double bound = depthOfTiltedAxes(a, b, a_T_b);
    if (!(bound > 0.0)) continue;
    ++positive;
    WarmStart warm_start;
    Cso cso(a, b, a_T_b, csoRounding(a, b, a_T_b), warm_start);
    for (int k = 0; k < 200; ++k) {
      const Vector3d n = Vector3d(any(random), any(random), any(random)).normalized();
      ASSERT_GE(n.dot(cso.vertex(n).point), bound - 1e-14) << i;
    }
  }
  EXPECT_GT(positive, 300);
}

}  // namespace proximity_server::narrowphase::parallel_axes_test
