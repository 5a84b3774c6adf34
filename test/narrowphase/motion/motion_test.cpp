// Holds the promises of motion.h against geometry on paper and the oracle of moving shapes.
#include "proximity_server/narrowphase/motion/motion.h"

#include "chance.h"
#include "narrowphase/certificate.h"
#include "oracle/motion_oracle.h"
#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::motion_test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ScrewMotion randomScrew(Chance& random, double turn) {
  const Isometry3d start = randomPose(random, 1.0);
  const Vector3d linear = randomDirection(random);
  return {start, linear, turn * randomDirection(random)};
}

MotionChain moving(const Isometry3d& start, const Vector3d& linear, const Vector3d& angular = Vector3d::Zero()) {
  return {{start, linear, angular}};
}
MotionChain still(const Isometry3d& pose = Isometry3d::Identity()) { return moving(pose, Vector3d::Zero()); }

double difference(const Isometry3d& pose, const LongPose& expected) {
  const Matrix3l turned = pose.linear().cast<long double>() - expected.rotation;
  const Vector3l moved = pose.translation().cast<long double>() - expected.translation;
  return static_cast<double>(turned.norm() + moved.norm());
}

/// Two shapes in motion that own what they are made of.
struct Case {
  Shape a;
  MotionChain a_motion;
  Shape b;
  MotionChain b_motion;

  TimeOfContact contact(const ContactOptions& options = {}) const {
    return timeOfContact(a, a_motion, b, b_motion, options);
  }
  MinimumOverMotion minimum(const MinimumOptions& options = {}) const {
    return minimumDistance(a, a_motion, b, b_motion, options);
  }
};

ContactOptions withContactDistance(double contact_distance, double tolerance = 1e-9) {
  ContactOptions options;
  options.contact_distance = contact_distance;
  options.tolerance = tolerance;
  return options;
}

/// Checks that there is a contact, at a time that is right within `time_tolerance`, and not later than the true one.
testing::AssertionResult isContactAt(const TimeOfContact& answer, double expected, double time_tolerance) {
  if (answer.status != Status::Converged) return testing::AssertionFailure() << "not converged";
  if (!answer.contact) return testing::AssertionFailure() << "no contact";
  if (!(answer.t_free <= expected * (1.0 + 4.0 * kEpsilon)))
    return testing::AssertionFailure() << "late by " << answer.t_free - expected;
  if (!(std::abs(answer.t_contact - expected) <= time_tolerance))
    return testing::AssertionFailure() << "contact off by " << answer.t_contact - expected;
  if (!(answer.t_free <= answer.t_contact)) return testing::AssertionFailure() << "t_free after t_contact";
  return testing::AssertionSuccess();
}

testing::AssertionResult isFree(const TimeOfContact& answer, double end = 1.0) {
  if (answer.status != Status::Converged) return testing::AssertionFailure() << "not converged";
  if (answer.contact) return testing::AssertionFailure() << "contact at " << answer.t_contact;
  if (answer.t_free != end) return testing::AssertionFailure() << "free only until " << answer.t_free;
  if (!std::isnan(answer.t_contact)) return testing::AssertionFailure() << "t_contact without contact";
  return testing::AssertionSuccess();
}

// ScrewMotion.

TEST(ScrewMotion, BetweenReachesTheEndPose) {
  Chance random(61);
  for (int i = 0; i < 1000; ++i) {
    const Isometry3d start = randomPose(random, 2.0), end = randomPose(random, 2.0);
    const ScrewMotion motion = ScrewMotion::between(start, end);
    EXPECT_LT((motion.at(0.0).matrix() - start.matrix()).norm(), 1e-15);
    EXPECT_LT((motion.at(1.0).matrix() - end.matrix()).norm(), 2e-14);
  }
}

TEST(ScrewMotion, BetweenTakesTheShorterTurn) {
  Chance random(62);
  for (int i = 0; i < 1000; ++i) {
    const ScrewMotion motion = ScrewMotion::between(randomPose(random, 1.0), randomPose(random, 1.0));
    EXPECT_LE(motion.angular.norm(), M_PI * (1.0 + kEpsilon));
  }
}

TEST(ScrewMotion, BetweenReachesTheEndOfTinyAndOfHalfTurns) {
  Chance random(63);
  for (const double angle : {0.0, 1e-300, 1e-17, 1e-12, 1e-8, 1e-4, 0.1, 3.0, M_PI - 1e-7, M_PI - 1e-12, M_PI}) {
    const Isometry3d start = randomPose(random, 1.0);
    Isometry3d end = randomPose(random, 1.0);
    end.linear() = Eigen::AngleAxisd(angle, randomDirection(random)) * start.linear();
    EXPECT_LT((ScrewMotion::between(start, end).at(1.0).matrix() - end.matrix()).norm(), 2e-14) << angle;
  }
}

TEST(ScrewMotion, PoseIsThatOfTheOracle) {
  Chance random(64);
  for (const double turn : {0.0, 1e-12, 1e-6, 0.05, 0.0999, 0.1001, 1.0, 3.0, 40.0})
    for (int i = 0; i < 50; ++i) {
      const ScrewMotion motion = randomScrew(random, turn);
      const double time = 0.02 * i;
      EXPECT_LT(difference(motion.at(time), exactPoseAt(motion, time)), 1e-15 * (8.0 + turn)) << turn << " " << time;
    }
}

