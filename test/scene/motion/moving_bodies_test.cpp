#include "scene/motion/moving_bodies.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace proximity_server::scene::moving_bodies_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Twist = RobotMotion::Twist;
using Interval = MovingBodies::Interval;

Bounds boundsOfShape(const Shape& shape) { return boundsOf(Piece{shape, Isometry3d::Identity(), 0}); }

/// Two bodies that move on their own.
struct TwoMoving {
  TwoMoving(const Isometry3d& start_a, const Twist& twist_a, const Isometry3d& start_b, const Twist& twist_b,
            const Shape& shape_a, const Shape& shape_b)
      : motion(RobotMotion::ofTwists({start_a, start_b}, {twist_a, twist_b})),
        a(boundsOfShape(shape_a)),
        b(boundsOfShape(shape_b)) {}

  const RobotMotion motion;
  const Bounds a, b;
  PosesInTime poses{motion};
  MovingBodies bodies{poses, 0, a, 1, b};
};

// --- intervals

TEST(IntervalOfTime, HasTheHalvesTwiceItsNumberAndTheNext) {
  const auto expectInterval = [](int number, double begin, double end) {
    const Interval interval(number);
    EXPECT_EQ(interval.begin, begin) << number;
    EXPECT_EQ(interval.end, end) << number;
    const auto [earlier, later] = interval.halves();
    EXPECT_EQ(earlier.number, 2 * number);
    EXPECT_EQ(earlier.begin, begin) << number;
    EXPECT_EQ(earlier.end, later.begin) << number;
    EXPECT_EQ(later.end, end) << number;
  };
  expectInterval(1, 0.0, 1.0);
  expectInterval(2, 0.0, 0.5);
  expectInterval(3, 0.5, 1.0);
  expectInterval(4, 0.0, 0.25);
  expectInterval(6, 0.5, 0.75);
  expectInterval(7, 0.75, 1.0);
  expectInterval((1 << 20) + 1, std::ldexp(1.0, -20), std::ldexp(2.0, -20));
}

TEST(PosesInTime, AreThoseOfTheMotion) {
  const RobotMotion motion = RobotMotion::ofTwists({at(0, 0, 0)}, {{{4, 0, 0}, {0, 0, 0}}});
  PosesInTime poses(motion);
  EXPECT_EQ(poses.at(0.25)[0]->translation(), Vector3d(1, 0, 0));
  EXPECT_EQ(poses.at(0.75)[0]->translation(), Vector3d(3, 0, 0));
  EXPECT_EQ(&poses.at(0.25), &poses.at(0.25)) << "computed once";
}

// --- bounds on paper

// Ball b passes ball a, 3 away, from x = -4 to x = 4.
TEST(SphereGapOfMovingBodies, OfAStraightPassIsThatOfTheSegment) {
  TwoMoving balls(at(0, 0, 0), {}, at(-4, 3, 0), {{8, 0, 0}, {0, 0, 0}}, Sphere{0.5}, Sphere{1.0});
  const auto [gap, travel] = balls.bodies.sphereGap(balls.a, balls.b, Interval(1), balls.poses);
  EXPECT_NEAR(gap, 3.0 - 0.5 - 1.0, 1e-11);
  EXPECT_LT(gap, 1.5) << "rounding";
  EXPECT_NEAR(travel, 8.0, 1e-11);
}

// In the last quarter it goes from x = 2, sqrt(13) from a, to x = 4.
TEST(SphereGapOfMovingBodies, CountsOnlyTheInterval) {
  TwoMoving balls(at(0, 0, 0), {}, at(-4, 3, 0), {{8, 0, 0}, {0, 0, 0}}, Sphere{0.5}, Sphere{1.0});
  const auto [gap, travel] = balls.bodies.sphereGap(balls.a, balls.b, Interval(7), balls.poses);
  EXPECT_NEAR(gap, std::sqrt(13.0) - 1.5, 1e-11);
  EXPECT_NEAR(travel, 2.0, 1e-11);
}

// Both move: b passes a, which comes towards it, half as far away in the end.
TEST(SphereGapOfMovingBodies, IsAboutTheirMotionAgainstEachOther) {
  TwoMoving balls(at(0, 0, 0), {{1, 0, 0}, {0, 0, 0}}, at(10, 0, 0), {{-4, 0, 0}, {0, 0, 0}}, Sphere{1}, Sphere{1});
  const auto [gap, travel] = balls.bodies.sphereGap(balls.a, balls.b, Interval(1), balls.poses);
  EXPECT_NEAR(gap, 5.0 - 2.0, 1e-11);
  EXPECT_NEAR(travel, 5.0, 1e-11);
}

