#include "proximity_server/scene/motion/limited_motion.h"

#include "chance.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <string>

namespace proximity_server::scene::limited_motion_test {

using namespace narrowphase;

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;
constexpr double kTolerance = 1e-6;  // [m] of the searches
constexpr double kRounding = 1e-12;
using Stated = std::vector<std::optional<double>>;

std::string limits(double lower, double upper) { return robots::limits(std::to_string(lower), std::to_string(upper)); }

/// Two cubes of edge 1 on the x axis, about (left, 0, 0) and (4 + right, 0, 0): the gap is 3 + right - left.
std::string carts(const std::string& left_limits, const std::string& right_limits) {
  return urdfOf(link("rail") + link("l", box("1 1 1")) + link("r", box("1 1 1")) +
                joint("left", "prismatic", "rail", "l", axis("1 0 0") + left_limits) +
                joint("right", "prismatic", "rail", "r", origin("4 0 0") + axis("1 0 0") + right_limits));
}

/// One joint about or along z, with a link at the tip of an arm of 1 m.
std::string oneJoint(const std::string& type, const std::string& limit) {
  return urdfOf(link("a") + link("b") + joint("j", type, "a", "b", origin("1 0 0") + axis("0 0 1") + limit));
}

std::size_t jointOf(const RobotModel& robot, const std::string& name) {
  const auto named = [&](const Joint& joint) { return joint.name == name; };
  return static_cast<std::size_t>(std::find_if(robot.joints.begin(), robot.joints.end(), named) - robot.joints.begin());
}

/// The position of a joint at a time of the motion.
struct Positions {
  const RobotModel& robot;
  const LimitedMotion& limited;

  double of(const std::string& name, double time) const {
    const std::size_t joint = jointOf(robot, name);
    const BodyPoses poses = limited.motion.at(time);
    const auto carried = [&](const Body& body) { return body.joint == static_cast<int>(joint); };
    const auto body = std::find_if(robot.bodies.begin(), robot.bodies.end(), carried);
    const auto& pose = poses[body - robot.bodies.begin()];
    return jointPosition(robot, robot.joints[joint], poses[body->parent]->inverse() * *pose);
  }
};

/// The stop time of the joint of oneJoint() from a position on; infinity: it does not stop.
double stopOf(const std::string& urdf, double position, double travel, const Stated& stated = {}) {
  const RobotModel robot = robotOf(urdf);
  const LimitedMotion limited =
      motionWithinLimits(robot, forwardKinematics(robot, std::vector<double>{position}), {travel}, stated);
  EXPECT_LE(limited.motion.pieces().size(), 2u);
  return limited.stops.empty() ? std::numeric_limits<double>::infinity() : limited.stops.front().time;
}

TEST(MotionWithinLimits, StopsAJointAtItsLimit) {
  const RobotModel robot = robotOf(carts(limits(-1, 1), limits(-5, 5)));
  const BodyPoses start = forwardKinematics(robot, byJoint(robot, {{"left", 0.5}}));
  const LimitedMotion limited = motionWithinLimits(robot, start, byJoint(robot, {{"left", 2.0}}));
  ASSERT_EQ(limited.stops.size(), 1u);
  EXPECT_EQ(limited.stops[0].joint, static_cast<int>(jointOf(robot, "left")));
  EXPECT_NEAR(limited.stops[0].time, 0.25, kRounding);  // 0.5 m of 2
  const Positions position{robot, limited};
  EXPECT_NEAR(position.of("left", 0.1), 0.7, kRounding);
  EXPECT_NEAR(position.of("left", 0.25), 1.0, kRounding);
  EXPECT_NEAR(position.of("left", 1.0), 1.0, kRounding);
}

std::optional<InequalityBreak> breakOf(const std::string& inequalities, const std::map<std::string, double>& start,
                                       const std::map<std::string, double>& travel) {
  RobotModel robot = robotOf(carts(limits(-1, 1), limits(-5, 5)));
  setJointInequalities(readYaml(inequalities, ""), "", robot);
  return motionWithinLimits(robot, forwardKinematics(robot, byJoint(robot, start)), byJoint(robot, travel)).broken;
}

TEST(MotionWithinLimits, TellsTheFirstInequalityThatItBreaks) {
  const char* const both = "- right <= 3\n- left - right <= 2";
  const auto second = breakOf(both, {}, {{"left", 0.5}, {"right", -2.0}});  // 2.5 by time
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->inequality, 1);
  EXPECT_NEAR(second->time, 0.8, kRounding);
  const auto first = breakOf(both, {}, {{"left", 0.9}, {"right", 4.0}});
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->inequality, 0);
  EXPECT_NEAR(first->time, 0.75, kRounding);
  EXPECT_FALSE(breakOf(both, {}, {{"left", 0.4}, {"right", -1.5}}));
}