TEST(ScrewMotion, OriginKeepsItsDistanceFromTheAxis) {
  Chance random(65);
  for (int i = 0; i < 100; ++i) {
    const ScrewMotion motion = randomScrew(random, 8.0);
    const Vector3d u = motion.angular.normalized();
    const Vector3d on_axis = motion.start.translation() + u.cross(motion.linear) / motion.angular.norm();
    const double distance = u.cross(motion.start.translation() - on_axis).norm();
    for (double time = 0.0; time <= 1.0; time += 0.1)
      EXPECT_NEAR(u.cross(motion.at(time).translation() - on_axis).norm(), distance, 1e-14);
  }
}

TEST(ScrewMotion, OriginSlidesAlongTheAxisAtConstantSpeed) {
  Chance random(66);
  for (int i = 0; i < 100; ++i) {
    const ScrewMotion motion = randomScrew(random, 8.0);
    const Vector3d u = motion.angular.normalized();
    for (double time = 0.0; time <= 1.0; time += 0.1)
      EXPECT_NEAR(u.dot(motion.at(time).translation() - motion.start.translation()), time * u.dot(motion.linear),
                  1e-14);
  }
}

TEST(ScrewMotion, InverseIsTheInverseAtEveryTime) {
  Chance random(83);
  for (int i = 0; i < 100; ++i) {
    const ScrewMotion motion = randomScrew(random, 0.1 * i), inverse = motion.inverse();
    const double time = 0.01 * i;
    EXPECT_LT(difference(inverse.at(time), exactPoseAt(motion, time).inverse()), 3e-14);
  }
}

TEST(ScrewMotion, ProductWithAPoseIsThatOfThePoses) {
  Chance random(84);
  for (int i = 0; i < 100; ++i) {
    const ScrewMotion motion = randomScrew(random, 0.1 * i), fixed{randomPose(random, 2.0), {0, 0, 0}, {0, 0, 0}};
    const double time = 0.01 * i;
    EXPECT_LT(difference((fixed.start * motion).at(time), exactPoseAt(MotionChain{fixed, motion}, time)), 3e-14);
    EXPECT_LT(difference((motion * fixed.start).at(time), exactPoseAt(MotionChain{motion, fixed}, time)), 3e-14);
  }
}

TEST(ScrewMotion, IsRestWithoutAnyVelocity) {
  EXPECT_TRUE((ScrewMotion{at(1, 2, 3), {0, 0, 0}, {0, 0, 0}}).isRest());
  EXPECT_FALSE((ScrewMotion{at(0, 0, 0), {1e-300, 0, 0}, {0, 0, 0}}).isRest());
  EXPECT_FALSE((ScrewMotion{at(0, 0, 0), {0, 0, 0}, {0, -1e-300, 0}}).isRest());
}

TEST(MotionChain, PoseIsThatOfTheOracle) {
  Chance random(67);
  for (int i = 0; i < 100; ++i) {
    const MotionChain chain = {randomScrew(random, 1.0), randomScrew(random, 0.0), randomScrew(random, 7.0)};
    const double time = 0.01 * i;
    EXPECT_LT(difference(poseAt(chain, time), exactPoseAt(chain, time)), 1e-13);
  }
}

TEST(MotionChain, WithoutScrewsIsTheIdentity) { EXPECT_TRUE(poseAt({}, 0.5).isApprox(Isometry3d::Identity(), 0.0)); }

// motionBound.

/// A point of the ball about the centre, in the last frame of the chain.
struct Observed {
  const MotionChain& chain;
  Vector3l point;

  Vector3l velocity(long double time) const {
    constexpr long double kStep = 1e-6L;
    return (exactPoseAt(chain, time + kStep) * point - exactPoseAt(chain, time - kStep) * point) / (2 * kStep);
  }
  Vector3l acceleration(long double time) const {
    constexpr long double kStep = 1e-5L;
    return (exactPoseAt(chain, time + kStep) * point - 2 * (exactPoseAt(chain, time) * point) +
            exactPoseAt(chain, time - kStep) * point) /
           (kStep * kStep);
  }
};

TEST(MotionBound, HoldsForTheSpeedAndAccelerationOfEveryPoint) {
  constexpr double kOfDifferences = 1e-6;  // relative, what the finite differences are off by
  Chance random(68);
  for (int i = 0; i < 300; ++i) {
    MotionChain chain;
    for (int screws = i % 4; screws >= 0; --screws) chain.push_back(randomScrew(random, screws % 2 == 0 ? 3.0 : 0.5));
    const Vector3d centre = randomDirection(random);
    const double radius = i % 3 == 0 ? 0.0 : 0.4, begin = 0.003 * i, end = begin + 0.0003 * i;
    const MotionBound bound = motionBound(chain, centre, radius, begin, end);
    for (int k = 0; k < 20; ++k) {
      const Observed at{chain, (centre + radius * randomDirection(random)).cast<long double>()};
      const long double time = begin + (end - begin) * k / 19;
      EXPECT_LE(at.velocity(time).norm(), bound.speed() * (1.0 + kOfDifferences));
      EXPECT_LE(at.acceleration(time).norm(), bound.acceleration * (1.0 + kOfDifferences) + kOfDifferences);
      EXPECT_LE((at.velocity(time) - bound.velocity.cast<long double>()).norm(),
                bound.deviation * (1.0 + kOfDifferences) + kOfDifferences);
    }
  }
}

