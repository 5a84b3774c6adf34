#include "narrowphase/motion/moving_pair.h"

#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase::moving_pair_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY();

MotionBound accelerated(double acceleration) { return {Vector3d::Zero(), 0.0, acceleration}; }

// The gap goes from 1 to 2 m in 2 units of time; the acceleration 4 takes 2 t (2 - t) from the chord 1 + t / 2.
TEST(AxisBound, IsTheChordLessAParabola) {
  const AxisBound bound({kX, 1.0}, {kX, 2.0}, accelerated(4.0), 2.0);
  EXPECT_EQ(bound.at(0.0), 1.0);
  EXPECT_EQ(bound.at(2.0), 2.0);
  EXPECT_EQ(bound.at(1.0), 1.5 - 2.0);
  EXPECT_EQ(bound.at(0.5), 1.25 - 1.5);
  EXPECT_EQ(bound.lowestTime(), 0.875);
  // 1 - 7/2 t + 2 t^2 = 0
  EXPECT_NEAR(bound.firstTimeAt(0.0), (3.5 - std::sqrt(4.25)) / 4.0, 1e-15);
  EXPECT_NEAR(bound.at(bound.firstTimeAt(0.25)), 0.25, 1e-15);
}

TEST(AxisBound, IsTheChordWithoutAcceleration) {
  const AxisBound falling({kX, 3.0}, {kX, 1.0}, accelerated(0.0), 4.0);
  EXPECT_EQ(falling.at(1.0), 2.5);
  EXPECT_EQ(falling.lowestTime(), 4.0);
  EXPECT_EQ(falling.firstTimeAt(2.0), 2.0);
  const AxisBound rising({kX, 1.0}, {kX, 3.0}, accelerated(0.0), 4.0);
  EXPECT_EQ(rising.lowestTime(), 0.0);
}

TEST(AxisBound, NeverReachesALevelBelowItsLowestPoint) {
  const AxisBound bound({kX, 2.0}, {kX, 2.0}, accelerated(2.0), 2.0);  // 2 - t (2 - t)
  EXPECT_EQ(bound.lowestTime(), 1.0);
  EXPECT_EQ(bound.at(1.0), 1.0);
  EXPECT_EQ(bound.firstTimeAt(0.5), 2.0);
  EXPECT_NEAR(bound.firstTimeAt(1.5), 1.0 - std::sqrt(0.5), 1e-15);  // t^2 - 2 t + 1/2 = 0
}

TEST(AxisBound, ReachesALevelAtOnceThatItIsBelow) {
  EXPECT_EQ(AxisBound({kX, 1.0}, {kX, 2.0}, accelerated(1.0), 1.0).firstTimeAt(1.0), 0.0);
  EXPECT_EQ(AxisBound({kX, 1.0}, {kX, 2.0}, accelerated(1.0), 1.0).firstTimeAt(1.5), 0.0);
}

// The axis turns from x to y, by (-1, 1, 0) in all. Along that b moves at 3 m, so the height over the axis gains
// 2 * 3 / 2 = 3 of second derivative, and the parabola takes 3 / 2 t (2 - t).
TEST(AxisBound, AddsWhatTheTurningAxisGains) {
  const MotionBound motion{{-1, 2, 7}, 0.0, 0.0};
  const AxisBound bound({kX, 4.0}, {kY, 4.0}, motion, 2.0);
  EXPECT_NEAR(bound.at(1.0), 4.0 - 1.5, 1e-15);
}

// The turn has a length of sqrt(2): velocities that differ by 1 m may go along it.
TEST(AxisBound, AddsWhatTheTurningAxisGainsFromTheDeviation) {
  const MotionBound motion{{0, 0, 0}, 1.0, 0.0};
  const AxisBound bound({kX, 4.0}, {kY, 4.0}, motion, 2.0);
  EXPECT_NEAR(bound.at(1.0), 4.0 - 0.5 * std::sqrt(2.0), 1e-15);
}

TEST(AxisBound, DoesNotRiseWhereTheAxisTurnsWithTheMotion) {
  const MotionBound motion{{5, -5, 0}, 0.0, 1.0};
  const AxisBound bound({kX, 4.0}, {kY, 4.0}, motion, 2.0);
  EXPECT_EQ(bound.at(1.0), 4.0);
}

// In the middle between x and y the axis has the length sqrt(1/2): an overlap of 1 along it is one of sqrt(2).
TEST(AxisBound, DeepensAnOverlapAlongAShorterAxis) {
  const AxisBound bound({kX, -1.0}, {kY, -1.0}, accelerated(0.0), 1.0);
  EXPECT_NEAR(bound.at(0.5), -std::sqrt(2.0), 1e-15);
  // The motion leads from 1 to -3 along the axis; a distance of -sqrt(2) is -1 along it.
  const AxisBound falling({kX, 1.0}, {kY, -3.0}, accelerated(0.0), 1.0);
  EXPECT_NEAR(falling.firstTimeAt(-std::sqrt(2.0)), 0.5, 1e-15);
  EXPECT_NEAR(falling.firstTimeAt(0.0), 0.25, 1e-15);
}

TEST(AxisBound, ProvesNothingWhereItOverflows) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(AxisBound({kX, 1.0}, {kX, 2.0}, accelerated(kInfinity), 1.0).firstTimeAt(0.0), 0.0);
  EXPECT_EQ(AxisBound({kX, 1.0}, {kX, kInfinity}, accelerated(0.0), 1.0).firstTimeAt(0.0), 0.0);
}