TEST(MotionWithinLimits, BreaksAnInequalityLaterWhereAJointStops) {
  const auto broken = breakOf("- left - right <= 2", {}, {{"left", 4.0}, {"right", -2.0}});  // left stops at 0.25
  ASSERT_TRUE(broken.has_value());
  EXPECT_NEAR(broken->time, 0.5, kRounding);  // 1 + 0.5 there, and then 2 by time
  const auto returning = breakOf("- left - right <= 2", {}, {{"left", 4.0}, {"right", 2.0}});
  EXPECT_FALSE(returning);
}

TEST(MotionWithinLimits, BreaksAnInequalityThatIsBrokenOnlyIfItGoesFarther) {
  EXPECT_FALSE(breakOf("- left - right <= 2", {{"right", -3.0}}, {{"left", -0.5}}));
  const auto farther = breakOf("- left - right <= 2", {{"right", -3.0}}, {{"left", 0.5}});
  ASSERT_TRUE(farther.has_value());
  EXPECT_NEAR(farther->time, 4e-6, kRounding);  // two tolerances of 1e-6
}

TEST(MotionWithinLimits, IsOneMotionWhereNoJointReachesItsLimit) {
  const RobotModel robot = robotOf(carts(limits(-1, 1), limits(-5, 5)));
  const BodyPoses start = forwardKinematics(robot, byJoint(robot, {}));
  const LimitedMotion limited = motionWithinLimits(robot, start, byJoint(robot, {{"left", 0.9}, {"right", -4.9}}));
  EXPECT_TRUE(limited.stops.empty());
  EXPECT_EQ(limited.motion.pieces().size(), 1u);
}

TEST(MotionWithinLimits, GoesOnWithTheOthersWhenOneStops) {
  const RobotModel robot = robotOf(carts(limits(-1, 1), limits(-1.5, 5)));
  const BodyPoses start = forwardKinematics(robot, byJoint(robot, {}));
  const LimitedMotion limited = motionWithinLimits(robot, start, byJoint(robot, {{"left", 4.0}, {"right", -4.0}}));
  ASSERT_EQ(limited.stops.size(), 2u);
  EXPECT_EQ(limited.stops[0].joint, static_cast<int>(jointOf(robot, "left")));
  EXPECT_NEAR(limited.stops[0].time, 0.25, kRounding);
  EXPECT_EQ(limited.stops[1].joint, static_cast<int>(jointOf(robot, "right")));
  EXPECT_NEAR(limited.stops[1].time, 0.375, kRounding);
  EXPECT_EQ(limited.motion.pieces().size(), 3u);
  const Positions position{robot, limited};
  EXPECT_NEAR(position.of("left", 0.3), 1.0, kRounding);
  EXPECT_NEAR(position.of("right", 0.3), -1.2, kRounding);
  EXPECT_NEAR(position.of("right", 1.0), -1.5, kRounding);
}

TEST(MotionWithinLimits, LeavesAJointBeyondItsLimitThereUnlessItMovesBackIn) {
  const RobotModel robot = robotOf(carts(limits(-1, 1), limits(-5, 5)));
  const BodyPoses start = forwardKinematics(robot, byJoint(robot, {{"left", 1.001}}));
  const LimitedMotion outwards = motionWithinLimits(robot, start, byJoint(robot, {{"left", 2.0}}));
  ASSERT_EQ(outwards.stops.size(), 1u);
  EXPECT_EQ(outwards.stops[0].time, 0.0);
  EXPECT_EQ(outwards.motion.pieces().size(), 1u);
  EXPECT_NEAR((Positions{robot, outwards}.of("left", 1.0)), 1.001, kRounding);
  const LimitedMotion inwards = motionWithinLimits(robot, start, byJoint(robot, {{"left", -1.0}}));
  EXPECT_TRUE(inwards.stops.empty());
  EXPECT_NEAR((Positions{robot, inwards}.of("left", 1.0)), 0.001, kRounding);
}