TEST(MotionBound, HoldsWhereAnArmIsStretchedAtTheEndsOfTheIntervalOnly) {
  // Two arms of 1 m. In the middle of the interval they are at right angles, the tip 1.41 m from the axis of the first;
  // at time 0 they lie on one line, and there every term of the acceleration has one direction.
  const MotionChain arms = {{at(0, 0, 0), {0, 0, 0}, {0, 0, 1}}, {at(1, 0, 0), {0, 0, 0}, {0, 0, M_PI}}};
  const Vector3d tip(1, 0, 0);
  const MotionBound bound = motionBound(arms, tip, 0.0, 0.0, 1.0);
  EXPECT_GE(bound.acceleration, 1.0 * 2.0 + 2.0 * M_PI + M_PI * M_PI);
  EXPECT_GE(bound.speed(), 2.0 + M_PI);
}

TEST(MotionBound, OfATranslationIsItsSpeed) {
  const MotionBound bound = motionBound(moving(at(1, 2, 3), {3, 4, 0}), {5, 5, 5}, 2.0, 0.0, 1.0);
  EXPECT_DOUBLE_EQ(bound.speed(), 5.0);
  EXPECT_EQ(bound.acceleration, 0.0);
}

TEST(MotionBound, OfATurnAboutTheCentreIsThatOfTheRim) {
  const MotionBound bound = motionBound(moving(at(1, 2, 3), {0, 0, 0}, {0, 0, 2}), {0, 0, 0}, 0.5, 0.0, 1.0);
  EXPECT_GE(bound.speed(), 1.0);
  EXPECT_DOUBLE_EQ(bound.acceleration, 2.0);  // w^2 r
}

// sweptShape.

/// Returns how far [m] a shape reaches along a unit direction, with its margin.
long double reachAlong(const Shape& shape, const LongPose& pose, const Vector3l& n) {
  return n.dot(pose * coreSupport(shape, pose.rotation.transpose() * n)) + shape.margin();
}

TEST(SweptShape, HoldsAllThatTheShapePassesThrough) {
  Chance random(69);
  for (const NamedShape& named : allShapes())
    for (const double turn : {0.0, 0.01, 0.5, 2.0, 9.0}) {
      const ScrewMotion motion = randomScrew(random, turn);
      const double begin = 0.2, end = turn == 0.5 ? 0.3 : 0.9;
      const Shape swept = sweptShape(named.shape, motion, begin, end);
      for (int k = 0; k < 200; ++k) {
        const long double time = begin + (end - begin) * k / 199;
        const LongPose pose = exactPoseAt(motion, begin).inverse() * exactPoseAt(motion, time);
        const Vector3l n = randomDirection(random).cast<long double>().normalized();
        EXPECT_LE(reachAlong(named.shape, pose, n), reachAlong(swept, {}, n) + 1e-14L) << named.name << " " << turn;
      }
    }
}

TEST(SweptShape, OfATranslatedBoxIsTheHullOfBothEnds) {
  Chance random(70);
  const Vector3d size(0.6, 0.4, 0.3), way(0.5, -0.7, 0.2);
  std::vector<Vector3d> corners = boxCorners(size);
  for (int i = 0; i < 8; ++i) corners.push_back(corners[i] + way);
  const Shape swept = sweptShape(Box{size}, {at(7, 8, 9), way, Vector3d::Zero()}), hull = hullOf(corners);
  EXPECT_EQ(swept.margin(), 0.0);
  for (const NamedShape& other : solidShapes())
    for (int i = 0; i < 50; ++i) {
      const Isometry3d pose = randomPose(random, 1.5);
      EXPECT_NEAR(signedDistance(swept, other.shape, pose).distance, signedDistance(hull, other.shape, pose).distance,
                  2e-9)
          << other.name;
    }
}

TEST(SweptShape, OfATranslatedSphereIsACapsule) {
  Chance random(71);
  const Shape swept = sweptShape(Sphere{0.2}, {Isometry3d::Identity(), {0, 0, 1}, {0, 0, 0}});
  const Shape capsule = Capsule{0.2, 1.0}, box = Box{{0.3, 0.4, 0.5}};
  for (int i = 0; i < 200; ++i) {
    const Isometry3d pose = randomPose(random, 1.5), from_middle = at(0, 0, -0.5) * pose;
    EXPECT_NEAR(signedDistance(swept, box, pose).distance, signedDistance(capsule, box, from_middle).distance, 2e-9);
  }
}

TEST(SweptShape, WithoutMotionIsTheShape) {
  Chance random(72);
  for (const NamedShape& named : allShapes()) {
    const Shape swept = sweptShape(named.shape, {randomPose(random, 1.0), {0, 0, 0}, {0, 0, 0}});
    EXPECT_EQ(swept.margin(), named.shape.margin());
    const Isometry3d pose = randomPose(random, 1.0);
    EXPECT_NEAR(signedDistance(swept, Box{{0.3, 0.3, 0.3}}, pose).distance,
                signedDistance(named.shape, Box{{0.3, 0.3, 0.3}}, pose).distance, 2e-9)
        << named.name;
  }
}

