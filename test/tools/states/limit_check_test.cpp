#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "robots/urdf.h"
#include "scene/files.h"
#include "tools/robot/two_sliders.h"
#include "tools/states/csv_states.h"
#include "tools/states/joint_columns.h"

#include <gtest/gtest.h>

#include <sstream>

namespace proximity_server::tools::limit_check_test {

using namespace scene;

// Limits: "elbow" from -2 to 3 rad, "lift" from 0 to 0.5 m, "wheel" none.
const std::string kArm = [] {
  using namespace robots;
  return urdfOf(link("a") + link("b") + link("c") + link("d") +
                robots::joint("elbow", "revolute", "a", "b", limits("-2", "3")) +
                robots::joint("lift", "prismatic", "b", "c", limits("0", "0.5")) +
                robots::joint("wheel", "continuous", "c", "d"));
}();

std::string warningFor(const std::string& urdf, const std::string& text, const std::string& inequalities = "[]") {
  RobotModel robot = loadRobotModel(urdf, packageResolver({}));
  setJointInequalities(readYaml(inequalities, ""), "", robot);
  std::istringstream stream(text);
  CsvStates states(stream, "s.csv", robot);
  for (scene::TrajectoryPoint state; states.next(state);) {
  }
  return states.limitWarning();
}

TEST(LimitCheck, CountsTheStatesBeyondAndNamesTheFirst) {
  EXPECT_EQ(warningFor(kArm, "lift,elbow\n0,0\n\n0.5,3.5\n0.75,-4\n0,1\n"),
            "s.csv: 2 of 4 states are beyond the limits of a joint. The first is state 1, line 4: \"elbow\" is at 3.5 "
            "rad, its limits are -2 and 3 rad. All joints that are: \"elbow\", \"lift\".");
  EXPECT_EQ(warningFor(kArm, "lift\n-0.25\n"),
            "s.csv: 1 of 1 states are beyond the limits of a joint. The first is state 0, line 2: \"lift\" is at -0.25 "
            "m, its limits are 0 and 0.5 m.");
}

TEST(LimitCheck, CountsTheStatesThatBreakAnInequality) {
  const std::string inequality = "- elbow - 2*lift <= 1";
  EXPECT_EQ(warningFor(kArm, "lift,elbow\n0,1\n0,1.25\n0.5,3\n0.5,1\n", inequality),
            "s.csv: 2 of 4 states break a joint inequality. The first is state 1, line 3: 'elbow - 2*lift <= 1' is "
            "broken by 0.25.");
  EXPECT_EQ(warningFor(kArm, "elbow\n1\n1.000001\n", inequality), "");
  EXPECT_EQ(warningFor(kArm, "elbow\n1.5\n3.5\n", inequality),
            "s.csv: 1 of 2 states are beyond the limits of a joint. The first is state 1, line 3: \"elbow\" is at 3.5 "
            "rad, its limits are -2 and 3 rad. s.csv: 2 of 2 states break a joint inequality. The first is state 0, "
            "line 2: 'elbow - 2*lift <= 1' is broken by 0.5.");
}

TEST(LimitCheck, IsSilentWithinTheLimits) {
  EXPECT_EQ(warningFor(kArm, "lift,elbow\n0,-2\n0.5,3\n"), "");
  EXPECT_EQ(warningFor(kArm, "lift,elbow\n-0.0000005,3.0000005\n"), "") << "rounded to six decimals";
  EXPECT_EQ(warningFor(kArm, "wheel\n1000\n"), "") << "it has none";
}

TEST(LimitCheck, SaysWhereDegreesExplainIt) {
  const auto looksLikeDegrees = [](const std::string& states) {
    return warningFor(kArm, states).find("look like degrees") != std::string::npos;
  };
  EXPECT_TRUE(looksLikeDegrees("elbow\n90\n-30\n"));
  EXPECT_FALSE(looksLikeDegrees("elbow\n3.1\n")) << "hardly beyond the limit";
  EXPECT_FALSE(looksLikeDegrees("elbow\n90\n270\n")) << "beyond the limit as degrees, too";
  EXPECT_FALSE(looksLikeDegrees("lift\n90\n")) << "no angle";
}

// "slide", which moves the ball, is within its limits; the column of "follow" is not used.
TEST(LimitCheck, LeavesFollowersOut) { EXPECT_EQ(warningFor(kTwoSliders, "slide,follow\n0,100\n"), ""); }

// "only" is at 0, which is not within its limits, but no state says so.
TEST(LimitCheck, LeavesOutWhatNoStateSets) {
  using namespace robots;
  const std::string urdf = urdfOf(link("a") + link("b") + link("c") + robots::joint("other", "continuous", "a", "c") +
                                  robots::joint("only", "revolute", "a", "b", limits("1", "2")));
  EXPECT_EQ(warningFor(urdf, "other\n1\n"), "");
}

}  // namespace proximity_server::tools::limit_check_test