TEST(MotionWithinLimits, NeverStopsAJointWithoutLimits) {
  EXPECT_TRUE(std::isinf(stopOf(oneJoint("continuous", ""), 0.0, 100.0)));
  EXPECT_TRUE(std::isinf(stopOf(oneJoint("prismatic", limits(1, -1)), 0.0, 100.0)));  // reversed: taken as none
  EXPECT_TRUE(std::isinf(stopOf(oneJoint("prismatic", limits(-1, 1)), 0.5, 0.0)));    // at rest
}

TEST(MotionWithinLimits, StopsARevoluteJointOnEitherSide) {
  EXPECT_NEAR(stopOf(oneJoint("revolute", limits(-1, 2)), 0.5, 3.0), 0.5, kRounding);
  EXPECT_NEAR(stopOf(oneJoint("revolute", limits(-1, 2)), 0.5, -3.0), 0.5, kRounding);
  EXPECT_EQ(stopOf(oneJoint("revolute", limits(-1, 1)), 1.3, 3.0), 0.0);
  EXPECT_EQ(stopOf(oneJoint("revolute", limits(-1, 1)), -1.3, -3.0), 0.0);
  EXPECT_NEAR(stopOf(oneJoint("revolute", limits(2, 4)), 3.5, 1.0), 0.5, kRounding);  // beyond half a turn
}

// A joint with limits more than a turn apart: the pose of 6 is that of 6 - 2 pi.
TEST(MotionWithinLimits, StopsAsLateAsTheLimitsAllowWhereAPoseLeavesTheTurnOpen) {
  const std::string joint = oneJoint("revolute", limits(-6.25, 6.25));
  EXPECT_NEAR(stopOf(joint, 6.0, 10.0), (0.25 + 2.0 * kPi) / 10.0, kRounding);
  EXPECT_NEAR(stopOf(joint, -6.0, -10.0), (0.25 + 2.0 * kPi) / 10.0, kRounding);
}

TEST(MotionWithinLimits, TakesTheTurnFromAStatedPosition) {
  const std::string joint = oneJoint("revolute", limits(-6.25, 6.25));
  EXPECT_NEAR(stopOf(joint, 6.0, 10.0, {6.01}), 0.025, kRounding);
  EXPECT_NEAR(stopOf(joint, -6.0, -10.0, {-5.99}), 0.025, kRounding);
  EXPECT_NEAR(stopOf(joint, 6.0, 10.0, {-0.3}), 0.025 + 0.2 * kPi, kRounding);
}

// Regression: of a joint stated more than 0.05 rad beyond a limit, which moves back in, the pose a turn away was taken,
// whose other limit is near: it stopped there, and what it would meet on its way was missed.
TEST(MotionWithinLimits, TakesAStatedPositionBeyondALimitForTheTurn) {
  const std::string joint = oneJoint("revolute", limits(-3.2, 3.2));
  for (const double beyond : {0.04, 0.06, 1.0, 3.1}) {
    EXPECT_TRUE(std::isinf(stopOf(joint, -3.2 - beyond, 4.0, {-3.2 - beyond}))) << beyond;
    EXPECT_NEAR(stopOf(joint, -3.2 - beyond, 10.0, {-3.2 - beyond}), (6.4 + beyond) / 10.0, kRounding) << beyond;
    EXPECT_EQ(stopOf(joint, -3.2 - beyond, -10.0, {-3.2 - beyond}), 0.0) << beyond;
    EXPECT_NEAR(stopOf(joint, 3.2 + beyond, -10.0, {3.2 + beyond}), (6.4 + beyond) / 10.0, kRounding) << beyond;
  }
}

TEST(MotionWithinLimits, RefusesAPositionThatDoesNotTellTheTurn) {
  const std::string joint = oneJoint("revolute", limits(-1, 2));
  EXPECT_EQ(stopOf(joint, 2.0 + 3.14, 1.0, {2.0 + 3.14}), 0.0);
  for (const double far : {1e9, 7.0, 2.0 + 3.15, -1.0 - 3.15}) {
    const std::string error = errorOf([&] { stopOf(joint, 0.5, 10.0, {far}); });
    EXPECT_NE(error.find("joint 'j' is stated to be at "), std::string::npos) << error;
    EXPECT_TRUE(std::isinf(stopOf(joint, 0.5, 0.0, {far}))) << "it rests";
    EXPECT_TRUE(std::isinf(stopOf(oneJoint("continuous", ""), 0.5, 10.0, {far})));
  }
}

