#include "scene/model/body_pose.h"

#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::scene::body_pose_test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Isometry3d stretched(double factor) {
  Isometry3d pose = at(1, 2, 3);
  pose.linear() *= factor;
  return pose;
}

TEST(UsablePose, OfNoneIsNone) { EXPECT_FALSE(usablePose(std::nullopt).has_value()); }

TEST(UsablePose, OfAnExactRotationIsThatPoseBitForBit) {
  Isometry3d pose = at(1e9, -2, 3);
  pose.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const std::optional<Isometry3d> usable = usablePose(pose);
  ASSERT_TRUE(usable.has_value());
  EXPECT_EQ(usable->matrix(), pose.matrix());
}

// In single precision each entry is rounded by up to 2^-25, so a rotation lies within 3 * 2^-25 of the matrix, and the
// nearest is no farther.
TEST(UsablePose, OfASinglePrecisionMatrixIsTheNearestRotation) {
  Chance chance(3);
  for (int i = 0; i < 200; ++i) {
    const Isometry3d exact = chance.pose(1.0);
    Isometry3d rounded = exact;
    rounded.linear() = exact.linear().cast<float>().cast<double>();
    const std::optional<Isometry3d> usable = usablePose(rounded);
    ASSERT_TRUE(usable.has_value());
    const Matrix3d error = usable->linear().transpose() * usable->linear() - Matrix3d::Identity();
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 8.0 * kEpsilon);
    EXPECT_LE((usable->linear() - rounded.linear()).norm(), 3.0 * std::ldexp(1.0, -25));
    EXPECT_EQ(usable->translation(), exact.translation());
  }
}

// A factor of 1 + d makes R^T R - 1 = 2 d. The limit is 16 float epsilons, 1.907e-6; the nearest rotation is the
// identity.
TEST(UsablePose, IsThatWithinSixteenFloatEpsilonsOfARotation) {
  for (const double factor : {1.0 + 0.9e-6, 1.0 - 0.9e-6}) {
    const std::optional<Isometry3d> usable = usablePose(stretched(factor));
    ASSERT_TRUE(usable.has_value());
    EXPECT_LE((usable->linear() - Matrix3d::Identity()).norm(), 8.0 * kEpsilon);
  }
  EXPECT_FALSE(usablePose(stretched(1.0 + 1.0e-6)).has_value());
  EXPECT_FALSE(usablePose(stretched(1.0 - 1.0e-6)).has_value());
  EXPECT_FALSE(usablePose(stretched(0.0)).has_value());
}

TEST(UsablePose, OfASkewMatrixIsNone) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear()(0, 1) = 1e-5;  // the columns keep their lengths to 1e-10
  EXPECT_FALSE(usablePose(pose).has_value());
}

TEST(UsablePose, OfAReflectionIsNone) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear()(2, 2) = -1.0;
  EXPECT_FALSE(usablePose(pose).has_value());
}

TEST(UsablePose, OfNumbersThatAreNotFiniteIsNone) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int k = 0; k < 3; ++k) {
      Isometry3d shifted = Isometry3d::Identity(), torn = Isometry3d::Identity();
      shifted.translation()[k] = bad;
      torn.linear()(k, 1) = bad;
      EXPECT_FALSE(usablePose(shifted).has_value());
      EXPECT_FALSE(usablePose(torn).has_value());
    }
  }
}

}  // namespace proximity_server::scene::body_pose_test
