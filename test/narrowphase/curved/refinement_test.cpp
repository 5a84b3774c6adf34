#include "narrowphase/curved/refinement.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::refinement_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Shape kCylinder = Cylinder{1.0, 2.0};  // rims of radius 1 at z = -1 and 1
const Shape kTallCone = Cone{1.0, 2.0};      // apex at z = 1, slant normal (2, 0, 1) / sqrt(5)
const Shape kEllipsoid = Ellipsoid{{1, 2, 3}};

/// Refines `guess` with the CSO vertices that lie farthest along it and along the directions of `seen`.
std::optional<StationaryDirection> refined(TwoCores& cores, const Vector3d& guess,
                                           const std::vector<Vector3d>& seen = {}) {
  std::vector<CsoVertex> vertices{cores.cso.vertex(guess.normalized())};
  for (const Vector3d& direction : seen) vertices.push_back(cores.cso.vertex(direction));
  return refine(cores.cso, simplexOf(vertices), guess.normalized());
}

/// The height is the depth, and minus the distance of shapes that are apart.
void expectStationary(const std::optional<StationaryDirection>& found, double height, const Vector3d& normal,
                      const Vector3d& on_a) {
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->height, height, 1e-13);
  EXPECT_TRUE(isNear(found->normal, normal, 1e-13));
  EXPECT_TRUE(isNear(found->points.on_a, on_a, 1e-13));
  EXPECT_TRUE(isNear(found->points.on_b, on_a - height * normal, 1e-13));
}

// The point is 5 m from (1, 0, 1), along (3, 0, 4).
TEST(Refinement, FindsTheRimOfACylinder) {
  TwoCores cores(kCylinder, pointAt({4, 0, 5}), Vector3d::Zero());
  expectStationary(refined(cores, {0.7, 0.1, 0.7}), -5.0, {0.6, 0, 0.8}, {1, 0, 1});
}

TEST(Refinement, FindsTheRimOfTheOtherCylinder) {
  TwoCores cores(pointAt({4, 0, 5}), kCylinder, Vector3d::Zero());
  expectStationary(refined(cores, {-0.7, 0.1, -0.7}), -5.0, {-0.6, 0, -0.8}, {4, 0, 5});
}

TEST(Refinement, FindsTheSideOfACylinderBetweenItsRims) {
  for (const double x : {3.0, 0.7}) {
    TwoCores cores(kCylinder, pointAt({x, 0, 0.25}), Vector3d::Zero());
    expectStationary(refined(cores, {1, 0.1, 0.1}, {{1, 0.1, -0.1}}), 1.0 - x, {1, 0, 0}, {1, 0, 0.25});
  }
}

TEST(Refinement, FindsTheFlatEndOfACylinder) {
  for (const double end : {1.0, -1.0})
    for (const double z : {4.0, 0.875}) {
      TwoCores cores(kCylinder, pointAt({0.3, 0.2, end * z}), Vector3d::Zero());
      expectStationary(refined(cores, {0.1, 0, end}), 1.0 - z, {0, 0, end}, {0.3, 0.2, end});
    }
}

TEST(Refinement, FindsTheFlatEndOfTheOtherCylinder) {
  for (const double end : {1.0, -1.0}) {
    TwoCores cores(pointAt(Vector3d::Zero()), kCylinder, Vector3d(0.3, 0.2, -end * 4.0));
    expectStationary(refined(cores, {0.1, 0, -end}), -3.0, {0, 0, -end}, {0, 0, 0});
  }
}

TEST(Refinement, FindsTheBaseOfACone) {
  TwoCores cores(kTallCone, pointAt({0.1, 0.2, -3}), Vector3d::Zero());
  expectStationary(refined(cores, {0.1, 0.1, -1}), -2.0, {0, 0, -1}, {0.1, 0.2, -1});
}

TEST(Refinement, FindsTheSlantOfACone) {
  const Vector3d normal = Vector3d(2, 0, 1).normalized(), on_slant(0.5, 0, 0);
  for (const double height : {-2.0, 0.125}) {
    TwoCores cores(kTallCone, pointAt(on_slant - height * normal), Vector3d::Zero());
    expectStationary(refined(cores, {2, 0.1, 0.9}, {{2, 0.1, 1.1}}), height, normal, on_slant);
  }
}

TEST(Refinement, FindsTheApexOfACone) {
  TwoCores cores(kTallCone, pointAt({0.3, 0.4, 2.2}), Vector3d::Zero());
  expectStationary(refined(cores, {0.1, 0.2, 1}), -1.3, Vector3d(0.3, 0.4, 1.2) / 1.3, {0, 0, 1});
}

// The point with the normal n = (2, 2, 1) / 3 is r^2 n / |r n|.
TEST(Refinement, FindsThePointOfAnEllipsoidWithAGivenNormal) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_a = Vector3d(2, 8, 9) / std::sqrt(29.0);
  for (const double height : {-0.7, 0.0625}) {
    TwoCores cores(kEllipsoid, pointAt(on_a - height * normal), Vector3d::Zero());
    expectStationary(refined(cores, {2, 2.2, 0.9}), height, normal, on_a);
  }
}

