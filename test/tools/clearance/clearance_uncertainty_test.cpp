// Guaranteed distances: what --joint-uncertainty adds, on paper and beside displaced states.
#include "robots/urdf.h"
#include "tools/program/clearance_command.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::tools::clearance_uncertainty_test {

/// Four balls of radius 0.1 on one rail, each with a joint of its own.
class ClearanceUncertainty : public Clearance {
 protected:
  ClearanceUncertainty() {
    const std::string ball = robots::ball("0.1");
    urdf_ = files_.write("balls.urdf", robots::onRail({{"a", ball}, {"b", ball}, {"c", ball}, {"d", ball}}));
  }

  /// a and b are 0.1, b and c 0.12 m apart; d is far.
  CommandResult runBalls(const std::string& arguments) { return run("to_a,to_b,to_c,to_d\n0,0.3,0.62,5\n", arguments); }

  std::string file(const std::string& yaml) { return "--joint-uncertainty " + files_.write("u.yaml", yaml) + " "; }

  void expectRow(const std::string& arguments, const std::string& links, double guaranteed) {
    const auto rows = rowsOf(runBalls(arguments).output);
    ASSERT_EQ(rows.size(), 2U) << arguments;
    EXPECT_EQ(rows[0].back(), "guaranteed");
    EXPECT_EQ(rows[1][1] + rows[1][2], links) << arguments;
    EXPECT_NEAR(std::stod(rows[1].back()), guaranteed, 1e-12) << arguments;
    EXPECT_LE(std::stod(rows[1].back()), guaranteed) << arguments;
  }
};

TEST_F(ClearanceUncertainty, EachJointBringsItsLinkCloser) {
  expectRow("--joint-uncertainty 0.01", "ab", 0.1 - 2 * 0.01);
  expectRow("--joint-uncertainty 0", "ab", 0.1 - 2e-15);
  expectRow(file("{joint_uncertainty: {to_b: 0.03}}"), "ab", 0.1 - 0.03);
  expectRow(file("{joint_uncertainty: {\"*\": 0.01, to_b: 0.03}}"), "ab", 0.1 - 0.04);
  expectRow(file("{joint_frame_uncertainty: {to_b: {translation: 0.02}}}"), "ab", 0.1 - 0.02);
  expectRow(file("{link_uncertainty: 0.015}"), "ab", 0.1 - 2 * 0.015);
}

TEST_F(ClearanceUncertainty, TheMinimumIsThePairWithTheSmallestGuaranteedDistance) {
  expectRow(file("{joint_uncertainty: {to_c: 0.05}}"), "bc", 0.12 - 0.05);
  const auto rows = rowsOf(runBalls(file("{joint_uncertainty: {to_c: 0.05}}") + "--pairs k:2").output);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1][1] + rows[1][2], "ab");  // lists are in the order of their distances
  EXPECT_NEAR(std::stod(rows[1].back()), 0.1, 1e-12);
  EXPECT_NEAR(std::stod(rows[2].back()), 0.12 - 0.05, 1e-12);
}

TEST_F(ClearanceUncertainty, ObjectsAreUncertainToo) {
  const std::string objects = "--objects " + files_.write("cell.yaml", R"(objects:
- {id: near, pose: {position: [0, 0.25, 0]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}
- {id: far, pose: {position: [0, -0.29, 0]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}
)");
  expectRow(objects + " " + file("{object_uncertainty: 0.02}"), "anear", 0.05 - 0.02);
  expectRow(objects + " " + file("{object_uncertainty: {\"*\": 0.02, far: {translation: 0.07}}}"), "afar", 0.09 - 0.07);
}

TEST_F(ClearanceUncertainty, TheAssertionIsAboutAllStatesWithinIt) {
  EXPECT_EQ(runBalls("--assert-above 0.09").exit_code, 0);
  const CommandResult holds = runBalls("--joint-uncertainty 0.004 --assert-above 0.09");
  EXPECT_EQ(holds.exit_code, 0) << holds.errors;
  EXPECT_TRUE(says(holds.errors, "proven: in 1 state all 6 pairs within the uncertainty are above 0.09 m"))
      << holds.errors;
  for (const std::string pairs : {"minimum", "all", "k:1", "below:0.15"}) {
    const CommandResult open = runBalls("--joint-uncertainty 0.006 --assert-above 0.09 --pairs " + pairs);
    EXPECT_EQ(open.exit_code, 2) << pairs;
    EXPECT_TRUE(says(open.errors, "1 within the uncertainty of that distance")) << open.errors;
    EXPECT_TRUE(says(open.errors, "a - b at 0.0999")) << open.errors;
  }
}

TEST_F(ClearanceUncertainty, DegreesAreThoseOfJointsThatTurn) {
  using namespace robots;
  urdf_ =
      files_.write("arm.urdf", urdfOf(link("base", ball("0.1", "2 0 0")) + link("arm") + link("ball", ball("0.1")) +
                                      hinge("turn", "base", "arm", "0 0 1") + slider("slide", "arm", "ball", "1 0 0")));
  const CommandResult result = run("turn,slide\n1.5707963267948966,2\n", "--joint-uncertainty 0.1deg");
  const auto rows = rowsOf(result.output);
  ASSERT_EQ(rows.size(), 2U) << result.errors;
  const double turned = M_PI / 2.0 - M_PI / 1800.0;  // the ball is on a circle of radius 2 about the axis
  const double nearest = 4.0 * std::sin(turned / 2.0) - 0.2;
  EXPECT_LE(std::stod(rows[1].back()), nearest);
  EXPECT_GT(std::stod(rows[1].back()), nearest - 1e-5);
  EXPECT_TRUE(says(result.errors, "\"slide\" is prismatic and taken to be exact")) << result.errors;
}

TEST_F(ClearanceUncertainty, OfAFileMayBeInDegrees) {
  const CommandResult in_degrees = runBalls(file("{joint_frame_uncertainty: {to_a: {angle: 0.5deg}}}"));
  const CommandResult in_radians = runBalls(file("{joint_frame_uncertainty: {to_a: {angle: 0.008726646259971648}}}"));
  EXPECT_EQ(in_degrees.output, in_radians.output);
  EXPECT_NE(in_degrees.output, "") << in_degrees.errors;
}

TEST_F(ClearanceUncertainty, AJointThatFollowsAnotherHasTheUncertaintyOfItsLeader) {
  using namespace robots;
  urdf_ = files_.write(
      "pair.urdf",
      urdfOf(link("base") + link("a", ball("0.1")) + link("b", ball("0.1")) + slider("to_a", "base", "a", "1 0 0") +
             joint("to_b", "prismatic", "base", "b",
                   origin("0.3 0 0") + axis("1 0 0") + limits("-9", "9") + mimic("to_a", "3"))));
  const auto rows = rowsOf(run("to_a\n0\n", "--joint-uncertainty 0.01").output);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_LE(std::stod(rows[1].back()), 0.1 - 0.02 + 1e-12);
  EXPECT_GE(std::stod(rows[1].back()), 0.1 - 0.04 - 1e-12);
}

}  // namespace proximity_server::tools::clearance_uncertainty_test