TEST(SweptShape, OfEveryKindHasItsTrueDistanceAndDepth) {
  Chance random(73);
  int apart = 0, overlapping = 0;
  for (const NamedShape& named : allShapes())
    for (const NamedShape& other : solidShapes())
      for (int i = 0; i < 3; ++i) {
        const Shape swept = sweptShape(named.shape, randomScrew(random, i == 0 ? 0.0 : 0.2), 0.0, 0.5);
        const PairCase c{named.name + " swept, " + other.name, swept, other.shape, randomPose(random, 1.2)};
        const SignedDistance result = signedDistance(c.a, c.b, c.a_T_b);
        const Truth truth = signedDistanceOracle(c.pair(), 5000);
        EXPECT_TRUE(enclosesTruth(c.pair(), result, truth)) << describe(c);
        EXPECT_TRUE(carriesItsProof(c.pair(), result)) << describe(c);
        EXPECT_LE(errorOf(result, truth), 1e-9) << describe(c);
        ++(truth.distance > 0 ? apart : overlapping);
      }
  EXPECT_GT(apart, 60);
  EXPECT_GT(overlapping, 60);
}

TEST(SweptShape, CanBeSweptAgain) {
  // A point along x, that segment along y: a rectangle.
  const Shape segment = sweptShape(hullOf({{0, 0, 0}}), {Isometry3d::Identity(), {2, 0, 0}, {0, 0, 0}});
  const Shape rectangle = sweptShape(segment, {Isometry3d::Identity(), {0, 1, 0}, {0, 0, 0}});
  EXPECT_NEAR(signedDistance(rectangle, Sphere{0.25}, at(1, 0.5, 1)).distance, 0.75, 1e-9);
  EXPECT_NEAR(signedDistance(rectangle, Sphere{0.25}, at(5, 5, 0)).distance, 4.75, 1e-9);
}

// timeOfContact.

/// Spheres of 0.25 and 0.5 m, their centres 2 m apart, that approach at 3 m per unit of time: both move.
Case approachingSpheres() {
  return {Sphere{0.25}, moving(at(0, 0, 0), {1, 0, 0}), Sphere{0.5}, moving(at(2, 0, 0), {-2, 0, 0})};
}

TEST(TimeOfContact, OfSpheresIsTheRootOfTheirQuadratic) {
  EXPECT_TRUE(isContactAt(approachingSpheres().contact(), 1.25 / 3.0, 1e-9));
}

TEST(TimeOfContact, OfSpheresBesideTheirWayIsTheRootOfTheirQuadratic) {
  Case c = approachingSpheres();
  c.b_motion = moving(at(2, 0.45, 0.6), {-2, 0, 0});  // 0.75 beside: they only just touch, at 2 / 3
  for (const double contact_distance : {0.25, 0.1, 0.01, 1e-4}) {
    const double half_chord = std::sqrt(std::pow(0.75 + contact_distance, 2) - 0.75 * 0.75);
    EXPECT_TRUE(isContactAt(c.contact(withContactDistance(contact_distance)), (2.0 - half_chord) / 3.0, 1e-6))
        << contact_distance;
  }
}

