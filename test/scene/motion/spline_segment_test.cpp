#include "proximity_server/scene/motion/joint_spline.h"

#include "chance.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace proximity_server::scene::spline_segment_test {

constexpr double kPi = 3.14159265358979323846;

/// One joint of a type, with limits.
RobotModel oneJoint(const std::string& type, const std::string& limits_of_joint = "") {
  return robotOf(urdfOf(link("a") + link("b") + joint("elbow", type, "a", "b", axis("0 0 1") + limits_of_joint)));
}
const RobotModel& free() {
  static const RobotModel robot = oneJoint("continuous");
  return robot;
}

struct State {
  double position, velocity, acceleration;
};

TrajectoryPoint pointAt(double time, const State& state) {
  return {time, {state.position}, {state.velocity}, {state.acceleration}};
}

State randomState(Chance& chance) {
  return {chance.between(-3.0, 3.0), chance.between(-2.0, 2.0), chance.between(-5.0, 5.0)};
}

/// A polynomial in powers of the time from the begin, as textbooks have it (Biagiotti and Melchiorri, Trajectory
/// Planning for Automatic Machines and Robots, 2008, section 2.1).
struct Powers {
  long double c0, c1, c2, c3 = 0.0L, c4 = 0.0L, c5 = 0.0L;
  double at(long double t) const {
    return static_cast<double>(c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))));
  }
};

Powers cubicOf(const State& from, const State& to, long double t) {
  const long double way = static_cast<long double>(to.position) - from.position, v0 = from.velocity, v1 = to.velocity;
  return {from.position, v0, (3.0L * way - (2.0L * v0 + v1) * t) / (t * t),
          (-2.0L * way + (v0 + v1) * t) / (t * t * t)};
}

Powers quinticOf(const State& from, const State& to, long double t) {
  const long double way = static_cast<long double>(to.position) - from.position, v0 = from.velocity, v1 = to.velocity;
  const long double a0 = from.acceleration, a1 = to.acceleration, t2 = t * t, t3 = t2 * t;
  return {from.position,
          v0,
          0.5L * a0,
          (20.0L * way - (8.0L * v1 + 12.0L * v0) * t - (3.0L * a0 - a1) * t2) / (2.0L * t3),
          (-30.0L * way + (14.0L * v1 + 16.0L * v0) * t + (3.0L * a0 - 2.0L * a1) * t2) / (2.0L * t3 * t),
          (12.0L * way - 6.0L * (v1 + v0) * t + (a1 - a0) * t2) / (2.0L * t3 * t2)};
}

TEST(SplineSegment, IsThePolynomialOfWhatBothPointsHave) {
  Chance chance(1);
  for (int i = 0; i < 1000; ++i) {
    const State from = randomState(chance), to = randomState(chance);
    const double begin = chance.between(0.0, 5.0), duration = chance.between(0.1, 2.0);
    TrajectoryPoint first = pointAt(begin, from), last = pointAt(begin + duration, to);
    const double exact_duration = last.time - first.time;
    const SplineSegment quintic(free(), first, last);
    first.accelerations.clear();
    const SplineSegment cubic(free(), first, last);
    last.velocities.clear();
    const SplineSegment linear(free(), first, last);
    const Powers five = quinticOf(from, to, exact_duration), three = cubicOf(from, to, exact_duration);
    for (const double time : {0.0, 0.1, 0.37, 0.5, 0.81, 1.0}) {
      EXPECT_NEAR(quintic.at(time)[0], five.at(time * exact_duration), 1e-13);
      EXPECT_NEAR(cubic.at(time)[0], three.at(time * exact_duration), 1e-13);
      EXPECT_NEAR(linear.at(time)[0], from.position + time * (to.position - from.position), 1e-13);
    }
  }
}

