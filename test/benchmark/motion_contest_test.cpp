// ./dev bench motion relies on this: all libraries are asked about the same motion, and the reference is right.

#include "benchmark/motions.h"
#include "peers/motion_library.h"
#include "peers/moving_solids.h"
#include "peers/robots.h"
#include "peers/swept_bisection.h"
#include "tools/second_opinion/fcl_shape.h"

#include <fcl/math/motion/screw_motion.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::benchmark::motion_contest_test {

using namespace narrowphase;
using namespace scene;
using namespace peers;
using tools::fclShape;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kMotions = 20;

Solid sphereOf(double radius) { return {Sphere{radius}, fclShape(Sphere{radius}), nullptr}; }
Solid boxOf(const Vector3d& size) { return {Box{size}, fclShape(Box{size}), nullptr}; }

RigidMotion atRest() { return {MotionKind::Translation, Isometry3d::Identity(), Vector3d::Zero(), Vector3d::Zero()}; }

RigidMotion straight(const Vector3d& from, const Vector3d& by) {
  return {MotionKind::Translation, Isometry3d(Eigen::Translation3d(from)), by, Vector3d::Zero()};
}

/// Returns a motion about the z axis of the common frame.
RigidMotion circling(const Vector3d& from, double turn) {
  const Vector3d angular = turn * Vector3d::UnitZ();
  return {MotionKind::Screw, Isometry3d(Eigen::Translation3d(from)), angular.cross(from), angular};
}

/// Returns the same solid on every run, whichever tests are among them.
Solid made(Solid (*make)(Random&), unsigned seed) {
  Random random(seed);
  return make(random);
}
Solid randomHullOf32(Random& random) { return randomHull(random, 32); }

MovingSolidPair randomPair(MotionKind kind, Outcome outcome, Random& random) {
  static const Solid a = made(randomBox, 1), b = made(randomHullOf32, 2);
  return randomMotion(a, b, kind, outcome, random);
}

class MotionKinds : public testing::TestWithParam<MotionKind> {};

TEST_P(MotionKinds, HaveThePosesOfFclsMotion) {
  Random random(1);
  for (int i = 0; i < kMotions; ++i) {
    const MovingSolidPair pair = randomPair(GetParam(), Outcome::Hit, random);
    for (const MovingSolid* moving : {&pair.a, &pair.b})
      for (const double time : {0.0, 0.25, 0.5, 1.0}) {
        fcl::Transform3d pose;
        moving->fcl->integrate(time);
        moving->fcl->getCurrentTransform(pose);
        EXPECT_LT((poseAt(moving->ours, time).matrix() - pose.matrix()).norm(), 1e-12) << time;
      }
  }
}

TEST_P(MotionKinds, AreNoFasterThanTheBoundOfTheReference) {
  Random random(2);
  for (int i = 0; i < kMotions; ++i) {
    const MovingSolidPair pair = randomPair(GetParam(), Outcome::Miss, random);
    for (double time = 0.0; time < 1.0; time += 0.05) {
      const double change = signedDistanceAt(pair, time + 0.05).distance - signedDistanceAt(pair, time).distance;
      EXPECT_LE(std::abs(change), 0.05 * pair.speedBound() + 1e-9);
    }
  }
}

TEST_P(MotionKinds, SeenFromOneSolidLeadToTheSamePoses) {
  Random random(3);
  for (int i = 0; i < kMotions; ++i) {
    const MovingSolidPair pair = randomPair(GetParam(), Outcome::Hit, random);
    const MotionChain relative = relativeMotion(pair.a.ours, pair.b.ours);
    for (const double time : {0.0, 0.3, 1.0})
      EXPECT_LT((poseAt(relative, time).matrix() - pair.poseOfBInA(time).matrix()).norm(), 1e-12);
  }
}

TEST_P(MotionKinds, EndAsTheOutcomeSays) {
  Random random(4);
  for (int i = 0; i < kMotions; ++i) {
    EXPECT_TRUE(firstContactOf(randomPair(GetParam(), Outcome::Hit, random)).contact);
    const MovingSolidPair miss = randomPair(GetParam(), Outcome::Miss, random);
    EXPECT_FALSE(firstContactOf(miss).contact);
    EXPECT_GT(lowestOf(miss, 200).distance, 0.01);
    const MovingSolidPair grazing = randomPair(GetParam(), Outcome::Grazing, random);
    const double lowest = lowestOf(grazing, 200).distance;
    EXPECT_LT(std::abs(lowest), 1.1e-3);
    EXPECT_EQ(firstContactOf(grazing).contact, lowest <= 0.0);
  }
}

