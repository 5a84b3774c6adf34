#include <proximity_server/ModelInfo.h>
#include <proximity_server/QueryConfiguration.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>

#include "node/faults/child_process.h"
#include "node/faults/running_node.h"
#include "node/gantry.h"
#include "node/threads/grants_real_time.h"
#include "sanitized.h"

// A node that cannot do its job must not start, and say why.

namespace proximity_server::node::startup_test {

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
  ros::param::set(kName + "/tolerance", 0.0);
  expectRefusal("parameter /broken/tolerance is 0, outside of [1e-14, 0.1]");
}

TEST_F(Startup, RefusesATimeBudgetOfNothing) {
  ros::param::set(kName + "/mesh_time_budget", 0);
  expectRefusal("/broken/mesh_time_budget");
}

TEST_F(Startup, RefusesAListOfLinksWhereAListOfPairsIsWantedAndShowsItsForm) {
  const std::vector<std::string> names = {"base", "ball"};
  ros::param::set(kName + "/exclude_pairs", names);
  expectRefusal(
      "parameter /broken/exclude_pairs must be a list of pairs, with brackets around each of them: [[base, ball]]");
}

TEST_F(Startup, RefusesAStopDistanceAboveTheWarnDistance) {
  ros::param::set(kName + "/stop_distance", 0.1);
  expectRefusal("parameter /broken/stop_distance is 0.1, above warn_distance, which is 0.05");
}

TEST_F(Startup, RefusesThresholdsOfPairsThatMakeNoSenseByName) {
  const auto set = [](const std::string& name, const std::string& key, double number) {
    ros::param::set(kName + "/" + name, std::map<std::string, double>{{key, number}});
  };
  set("link_stop_distance", "bal", 0.01);
  expectRefusal("link_stop_distance: no link \"bal\" (did you mean \"ball\"?)");
  ros::param::del(kName + "/link_stop_distance");
  set("link_warn_distance", "ball", 0.01);
  expectRefusal("the stop distance of base - ball is 0.02, above its warn distance, which is 0.01");
  set("link_warn_distance", "ball", 0.3);
  set("link_stop_distance", "ball", 0.2);
  expectRefusal("the stop distance of base - ball is 0.2, not below influence_distance, which is 0.1");
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

// ---- a place that cannot be written

/// Two meshes that soon become pieces, under a sanitizer too.
constexpr char kTwoHands[] = R"(<robot name="hands">
  <link name="left"><collision><geometry><mesh filename="package://proximity_server/config/demo/meshes/wrist.obj"/></geometry></collision></link>
  <link name="right"><collision><geometry><mesh filename="package://proximity_server/config/demo/meshes/hand.dae"/></geometry></collision></link>
  <link name="middle"/>
  <joint name="turn" type="continuous"><parent link="left"/><child link="middle"/></joint>
  <joint name="bend" type="continuous"><parent link="middle"/><child link="right"/><origin xyz="0.5 0 0"/></joint>
</robot>)";

/// What a node says about itself, and how close the robot is to itself at rest.
struct Loaded {
  ModelInfo info;
  QueryConfigurationResponse at_rest;
};
Loaded load(const std::string& name) {
  Loaded loaded;
  ros::service::waitForService(name + "/query_configuration", ros::Duration(60.0));
  Inbox<ModelInfo> inbox(ros::NodeHandle(), name + "/model_info");
  loaded.info = inbox.next().value_or(ModelInfo());
  QueryConfigurationRequest request;
  request.states.resize(1);
  request.missing_joints = QueryConfigurationRequest::ZERO;
  loaded.at_rest = call<QueryConfigurationResponse>(name + "/query_configuration", request);
  return loaded;
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST_F(Startup, WithAFullDiskCostsAWarningAndNoAnswer) {
  if (kIsSanitized) GTEST_SKIP() << "its meshes take minutes under a sanitizer";
  ros::param::set("/robot_description", kTwoHands);
  const std::filesystem::path cache = std::filesystem::temp_directory_path() / ("cache." + std::to_string(getpid()));
  ros::param::set("/roomy/mesh_cache", (cache / "roomy").string());
  ros::param::set("/full/mesh_cache", (cache / "full").string());
  const ChildProcess roomy({NODE_EXECUTABLE, "__name:=roomy"});
  // No file can grow, that of the log neither; the signal that would say so is ignored, as the kernel's ENOSPC has
  // none.
  const ChildProcess full({"sh", "-c", "trap '' XFSZ; ulimit -f 0; exec " NODE_EXECUTABLE " __name:=full"});
  const Loaded expected = load("/roomy"), loaded = load("/full");

  EXPECT_FALSE(expected.info.links.empty());
  EXPECT_EQ(all(expected.info.warnings).find("mesh cache"), std::string::npos) << all(expected.info.warnings);
  EXPECT_NE(all(loaded.info.warnings).find("cannot be written"), std::string::npos) << all(loaded.info.warnings);
  ASSERT_EQ(loaded.at_rest.states.size(), 1u);
  EXPECT_EQ(loaded.at_rest.states[0].minimum.distance, expected.at_rest.states[0].minimum.distance);
  EXPECT_TRUE(std::filesystem::is_empty(cache / "full")) << "drafts are left behind";
  std::filesystem::remove_all(cache);
  ros::param::del("/roomy");
  ros::param::del("/full");
}

/// How many threads of a process go before all that is not real-time.
int realtimeThreads(pid_t process) {
  int count = 0;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task"))
    count += (sched_getscheduler(std::stoi(thread.path().filename())) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
  return count;
}

TEST_F(Startup, RunsMonitorAndTfInRealTimeWhereAsked) {
  if (!grantsRealTime()) GTEST_SKIP() << "the system does not grant real-time priorities";
  for (const int priority : {0, 10}) {
    ros::param::set("/ready/realtime_priority", priority);
    Inbox<ModelInfo> inbox(ros::NodeHandle(), "/ready/model_info");
    const ChildProcess node({NODE_EXECUTABLE, "__name:=ready"});
    ASSERT_TRUE(inbox.next());
    // Two of the monitor, for its rate and for what wakes it up; one of tf.
    const int expected = priority > 0 ? 3 : 0;
    const pid_t process = processOf("/ready");
    EXPECT_TRUE(holdsWithin(kPatience, [&] { return realtimeThreads(process) == expected; }))
        << realtimeThreads(process);
  }
  ros::param::del("/ready");
}

TEST_F(Startup, RefusesAnSrdfThatIsNamedAndNotThere) {
  ros::param::set(kName + "/semantic_description", "elsewhere");
  expectRefusal("no SRDF: parameter 'elsewhere', which semantic_description names, is not set");
}

TEST_F(Startup, ReadsNoSrdfWhereItsNameIsEmpty) {
  ros::param::set("/robot_description_semantic", "<robot name=");  // refused if it were read
  ros::param::set("/ready/semantic_description", "");
  Inbox<ModelInfo> inbox(ros::NodeHandle(), "/ready/model_info");
  const ChildProcess node({NODE_EXECUTABLE, "__name:=ready"});
  EXPECT_TRUE(inbox.next());
  ros::param::del("/ready");
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

}  // namespace proximity_server::node::startup_test
