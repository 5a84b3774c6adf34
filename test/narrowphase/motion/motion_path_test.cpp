#include "narrowphase/motion/motion_path.h"

#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::motion_path_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kQuarter = M_PI / 2.0;

ScrewMotion screwFrom(const Vector3d& start, const Vector3d& linear, const Vector3d& angular) {
  return {Isometry3d(Eigen::Translation3d(start)), linear, angular};
}

ScrewPath pathFrom(const Vector3d& start, const Vector3d& linear, const Vector3d& angular,
                   const Vector3d& from = Vector3d::Zero()) {
  return {Isometry3d(Eigen::Translation3d(start)), linear, angular, from};
}

// A point that is 1 m from the axis moves at pi / 2 m per unit of time: about the origin of the fixed frame.
TEST(ScrewPath, TurnsAboutAnAxisThatStandsStill) {
  const ScrewPath path = pathFrom({1, 0, 0}, {0, kQuarter, 0}, {0, 0, kQuarter});
  EXPECT_TRUE(isNear(path.at(0.0).origin, {1, 0, 0}, 1e-15));
  EXPECT_TRUE(isNear(path.at(1.0).origin, {0, 1, 0}, 1e-15));
  EXPECT_TRUE(isNear(path.at(2.0).origin, {-1, 0, 0}, 1e-15));
  EXPECT_TRUE(isNear(path.at(1.0) * Vector3d(1, 0, 0), {0, 2, 0}, 1e-15));
  EXPECT_TRUE(isNear(path.at(1.0).rotation.col(0), {0, 1, 0}, 1e-15));
}

TEST(ScrewPath, SlidesAlongItsAxisWhileItTurns) {
  const ScrewPath path = pathFrom({1, 0, 0}, {0, kQuarter, 3}, {0, 0, kQuarter});
  EXPECT_TRUE(isNear(path.at(1.0).origin, {0, 1, 3}, 1e-15));
  EXPECT_TRUE(isNear(path.at(0.5).origin, {std::sqrt(0.5), std::sqrt(0.5), 1.5}, 1e-15));
}