TEST(TimeOfContact, HoldsTheResultAtThatTimeInTheFrameOfTheChains) {
  Case c = approachingSpheres();
  c.a_motion.front().start.translation().y() = c.b_motion.front().start.translation().y() = 7.0;
  const TimeOfContact answer = c.contact();
  ASSERT_TRUE(answer.contact);
  EXPECT_LE((answer.at_contact.normal - Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LE((answer.at_contact.point_a - Vector3d(1.25 / 3.0 + 0.25, 7, 0)).norm(), 1e-8);
  EXPECT_LE((answer.at_contact.point_b - answer.at_contact.point_a).norm(), 2e-9);
}

TEST(TimeOfContact, OfASphereOnAnArcIsThatOfItsSine) {
  // Half a turn about z at 1 m: y is sin(pi t) and touches the face at 0.8 with a radius of 0.1.
  const Case c{Sphere{0.1},
               {{Isometry3d::Identity(), {0, 0, 0}, {0, 0, M_PI}}, {at(1, 0, 0), {0, 0, 0}, {0, 0, 0}}},
               Box{{4, 0.4, 1}},
               still(at(0, 1, 0))};
  EXPECT_TRUE(isContactAt(c.contact(), std::asin(0.7) / M_PI, 1e-9));
}

TEST(TimeOfContact, IsTheBeginWhereTheShapesAreInContactAlready) {
  const Case overlapping{Box{{1, 1, 1}}, still(), Sphere{0.5}, moving(at(0.9, 0, 0), {5, 0, 0})};
  for (const double begin : {0.0, 0.01}) {
    ContactOptions options;
    options.begin = begin;
    const TimeOfContact answer = overlapping.contact(options);
    EXPECT_TRUE(isContactAt(answer, begin, 0.0));
    EXPECT_EQ(answer.t_free, begin);
  }
}

TEST(TimeOfContact, IsNoneForShapesThatPass) {
  const Case past{Box{{1, 1, 1}}, still(), Sphere{0.5}, moving(at(-3, 0, 1.25), {6, 0, 0})};
  EXPECT_TRUE(isFree(past.contact()));
}

TEST(TimeOfContact, IsNoneForShapesThatMoveApartFromTouch) {
  const Case apart{Box{{1, 1, 1}}, still(), Box{{1, 1, 1}}, moving(at(1 + 1e-6, 0, 0), {1, 0, 0})};
  EXPECT_TRUE(isFree(apart.contact()));
}

/// Closest to each other at 0.25 m, at a time that is known.
struct Grazing {
  const char* name;
  Case c;
  double closest;
  double time;
};

std::vector<Grazing> grazingCases() {
  const double diagonal = std::sqrt(0.5);  // from the centre of a unit square to its corner
  return {
      {"spheres in translation",
       {Sphere{0.25}, still(), Sphere{0.5}, moving(at(-2, 0.6, 0.8), {3, 0, 0})},
       0.25,
       2.0 / 3.0},
      {"corner of a turning box over a plate",
       {Box{{1, 1, 1}}, moving(at(0, 0, diagonal + 0.25), {0, 0, 0}, {0, M_PI / 2, 0}), Box{{9, 9, 1}},
        still(at(0, 0, -0.5))},
       0.25,
       0.5},
      {"several turns over a plate",
       {Box{{1, 1, 1}}, moving(at(0, 0, diagonal + 0.25), {0, 0, 0}, {0, 9 * M_PI / 2, 0}), Box{{9, 9, 1}},
        still(at(0, 0, -0.5))},
       0.25,
       1.0 / 18.0},
      {"sphere on an arc over a plate",
       {Sphere{0.25},
        {{at(0, 0, 1.5), {0, 0, 0}, {0, M_PI, 0}}, {at(1, 0, 0), {0, 0, 0}, {0, 0, 0}}},
        Box{{9, 9, 1}},
        still(at(0, 0, -0.5))},
       0.25,
       0.5},
      {"tip of a capsule that comes down and swings",
       {Capsule{0.1, 1.0}, moving(at(0, 0, 0.85), {0, 0, 0}, {M_PI, 0, 0}), Box{{9, 9, 1}}, still(at(0, 0, -0.5))},
       0.25,
       0.0},
  };
}

TEST(TimeOfContact, IsNoneWhereTheContactDistanceIsALittleBelowTheClosestApproach) {
  for (const Grazing& grazing : grazingCases())
    for (double beside = 1e-3; beside > 0.9e-12; beside /= 10.0)
      EXPECT_TRUE(isFree(grazing.c.contact(withContactDistance(grazing.closest - beside, 0.25 * beside))))
          << grazing.name << " " << beside;
}

TEST(TimeOfContact, IsFoundWhereTheContactDistanceIsALittleAboveTheClosestApproach) {
  for (const Grazing& grazing : grazingCases())
    for (double beside = 1e-3; beside > 0.9e-12; beside /= 10.0) {
      const TimeOfContact answer = grazing.c.contact(withContactDistance(grazing.closest + beside, 0.25 * beside));
      EXPECT_LE(answer.t_free, grazing.time + 1e-15) << grazing.name << " " << beside;
      // Below the rounding of the poses it may be left undecided.
      EXPECT_TRUE(answer.contact || (beside < 1e-11 && answer.status == Status::Degenerate))
          << grazing.name << " " << beside;
      if (answer.contact) {
        EXPECT_LE(answer.t_contact, grazing.time + 1e-15) << grazing.name << " " << beside;
      }
    }
}

TEST(TimeOfContact, IsNeverMissedAtTheClosestApproachItself) {
  for (const Grazing& grazing : grazingCases())
    for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
      const TimeOfContact answer = grazing.c.contact(withContactDistance(grazing.closest, tolerance));
      EXPECT_TRUE(answer.contact) << grazing.name << " " << tolerance;
      EXPECT_LE(answer.t_free, grazing.time + 1e-15) << grazing.name << " " << tolerance;
    }
}

TEST(TimeOfContact, WithoutMotionIsTheBeginOrNone) {
  const Case apart{Box{{1, 1, 1}}, still(), Cone{0.5, 1}, still(at(0, 0, 2))};
  const Case touching{Box{{1, 1, 1}}, still(), Cone{0.5, 1}, still(at(0, 0, 1))};
  const Case without_chains{Box{{1, 1, 1}}, {}, Cone{0.5, 1}, {}};
  EXPECT_TRUE(isFree(apart.contact()));
  EXPECT_TRUE(isContactAt(touching.contact(), 0.0, 0.0));
  EXPECT_TRUE(isContactAt(without_chains.contact(), 0.0, 0.0));
}

/// Two thin shapes that are in each other at one time only, 1 m above at first.
struct Crossing {
  const char* name;
  Shape a, b;
  double height;  ///< [m] of both above their middle
};

TEST(TimeOfContact, OfThinShapesIsNotPassedAtAnySpeed) {
  const Crossing cases[] = {
      {"plates", Box{{1, 1, 1e-6}}, Box{{1, 1, 1e-6}}, 1e-6},
      {"point and polygon", hullOf({{0.1, 0.05, 0}}), hullOf({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}), 0.0},
      {"crossed segments", hullOf({{-1, 0, 0}, {1, 0, 0}}), hullOf({{0, -1, 0}, {0, 1, 0}}), 0.0},
      {"points", hullOf({{0, 0, 0}}), hullOf({{0, 0, 0}}), 0.0},
      {"polygons", hullOf({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}), hullOf({{-1, 1, 0}, {1, 1, 0}, {0, -1, 0}}), 0.0},
  };
  for (const Crossing& crossing : cases)
    for (const double speed : {1.5, 1e3, 1e6}) {
      const double tolerance = 1e-12 * std::max(1e3, speed);  // poses so far along are rounded
      const Case c{crossing.a, still(), crossing.b, moving(at(0, 0, 1), {0, 0, -speed})};
      EXPECT_TRUE(isContactAt(c.contact(withContactDistance(0.0, tolerance)), (1.0 - crossing.height) / speed,
                              2.0 * tolerance / speed + 1e-15))
          << crossing.name << " " << speed;
    }
}

TEST(TimeOfContact, OfANeedleThatTurnsThroughAnotherIsNotPassed) {
  // Both lie in one plane: b turns about its end by one turn and meets a, which points at 90 degrees, after a quarter.
  const Case c{hullOf({{0, 0.5, 0}, {0, 1.0, 0}}), still(), hullOf({{0, 0, 0}, {1, 0, 0}}),
               moving(at(0, 0, 0), {0, 0, 0}, {0, 0, 2.0 * M_PI})};
  EXPECT_TRUE(isContactAt(c.contact(), 0.25, 1e-8));
}

TEST(TimeOfContact, OfOneMotionForBothIsNone) {
  Chance random(75);
  for (int i = 0; i < 50; ++i) {
    const ScrewMotion carrier = randomScrew(random, 3.0);
    const Case c{Box{{1, 1, 1}}, {carrier, {}}, Cylinder{0.5, 1}, {carrier, {at(0, 0, 1.01), {0, 0, 0}, {0, 0, 0}}}};
    EXPECT_TRUE(isFree(c.contact()));
    EXPECT_TRUE(isContactAt(c.contact(withContactDistance(0.011)), 0.0, 0.0));
  }
}

TEST(TimeOfContact, FarFromTheOriginIsTheSame) {
  for (const double far : {1e3, 1e6}) {
    const Vector3d offset(far, -far, 0.5 * far);
    Case c = approachingSpheres();
    c.a = Box{{0.5, 0.5, 0.5}};
    c.a_motion.front().start.translation() += offset;
    c.b_motion.front().start.translation() += offset;
    // The starts themselves are rounded.
    EXPECT_TRUE(isContactAt(c.contact(), 1.25 / 3.0, 1e-9 + 4.0 * kEpsilon * far)) << far;
  }
}

TEST(TimeOfContact, OfAContactDistanceIsWhenThatIsReached) {
  for (const double contact_distance : {1e-6, 0.01, 0.5})
    EXPECT_TRUE(isContactAt(approachingSpheres().contact(withContactDistance(contact_distance)),
                            (1.25 - contact_distance) / 3.0, 1e-9));
}

TEST(TimeOfContact, OfADepthIsWhenThatIsReached) {
  // A sphere of 0.2 from above into a box whose top is at 0.5: the depth is that of its lowest point.
  const Case c{Box{{4, 4, 1}}, still(), Sphere{0.2}, moving(at(0, 0, 1), {0, 0, -0.5})};
  for (const double depth : {1e-6, 0.01, 0.1})
    EXPECT_TRUE(isContactAt(c.contact(withContactDistance(-depth)), (0.3 + depth) / 0.5, 1e-8)) << depth;
  EXPECT_TRUE(isFree(c.contact(withContactDistance(-0.21))));  // 0.2 at the end of the motion
}

TEST(TimeOfContact, KeepsToItsInterval) {
  const Case c = approachingSpheres();  // 0.4167
  ContactOptions before, around, after;
  before.end = 0.41;
  around.begin = 0.3;
  around.end = 0.5;
  after.begin = 0.45;
  EXPECT_TRUE(isFree(c.contact(before), 0.41));
  EXPECT_TRUE(isContactAt(c.contact(around), 1.25 / 3.0, 1e-9));
  EXPECT_TRUE(isContactAt(c.contact(after), 0.45, 0.0));
  ContactOptions moment;
  moment.begin = moment.end = 0.4;
  EXPECT_TRUE(isFree(c.contact(moment), 0.4));
}

TEST(TimeOfContact, EndsBeforeTheQueryWithWhichItIsOver) {
  const Case c{Capsule{0.05, 1.0}, moving(at(0.5, 0, 0), {-0.6, 0, 0}, {0, 3, 0}), Capsule{0.05, 1.0}, {}};
  ASSERT_GT(c.contact().queries, 2);
  int asked = 0;
  ContactOptions options;
  options.is_over = [&] { return ++asked == 2; };
  const TimeOfContact answer = c.contact(options);
  EXPECT_EQ(answer.queries, 2);
  EXPECT_EQ(answer.status, Status::IterationLimit);
  EXPECT_GT(answer.t_free, 0.0);
  EXPECT_LE(answer.t_free, c.contact().t_free);
}

TEST(TimeOfContact, OfAMotionThatIsNotFiniteIsUnknown) {
  for (const double bad : {kNaN, kInfinity, -kInfinity})
    for (int what = 0; what < 4; ++what) {
      Case c = approachingSpheres();
      c.b_motion.push_back({});
      ScrewMotion& screw = c.b_motion[what % 2];
      if (what == 0) screw.linear.y() = bad;
      if (what == 1) screw.angular.z() = bad;
      if (what == 2) screw.start.translation().x() = bad;
      if (what == 3) screw.start.linear()(1, 2) = bad;
      EXPECT_EQ(c.contact().status, Status::Unknown) << bad << " " << what;
      EXPECT_FALSE(c.contact().contact) << bad << " " << what;
      EXPECT_EQ(c.minimum().status, Status::Unknown) << bad << " " << what;
    }
}

TEST(TimeOfContact, OutsideOfTheMotionIsUnknown) {
  const ScrewMotion rest;
  for (const auto& [begin, end] : {std::make_pair(-0.1, 1.0), {0.0, 1.1}, {0.6, 0.4}, {std::nan(""), 1.0}}) {
    ContactOptions contact;
    MinimumOptions minimum;
    contact.begin = minimum.begin = begin;
    contact.end = minimum.end = end;
    EXPECT_EQ(timeOfContact(Sphere{1.0}, {rest}, Sphere{1.0}, {rest}, contact).status, Status::Unknown);
    EXPECT_EQ(minimumDistance(Sphere{1.0}, {rest}, Sphere{1.0}, {rest}, minimum).status, Status::Unknown);
  }
}

TEST(TimeOfContact, OfAMotionThatOverflowsIsNeverSaidToBeFree) {
  for (const double huge : {1e100, 1e155, 1e200, 1e308})
    for (int what = 0; what < 3; ++what) {
      Case c = approachingSpheres();
      if (what != 1) c.b_motion.front().angular = Vector3d(huge, -huge, huge);
      if (what != 0) c.b_motion.front().linear = Vector3d(-huge, huge, huge);
      EXPECT_NE(c.contact().t_free, 1.0) << huge << " " << what;
      const MinimumOverMotion minimum = c.minimum();
      EXPECT_TRUE(minimum.status != Status::Converged || minimum.lower_bound <= 1.25)
          << huge << " " << what << ": " << minimum.lower_bound;
    }
}

// Regression: only the last of the two ends counted.
TEST(MinimumDistance, WithAnEndThatIsTooFarIsUnknown) {
  for (const double far : {1e31, 1e160})
    for (const bool departs : {false, true}) {
      Case c{Sphere{1.0}, {ScrewMotion()}, Sphere{1.0}, {ScrewMotion()}};
      c.b_motion.front().start.translation().x() = departs ? 3.0 : far;
      c.b_motion.front().linear.x() = departs ? far : -far;
      EXPECT_EQ(c.minimum().status, Status::Unknown) << far << " " << departs;
      EXPECT_EQ(c.minimum().lower_bound, -kInfinity) << far << " " << departs;
    }
}

// minimumDistance.

testing::AssertionResult encloses(const MinimumOverMotion& minimum, double expected, double rounding) {
  if (!(minimum.lower_bound <= expected + rounding))
    return testing::AssertionFailure() << "lower bound above by " << minimum.lower_bound - expected;
  if (!(minimum.upper_bound >= expected - rounding))
    return testing::AssertionFailure() << "upper bound below by " << expected - minimum.upper_bound;
  return testing::AssertionSuccess();
}

TEST(MinimumDistance, OfPassingSpheresIsThatOfTheirLines) {
  // Past each other at sqrt(0.3^2 + 0.4^2) = 0.5 between the centres, at 0.5 / 1.25.
  const Case c{Sphere{0.1}, still(), Sphere{0.2}, moving(at(-0.5, 0.3, 0.4), {1.25, 0, 0})};
  const MinimumOverMotion minimum = c.minimum();
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_TRUE(encloses(minimum, 0.2, 1e-15));
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1e-9);
  EXPECT_NEAR(minimum.time, 0.4, 1e-4);  // flat: 1e-9 m takes 3e-5 of time
  EXPECT_NEAR(minimum.at_minimum.distance, 0.2, 1e-9);
}

