#include "narrowphase/curved/stationary_rims.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace proximity_server::narrowphase::stationary_rims_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Shape kTallCylinder = Cylinder{1.0, 2.0};  // rims of radius 1 at z = -1 and 1

/// Searches from `guess`, with a simplex of the CSO vertices that lie farthest along it and along the directions of
/// `seen`.
std::optional<StationaryRims> rimsOf(TwoCores& cores, const Vector3d& guess, const std::vector<Vector3d>& seen = {}) {
  std::vector<CsoVertex> vertices{cores.cso.vertex(guess.normalized())};
  for (const Vector3d& direction : seen) vertices.push_back(cores.cso.vertex(direction));
  return stationaryRims(cores.cso, simplexOf(vertices), guess.normalized());
}

void expectRims(const std::optional<StationaryRims>& found, const RimEnds& ends, double height, const Vector3d& normal,
                const Vector3d& on_a) {
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->ends.of_a, ends.of_a);
  EXPECT_EQ(found->ends.of_b, ends.of_b);
  EXPECT_NEAR(found->direction.height, height, 1e-13);
  EXPECT_TRUE(isNear(found->direction.normal, normal, 1e-13));
  EXPECT_TRUE(isNear(found->direction.points.on_a, on_a, 1e-13));
  EXPECT_TRUE(isNear(found->direction.points.on_b, on_a - height * normal, 1e-13));
}

/// A cylinder whose axis lies along x, with its lower end near to a.
Isometry3d lying(const Vector3d& at) {
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.linear() << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  a_T_b.translation() = at;
  return a_T_b;
}

// Towards -n the rim of b has the point (-1, -2 / sqrt(5), -1 / sqrt(5)).
TEST(StationaryRims, FindThePointsOfTwoRimsApartAndInOverlap) {
  const Vector3d normal = Vector3d(2, 2, 1) / 3.0, on_a(std::sqrt(0.5), std::sqrt(0.5), 1);
  const Vector3d towards_a(-1, -2 / std::sqrt(5.0), -1 / std::sqrt(5.0));
  for (const double height : {-1.5, 0.125}) {
    TwoCores cores(kTallCylinder, kTallCylinder, lying(on_a - height * normal - towards_a));
    expectRims(rimsOf(cores, {2, 2.1, 0.95}), {1, -1}, height, normal, on_a);
  }
}

// The lowest point of b's rim lies 0.25 m above the middle of a, and b's axis points away from a.
TEST(StationaryRims, FindTheMantleOfAAndTheRimOfB) {
  const Vector3d out = Vector3d(0.6, 0.8, 0.0);
  Isometry3d a_T_b = Isometry3d::Identity();
  const Vector3d axis = Vector3d(0.6 * 0.6, 0.6 * 0.8, 0.8);
  a_T_b.linear() << Vector3d(-0.8, 0.6, 0), Vector3d(0.8 * 0.6, 0.8 * 0.8, -0.6) * -1.0, axis;
  if (a_T_b.linear().determinant() < 0.0) a_T_b.linear().col(0) *= -1.0;
  const Vector3d nearest = -axis - 0.5 * Vector3d(0.8 * 0.6, 0.8 * 0.8, -0.6);  // of b's lower rim, radius 0.5
  for (const double height : {-1.5, 0.125}) {
    a_T_b.translation() = (1.0 - height) * out + Vector3d(0, 0, 0.25) - nearest;
    TwoCores cores(kTallCylinder, Cylinder{0.5, 2.0}, a_T_b);
    expectRims(rimsOf(cores, {0.7, 0.7, 0.02}, {{0.7, 0.7, -0.02}}), {0, -1}, height, out, out + Vector3d(0, 0, 0.25));
  }
}

TEST(StationaryRims, FindTheRimOfAAndTheMantleOfB) {
  TwoCores cores(kTallCylinder, Cylinder{0.5, 2.0}, lying({0.25, 0, 3.0}));
  EXPECT_FALSE(
      rimsOf(cores, {0.02, 0.1, 1}).has_value());  // the rim meets the plane of the mantle's lines in many points
  TwoCores leaning(kTallCylinder, Cylinder{0.5, 6.0}, lying({0, 2.5, 2.0}));
  expectRims(rimsOf(leaning, {0.01, 1, 0.7}, {{-0.01, 1, 0.7}}), {1, 0}, 0.5 - std::sqrt(1.5 * 1.5 + 1.0),
             Vector3d(0, 1.5, 1).normalized(), {0, 1, 1});
}

// The simplex knows the lower rim only; the nearest point lies on the mantle above it, or on the upper rim.
TEST(StationaryRims, CorrectTheEndThatTheSimplexDoesNotKnow) {
  const Vector3d guess(1, 0.1, -0.05);
  TwoCores beside(kTallCylinder, Capsule{0.1, 2.0},
                  Isometry3d(Eigen::Translation3d(3, 0, 0) * Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY())));
  expectRims(rimsOf(beside, guess), {0, -1}, -1.0, {1, 0, 0}, {1, 0, 0});
  TwoCores above(kTallCylinder, Capsule{0.1, 2.0},
                 Isometry3d(Eigen::Translation3d(3, 0, 2) * Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY())));
  expectRims(rimsOf(above, guess), {1, -1}, -std::sqrt(2.0), Vector3d(1, 0, 1).normalized(), {1, 0, 1});
}

TEST(StationaryRims, ReturnNothingAlongARingOfEqualDepths) {
  TwoCores cores(kTallCylinder, Cylinder{0.5, 1.0}, Vector3d(0, 0, 0));
  EXPECT_FALSE(rimsOf(cores, {1, 0.1, 0.3}).has_value());
}

TEST(StationaryRims, ReturnNothingForOtherCores) {
  TwoCores cores(kTallCylinder, Box{{1, 1, 1}}, Vector3d(4, 0, 5));
  EXPECT_FALSE(rimsOf(cores, {0.7, 0.1, 0.7}).has_value());
}

}  // namespace proximity_server::narrowphase::stationary_rims_test
