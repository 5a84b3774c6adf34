#include "scene/example_robots.h"
#include "scene/files.h"
#include "tools/program/run_command.h"

#include <gtest/gtest.h>

#include <filesystem>

// The example of a controller on real arms, each with a ROS master of its own; what is asked of it is in real_arm.py.

namespace proximity_server::real_arms_test {

class RealArm : public testing::TestWithParam<const char*> {};

// Regression: a UR10 rested for ever, as a pair that no joint can part contradicted all others; a UR5 was told to move
// at 97 rad/s.
TEST_P(RealArm, IsDrivenPastPairsThatAreNearByDesign) {
  if (kIsSanitized) GTEST_SKIP() << "its meshes take minutes under a sanitizer";
  const scene::MeshResolver resolve = scene::exampleRobotsResolver();
  if (!scene::findsExampleRobots(resolve)) GTEST_SKIP() << scene::kExampleRobotsMissing;
  const std::string robot = scene::exampleRobotFile(resolve, std::string("ur_description/urdf/") + GetParam());
  const std::string packages =
      std::filesystem::canonical(robot).parent_path().parent_path().parent_path().parent_path().parent_path();
  const scene::TemporaryFiles files;
  const std::string motion =
      files.write("motion.yaml",
                  "start: {shoulder_lift_joint: -1.5, elbow_joint: 0.5}\n"
                  "target: {shoulder_pan_joint: 1.0, shoulder_lift_joint: -1.0, elbow_joint: 2.9}\n");
  const std::string drive =
      "rostest " PROXIMITY_SOURCE_DIR "/test/demo/real_arm.test robot:=" + robot + " motion:=" + motion;
  const tools::CommandResult result = tools::runCommand(
      "ROS_HOME=" + files.path("") + " ROS_TEST_RESULTS_DIR=" + files.path("") +
      " " ENVIRONMENT " sh -c 'ROS_PACKAGE_PATH=$ROS_PACKAGE_PATH:/usr/share:" + packages + " " + drive + "' 2>&1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("RESULT: SUCCESS"), std::string::npos) << result.output;
}

INSTANTIATE_TEST_SUITE_P(Shared, RealArm, testing::Values("ur10_robot.urdf", "ur5_robot.urdf"));

}  // namespace proximity_server::real_arms_test