TEST(SplineSegment, TellsItsStateInSeconds) {
  Chance chance(5);
  for (int i = 0; i < 1000; ++i) {
    const State from = randomState(chance), to = randomState(chance);
    const double begin = chance.between(0.0, 5.0);
    const TrajectoryPoint first = pointAt(begin, from), last = pointAt(begin + chance.between(0.1, 2.0), to);
    const long double duration = static_cast<long double>(last.time) - first.time;
    const Powers p = quinticOf(from, to, duration);
    for (const double time : {0.0, 0.37, 1.0}) {
      const TrajectoryPoint state = SplineSegment(free(), first, last).stateAt(time);
      const long double t = time * duration;
      const long double velocity = p.c1 + t * (2 * p.c2 + t * (3 * p.c3 + t * (4 * p.c4 + t * 5 * p.c5)));
      const long double acceleration = 2 * p.c2 + t * (6 * p.c3 + t * (12 * p.c4 + t * 20 * p.c5));
      EXPECT_NEAR(state.time, static_cast<double>(first.time + t), 1e-14);
      EXPECT_NEAR(state.positions[0], p.at(t), 1e-13);
      EXPECT_NEAR(state.velocities[0], static_cast<double>(velocity), 1e-12);
      EXPECT_NEAR(state.accelerations[0], static_cast<double>(acceleration), 1e-10);
    }
  }
}

TEST(SplineSegment, IsMadeAnewJointByJoint) {
  const RobotModel robot =
      robotOf(urdfOf(link("a") + link("b") + link("c") + link("d") + hinge("first", "a", "b", "0 0 1") +
                     hinge("second", "b", "c", "0 0 1") + hinge("third", "c", "d", "0 0 1")));
  const SplineSegment other(robot, {0.0, {5.0, 6.0, 0.0}, {0.0, 0.0, 0.0}}, {2.0, {5.0, 7.0, 0.0}, {0.0, 0.0, 0.0}});
  SplineSegment segment;
  segment.rest(3.0, 4.0, {1.0, 2.0, 3.0});
  segment.goStraight(0, 1.0, 2.0);
  segment.copy(1, other, 0.25, 1.0);
  EXPECT_EQ(segment.timeAt(0.5), 3.5);
  EXPECT_EQ(segment.at(0.0), (Positions{1.0, other.positionAt(1, 0.25), 3.0}));
  EXPECT_EQ(segment.at(0.5), (Positions{1.5, segment.positionAt(1, 0.5), 3.0}));
  EXPECT_NEAR(segment.positionAt(1, 0.5), other.positionAt(1, 0.625), 1e-15);
  EXPECT_EQ(segment.at(1.0), (Positions{2.0, 7.0, 3.0}));
}

SplineSegment::Chord chordOf(const SplineSegment& segment, double begin, double end) {
  SplineSegment::Chord chord;
  segment.chord(begin, end, chord);
  return chord;
}

TEST(SplineSegment, StaysWithinTheDeviationOfItsChord) {
  Chance chance(2);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const SplineSegment segment(free(), pointAt(0.0, randomState(chance)), pointAt(1.0, randomState(chance)));
    const double begin = chance.between(0.0, 0.9), end = chance.between(begin + 0.01, 1.0);
    const SplineSegment::Chord chord = chordOf(segment, begin, end);
    double largest = 0.0;
    for (int k = 0; k <= 100; ++k) {
      const double part = 0.01 * k;
      const double position = segment.at(begin + part * (end - begin))[0];
      largest = std::max(largest, std::abs(position - chord.from[0] - part * (chord.to[0] - chord.from[0])));
    }
    EXPECT_LE(largest, chord.deviation[0]);
    worst = std::max(worst, largest / chord.deviation[0]);
  }
  EXPECT_GT(worst, 0.8);  // the bound is not much too large
}

TEST(SplineSegment, HalvesLeaveTheirChordsByAQuarter) {
  const SplineSegment segment(free(), pointAt(0.0, {0.0, 1.0, 0.0}), pointAt(1.0, {1.0, -1.0, 3.0}));
  double before = chordOf(segment, 0.0, 0.25).deviation[0];
  for (double length = 0.125; length > 1e-3; length *= 0.5) {
    const double now = chordOf(segment, 0.0, length).deviation[0];
    EXPECT_LT(now, 0.5 * before);
    before = now;
  }
}