// A quarter turn about z makes the radii of the other (2, 1, 3).
TEST(Refinement, FindsThePointsOfTwoEllipsoids) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_a = Vector3d(2, 8, 9) / std::sqrt(29.0);
  for (const double height : {-1.5, 0.125}) {
    Isometry3d a_T_b = Isometry3d::Identity();
    a_T_b.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    a_T_b.translation() = on_a - height * normal + Vector3d(8, 2, 9) / std::sqrt(29.0);
    TwoCores cores(kEllipsoid, kEllipsoid, a_T_b);
    expectStationary(refined(cores, {2, 2.2, 0.9}), height, normal, on_a);
  }
}

// The axis of the other cylinder lies along x: towards -n its rim has the point (-1, -2 / sqrt(5), -1 / sqrt(5)).
TEST(Refinement, FindsThePointsOfTwoRims) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_a(std::sqrt(0.5), std::sqrt(0.5), 1);
  const Vector3d towards_a(-1, -2 / std::sqrt(5.0), -1 / std::sqrt(5.0));
  for (const double height : {-1.5, 0.125}) {
    Isometry3d a_T_b = Isometry3d::Identity();
    a_T_b.linear() << 0, 0, 1, 0, 1, 0, -1, 0, 0;
    a_T_b.translation() = on_a - height * normal - towards_a;
    TwoCores cores(kCylinder, kCylinder, a_T_b);
    expectStationary(refined(cores, {2, 2.1, 0.95}), height, normal, on_a);
  }
}

// Beside the upper rim the lower one weighs nothing, within rounding.
TEST(Refinement, AcceptsAPieceThatWeighsNothing) {
  TwoCores cores(kCylinder, pointAt({3, 0, 1}), Vector3d::Zero());
  expectStationary(refined(cores, {1, 0.1, 0.1}, {{1, 0.1, -0.1}}), -2.0, {1, 0, 0}, {1, 0, 1});
}

// The step from a direction to that of a sharp point is the tangent of the angle between them: 11 / 9 and 0.41.
TEST(Refinement, RefusesAStepOfMoreThanHalfARadian) {
  TwoCores cores(kTallCone, pointAt({1, 0, 2}), Vector3d::Zero());  // at 45 degrees over the apex
  EXPECT_FALSE(refined(cores, {-0.1, 0, 1}).has_value());
  expectStationary(refined(cores, {std::sqrt(2.0) - 1.0, 0, 1}), -std::sqrt(2.0), Vector3d(1, 0, 1).normalized(),
                   {0, 0, 1});
}

TEST(Refinement, ReturnsNothingFromADirectionFarAway) {
  TwoCores cores(kCylinder, pointAt({4, 0, 5}), Vector3d::Zero());
  EXPECT_FALSE(refined(cores, {-0.6, 0.7, 0.3}).has_value());
  EXPECT_FALSE(refined(cores, {0, 1, 0.5}).has_value());
}

// The point is nearest to the upper rim: the line between the rims meets the plane of the point above both.
TEST(Refinement, LeavesOutARimThatTheOriginDoesNotLieOver) {
  TwoCores cores(kCylinder, pointAt({3, 0, 1.25}), Vector3d::Zero());
  expectStationary(refined(cores, {1, 0.01, 0.01}, {{1, 0.01, -0.01}}), -std::sqrt(4.0625),
                   Vector3d(2, 0, 0.25).normalized(), {1, 0, 1});
}

// A point beside the axis of a spheroid, by 1e-7 of its radius: along the ring of its equator the depth varies by that
// much, and is least on the side of the point.
TEST(Refinement, FindsTheShallowestDirectionOfARing) {
  TwoCores cores(Ellipsoid{{1, 1, 2}}, pointAt({1e-7, 0, 0}), Vector3d::Zero());
  for (const double angle : {0.3, 1.5, 2.9}) {
    const auto found = refined(cores, {std::cos(angle), std::sin(angle), 0.01});
    ASSERT_TRUE(found.has_value()) << angle;
    EXPECT_NEAR(found->height, 1.0 - 1e-7, 1e-15) << angle;
  }
}

// The common perpendicular of both axes lies 1.2 rad from the guess.
TEST(Refinement, FindsThePerpendicularOfTwoNearlyParallelAxes) {
  Isometry3d tilt(Eigen::AngleAxisd(1e-6, Vector3d::UnitX()));
  TwoCores cores(kCylinder, Capsule{0.1, 1.0}, tilt);
  expectStationary(refined(cores, {std::cos(1.2), std::sin(1.2), 0.01}), 1.0, Vector3d::UnitX(), {1, 0, 0});
}