// b goes round a at a distance of 2, by a quarter. The chord comes within sqrt(2) of a. Each point of b leaves its
// chord by at most w^2 / 8 of its distance from the axis: 2, and 0.5 more.
TEST(SphereGapOfMovingBodies, OfAnArcIsThatOfTheChordLessItsBulge) {
  const double turning = M_PI / 2;
  TwoMoving balls(at(0, 0, 0), {}, at(2, 0, 0), {{0, 2 * turning, 0}, {0, 0, turning}}, Sphere{0.25}, Sphere{0.5});
  MovingBodies from_a(balls.poses, 0, balls.a, 1, balls.b, SeenFrom::A);
  const auto [gap, travel] = from_a.sphereGap(balls.a, balls.b, Interval(1), balls.poses);
  const double bulge = turning * turning * (2.0 + 0.5) / 8.0;
  EXPECT_NEAR(gap, std::sqrt(2.0) - bulge - 0.25 - 0.5, 1e-11);
  EXPECT_NEAR(travel, 2.0 * std::sqrt(2.0) + bulge, 1e-11);
}

// A cube of edge 2 comes within 3 of another one at rest; in the middle of the motion it is 4 away, and moves by 1 from
// there.
TEST(BoxGapOfMovingBodies, IsTheGapInTheMiddleLessTheWayFromThere) {
  TwoMoving boxes(at(0, 0, 0), {}, at(7, 0, 0), {{-2, 0, 0}, {0, 0, 0}}, Box{{2, 2, 2}}, Box{{2, 2, 2}});
  EXPECT_NEAR(boxes.bodies.boxGap(boxes.a, boxes.b, Interval(1), boxes.poses), 3.0, 1e-11);
  EXPECT_NEAR(boxes.bodies.boxGap(boxes.a, boxes.b, Interval(2), boxes.poses), 4.0, 1e-11);
}

// Towards each other they come within 9 - 2 - 2; in one direction they stay 9 - 2 apart.
TEST(BoxGapOfMovingBodies, IsAboutTheirMotionAgainstEachOther) {
  const Twist ahead{{1, 0, 0}, {0, 0, 0}}, back{{-1, 0, 0}, {0, 0, 0}};
  TwoMoving towards(at(0, 0, 0), ahead, at(9, 0, 0), back, Box{{2, 2, 2}}, Box{{2, 2, 2}});
  EXPECT_NEAR(towards.bodies.boxGap(towards.a, towards.b, Interval(1), towards.poses), 5.0, 1e-11);
  TwoMoving together(at(0, 0, 0), ahead, at(9, 0, 0), ahead, Box{{2, 2, 2}}, Box{{2, 2, 2}});
  EXPECT_NEAR(together.bodies.boxGap(together.a, together.b, Interval(1), together.poses), 7.0, 1e-11);
}

// One of these two cubes, b, turns in its place. In the middle of the motion one of its edges points at a. All of its
// points are within sqrt(3) of the axis, so their speed is at most sqrt(3) times the turning, and their velocities
// turn with it.
TEST(BoxGapOfMovingBodies, TurnsTheBoxes) {
  const double turning = 0.1;
  TwoMoving boxes(at(0, 0, 0), {}, turned(M_PI / 4 - turning / 2, Vector3d::UnitZ(), {6, 0, 0}),
                  {{0, 0, 0}, {0, 0, turning}}, Box{{2, 2, 2}}, Box{{2, 2, 2}});
  const double way = 0.5 * turning * std::sqrt(3.0) * (1.0 + 0.5 * turning);
  EXPECT_NEAR(boxes.bodies.boxGap(boxes.a, boxes.b, Interval(1), boxes.poses), 5.0 - std::sqrt(2.0) - way, 1e-11);
}

// --- chains

// Links "0" to "4" on a row of joints about z, y, z, y, each 1 before the other.
RobotModel rowOfJoints() {
  std::string parts;
  for (int i = 0; i < 5; ++i) parts += link(std::to_string(i), box("0.6 0.2 0.3", "0.4 0 0"));
  for (int i = 0; i < 4; ++i)
    parts += hinge(std::to_string(i), std::to_string(i), std::to_string(i + 1), i % 2 ? "0 1 0" : "0 0 1", "1 0 0");
  return robotOf(urdfOf(parts));
}