// An encoder may tell a position beyond a limit, which is the pose of one at the other end.
TEST(MotionWithinLimits, DoesNotTakeALittleBeyondOneLimitForTheOtherOne) {
  const std::string joint = oneJoint("revolute", limits(-3.14, 3.14));
  EXPECT_GT(stopOf(joint, -3.15, 4.0), 1.0);
  EXPECT_GT(stopOf(joint, 3.15, -4.0), 1.0);
}

const std::string kFollowers =
    urdfOf(link("rail") + link("l") + link("f", ball("0.1")) +
           joint("lead", "prismatic", "rail", "l", axis("1 0 0") + limits(-1, 1)) +
           joint("follow", "prismatic", "rail", "f",
                 axis("0 1 0") + limits(-9, 9) + "<mimic joint='lead' multiplier='-2' offset='0.5'/>"));

TEST(MotionWithinLimits, StopsAFollowerWithItsLeader) {
  const RobotModel robot = robotOf(kFollowers);
  const BodyPoses start = forwardKinematics(robot, byJoint(robot, {{"lead", 0.5}}));
  const LimitedMotion limited = motionWithinLimits(robot, start, byJoint(robot, {{"lead", 2.0}}));
  ASSERT_EQ(limited.stops.size(), 1u);
  EXPECT_EQ(limited.stops[0].joint, static_cast<int>(jointOf(robot, "lead")));
  EXPECT_NEAR(limited.stops[0].time, 0.25, kRounding);
  EXPECT_NEAR((Positions{robot, limited}.of("follow", 1.0)), -1.5, kRounding);  // 0.5 - 2 * 1
}

TEST(MotionWithinLimits, ReadsALeaderOffItsFollowerWhereItsOwnPoseIsMissing) {
  const RobotModel robot = robotOf(kFollowers);
  BodyPoses start = forwardKinematics(robot, byJoint(robot, {{"lead", 0.5}}));
  start[robot.links[robot.findLink("l")].body].reset();
  const LimitedMotion limited = motionWithinLimits(robot, start, byJoint(robot, {{"lead", 2.0}}));
  ASSERT_EQ(limited.stops.size(), 1u);
  EXPECT_NEAR(limited.stops[0].time, 0.25, kRounding);
  EXPECT_NEAR((Positions{robot, limited}.of("follow", 1.0)), -1.5, kRounding);
}

/// A chain of joints, revolute about skew axes and prismatic by turns, with random limits; one in five follows the
/// first, and every link is fixed beside its joint.
std::string chain(int joints, Chance& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto triple = [&] {
    return std::to_string(unit(random)) + " " + std::to_string(unit(random)) + " " + std::to_string(unit(random));
  };
  std::string parts = link("m0");
  for (int i = 0; i < joints; ++i) {
    const std::string number = std::to_string(i), next = std::to_string(i + 1);
    const std::string xyz = triple(), rpy = triple(), direction = triple(), place = triple();
    const double lower = -1.0 - unit(random), upper = 1.0 + unit(random);
    const std::string following = i % 5 == 4 ? "<mimic joint='j0' multiplier='0.5' offset='0.1'/>" : "";
    parts += link("l" + next) + link("m" + next) + weld("f" + number, "l" + next, "m" + next, place) +
             joint("j" + number, i % 3 == 2 ? "prismatic" : "revolute", "m" + number, "l" + next,
                   origin(xyz, rpy) + axis(direction) + limits(lower, upper) + following);
  }
  return urdfOf(parts);
}

TEST(MotionWithinLimits, IsForwardKinematicsOfClampedPositionsAtAnyTime) {
  Chance random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int stops = 0;
  for (int i = 0; i < 50; ++i) {
    const RobotModel robot = robotOf(chain(12, random));
    std::vector<double> from, travel;
    for (const Joint& joint : robot.joints) {
      from.push_back(joint.lower + unit(random) * (joint.upper - joint.lower));
      travel.push_back(4.0 * (unit(random) - 0.5));
    }
    const LimitedMotion limited = motionWithinLimits(robot, forwardKinematics(robot, from), travel);
    stops += static_cast<int>(limited.stops.size());
    EXPECT_LE(limited.motion.pieces().size(), robot.joints.size() + 1);
    for (const double time : {0.0, unit(random), unit(random), unit(random), 1.0}) {
      std::vector<double> at;
      for (std::size_t j = 0; j < from.size(); ++j) {
        at.push_back(std::clamp(from[j] + time * travel[j], robot.joints[j].lower, robot.joints[j].upper));
      }
      const BodyPoses expected = forwardKinematics(robot, at), poses = limited.motion.at(time);
      for (std::size_t body = 0; body < poses.size(); ++body) {
        EXPECT_TRUE(poses[body]->isApprox(*expected[body], 1e-11)) << "body " << body << " at " << time;
      }
    }
  }
  EXPECT_GT(stops, 100);
  EXPECT_LT(stops, 400);
}

