#include "tools/states/state_options.h"

#include "scene/files.h"
#include "tools/states/arm.h"
#include "tools/states/numpy_bytes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace proximity_server::tools::state_options_test {

using namespace scene;

TEST(StateOptions, ZeroIsAsNearToZeroAsTheLimitsOfEachJointAllow) {
  RobotModel robot = arm();
  robot.joints[joint("elbow")].lower = 0.5;
  robot.joints[joint("lift")].lower = -1.0;
  robot.joints[joint("lift")].upper = -0.25;
  robot.joints[joint("finger")].lower = 0.25;  // it follows the lift
  StateOptions options;
  options.is_zero = true;
  EXPECT_EQ(restOf(*openStates(options, robot)), std::vector<Positions>{at(0.5, -0.25, 0.0)});
}

TEST(StateOptions, OpenAFileByItsFirstBytesIfItsNameDoesNotTellWhatItIs) {
  const TemporaryFiles files;
  StateOptions options;
  options.file = files.write("csv", "elbow\n0.5\n");
  EXPECT_EQ(restOf(*openStates(options, arm())), std::vector<Positions>{at(0.5, 0.0, 0.0)});
  options.joints = {"lift"};
  EXPECT_EQ(errorOf([&] { openStates(options, arm()); }),
            "--joints goes with a .npy or .npz: the header of a CSV names its joints");
  options.file = files.write("npy", npyHeader(npyDictionary("<f8", "(1, 1)")) + bytesOf<double>({0.25}));
  EXPECT_EQ(restOf(*openStates(options, arm())), std::vector<Positions>{at(0.0, 0.25, 0.0)});
}

}  // namespace proximity_server::tools::state_options_test