TEST(MinimumDistance, OfGrazingCasesIsTheirClosestApproach) {
  for (const Grazing& grazing : grazingCases()) {
    const MinimumOverMotion minimum = grazing.c.minimum();
    EXPECT_EQ(minimum.status, Status::Converged) << grazing.name;
    EXPECT_TRUE(encloses(minimum, grazing.closest, 1e-15)) << grazing.name;
    EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1e-9) << grazing.name;
  }
}

TEST(MinimumDistance, OfASphereThroughABoxIsItsGreatestDepth) {
  // Along the longest axis of the box: deepest where the way out is by the side, 0.5 + 0.1.
  const Case c{Box{{3, 1, 2}}, still(), Sphere{0.1}, moving(at(-3, 0, 0), {6, 0, 0})};
  const MinimumOverMotion minimum = c.minimum();
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_TRUE(encloses(minimum, -0.6, 1e-14));
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1e-9);
}

TEST(MinimumDistance, AtTheEndsOfTheMotionIsFound) {
  const Case approaching{Sphere{0.1}, still(), Box{{1, 1, 1}}, moving(at(3, 0, 0), {-1, 0, 0})};
  EXPECT_TRUE(encloses(approaching.minimum(), 1.4, 1e-15));
  EXPECT_EQ(approaching.minimum().time, 1.0);
  const Case leaving{Sphere{0.1}, still(), Box{{1, 1, 1}}, moving(at(3, 0, 0), {1, 0, 0})};
  EXPECT_TRUE(encloses(leaving.minimum(), 2.4, 1e-15));
  EXPECT_EQ(leaving.minimum().time, 0.0);
}

