#include "proximity_server/scene/proof/joint_box.h"

#include "laws/refusals.h"
#include "proximity_server/scene/model/names.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace proximity_server::scene::joint_box_test {

const std::string kRobot =
    urdfOf(link("base") + link("arm") + link("tool") + link("twin") + link("cart") +
           joint("turn", "revolute", "base", "arm", axis("0 0 1") + limits("-1", "2")) +
           joint("roll", "continuous", "arm", "tool", axis("1 0 0")) +
           joint("follow", "revolute", "base", "twin", axis("0 0 1") + limits("-1", "1") + mimic("turn", "0.5")) +
           joint("drive", "planar", "base", "cart", axis("0 0 1")));

void expectRefused(const std::string& yaml, const std::string& reason) {
  const RobotModel robot = robotOf(kRobot);
  EXPECT_TRUE(isRefused([&] { jointBoxFrom(yaml, "box.yaml", robot, jointRanges(robot)); }, reason)) << yaml;
}

TEST(JointBox, NamedJointsGetTheirIntervals) {
  const RobotModel robot = robotOf(kRobot);
  const JointBox box = jointBoxFrom("turn: [-0.5, 0.25]\n", "box.yaml", robot, jointRanges(robot));
  ASSERT_EQ(box.size(), 2U);
  EXPECT_EQ(box[0].lower, -0.5);
  EXPECT_EQ(box[0].upper, 0.25);
  EXPECT_EQ(box[1].lower, -M_PI);
  const JointBox fixed = jointBoxFrom("roll: 3", "box.yaml", robot, jointRanges(robot));
  EXPECT_EQ(fixed[1].lower, 3.0);
  EXPECT_EQ(fixed[1].upper, 3.0);
}

TEST(JointBox, IntervalsMayBeInDegreesOfWhatTurns) {
  const RobotModel robot = robotOf(kRobot);
  const JointBox box = jointBoxFrom("turn: [-30deg, 0.5]\nroll: 90 deg", "box.yaml", robot, jointRanges(robot));
  EXPECT_DOUBLE_EQ(box[0].lower, -M_PI / 6.0);
  EXPECT_EQ(box[0].upper, 0.5);
  EXPECT_DOUBLE_EQ(box[1].lower, M_PI / 2.0);
  const RobotModel slider =
      robotOf(urdfOf(link("base") + link("arm") + joint("lift", "prismatic", "base", "arm", limits("0", "1"))));
  EXPECT_THROW(jointBoxFrom("lift: 1deg", "box.yaml", slider, jointRanges(slider)), std::invalid_argument);
}

TEST(JointBox, WrongFilesAreRefusedByName) {
  expectRefused("turn: 1\nrol: 1", "box.yaml, line 2: rol: there is no movable joint \"rol\" (did you mean \"roll\"?)");
  expectRefused("turn: [1, 0]", "box.yaml, line 1: turn: is neither a position nor [lower, upper]");
  expectRefused("turn: [1, 2, 3]", "neither a position");
  expectRefused("turn: wide", "line 1: turn");
  expectRefused("turn: .inf", "line 1: turn");
  expectRefused("drive: 1", "drive: the joint is planar");
  expectRefused("follow: 1", "follow: the joint follows \"turn\"");
  expectRefused("- 1", "box.yaml");
}

TEST(JointBox, TheBoxAboutAStateIsCutAtTheLimits) {
  const RobotModel robot = robotOf(kRobot);
  const JointBox box =
      boxAbout(robot, byJoint(robot, {{"turn", 1.5}, {"roll", 3.0}}), byJoint(robot, {{"turn", 0.75}, {"roll", 0.75}}));
  EXPECT_EQ(box[0].lower, 0.75);
  EXPECT_EQ(box[0].upper, 2.0);
  EXPECT_EQ(box[1].lower, 2.25);
  EXPECT_EQ(box[1].upper, 3.75) << "no limit";
}

TEST(JointBox, JointsWithoutAKnownRangeHaveNoInterval) {
  RobotModel robot = robotOf(urdfOf(link("a") + link("b") + link("c") + link("d") + link("e") +
                                    joint("slide", "prismatic", "a", "b", axis("1 0 0") + limits("-1", "1")) +
                                    joint("turn", "continuous", "a", "c", axis("0 0 1")) +
                                    joint("half", "continuous", "a", "d", axis("0 0 1") + mimic("turn", "0.5")) +
                                    joint("roll", "continuous", "a", "e", axis("1 0 0"))));
  robot.joints[findNamed(robot.joints, "slide")].lower = -INFINITY;
  const JointBox box = knownRanges(robot);
  ASSERT_EQ(box.size(), 1U);
  EXPECT_EQ(robot.joints[box[0].joint].name, "roll");
}

TEST(JointBox, StatesBeyondTheLimitsHaveNoBox) {
  const RobotModel robot = robotOf(kRobot);
  const std::vector<double> radii(4, 0.4);
  EXPECT_THROW(boxAbout(robot, byJoint(robot, {{"turn", 2.5}}), radii), std::invalid_argument);
  EXPECT_THROW(boxAbout(robot, byJoint(robot, {{"turn", NAN}}), radii), std::invalid_argument);
  EXPECT_THROW(boxAbout(robot, byJoint(robot, {}), byJoint(robot, {{"turn", -0.4}})), std::invalid_argument);
  EXPECT_THROW(boxAbout(robot, {0.0}, radii), std::invalid_argument);
}

}  // namespace proximity_server::scene::joint_box_test