TEST(MotionWithinLimits, EndsWhereEveryJointIsWithinRoundingOfItsLimit) {
  Chance random(6);
  const RobotModel robot = robotOf(chain(40, random));
  std::vector<double> from, travel;
  for (const Joint& joint : robot.joints) {
    from.push_back(std::nextafter(joint.upper, joint.lower));
    travel.push_back(1e300);
  }
  const LimitedMotion limited = motionWithinLimits(robot, forwardKinematics(robot, from), travel);
  EXPECT_LE(limited.motion.pieces().size(), robot.joints.size() + 1);
  const BodyPoses expected = forwardKinematics(robot, from), poses = limited.motion.at(1.0);
  EXPECT_TRUE(poses.back()->isApprox(*expected.back(), 1e-9));
}

// From 6 rad, which is -0.28 rad as well, upwards: 0.25 rad or 6.53 rad are left, or 12.25 rad and 5.97 rad downwards.
TEST(MotionWithinLimits, NamesAJointThatWouldStopEarlierOnAnotherTurn) {
  const auto assumed = [](double position, double travel, const Stated& stated = {}, double limit = 6.25) {
    const RobotModel robot = robotOf(oneJoint("revolute", limits(-limit, limit)));
    return motionWithinLimits(robot, forwardKinematics(robot, std::vector<double>{position}), {travel}, stated).assumed;
  };
  const std::vector<int> named{0}, none;
  EXPECT_EQ(assumed(6.0, 1.0), named);
  EXPECT_EQ(assumed(6.0, 0.2), none) << "no turn stops it";
  EXPECT_EQ(assumed(6.0, 0.0), none);
  EXPECT_EQ(assumed(6.0, -6.5), named);
  EXPECT_EQ(assumed(6.0, -5.5), none);
  EXPECT_EQ(assumed(0.0, 9.0, {}, 3.0), none) << "the limits allow one turn";
  EXPECT_EQ(assumed(6.0, 1.0, {6.0}), none) << "it is stated";
}

TEST(MotionWithinLimits, RefusesTheWrongNumberOfStatedPositions) {
  const RobotModel robot = robotOf(oneJoint("revolute", limits(-1, 1)));
  EXPECT_THROW(motionWithinLimits(robot, forwardKinematics(robot, std::vector<double>{0.0}), {1.0}, {0.0, 0.0}),
               std::invalid_argument);
}

TEST(Motion, RefusesPiecesThatLeaveAGap) {
  const RobotModel robot = robotOf(oneJoint("revolute", limits(-1, 1)));
  const RobotMotion rest = RobotMotion::between(robot, std::vector<double>{0.0}, std::vector<double>{0.0});
  using Pieces = std::vector<Motion::Piece>;
  EXPECT_THROW(Motion{Pieces{}}, std::invalid_argument);
  EXPECT_THROW((Motion{Pieces{{0.0, 0.4, rest}, {0.5, 1.0, rest}}}), std::invalid_argument);
  EXPECT_THROW((Motion{Pieces{{0.0, 0.5, rest}}}), std::invalid_argument);
  EXPECT_NO_THROW((Motion{Pieces{{0.0, 0.5, rest}, {0.5, 1.0, rest}}}));
}

// ---- what a scene says of such a motion

struct Carts {
  std::shared_ptr<const SceneModel> model;
  MotionSearch scene;
  LimitedMotion limited;

  Carts(const std::string& left_limits, const std::string& right_limits, double left_travel, double right_travel)
      : model(modelOf(carts(left_limits, right_limits))),
        scene(model),
        limited(motionWithinLimits(model->robot, forwardKinematics(model->robot, byJoint(model->robot, {})),
                                   byJoint(model->robot, {{"left", left_travel}, {"right", right_travel}}))) {}

  std::vector<ShapeRefPair> pairs() const { return {pairOf(*model, "l", "r")}; }
  RobotTimeOfContact contact(const MotionQuestion& question = {}) {
    return scene.timeOfContact(pairs(), limited.motion, question);
  }
  RobotMinimum minimum(const MotionQuestion& question = {}) { return scene.minimum(pairs(), limited.motion, question); }
};

