#include "narrowphase/curved/inner_ellipsoid.h"

#include "narrowphase/cso/two_cores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::inner_ellipsoid_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

StationaryDirection along(const Vector3d& normal, const Vector3d& on_a, const Vector3d& on_b) {
  return {normal, normal.dot(on_a - on_b), {on_a, on_b}, 1.0};
}

double bound(TwoCores& cores, const StationaryDirection& direction) {
  return depthOfInnerEllipsoid(cores.cso, direction, direction.height, 1e-9);
}

Isometry3d turnedAbout(const Vector3d& axis, double angle) {
  return Isometry3d(Eigen::AngleAxisd(angle, axis.normalized()));
}

// The point lies 0.5 m beside the centre, so that a ball of 1.5 m about it touches the equator of radius 2.
TEST(InnerEllipsoid, ProvesTheDepthOfAPointInASpheroid) {
  TwoCores cores(Ellipsoid{{2, 2, 3}}, pointAt({0.5, 0, 0}), Vector3d::Zero());
  EXPECT_NEAR(bound(cores, along({1, 0, 0}, {2, 0, 0}, {0.5, 0, 0})), 1.5, 1e-12);
}

// A ring of directions has the depth 2.
TEST(InnerEllipsoid, ProvesTheDepthOfARing) {
  TwoCores cores(Ellipsoid{{2, 2, 3}}, pointAt({0, 0, 0}), Vector3d::Zero());
  EXPECT_NEAR(bound(cores, along({0.6, 0.8, 0}, {1.2, 1.6, 0}, {0, 0, 0})), 2.0, 1e-12);
}

TEST(InnerEllipsoid, ProvesNoMoreThanTheDepthFromADirectionThatIsNotTheShallowest) {
  TwoCores cores(Ellipsoid{{1, 2, 3}}, pointAt({0, 0, 0}), Vector3d::Zero());
  EXPECT_LE(bound(cores, along({0, 1, 0}, {0, 2, 0}, {0, 0, 0})), 1.0);
}

TEST(InnerEllipsoid, ProvesTheDepthOfTwoConcentricEllipsoids) {
  TwoCores cores(Ellipsoid{{0.3, 0.4, 0.5}}, Ellipsoid{{0.1, 0.2, 0.4}}, Vector3d::Zero());
  EXPECT_NEAR(bound(cores, along({1, 0, 0}, {0.3, 0, 0}, {-0.1, 0, 0})), 0.4, 1e-12);
}

// The axes cross in both centres, and the shortest way out is across both axes, whatever the angle between them is.
TEST(InnerEllipsoid, ProvesTheDepthOfASegmentInACylinderAtEveryTilt) {
  const Shape cylinder = Cylinder{0.25, 0.3}, segment = Capsule{0.1, 0.4};
  for (const double tilt : {1e-12, 1e-8, 1e-6, 1e-4, 1e-2}) {
    TwoCores cores(cylinder, segment, turnedAbout(Vector3d::UnitX(), tilt));
    EXPECT_NEAR(bound(cores, along({1, 0, 0}, {0.25, 0, 0}, {0, 0, 0})), 0.25, 1e-12) << tilt;
  }
}

// The slant of this cone has the normal (0.8, 0, 0.6). From the point on the axis 1 m below the apex it is 0.6 m away.
TEST(InnerEllipsoid, ProvesTheDepthOfAPointOnTheAxisOfACone) {
  TwoCores cores(Cone{1.5, 2.0}, pointAt({0, 0, 0}), Vector3d::Zero());
  EXPECT_NEAR(bound(cores, along({0.8, 0, 0.6}, {0.48, 0, 0.36}, {0, 0, 0})), 0.6, 1e-12);
}

Shape anyCore(std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.05, 1.0);
  const double x = size(random), y = size(random), z = size(random);
  switch (random() % 6) {
    case 0:
      return Capsule{x, y};
    case 1:
      return Cylinder{x, y};
    case 2:
      return Cone{x, y};
    case 3:
      return Ellipsoid{{x, x, z}};
    case 4:
      return Box{{x, y, z}};
    default:
      return Ellipsoid{{x, y, z}};
  }
}

Vector3d anyVector(std::mt19937& random) {
  std::normal_distribution<double> entry;
  return {entry(random), entry(random), entry(random)};
}

Isometry3d anyPose(std::mt19937& random) {
  std::uniform_real_distribution<double> exponent(-12.0, 0.5);
  Isometry3d pose = turnedAbout(anyVector(random), std::pow(10.0, exponent(random)));
  pose.translation() = 0.3 * std::pow(10.0, exponent(random)) * anyVector(random).normalized();
  return pose;
}

/// The least depth over directions everywhere, and near the given one.
double sampledDepth(Cso& cso, const Vector3d& normal, std::mt19937& random) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 400; ++i) {
    const double spread = std::pow(10.0, -0.02 * i);
    const Vector3d direction =
        (i % 2 == 0 ? anyVector(random) : Vector3d(normal + spread * anyVector(random))).normalized();
    least = std::min(least, direction.dot(cso.vertex(direction).point));
  }
  return least;
}

/// A unit normal of the slant of a cone, in its frame.
Vector3d normalOfSlant(const Shape& cone, std::mt19937& random) {
  const double angle = std::uniform_real_distribution<double>(0.0, 6.3)(random);
  const double length = 2.0 * cone.halfExtents().z(), radius = cone.halfExtents().x();
  return Vector3d(length * std::cos(angle), length * std::sin(angle), radius).normalized();
}

/// A point of the slant below this normal; the rim and places near it as often as others.
Vector3d pointOfSlant(const Shape& cone, const Vector3d& normal, std::mt19937& random) {
  const double part = std::uniform_real_distribution<double>(0.0, 1.0)(random);
  const double from_apex = part < 0.3 ? 1.0 : part < 0.5 ? 1.0 - 1e-9 : part;
  const Vector3d apex(0.0, 0.0, cone.halfExtents().z()), across(normal.x(), normal.y(), 0.0);
  const Vector3d rim = cone.halfExtents().x() * across.normalized() - apex;
  return apex + from_apex * (rim - apex);
}

// It is a proof from any witness points and along any normal, stationary or not.
TEST(InnerEllipsoid, NeverProvesMoreThanTheDepth) {
  std::mt19937 random(29);
  int proofs = 0, proofs_on_slants = 0;
  for (int i = 0; i < 60000; ++i) {
    const Shape a = anyCore(random), b = anyCore(random);
    TwoCores cores(a, b, anyPose(random));
    Vector3d normal = anyVector(random).normalized();
    if (i % 3 == 0) normal = Vector3d(normal.x(), normal.y(), 0.0).normalized();
    const bool on_slant = i % 3 == 1 && a.kind() == Shape::Kind::Cone;
    if (on_slant) normal = normalOfSlant(a, random);
    const CsoVertex w = cores.cso.vertex(normal);
    const double depth = normal.dot(w.point);
    const Vector3d on_a = on_slant ? pointOfSlant(a, normal, random) : w.on_a;
    const StationaryDirection direction{normal, depth, {on_a, w.onB()}, 1.0};
    const double proven = depthOfInnerEllipsoid(cores.cso, direction, depth, i % 2 == 0 ? 1e-9 : 1.0);
    if (!(proven > 0.0)) continue;
    ++proofs;
    proofs_on_slants += on_slant ? 1 : 0;
    ASSERT_LE(proven, sampledDepth(cores.cso, normal, random)) << i;
  }
  EXPECT_GT(proofs, 1000);
  EXPECT_GT(proofs_on_slants, 100);
}

}  // namespace proximity_server::narrowphase::inner_ellipsoid_test
