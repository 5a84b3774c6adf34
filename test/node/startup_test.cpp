#include <sys/wait.h>

#include <array>
#include <cstdio>

#include "gantry.h"

// A node that cannot do its job must not start, and say why.

namespace proximity_server {
namespace {

const std::string kName = "/broken";

struct Outcome {
  int exit_code;
  std::string output;
};

/// Starts a node with the parameters in its name and waits for its end; 124 if it does not end.
Outcome runNode(const std::string& name) {
  const std::string command = std::string("timeout 20 ") + NODE_EXECUTABLE + " __name:=" + name + " 2>&1";
  Outcome outcome{-1, ""};
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 256> buffer;
  while (fgets(buffer.data(), buffer.size(), pipe)) outcome.output += buffer.data();
  outcome.exit_code = WEXITSTATUS(pclose(pipe));
  return outcome;
}

class Startup : public testing::Test {
 protected:
  void SetUp() override {
    std::string urdf;
    ASSERT_TRUE(ros::param::get("/gantry", urdf));
    ros::param::set("/robot_description", urdf);
  }
  void TearDown() override {
    ros::param::del(kName);
    ros::param::del("/robot_description");
    ros::param::del("/robot_description_semantic");
  }

  static void expectRefusal(const std::string& named) {
    const Outcome outcome = runNode("broken");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find(named), std::string::npos) << "expected " << named << " in:\n" << outcome.output;
  }
};

TEST_F(Startup, RefusesAParameterOfTheWrongType) {
  ros::param::set(kName + "/threshold", "wide");
  expectRefusal("parameter /broken/threshold must be a number");
}

TEST_F(Startup, RefusesAParameterOutsideItsRange) {
  ros::param::set(kName + "/stop_distance", -0.1);
  expectRefusal("/broken/stop_distance");
}

TEST_F(Startup, RefusesAListThatIsNoListOfPairs) {
  const std::vector<std::string> names = {"base", "ball"};
  ros::param::set(kName + "/exclude_pairs", names);
  expectRefusal("/broken/exclude_pairs");
}

TEST_F(Startup, WarnsAboutAnUnknownParameterWithTheNearestName) {
  ros::param::set(kName + "/treshold", 0.1);
  ros::param::del("/robot_description");  // ends the node
  expectRefusal("parameter /broken/treshold is unknown and has no effect: did you mean 'threshold'?");
}

TEST_F(Startup, KnowsEveryParameterOfItsDocumentation) {
  ros::param::del("/robot_description");  // ends the node
  const Outcome outcome = runNode("documented");
  EXPECT_NE(outcome.output.find("'robot_description'"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("unknown"), std::string::npos) << outcome.output;
}

TEST_F(Startup, RefusesAMissingRobot) {
  ros::param::del("/robot_description");
  expectRefusal("'robot_description'");
}

TEST_F(Startup, RefusesAUrdfThatIsNoXml) {
  ros::param::set("/robot_description", "<robot name=");
  expectRefusal("URDF");
}

TEST_F(Startup, RefusesALinkWithABrokenShape) {
  ros::param::set("/robot_description",
                  "<robot name='r'><link name='flat'><collision><geometry><box size='0 1 1'/></geometry></collision>"
                  "</link></robot>");
  expectRefusal("flat");
}

TEST_F(Startup, RefusesAMeshThatCannotBeFound) {
  ros::param::set("/robot_description",
                  "<robot name='r'><link name='shell'><collision><geometry><mesh filename='package://nowhere/a.stl'/>"
                  "</geometry></collision></link></robot>");
  expectRefusal("package://nowhere/a.stl");
}

TEST_F(Startup, RefusesAnSrdfThatIsNoXml) {
  ros::param::set("/robot_description_semantic", "<robot name=");
  expectRefusal("SRDF");
}

TEST_F(Startup, RefusesAnExcludedLinkThatDoesNotExist) {
  XmlRpc::XmlRpcValue pairs;
  pairs[0][0] = "base";
  pairs[0][1] = "bal";
  ros::param::set(kName + "/exclude_pairs", pairs);
  expectRefusal("bal");
}

}  // namespace
}  // namespace proximity_server

PROXIMITY_SERVER_ROSTEST_MAIN("startup_test")