TEST(ContactWithinLimits, ThatLiesBeyondALimitIsNone) {
  Carts carts(limits(-2, 2), limits(-5, 5), 6.0, 0.0);  // without the limit at 0.5, but it stops at 1/3
  const RobotTimeOfContact contact = carts.contact();
  EXPECT_EQ(contact.status, Status::Converged);
  EXPECT_FALSE(contact.contact);
  EXPECT_EQ(contact.t_free, 1.0);
  const RobotMinimum minimum = carts.minimum();
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_LE(minimum.lower_bound, 1.0 + kRounding);
  EXPECT_GE(minimum.upper_bound, 1.0 - kRounding);
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1.01 * kTolerance);
  EXPECT_GE(minimum.time, 1.0 / 3.0 - kTolerance);
}

TEST(ContactWithinLimits, ThatComesBeforeALimitIsThatOfTheWholeMotion) {
  Carts carts(limits(-4, 4), limits(-5, 5), 6.0, 0.0);
  const RobotTimeOfContact contact = carts.contact();
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 0.5, kTolerance);
  EXPECT_LE(contact.t_free, 0.5 + kRounding);
  EXPECT_EQ(carts.limited.stops.size(), 1u);
}

// The gap is 3 - 8 t until the left one stops at 1/4, and then 1 - 4 (t - 1/4).
TEST(ContactWithinLimits, IsThatOfTheJointThatStillMoves) {
  Carts carts(limits(-1, 1), limits(-5, 5), 4.0, -4.0);
  const RobotTimeOfContact contact = carts.contact();
  EXPECT_EQ(contact.status, Status::Converged);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 0.5, kTolerance);
  EXPECT_LE(contact.t_free, 0.5 + kRounding);
  EXPECT_GE(contact.t_free, 0.5 - 3.0 * kTolerance);
  EXPECT_NEAR(contact.pair.result.point_a.x(), 1.5, 2.0 * kTolerance);
}

TEST(ContactWithinLimits, IsNoneWhereBothJointsStopBefore) {
  Carts carts(limits(-1, 1), limits(-1.5, 5), 4.0, -4.0);
  EXPECT_FALSE(carts.contact().contact);
  const RobotMinimum minimum = carts.minimum();
  EXPECT_NEAR(minimum.upper_bound, 0.5, kTolerance);
  EXPECT_NEAR(minimum.lower_bound, 0.5, kTolerance);
}

// They part after the stop: left runs away from right at 1 of 3, and right, which is slower, follows until the end.
TEST(MinimumWithinLimits, IsThatOfThePhaseInWhichItLies) {
  Carts carts(limits(-1, 1), limits(-5, 5), 2.0, 1.0);  // the gap is 3 - t until 1/2, then 2.5 + (t - 1/2)
  const RobotMinimum minimum = carts.minimum();
  EXPECT_NEAR(minimum.time, 0.5, 1e-5);
  EXPECT_NEAR(minimum.upper_bound, 2.5, kTolerance);
  EXPECT_NEAR(minimum.lower_bound, 2.5, kTolerance);
  EXPECT_NEAR(minimum.pair.result.point_a.x(), 1.5, 1e-5);
}

TEST(DeadlineOfPhases, IsOneForAllOfThem) {
  Carts carts(limits(-1, 1), limits(-5, 5), 4.0, -4.0);
  MotionQuestion question;
  question.deadline = std::chrono::steady_clock::now();
  const RobotTimeOfContact contact = carts.contact(question);
  EXPECT_EQ(contact.status, Status::IterationLimit);
  EXPECT_FALSE(contact.contact);
  EXPECT_LE(contact.t_free, 0.5 + kRounding);
  const RobotMinimum minimum = carts.minimum(question);
  EXPECT_LE(minimum.lower_bound, -1.0);  // as deep as that while they pass through each other
  EXPECT_GE(minimum.upper_bound, minimum.lower_bound);
}

TEST(CountsOfPhases, TellThePairsOnce) {
  Carts carts(limits(-1, 1), limits(-1.5, 5), 4.0, -4.0);
  ASSERT_EQ(carts.limited.motion.pieces().size(), 3u);
  EXPECT_EQ(carts.contact().counts.pairs, 1);
}

}  // namespace proximity_server::scene::limited_motion_test