/// The distance of a tumbling box has a kink wherever another corner or edge comes nearest.
Case tumblingBox(Chance& random, double beside) {
  const Isometry3d start = at(-1.5, beside, 0.2) * randomPose(random, 0.0);
  return {Box{{0.6, 0.4, 0.8}}, still(), Box{{0.5, 0.7, 0.3}}, moving(start, {3, 0, 0}, 6.0 * randomDirection(random))};
}

TEST(MinimumDistance, OfATumblingBoxConverges) {
  Chance random(78);
  for (int i = 0; i < 20; ++i) {
    const MinimumOverMotion minimum = tumblingBox(random, 0.75 + 0.05 * i).minimum();
    EXPECT_EQ(minimum.status, Status::Converged) << i;
    EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1e-9) << i;
  }
}

TEST(MinimumDistance, AboveTheThresholdIsOnlyProven) {
  const Case c{Sphere{0.1}, still(), Sphere{0.2}, moving(at(-0.5, 0.3, 0.4), {1.25, 0, 0})};  // 0.2
  MinimumOptions options;
  options.stop_above = 0.19;
  const MinimumOverMotion above = c.minimum(options);
  EXPECT_EQ(above.status, Status::Threshold);
  EXPECT_GT(above.lower_bound, 0.19);
  EXPECT_TRUE(encloses(above, 0.2, 1e-15));
  EXPECT_LE(above.queries, c.minimum().queries);
  options.stop_above = 0.21;
  EXPECT_EQ(c.minimum(options).status, Status::Converged);
  EXPECT_TRUE(encloses(c.minimum(options), 0.2, 1e-15));
}