// The base of the cone has the weight 0.79. With equal weights the depth would seem to have a maximum along the slant.
TEST(Refinement, WeighsThePiecesOfASlantByTheirSlopes) {
  const Vector3d normal = Vector3d(2, 0, 1).normalized();
  TwoCores cores(kTallCone, Cylinder{0.5, 0.25}, Vector3d(1e-7, 0, -1.1));
  const double height = normal.dot(Vector3d(-1e-7, 0, 2.1)) + normal.dot(Vector3d(0.5, 0, 0.125));
  for (const double angle : {0.3, 1.5}) {
    const Vector3d around = Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * Vector3d(2, 0, 1);
    const auto found = refined(cores, around + 0.01 * Vector3d::UnitZ(), {around - 0.1 * Vector3d::UnitZ()});
    ASSERT_TRUE(found.has_value()) << angle;
    EXPECT_NEAR(found->height, height, 1e-14) << angle;
  }
}

TEST(Refinement, ReturnsNothingForTheSweepOfACurve) {
  const Shape swept = kCylinder.sweptTo(Isometry3d(Eigen::Translation3d(0.5, 0, 0)));
  TwoCores cores(swept, pointAt({4, 0, 5}), Vector3d::Zero());
  EXPECT_FALSE(refined(cores, {0.6, 0, 0.8}).has_value());
}

// Deeper than the climb over the end allows, a cap holds only near the axis: climb (1 + c) >= height sqrt(1 - c^2).
TEST(Refinement, ProvesTheCapThatTheClimbOverAFlatEndAllows) {
  const struct {
    double beside, height, cosine;  // from the rim; below the end; of the widest of the offered caps
  } cases[] = {{0.7, 0.05, 0.05}, {0.05, 0.5, 0.985}, {0.05, 0.1, 0.8}, {0.001, 0.5, 1.0}};
  for (const auto& [beside, height, cosine] : cases) {
    TwoCores cores(kCylinder, pointAt({1.0 - beside, 0, 1.0 - height}), Vector3d::Zero());
    const std::optional<StationaryDirection> found = refined(cores, {0, 0.01, 1});
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->cos_proven, cosine) << beside;
  }
}

// A ball of the smallest curvature in each direction: two of 1 and 2 m along z curve like radii 1 and 4 there.
TEST(Refinement, DoesNotProveACapWhereTheCurvatureIsLessThanTheDepth) {
  // At its long end an ellipsoid has the radii of curvature 1/3 and 4/3 m, so 1 m inside there is a shorter way out.
  TwoCores cores(kEllipsoid, pointAt({0, 0, 2}), Vector3d::Zero());
  const std::optional<StationaryDirection> found = refined(cores, {0, 0, 1});
  EXPECT_TRUE(!found || found->cos_proven == 1.0);
}

/// Checks that the CSO reaches at least as far as the stationary point in `count` directions of the cap.
void expectProvenCap(TwoCores& cores, const StationaryDirection& found, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0.0, 1.0), angle(0.0, 2.0 * M_PI);
  const Vector3d u = found.normal.unitOrthogonal(), v = found.normal.cross(u);
  for (int i = 0; i < count; ++i) {
    const double cosine = 1.0 - part(random) * (1.0 - found.cos_proven), sine = std::sqrt(1.0 - cosine * cosine);
    const double turn = angle(random);
    const Vector3d direction = cosine * found.normal + sine * (std::cos(turn) * u + std::sin(turn) * v);
    ASSERT_GE(direction.dot(cores.cso.vertex(direction).point), found.height - 1e-13);
  }
}

TEST(Refinement, ProvesOnlyCapsInWhichNoDirectionIsShallower) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_ellipsoid = Vector3d(2, 8, 9) / std::sqrt(29.0);
  const Vector3d slant = Vector3d(2, 0, 1).normalized();
  int proven = 0;
  for (const double height : {0.01, 0.05, 0.1, 0.2, 0.4, 0.7}) {
    const struct {
      const Shape& shape;
      Vector3d point, guess;
      std::vector<Vector3d> seen;
    } cases[] = {
        {kCylinder, {0.3, 0.2, 1.0 - height}, {0.1, 0, 1}, {}},
        {kCylinder, {1.0 - height, 0, 0.25}, {1, 0.01, 0.01}, {{1, 0.01, -0.01}}},
        {kEllipsoid, on_ellipsoid - height * normal, {2, 2.1, 0.95}, {}},
        {kTallCone, Vector3d(0.5, 0, 0) - height * slant, {2, 0.01, 0.99}, {{2, 0.01, 1.01}}},
    };
    for (const auto& [shape, point, guess, seen] : cases) {
      TwoCores cores(shape, pointAt(point), Vector3d::Zero());
      const std::optional<StationaryDirection> found = refined(cores, guess, seen);
      if (!found || found->cos_proven == 1.0) continue;
      ++proven;
      expectProvenCap(cores, *found, 2000);
    }
  }
  EXPECT_GE(proven, 16);
}

}  // namespace proximity_server::narrowphase::refinement_test