MotionChain moving(const Vector3d& start, const Vector3d& linear, const Vector3d& angular = Vector3d::Zero()) {
  return {{Isometry3d(Eigen::Translation3d(start)), linear, angular}};
}

TEST(MovingPair, MeasuresTheDistanceAtATime) {
  const Shape a = Sphere{0.5}, b = Sphere{0.25};
  const MotionChain rest = moving({1, 2, 3}, {0, 0, 0}), approach = moving({6, 2, 3}, {-2, 0, 0});
  MovingPair pair(a, rest, b, approach);
  const SignedDistance result = pair.distance(pair.at(0.5), {});  // the centres are 4 m apart
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.distance, 3.25, 1e-15);
  EXPECT_TRUE(isNear(result.normal, kX, 1e-15));
  EXPECT_LE(result.lower_bound, 3.25);
  EXPECT_GE(result.upper_bound, 3.25);
  EXPECT_TRUE(isNear(result.point_a, {0.5, 0, 0}, 1e-15));  // counted from where a's chain begins
  const SignedDistance seen = pair.inChainsFrame(result);
  EXPECT_TRUE(isNear(seen.point_a, {1.5, 2, 3}, 1e-15));
  EXPECT_TRUE(isNear(seen.point_b, {4.75, 2, 3}, 1e-14));
}

// a has turned by a quarter about z: its corner (1, 2) is at (-2, 1), and it reaches 2 m along x.
TEST(MovingPair, MeasuresTurnedShapesInTheFrameOfTheChains) {
  const Shape a = Box{{2.0, 4.0, 6.0}}, b = Sphere{0.5};
  const MotionChain turning = moving({0, 0, 0}, {0, 0, 0}, {0, 0, M_PI / 2.0}), rest = moving({5, 0.5, 0}, {0, 0, 0});
  MovingPair pair(a, turning, b, rest);
  const SignedDistance result = pair.distance(pair.at(1.0), {});
  EXPECT_NEAR(result.distance, 2.5, 1e-14);
  EXPECT_TRUE(isNear(result.normal, kX, 1e-15));
  EXPECT_TRUE(isNear(result.point_a, {2, 0.5, 0}, 1e-14));
}

TEST(MovingPair, KnowsTheGapAlongAnyNormal) {
  const Shape a = Box{{2.0, 4.0, 6.0}}, b = Capsule{0.25, 1.0};
  const MotionChain rest = moving({0, 0, 0}, {0, 0, 0}), away = moving({5, 0, 0}, {0, 6, 0});
  MovingPair pair(a, rest, b, away);
  const MovingPair::Poses poses = pair.at(0.5);  // b is at (5, 3, 0)
  EXPECT_NEAR(pair.gapAlong(kX, poses), 5.0 - 1.0 - 0.25, 1e-12);
  EXPECT_NEAR(pair.gapAlong(kY, poses), 3.0 - 2.0 - 0.25, 1e-12);
  EXPECT_NEAR(pair.gapAlong(-kX, poses), -5.0 - 1.0 - 0.25, 1e-12);
  EXPECT_NEAR(pair.gapAlong(Vector3d::UnitZ(), poses), -3.0 - 0.5 - 0.25, 1e-12);
  EXPECT_LE(pair.gapAlong(kX, poses), 3.75);
}

TEST(MovingPair, BoundsTheMotionOfBAsSeenFromA) {
  const Shape a = Sphere{0.5}, b = Sphere{0.25};
  const MotionChain forwards = moving({0, 0, 0}, {1, 0, 0}), sideways = moving({5, 0, 0}, {0, 3, 0});
  const MotionBound straight = MovingPair(a, forwards, b, sideways).motion(0.0, 1.0);
  EXPECT_EQ(straight.velocity, Vector3d(-1, 3, 0));
  EXPECT_EQ(straight.deviation, 0.0);
  EXPECT_EQ(straight.acceleration, 0.0);
  // A box of which a corner is |(1, 2, 2)| = 3 m from the axis of a turn of 2 rad.
  const Shape box = Box{{2.0, 4.0, 4.0}};
  const MotionChain turning = moving({0, 0, 0}, {0, 0, 0}, {0, 0, 2});
  const MotionBound turned = MovingPair(box, turning, box, turning).motion(0.0, 0.0);
  EXPECT_EQ(turned.velocity, Vector3d(0, 0, 0));
  EXPECT_NEAR(turned.deviation, 2.0 * 6.0, 1e-14);
  EXPECT_NEAR(turned.acceleration, 2.0 * 12.0, 1e-14);
}

TEST(MovingPair, SeesAMotionThatIsNotFinite) {
  const Shape shape = Sphere{0.5};
  const MotionChain fine = moving({0, 0, 0}, {1, 0, 0});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const MotionChain broken = moving({0, 0, 0}, {kNan, 0, 0}), lost = moving({0, kNan, 0}, {1, 0, 0});
  EXPECT_TRUE(MovingPair(shape, fine, shape, fine).isRigid());
  EXPECT_FALSE(MovingPair(shape, fine, shape, broken).isRigid());
  EXPECT_FALSE(MovingPair(shape, lost, shape, fine).isRigid());
}

}  // namespace proximity_server::narrowphase::moving_pair_test