struct Row {
  explicit Row(const std::vector<double>& travel, const std::string& link_a = "0", const std::string& link_b = "4")
      : a(bodyOf(robot, link_a)),
        b(bodyOf(robot, link_b)),
        motion(
            RobotMotion::ofTravel(robot, forwardKinematics(robot, std::vector<double>{0.3, -0.4, 0.5, 0.6}), travel)) {}

  const Piece& pieceOf(int body) const { return robot.pieces[robot.bodies[body].pieces[0]]; }

  /// The pose of b in the frame of a.
  Isometry3d relative(double time) const {
    const BodyPoses all = motion.at(time);
    return all[a]->inverse() * *all[b];
  }
  double distance(double time) const {
    const Piece &of_a = pieceOf(a), &of_b = pieceOf(b);
    return signedDistance(of_a.shape, of_b.shape, of_a.body_T_piece.inverse() * relative(time) * of_b.body_T_piece)
        .distance;
  }

  const RobotModel robot = rowOfJoints();
  const int a, b;
  const RobotMotion motion;
  const Bounds bounds_a = boundsOf(pieceOf(a)), bounds_b = boundsOf(pieceOf(b));
  PosesInTime poses{motion};
  MovingBodies bodies{poses, a, bounds_a, b, bounds_b};
};

TEST(MiddleOfMovingBodies, HasAsManyMovingJointsOnEitherSide) {
  const Row all({1, 1, 1, 1}), last({0, 0, 1, 1}), back({1, 1, 1, 1}, "4", "0");
  EXPECT_EQ(all.bodies.middle(), bodyOf(all.robot, "2"));
  EXPECT_EQ(last.bodies.middle(), bodyOf(last.robot, "3"));
  EXPECT_EQ(back.bodies.middle(), bodyOf(back.robot, "2"));
}

TEST(MiddleOfMovingBodies, OfTwoThatMoveOnTheirOwnIsTheFrameOfThePoses) {
  TwoMoving balls(at(0, 0, 0), {{1, 0, 0}, {0, 0, 0}}, at(4, 3, 0), {{0, 1, 0}, {0, 0, 0}}, Sphere{1}, Sphere{1});
  EXPECT_EQ(balls.bodies.middle(), -1);
}

// The box of link 0 is 0.6 from the axis of joint 0, that of link 1 0.4, and that of link 4 farther than both.
TEST(MiddleOfMovingBodies, OfOneJointIsWhereItsTurnMovesTheOtherLess) {
  const Row down({1, 0, 0, 0}, "0", "1"), up({1, 0, 0, 0}, "1", "0"), far({1, 0, 0, 0}, "0", "4");
  EXPECT_EQ(down.bodies.middle(), bodyOf(down.robot, "0"));
  EXPECT_EQ(up.bodies.middle(), bodyOf(up.robot, "0"));
  EXPECT_EQ(far.bodies.middle(), bodyOf(far.robot, "4"));
}

TEST(ChainsOfMovingBodies, MoveThemAgainstEachOtherAsTheRobotDoes) {
  const Isometry3d a_T_frame = turned(0.3, {1, 0, 1}, {1, 2, 3}), b_T_frame = turned(0.7, {0, 1, 1}, {3, 2, 1});
  const std::vector<std::vector<double>> travels{{1, 2, -1, 0.5}, {0, 2, 0, 0.5}, {1, 0, 0, 0}, {0, 0, 0, 0}};
  for (const auto& travel : travels) {
    for (const auto& [link_a, link_b] : {std::make_pair("0", "4"), {"4", "1"}, {"2", "3"}}) {
      const Row row(travel, link_a, link_b);
      for (const double time : {0.0, 0.4, 1.0}) {
        const Isometry3d a = poseAt(row.bodies.chainOfA(), time) * a_T_frame,
                         b = poseAt(row.bodies.chainOfB(), time) * b_T_frame;
        const Isometry3d expected = a_T_frame.inverse() * row.relative(time) * b_T_frame;
        EXPECT_LE(((a.inverse() * b).matrix() - expected.matrix()).norm(), 1e-12);
      }
    }
  }
}