TEST(MinimumDistance, KeepsToItsInterval) {
  const Case c{Sphere{0.1}, still(), Box{{1, 1, 1}}, moving(at(3, 0, 0), {-1, 0, 0})};  // 2.4 - t
  MinimumOptions options;
  options.begin = 0.25;
  options.end = 0.5;
  EXPECT_TRUE(encloses(c.minimum(options), 1.9, 1e-15));
  options.begin = options.end;
  EXPECT_TRUE(encloses(c.minimum(options), 1.9, 1e-15));
  EXPECT_EQ(c.minimum(options).time, 0.5);
}

// Regression: all points of the shape counted as turning, so that a distance that never changes was bounded in 512
// pieces of the time, and the search ended there.
TEST(MinimumDistance, OfAShapeThatSpinsAboutItsAxisNeedsTwoQueries) {
  const Shape box = Box{{0.3, 0.4, 0.5}};
  for (const Shape& round : {Shape(Cylinder{0.2, 0.5}), Shape(Cone{0.2, 0.5}), Shape(Capsule{0.2, 0.5}),
                             Shape(Ellipsoid{{0.2, 0.2, 0.5}}), Shape(Sphere{0.2})}) {
    Chance random(78);
    for (int i = 0; i < 20; ++i) {
      const Isometry3d start = randomPose(random, 1.0);
      Case c{round, moving(start, Vector3d::Zero(), 6.0 * start.linear().col(2)), box, still(randomPose(random, 1.0))};
      const MinimumOverMotion minimum = c.minimum();
      EXPECT_EQ(minimum.status, Status::Converged);
      EXPECT_EQ(minimum.queries, 2);
    }
  }
}

/// A prism with 100 edges turns about its axis: 0.5 m from the box each time that one of them is nearest, 96 times.
TEST(MinimumDistance, EndsWithTheQueriesForWhichItHasRoom) {
  std::vector<Vector3d> prism;
  for (int i = 0; i < 200; ++i)
    prism.emplace_back(0.2 * std::cos(0.02 * M_PI * i), 0.2 * std::sin(0.02 * M_PI * i), i < 100 ? -0.5 : 0.5);
  const Case c{ConvexHull(prism), moving(Isometry3d::Identity(), Vector3d::Zero(), {0, 0, 6}), Box{{1, 1, 1}},
               still(at(1.2, 0, 0))};
  MinimumOptions options;
  options.tolerance = 1e-15;
  options.max_queries = 100000;
  const MinimumOverMotion minimum = c.minimum(options);
  EXPECT_EQ(minimum.status, Status::IterationLimit);
  EXPECT_EQ(minimum.queries, 512);
  EXPECT_TRUE(encloses(minimum, 0.5, 1e-14));
}

// Regression: the minimum converged with the bounds of both ends, and the contact was found at any distance.
TEST(Motion, ToleranceThatIsNotANumberCountsAsZero) {
  const Case c{Cylinder{0.3, 0.5}, {{at(-1, 0, 0), {2, 0, 0}}}, Box{{0.3, 0.5, 0.4}}, {}};
  ContactOptions contact;
  MinimumOptions minimum;
  contact.tolerance = minimum.tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(c.contact(contact).status, c.contact({0.0, 0.0}).status);
  EXPECT_EQ(c.contact(contact).t_free, c.contact({0.0, 0.0}).t_free);
  EXPECT_NE(c.minimum(minimum).status, Status::Converged);
  EXPECT_NEAR(c.minimum(minimum).lower_bound, c.minimum().lower_bound, 1e-6);
}

TEST(Motion, WhoseBeginIsNoRotationIsUnknown) {
  Isometry3d scaled = at(-1, 0, 0);
  scaled.linear() *= 2.0;
  const Case c{Sphere{0.3}, {{scaled, {2, 0, 0}}}, Box{{0.3, 0.5, 0.4}}, {}};
  EXPECT_EQ(c.contact().status, Status::Unknown);
  EXPECT_EQ(c.minimum().status, Status::Unknown);
  EXPECT_THROW(Shape(Sphere{0.3}).sweptTo(scaled), std::invalid_argument);
}

}  // namespace proximity_server::narrowphase::motion_test