TEST_P(MotionKinds, HaveTheContactThatTheReferenceSays) {
  Random random(5);
  for (int i = 0; i < kMotions; ++i) {
    const MovingSolidPair pair = randomPair(GetParam(), i % 2 == 0 ? Outcome::Hit : Outcome::Grazing, random);
    const FirstContact truth = firstContactOf(pair);
    for (const ContactLibrary& library : {oursWithin(1e-9), sweptBisectionWithin(1e-9)}) {
      const ContactAnswer answer = library.ask(pair);
      ASSERT_EQ(answer.contact, truth.contact) << library.name;
      if (!truth.contact) continue;
      EXPECT_LE(answer.t_free, truth.to + 1e-12) << library.name;
      EXPECT_LE(signedDistanceAt(pair, answer.t_contact).distance, 1.1e-9) << library.name;
      EXPECT_NEAR(signedDistanceAt(pair, answer.t_free).distance, 0.0, 1e-7) << library.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MotionKinds,
                         testing::Values(MotionKind::Translation, MotionKind::Linear, MotionKind::Screw));

TEST(FirstContact, OfSpheresHeadOnIsTheGapOverTheSpeed) {
  const Solid a = sphereOf(0.5), b = sphereOf(0.25);
  const MovingSolidPair pair{MovingSolid(a, atRest()), MovingSolid(b, straight({3.0, 0.0, 0.0}, {-4.0, 0.0, 0.0}))};
  const FirstContact contact = firstContactOf(pair);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.from, 2.25 / 4.0, 1e-12);
  EXPECT_NEAR(contact.to, 2.25 / 4.0, 1e-12);
}

TEST(FirstContact, OfASphereOnACircleIsWhereTheChordIsTheSumOfTheRadii) {
  const Solid a = sphereOf(0.5), b = sphereOf(0.25);
  // Both 2 m from the z axis, b a quarter of a turn ahead and coming back by 2 rad: at the angle phi between them the
  // centres are 2 * 2 sin(phi / 2) apart.
  const MovingSolidPair pair{MovingSolid(a, straight({2.0, 0.0, 0.0}, Vector3d::Zero())),
                             MovingSolid(b, circling({0.0, 2.0, 0.0}, -2.0))};
  const double angle = 2.0 * std::asin(0.75 / 4.0);
  const FirstContact contact = firstContactOf(pair);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.from, (0.5 * M_PI - angle) / 2.0, 1e-12);
}

TEST(FirstContact, OfAPlateThatPassesThroughAPlateIsFound) {
  const Solid a = boxOf({1.0, 1.0, 1e-6}), b = boxOf({1.0, 1.0, 1e-6});
  const MovingSolidPair pair{MovingSolid(a, atRest()), MovingSolid(b, straight({0.0, 0.0, 0.3}, {0.0, 0.0, -3.0}))};
  const FirstContact contact = firstContactOf(pair);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.from, (0.3 - 1e-6) / 3.0, 1e-12);
}

TEST(FirstContact, OfSpheresThatPassEachOtherIsNone) {
  const Solid a = sphereOf(0.5), b = sphereOf(0.25);
  const MovingSolidPair pair{MovingSolid(a, atRest()), MovingSolid(b, straight({3.0, 0.751, 0.0}, {-6.0, 0.0, 0.0}))};
  EXPECT_FALSE(firstContactOf(pair).contact);
  EXPECT_NEAR(lowestOf(pair, 50).distance, 0.001, 1e-12);
}

TEST(FclAdvancement, TakesNoNoticeOfTheErrorThatTheRequestAsksFor) {
  Random random(6);
  fcl::ContinuousCollisionRequestd coarse, fine;
  coarse.ccd_solver_type = fine.ccd_solver_type = fcl::CCDC_CONSERVATIVE_ADVANCEMENT;
  coarse.toc_err = 0.1, fine.toc_err = 1e-9;
  coarse.num_max_iterations = 1, fine.num_max_iterations = 10000;
  for (int i = 0; i < kMotions; ++i) {
    const MovingSolidPair pair = randomPair(MotionKind::Translation, Outcome::Hit, random);
    double times[2];
    for (const auto& [request, time] : {std::pair(&coarse, &times[0]), std::pair(&fine, &times[1])}) {
      pair.a.fcl->integrate(0.0), pair.b.fcl->integrate(0.0);
      fcl::ContinuousCollisionResultd result;
      *time = fcl::continuousCollide(pair.a.solid->fcl.get(), pair.a.fcl.get(), pair.b.solid->fcl.get(),
                                     pair.b.fcl.get(), *request, result);
    }
    EXPECT_EQ(times[0], times[1]);
  }
}

TEST(FclAdvancement, IsTheSameInOurLoopWithItsOwnErrorOfTheTime) {
  Random random(7);
  const Solid a = randomCylinder(random), b = randomCylinder(random);
  for (const MotionKind kind : {MotionKind::Translation, MotionKind::Linear, MotionKind::Screw})
    for (int i = 0; i < kMotions; ++i) {
      const MovingSolidPair pair = randomMotion(a, b, kind, Outcome::Hit, random);
      const ContactAnswer theirs = fclAdvancement(fcl::GST_LIBCCD).ask(pair),
                          ours = fclAdvancementWithin(1e-4).ask(pair);
      EXPECT_EQ(theirs.contact, ours.contact);
      if (std::isnan(theirs.t_contact)) {  // libccd of Debian 11 has no answer to some
        EXPECT_TRUE(std::isnan(ours.t_contact));
      } else {
        EXPECT_EQ(theirs.t_contact, ours.t_contact);
      }
    }
}

// Translations are put to FCL as TranslationMotion for this reason: its screw multiplies the way with its own length.
TEST(FclScrewMotion, WithoutATurnGoesTooFar) {
  const fcl::ScrewMotion<double> motion(Isometry3d::Identity(), Isometry3d(Eigen::Translation3d(2.0, 0.0, 0.0)));
  motion.integrate(1.0);
  fcl::Transform3d end;
  motion.getCurrentTransform(end);
  EXPECT_NEAR(end.translation().x(), 4.0, 1e-12);
}

TEST(RandomJointMotions, StayWithinLimitsAndAreNoFasterThanTheJoint) {
  const NamedRobot demo = demoRobot();
  const RobotModel& robot = demo.model->robot;
  double moved = 0.0;
  for (const JointMotion& motion : randomJointMotions(robot, 100))
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const Joint& joint = robot.joints[i];
      EXPECT_LE(motion.to[i], joint.upper);
      EXPECT_GE(motion.to[i], joint.lower);
      EXPECT_LE(std::abs(motion.to[i] - motion.from[i]), joint.max_velocity);
      moved = std::max(moved, std::abs(motion.to[i] - motion.from[i]));
    }
  EXPECT_GT(moved, 0.5);
}

}  // namespace proximity_server::benchmark::motion_contest_test
