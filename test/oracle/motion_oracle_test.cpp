// The reference for moving shapes against answers that are known on paper, and against a second method.
#include "oracle/motion_oracle.h"

#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::motion_oracle_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Matrix4l = Eigen::Matrix<long double, 4, 4>;

testing::AssertionResult isNear(long double actual, long double expected, long double tolerance) {
  if (std::abs(actual - expected) <= tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "off by " << static_cast<double>(actual - expected);
}

ScrewMotion randomScrew(std::mt19937& random, double turn) {
  return {randomPose(random, 1.0), randomDirection(random), turn * randomDirection(random)};
}

/// exp(time * twist) * start by the power series; the twist's velocity is that of the point that is at the origin.
Matrix4l poseBySeries(const ScrewMotion& screw, long double time) {
  Matrix4l twist = Matrix4l::Zero();
  const Vector3l w = screw.angular.cast<long double>() * time;
  const Vector3l v = screw.linear.cast<long double>() * time - w.cross(screw.start.translation().cast<long double>());
  twist.topLeftCorner<3, 3>() << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  twist.topRightCorner<3, 1>() = v;
  Matrix4l sum = Matrix4l::Identity(), term = Matrix4l::Identity();
  for (int i = 1; i < 80; ++i) {
    term = term * twist / i;
    sum += term;
  }
  return sum * screw.start.matrix().cast<long double>();
}

Matrix4l matrixOf(const LongPose& pose) {
  Matrix4l matrix = Matrix4l::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation;
  matrix.topRightCorner<3, 1>() = pose.translation;
  return matrix;
}

/// By branch and bound in long double.
DistanceOverTime exactDistanceOf(const MovingPair& pair) {
  return {[pair](long double time) { return exactDistanceAt(pair, time, 20000); }, pair.speedLimit()};
}

DistanceOverTime fastDistanceOf(const MovingPair& pair) {
  return {[pair](long double time) { return fastDistanceAt(pair, time); }, pair.speedLimit()};
}

void expectContactAt(long double expected, const FirstContact& found) {
  ASSERT_TRUE(found.contact_by);
  EXPECT_TRUE(isNear(found.free_until, expected, 1e-11L));
  EXPECT_TRUE(isNear(*found.contact_by, expected, 1e-11L));
}

ScrewMotion translation(const Vector3d& from, const Vector3d& way) {
  return {at(from.x(), from.y(), from.z()), way, {0, 0, 0}};
}

TEST(MotionOracle, PoseIsTheExponentialOfTheTwist) {
  std::mt19937 random(51);
  for (const double turn : {0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.5, 3.0, 7.0})
    for (int i = 0; i < 20; ++i) {
      const ScrewMotion screw = randomScrew(random, turn);
      const long double time = 0.05L * i;
      EXPECT_LT((matrixOf(exactPoseAt(screw, time)) - poseBySeries(screw, time)).norm(), 1e-16L) << turn;
    }
}

TEST(MotionOracle, ChainIsTheProductOfItsScrews) {
  std::mt19937 random(52);
  const MotionChain chain = {randomScrew(random, 1.0), randomScrew(random, 2.0), randomScrew(random, 0.0)};
  const Matrix4l product = poseBySeries(chain[0], 0.7L) * poseBySeries(chain[1], 0.7L) * poseBySeries(chain[2], 0.7L);
  EXPECT_LT((matrixOf(exactPoseAt(chain, 0.7L)) - product).norm(), 1e-16L);
}

TEST(MotionOracle, NoPointOfABallIsFasterThanTheSpeedLimit) {
  std::mt19937 random(53);
  const Shape ball = Sphere{0.3};
  const MotionChain still;
  for (int i = 0; i < 100; ++i) {
    const MotionChain chain = {randomScrew(random, 2.0), randomScrew(random, 5.0), randomScrew(random, 0.5)};
    const long double limit = MovingPair{ball, chain, ball, still}.speedLimit();
    const Vector3l point = (0.3 * randomDirection(random)).cast<long double>();
    for (long double time = 0; time < 1; time += 0.1L) {
      const Vector3l way = exactPoseAt(chain, time + 1e-6L) * point - exactPoseAt(chain, time) * point;
      EXPECT_LE(way.norm(), 1e-6L * limit);
    }
  }
}

TEST(MotionOracle, FindsTheContactOfSpheresInTranslation) {
  // The way of the centres has the quadratic |offset + way t| = sum of radii.
  const Shape a = Sphere{0.25}, b = Sphere{0.5};
  const MotionChain a_motion = {translation({0, 0, 0}, {1, 0, 0})},
                    b_motion = {translation({4, 0.3, 0.2}, {-2, 0, 0.1})};
  const Vector3l offset(4, 0.3, 0.2), way(-3, 0, 0.1);
  const long double half_b = offset.dot(way), a2 = way.squaredNorm(), c = offset.squaredNorm() - 0.75L * 0.75L;
  const long double expected = (-half_b - std::sqrt(half_b * half_b - a2 * c)) / a2;
  ASSERT_GT(expected, 1.0L);  // just after the motion's end: so none, and with two units of time one

  const MovingPair pair{a, a_motion, b, b_motion};
  EXPECT_TRUE(firstContact(exactDistanceOf(pair), 0).never({0, 1}));
  const FirstContact found = firstContact(exactDistanceOf(pair), 0, {0, 2});
  expectContactAt(expected, found);
  EXPECT_LE(found.free_until, expected);
  EXPECT_GE(*found.contact_by, expected);
}

TEST(MotionOracle, FindsTheContactOfASphereOnAnArcWithABox) {
  // Half a turn about z at a radius of 1 m: the centre's y is sin(pi t); it touches the face y = 0.8 of the box at
  // y = 0.8 - 0.1.
  const Shape sphere = Sphere{0.1}, box = Box{{4, 0.4, 1}};
  const MotionChain arc = {{Isometry3d::Identity(), {0, 0, 0}, {0, 0, M_PI}}, {at(1, 0, 0), {0, 0, 0}, {0, 0, 0}}};
  const MotionChain still = {{at(0, 1, 0), {0, 0, 0}, {0, 0, 0}}};
  const long double expected = std::asin(0.7L) / static_cast<long double>(M_PI);
  const FirstContact found = firstContact(exactDistanceOf({sphere, arc, box, still}), 0);
  expectContactAt(expected, found);
}

/// A root of an increasing function by bisection.
long double rootOf(const std::function<long double(long double)>& f, long double low, long double high) {
  for (int i = 0; i < 200; ++i) {
    const long double middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return high;
}

TEST(MotionOracle, FindsTheContactOfAPointOnAHelixWithASphere) {
  // The point (cos w t, sin w t, t - 1) comes up to a sphere about (1.2, 0, 0.3) from below.
  const double w = 4 * M_PI;
  const Shape point = hullOf({{0, 0, 0}}), sphere = Sphere{0.4};
  const MotionChain helix = {{at(1, 0, -1), {0, w, 1}, {0, 0, w}}}, still = {{at(1.2, 0, 0.3), {0, 0, 0}, {0, 0, 0}}};
  const auto distance = [&](long double t) {
    const long double angle = static_cast<long double>(w) * t;
    const Vector3l offset(std::cos(angle) - static_cast<long double>(1.2), std::sin(angle),
                          t - 1 - static_cast<long double>(0.3));
    return offset.norm() - static_cast<long double>(0.4);
  };
  const long double expected = rootOf([&](long double t) { return -distance(t); }, 0.9L, 1.0L);
  ASSERT_GT(distance(0.99L * expected), 0);
  const FirstContact found = firstContact(exactDistanceOf({point, helix, sphere, still}), 0);
  expectContactAt(expected, found);
}

TEST(MotionOracle, ProvesThatShapesNeverMeet) {
  const Shape a = Sphere{0.5}, b = Box{{1, 1, 1}};
  const MotionChain past = {translation({-3, 0, 1.25}, {6, 0, 0})}, still;
  const DistanceOverTime distance = fastDistanceOf({a, past, b, still});  // closest approach: 0.25
  EXPECT_TRUE(firstContact(distance, 0).never({0, 1}));
  EXPECT_TRUE(firstContact(distance, 0.249L).never({0, 1}));
  EXPECT_TRUE(firstContact(distance, 0.251L).contact_by);
}

TEST(MotionOracle, SaysNothingOfAGrazeWithinItsResolution) {
  const Shape a = Sphere{0.5}, b = Sphere{0.5};
  const MotionChain past = {translation({-0.01, 1, 0}, {0.02, 0, 0})}, still;
  const DistanceOverTime distance = fastDistanceOf({a, past, b, still});
  const FirstContact found = firstContact(distance, -1e-9L, {0, 1}, 1e-8L);
  EXPECT_FALSE(found.never({0, 1}));
  EXPECT_FALSE(found.contact_by);
}

TEST(MotionOracle, EnclosesTheSmallestDistanceOfSpheres) {
  // Past each other at sqrt(0.3^2 + 0.4^2) = 0.5 between the centres.
  const Shape a = Sphere{0.1}, b = Sphere{0.2};
  const MotionChain past = {translation({-0.5, 0.3, 0.4}, {1.3, 0, 0})}, still;
  const DistanceOverTime distance = fastDistanceOf({a, past, b, still});
  const DistanceBounds smallest = smallestDistance(distance, 1e-4L);
  EXPECT_LE(smallest.low, 0.2L);
  EXPECT_GE(smallest.high, 0.2L - 1e-15L);
  EXPECT_LE(smallest.high - smallest.low, 1e-4L);
  const long double closest = timeOfLocalMinimum(distance, {0.2, 0.6});
  EXPECT_TRUE(isNear(distance.at(closest).low, 0.2L, 1e-14L));
}

TEST(MotionOracle, FastAndExactDistancesAgree) {
  std::mt19937 random(54);
  for (const NamedShape& a : solidShapes())
    for (const NamedShape& b : solidShapes()) {
      const MotionChain a_motion = {randomScrew(random, 3.0)}, b_motion = {randomScrew(random, 3.0)};
      const MovingPair pair{a.shape, a_motion, b.shape, b_motion};
      const DistanceBounds exact = exactDistanceAt(pair, 0.37L, 20000), fast = fastDistanceAt(pair, 0.37L);
      EXPECT_LE(fast.low, exact.high) << a.name << " " << b.name;
      EXPECT_GE(fast.high, exact.low) << a.name << " " << b.name;
    }
}

}  // namespace proximity_server::narrowphase::motion_oracle_test