TEST(SplineSegment, PartIsTheSameMotion) {
  const SplineSegment whole(free(), pointAt(2.0, {0.0, 1.0, 0.0}), pointAt(4.0, {1.0, -1.0, 3.0}));
  const SplineSegment part = whole.between(0.25, 0.75);
  EXPECT_EQ(part.begin(), 2.5);
  EXPECT_EQ(part.end(), 3.5);
  for (const double time : {0.0, 0.3, 1.0}) EXPECT_NEAR(part.at(time)[0], whole.at(0.25 + 0.5 * time)[0], 1e-15);
}

// u (1 - u) in a second: it rises to 1/4 between two points at 0.
TEST(SplineSegment, NamesTheJointThatOvershootsItsLimit) {
  const TrajectoryPoint from{1.0, {0.0}, {1.0}}, to{2.0, {0.0}, {-1.0}};
  const RobotModel robot = oneJoint("revolute", limits("-1", "0.2"));
  const auto beyond = SplineSegment(robot, from, to).beyondLimits(robot);
  ASSERT_EQ(beyond.size(), 1U);
  EXPECT_EQ(beyond[0].joint, 0);
  EXPECT_NEAR(beyond[0].time, 0.5, 1e-4);
  EXPECT_NEAR(beyond[0].position, 0.25, 1e-9);
  EXPECT_EQ(beyond[0].limit, 0.2);
  const RobotModel wider = oneJoint("revolute", limits("-1", "0.2500001"));
  EXPECT_TRUE(SplineSegment(wider, from, to).beyondLimits(wider).empty());
  const TrajectoryPoint down{1.0, {0.0}, {-1.0}}, up{2.0, {0.0}, {1.0}};
  const RobotModel above = oneJoint("revolute", limits("-0.2", "1"));
  const auto below = SplineSegment(above, down, up).beyondLimits(above);
  ASSERT_EQ(below.size(), 1U);
  EXPECT_NEAR(below[0].position, -0.25, 1e-9);
  EXPECT_EQ(below[0].limit, -0.2);
}

TEST(DrivenFrom, ContinuousJointGoesTheShorterWayAndKeepsItsTurns) {
  const auto driven = drivenFrom(free(), {9.0, {4.0 * kPi + 0.1}}, {{1.0, {-0.1}}, {2.0, {-0.1 - 3.0 * kPi}}});
  ASSERT_EQ(driven.size(), 3U);
  EXPECT_EQ(driven[0].time, 0.0);
  EXPECT_NEAR(driven[1].positions[0], 4.0 * kPi - 0.1, 1e-14);
  EXPECT_NEAR(driven[2].positions[0], kPi - 0.1, 1e-14);  // between points nothing is wrapped
  const RobotModel revolute = oneJoint("revolute", limits("-20", "20"));
  EXPECT_EQ(drivenFrom(revolute, {0.0, {4.0 * kPi}}, {{1.0, {0.0}}})[1].positions[0], 0.0);
}

TEST(DrivenFrom, DropsPointsThatAreNotLaterThanTheStart) {
  const auto driven = drivenFrom(free(), {0.0, {0.5}}, {{0.0, {0.0}}, {1.0, {0.25}}});
  ASSERT_EQ(driven.size(), 2U);
  EXPECT_EQ(driven[0].positions[0], 0.5);
  EXPECT_EQ(driven[1].positions[0], 0.25);
  EXPECT_EQ(errorOf([] {
              drivenFrom(free(), {0.0, {0.5}}, {{0.0, {0.0}}});
            }),
            "no point of the trajectory is later than its start");
}

TEST(SplineSegment, NamesWhatIsWrong) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const TrajectoryPoint& from, const TrajectoryPoint& to) {
    return errorOf([&] { SplineSegment(free(), from, to); });
  };
  const TrajectoryPoint start{1.0, {0.0}};
  EXPECT_EQ(error(start, {1.0, {1.0}}), "the point at 1.000000 s is not later than the point at 1.000000 s");
  EXPECT_EQ(error(start, {kNan, {1.0}}), "the time of a point is not finite");
  EXPECT_EQ(error(start, {2.0, {1.0, 2.0}}), "the point at 2.000000 s has 2 positions for 1 joints");
  EXPECT_EQ(error(start, {2.0, {1.0}, {0.0, 0.0}}), "the point at 2.000000 s has 2 velocities for 1 joints");
  EXPECT_EQ(error(start, {2.0, {1.0}, {0.0}, {kNan}}),
            "the point at 2.000000 s: joint 'elbow': one of the accelerations is not finite");
  EXPECT_EQ(error({1.0, {-1e308}}, {2.0, {1e308}}),
            "the point at 2.000000 s: joint 'elbow' is too fast or too far away");
}