TEST(ChainsOfMovingBodies, LeaveOutJointsThatRest) {
  const Row row({0, 1, 0, 1});
  EXPECT_EQ(row.bodies.chainOfA().size() + row.bodies.chainOfB().size(), 2u);
}

// --- unknown poses

TEST(MovingBodies, AreUnknownWhereABodyOrOneThatCarriesItHasNoPose) {
  const RobotModel robot = rowOfJoints();
  const auto isKnown = [&](const std::string& missing, const std::string& link_a, const std::string& link_b) {
    BodyPoses start = forwardKinematics(robot, std::vector<double>(4));
    start[bodyOf(robot, missing)].reset();
    const RobotMotion motion = RobotMotion::ofTravel(robot, start, {1, 1, 1, 1});
    return MovingBodies(PosesInTime(motion), bodyOf(robot, link_a), Bounds(), bodyOf(robot, link_b), Bounds())
        .isKnown();
  };
  EXPECT_TRUE(Row({1, 1, 1, 1}).bodies.isKnown());
  EXPECT_FALSE(isKnown("2", "2", "0"));
  EXPECT_FALSE(isKnown("2", "0", "2"));
  EXPECT_FALSE(isKnown("2", "0", "4"));
  EXPECT_TRUE(isKnown("2", "0", "1"));
}

// --- laws

TEST(BoundsOfMovingBodies, AreNeverAboveTheDistanceDuringTheInterval) {
  Chance chance(71);
  int positive = 0;
  for (int i = 0; i < 60; ++i) {
    Row row({chance.between(-2, 2), chance.between(-2, 2), chance.between(-2, 2), chance.between(-2, 2)}, "0", "4");
    for (const int number : {1, 2, 3, 5, 10, 100}) {
      const Interval interval(number);
      const double begin = interval.begin, end = interval.end;
      double smallest = row.distance(end);
      for (int k = 0; k < 20; ++k) smallest = std::min(smallest, row.distance(begin + k / 20.0 * (end - begin)));
      const double sphere = row.bodies.sphereGap(row.bounds_a, row.bounds_b, interval, row.poses).gap;
      const double boxes = row.bodies.boxGap(row.bounds_a, row.bounds_b, interval, row.poses);
      EXPECT_LE(sphere, smallest + 1e-9);
      EXPECT_LE(boxes, smallest + 1e-9);
      positive += sphere > 0.0 || boxes > 0.0;
    }
  }
  EXPECT_GT(positive, 100);
}

// In 2^-20 of the motion no point moves by more than 1e-4, and the spheres' gap is that of one time.
TEST(BoundsOfMovingBodies, OfAShortIntervalAreNearlyThoseOfOneTime) {
  Row row({2, 1, -1, 2});
  const Interval interval((1 << 20) + 12345);
  const Isometry3d a_T_b = row.relative(interval.begin);
  const Vector3d between = a_T_b * row.bounds_b.centre - row.bounds_a.centre;
  const double spheres = between.norm() - row.bounds_a.radius - row.bounds_b.radius;
  EXPECT_NEAR(row.bodies.sphereGap(row.bounds_a, row.bounds_b, interval, row.poses).gap, spheres, 1e-4);
  const double boxes =
      boxGap(between, row.bounds_a, row.bounds_a.axes, row.bounds_b, a_T_b.linear() * row.bounds_b.axes);
  EXPECT_NEAR(row.bodies.boxGap(row.bounds_a, row.bounds_b, interval, row.poses), boxes, 1e-4);
}

// The bounds of a part of a body, within those of the whole.
TEST(BoundsOfMovingBodies, HoldForPartsOfTheBodies) {
  Bounds all_of_b = boundsOfShape(Sphere{3.0}), part_of_b = boundsOfShape(Sphere{0.5});
  part_of_b.centre = {2, 0, 0};
  const Bounds a = boundsOfShape(Sphere{1.0});
  const RobotMotion motion = RobotMotion::ofTwists({at(0, 0, 0), at(10, 0, 0)}, {{}, {{0, 4, 0}, {0, 0, 0}}});
  PosesInTime poses(motion);
  MovingBodies bodies(poses, 0, a, 1, all_of_b);
  EXPECT_NEAR(bodies.sphereGap(a, part_of_b, Interval(1), poses).gap, 12.0 - 1.5, 1e-11);
}

}  // namespace proximity_server::scene::moving_bodies_test