TEST(ScrewPath, GoesStraightWithoutATurn) {
  const ScrewPath path = pathFrom({1, 2, 3}, {4, 5, 6}, {0, 0, 0});
  EXPECT_EQ(path.at(0.5).origin, Vector3d(3, 4.5, 6));
  EXPECT_EQ(path.at(0.5).rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(path.turning(), 0.0);
}

TEST(ScrewPath, CountsPositionsFromAPoint) {
  const ScrewPath path = pathFrom({1, 0, 0}, {0, kQuarter, 0}, {0, 0, kQuarter}, {1, 2, 3});
  EXPECT_TRUE(isNear(path.at(1.0).origin, {-1, -1, -3}, 1e-15));
}

TEST(ScrewPath, KnowsTheVelocityOfAPoint) {
  const ScrewPath path = pathFrom({1, 0, 0}, {0, 2, 3}, {0, 0, 2});
  EXPECT_EQ(path.velocity({1, 0, 0}), Vector3d(0, 2, 3));
  EXPECT_EQ(path.velocity({0, 0, 7}), Vector3d(0, 0, 3));  // on the axis
  EXPECT_EQ(path.velocity({0, 5, 0}), Vector3d(-10, 0, 3));
  EXPECT_EQ(path.turning(), 2.0);
}

// Each arm is 1 m long and turns by a quarter in the frame of the one before: the second ends up pointing back.
TEST(MotionPath, CarriesEachScrewInTheFrameOfTheOneBefore) {
  const ScrewMotion shoulder = screwFrom({0, 0, 0}, {0, 0, 0}, {0, 0, kQuarter});
  const ScrewMotion elbow = screwFrom({1, 0, 0}, {0, 0, 0}, {0, 0, kQuarter});
  const ScrewPath::Pose hand = MotionPath({shoulder, elbow}).at(1.0);
  EXPECT_TRUE(isNear(hand.origin, {0, 1, 0}, 1e-15));
  EXPECT_TRUE(isNear(hand * Vector3d(1, 0, 0), {-1, 1, 0}, 1e-15));
}

// Twelve sides of 1 m, each turned by 30 degrees against the one before, close to a polygon; more than eight allocate.
TEST(MotionPath, HasRoomForLongChains) {
  const ScrewMotion side = screwFrom({1, 0, 0}, {0, 0, 0}, {0, 0, M_PI / 6.0});
  for (const std::size_t count : {4u, 8u, 9u, 12u}) {
    const ScrewPath::Pose end = MotionPath(MotionChain(count, side)).at(1.0);
    Vector3d expected(0, 0, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = M_PI / 6.0 * static_cast<double>(i);
      expected += Vector3d(std::cos(angle), std::sin(angle), 0);
    }
    EXPECT_TRUE(isNear(end.origin, expected, 1e-14)) << count;
  }
  EXPECT_TRUE(isNear(MotionPath(MotionChain(12, side)).at(1.0).origin, {0, 0, 0}, 1e-14));
}

TEST(MotionPath, OfNoScrewIsAtRest) {
  const MotionPath path({}, {1, 2, 3});
  EXPECT_EQ(path.at(0.7).origin, Vector3d(-1, -2, -3));
  EXPECT_EQ(path.bound({1, 0, 0}, 2.0, 0.0, 1.0).speed(), 0.0);
}

// At 2 rad per unit of time a ball of 0.5 m, 3 m from the axis: 6 m/s; centripetal 4 * 3, and 4 * 0.5 of its rim.
TEST(MotionPath, BoundsTheVelocityAndAccelerationOfATurn) {
  const MotionPath path({screwFrom({0, 0, 0}, {0, 0, 0}, {0, 0, 2})});
  const double duration = M_PI / 4.0;
  const MotionBound bound = path.bound({3, 0, 0}, 0.5, 0.0, duration);
  EXPECT_TRUE(
      isNear(bound.velocity, 6.0 * Vector3d(-std::sqrt(0.5), std::sqrt(0.5), 0), 1e-14));  // half way: 45 degrees
  EXPECT_NEAR(bound.acceleration, 14.0, 1e-14);
  EXPECT_NEAR(bound.deviation, 1.0 + 0.5 * duration * 14.0, 1e-14);
}

// The hand of an arm of 1 + 1 m, stretched, whose joints turn at 1 and 2 rad: the elbow gives 2 m/s about itself, the
// shoulder 2 m/s about the base; the accelerations are 4 (elbow), 2 (shoulder) and 2 * 1 * 2 of Coriolis.
TEST(MotionPath, AddsTheCoriolisAccelerationOfAChain) {
  const ScrewMotion shoulder = screwFrom({0, 0, 0}, {0, 0, 0}, {0, 0, 1});
  const ScrewMotion elbow = screwFrom({1, 0, 0}, {0, 0, 0}, {0, 0, 2});
  const MotionBound bound = MotionPath({shoulder, elbow}).bound({1, 0, 0}, 0.0, 0.0, 0.0);
  EXPECT_TRUE(isNear(bound.velocity, {0, 4, 0}, 1e-15));
  EXPECT_NEAR(bound.acceleration, 10.0, 1e-14);
}

// About its own axis, a round body of any size moves as its centre does: on a circle of 3 m at 2 rad, and not at all.
TEST(MotionPath, DoesNotCountTheSpinOfARoundBody) {
  const MotionPath orbit({screwFrom({3, 0, 0}, {0, 6, 0}, {0, 0, 2})}),
      spin({screwFrom({3, 0, 0}, {0, 0, 0}, {0, 0, 2})});
  EXPECT_NEAR(orbit.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).acceleration, 12.0, 1e-13);
  EXPECT_NEAR(orbit.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).deviation, 0.0, 1e-14);
  EXPECT_NEAR(spin.bound({0, 0, 0}, 0.5, 0.0, 1.0, Symmetry::AboutZ).deviation, 0.0, 1e-14);
  EXPECT_NEAR(spin.bound({0, 0, 0}, 0.5, 0.0, 1.0, Symmetry::None).acceleration, 2.0, 1e-14);
}

// An axis that is tilted against the turn goes round: with 3 rad along the axis and 1 across it, points 0.5 m from the
// centre are accelerated by 0.5 * 1 * (3 + 1). Across alone there is no spin to leave out.
TEST(MotionPath, CountsHowTheAxisOfARoundBodyTurns) {
  const MotionPath tilted({screwFrom({0, 0, 0}, {0, 0, 0}, {1, 0, 3})}),
      across({screwFrom({0, 0, 0}, {0, 0, 0}, {2, 0, 0})});
  EXPECT_NEAR(tilted.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).acceleration, 2.0, 1e-13);
  EXPECT_NEAR(tilted.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).deviation, 0.5, 1e-13);
  EXPECT_EQ(across.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).acceleration, 2.0);
}

// The frame that carries the wheel turns the wheel, too: 1 m from its axis at 1 rad, 0.5 m of radius.
TEST(MotionPath, CountsTheTurnsOfFramesThatCarryARoundBody) {
  const MotionPath path({screwFrom({0, 0, 0}, {0, 0, 0}, {0, 0, 1}), screwFrom({1, 0, 0}, {0, 0, 0}, {0, 0, 5})});
  EXPECT_NEAR(path.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).acceleration, 1.5, 1e-13);
  EXPECT_NEAR(path.bound({0, 0, 0}, 0.5, 0.0, 0.0, Symmetry::AboutZ).deviation, 0.5, 1e-13);
}

}  // namespace proximity_server::narrowphase::motion_path_test