TEST(SplineSegment, TellsTheInequalitiesThatItBreaksWhereTheyAreBrokenMost) {
  RobotModel robot = robotOf(urdfOf(link("base") + link("a") + link("b") + slider("p", "base", "a", "1 0 0") +
                                    slider("q", "base", "b", "1 0 0")));
  setJointInequalities(readYaml("- 2*p - q <= 1\n- p + q <= 9\n- q - p <= 0", ""), "", robot);
  // p is 3 t^2 - 2 t^3, from 0 to 1 at rest, and q is 4 (t - t^2): 2 p - q is 10 t^2 - 4 t^3 - 4 t.
  const SplineSegment segment(robot, {0.0, {0.0, 0.0}, {0.0, 4.0}, {}}, {1.0, {1.0, 0.0}, {0.0, -4.0}, {}});
  const auto broken = segment.brokenInequalities(robot);
  ASSERT_EQ(broken.size(), 2u);
  EXPECT_EQ(broken[0].inequality->text, "2*p - q <= 1");
  EXPECT_NEAR(broken[0].time, 1.0, 1e-4);
  EXPECT_NEAR(broken[0].excess, 1.0, 1e-8);
  // q - p is 4 t - 7 t^2 + 2 t^3, highest where 4 - 14 t + 6 t^2 = 0
  const double t = (14.0 - std::sqrt(100.0)) / 12.0;
  EXPECT_EQ(broken[1].inequality->text, "q - p <= 0");
  EXPECT_NEAR(broken[1].time, t, 1e-4);
  EXPECT_NEAR(broken[1].excess, 4.0 * t - 7.0 * t * t + 2.0 * t * t * t, 1e-8);
}

TEST(SplineSegment, TakesPositionsOfRestingJointsForInequalities) {
  RobotModel robot = robotOf(urdfOf(link("base") + link("a") + link("b") + slider("p", "base", "a", "1 0 0") +
                                    slider("q", "base", "b", "1 0 0")));
  setJointInequalities(readYaml("- p + q <= 1", ""), "", robot);
  const SplineSegment segment(robot, {0.0, {0.0, 0.0}}, {1.0, {1.0, 0.0}});
  EXPECT_TRUE(segment.brokenInequalities(robot).empty());
  const auto broken = segment.brokenInequalities(robot, {std::nullopt, 0.5});
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_NEAR(broken[0].excess, 0.5, 1e-12);
  EXPECT_TRUE(segment.brokenInequalities(robot, {std::nullopt, std::nan("")}).empty());
}

TEST(SplineSegment, IsNowhereFasterThanItsLargestSpeed) {
  Chance chance(3);
  for (int i = 0; i < 200; ++i) {
    const double begin = chance.between(-1.0, 1.0), duration = chance.between(0.1, 3.0);
    const SplineSegment segment(free(), pointAt(begin, randomState(chance)),
                                pointAt(begin + duration, randomState(chance)));
    double fastest = 0.0;
    for (double time = 0.0; time <= 1.0; time += 0.01) {
      const TrajectoryPoint state = segment.stateAt(time);
      EXPECT_EQ(segment.positionAt(0, time), segment.at(time)[0]);
      fastest = std::max(fastest, std::abs(state.velocities[0]));
    }
    EXPECT_LE(fastest, segment.largestSpeed(0));
    EXPECT_LE(segment.largestSpeed(0), 10.0 * fastest) << i;
  }
  const SplineSegment line(free(), {0.0, {0.0}}, {2.0, {3.0}});
  EXPECT_NEAR(line.largestSpeed(0), 1.5, 1e-15);
}

}  // namespace proximity_server::scene::spline_segment_test
