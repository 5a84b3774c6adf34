#include <proximity_server/ModelInfo.h>
#include <proximity_server/QueryConfiguration.h>
#include "node/diagnosis.h"
#include "node/faults/child_process.h"
#include "node/faults/running_node.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/threads/grants_real_time.h"
#include "robots/urdf.h"
#include "sanitized.h"
#include "scene/files.h"
#include "scene/solids.h"
#include "tools/program/run_command.h"

#include <rosgraph_msgs/Log.h>
#include <signal.h>
#include <std_msgs/Float64.h>

#include <sched.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

// A node that cannot do its job must not start, and say why.

namespace proximity_server::node::startup_test {

const std::string kName = "/broken";

/// Starts a node with the parameters in its name and waits for its end; 124 if it does not end.
tools::CommandResult runNode(const std::string& name) {
  return tools::runCommand("timeout 20 " NODE_EXECUTABLE " __name:=" + name + " 2>&1");
}

class Startup : public testing::Test {
 protected:
  void SetUp() override {
    // A node that cannot start waits for whoever listens to its log, and a rostest has no node that does.
    static const Inbox<rosgraph_msgs::Log> log(ros::NodeHandle(), "/rosout");
    std::string urdf;
    ASSERT_TRUE(ros::param::get("/gantry", urdf));
    ros::param::set("/robot_description", urdf);
  }
  void TearDown() override {
    ros::param::del(kName);
    ros::param::del("/robot_description");
    ros::param::del("/robot_description_semantic");
  }
};

/// What a node finds at its start, and what it says then.
const std::pair<std::function<void()>, std::string> kRefusals[] = {
    {[] { ros::param::set(kName + "/threshold", "wide"); }, "parameter /broken/threshold must be a number"},
    {[] {
       ros::param::set(kName + "/exclude_pairs", std::vector<std::string>{"base", "ball"});
     },
     "parameter /broken/exclude_pairs must be a list of pairs, with brackets around each of them: [[base, ball]]"},
    {[] {
       ros::param::set(kName + "/link_stop_distance", std::map<std::string, double>{{"bal", 0.01}});
     },
     "link_stop_distance: no link \"bal\" (did you mean \"ball\"?)"},
    {[] { ros::param::set(kName + "/record_directory", "/nowhere/records"); },
     "record_directory: /nowhere/records cannot be written into (No such file or directory)"},
    {[] { ros::param::set(kName + "/semantic_description", "elsewhere"); },
     "no SRDF: parameter 'elsewhere', which semantic_description names, is not set"},
    {[] { ros::param::set("/robot_description_semantic", "<robot name="); }, "SRDF"},
    {[] { ros::param::set("/robot_description", "<robot name="); }, "URDF"},
    {[] { ros::param::del("/robot_description"); }, "'robot_description'"},
    {[] { ros::param::del("/robot_description"), ros::param::set(kName + "/treshold", 0.1); },
     "parameter /broken/treshold is unknown and has no effect: did you mean 'threshold'?"},
};

TEST_F(Startup, RefusesWhatItCannotUse) {
  for (const auto& [set, refusal] : kRefusals) {
    set();
    const auto outcome = runNode("broken");
    EXPECT_EQ(outcome.exit_code, 1) << refusal;
    EXPECT_NE(outcome.output.find(refusal), std::string::npos) << "expected " << refusal << " in:\n" << outcome.output;
    TearDown();
    SetUp();
  }
}

// It is neither read nor refused, whatever it names.
TEST_F(Startup, WarnsOnceAboutConditionalPairsAndStarts) {
  ros::param::set("/former/conditional_pairs", "no/absolute/path.yaml");
  const scene::TemporaryFiles files;
  const std::string output = files.write("output", "");
  Inbox<ModelInfo> info(ros::NodeHandle(), "/former/model_info");
  const ChildProcess node({"sh", "-c", "exec " NODE_EXECUTABLE " __name:=former >" + output + " 2>&1"});
  EXPECT_TRUE(info.next());
  const std::string log = scene::readFile(output);
  const std::size_t first = log.find("conditional_pairs");
  ASSERT_NE(log.find("parameter /former/conditional_pairs has no effect any more"), std::string::npos) << log;
  EXPECT_EQ(log.find("conditional_pairs", first + 1), std::string::npos) << log;
  ros::param::del("/former");
}

TEST_F(Startup, KnowsEveryParameterOfItsDocumentation) {
  ros::param::del("/robot_description");  // ends the node
  const auto outcome = runNode("documented");
  EXPECT_NE(outcome.output.find("'robot_description'"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("unknown"), std::string::npos) << outcome.output;
}

// ---- a place that cannot be written

/// Two meshes that soon become pieces, under a sanitizer too.
const std::string kTwoHands = [] {
  using namespace robots;
  const auto meshOf = [](const std::string& file) {
    return collision("<mesh filename='package://proximity_server/config/demo/meshes/" + file + "'/>");
  };
  return urdfOf(link("left", meshOf("wrist.obj")) + link("right", meshOf("hand.dae")) + link("middle") +
                hinge("turn", "left", "middle", "1 0 0") + hinge("bend", "middle", "right", "1 0 0", "0.5 0 0"));
}();

/// The model_info of a node, and the distance of the robot from itself at rest.
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
  std::filesystem::create_directory(cache);
  ros::param::set("/full/objects_file", (cache / "objects.yaml").string());
  const ChildProcess roomy({NODE_EXECUTABLE, "__name:=roomy"});
  // No file can grow, that of the log neither; the signal that would say so is ignored, as the kernel's ENOSPC has
  // none.
  const ChildProcess full({"sh", "-c", "trap '' XFSZ; ulimit -f 0; exec " NODE_EXECUTABLE " __name:=full"});
  const Loaded expected = load("/roomy"), loaded = load("/full");
  const auto objects = Diagnosis("full: objects").next();
  ASSERT_TRUE(objects);
  EXPECT_EQ(objects->level, diagnostic_msgs::DiagnosticStatus::ERROR);
  EXPECT_EQ(objects->message.find("not kept for the next start: " + (cache / "objects.yaml").string()), 0u)
      << objects->message;

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

// As Ctrl-C does. Before, the node ended after it had decomposed the mesh and had kept its pieces.
TEST_F(Startup, EndsAtSigintWhileItLoadsAMesh) {
  using namespace robots;
  const scene::TemporaryFiles files;
  const std::string ball = files.write("ball.stl", scene::stlOf(scene::bumpyBall(64, 128)));
  ros::param::set("/robot_description", urdfOf(link("a", collision("<mesh filename='file://" + ball + "'/>"))));
  ros::param::set("/slow/mesh_cache", files.path("cache"));
  // Read from the output of the node, because /rosout loses lines that are sent before a subscriber is connected.
  const std::string output = files.write("output", "");
  ChildProcess node({"sh", "-c", "ROSCONSOLE_STDOUT_LINE_BUFFERED=1 exec " NODE_EXECUTABLE " __name:=slow >" + output});
  ASSERT_TRUE(holdsWithin(kPatience, [&] { return scene::readFile(output).find("decomposing") != std::string::npos; }));
  node.signal(SIGINT);
  EXPECT_TRUE(node.hasEndedWithin(kPatience));
  EXPECT_EQ(node.exitCode(), 0);
  EXPECT_FALSE(std::filesystem::exists(files.path("cache")));
  ros::param::del("/slow");
}

/// True if a signal is blocked in a thread.
bool isBlocked(int signal, const std::filesystem::path& thread) {
  std::ifstream status(thread / "status");
  std::string line;
  while (std::getline(status, line) && line.rfind("SigBlk:", 0) != 0) {
  }
  return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

// Regression: where the signal interrupted the setting of a parameter, the node did not end: roscpp on Debian 11 waited
// for its own lock.
TEST_F(Startup, LeavesCtrlCToThreadsThatSetNoParameter) {
  Inbox<ModelInfo> info(ros::NodeHandle(), "/calm/model_info");
  ChildProcess node({NODE_EXECUTABLE, "__name:=calm"});
  ASSERT_TRUE(info.next());
  const std::filesystem::path process = "/proc/" + std::to_string(processOf("/calm"));
  EXPECT_TRUE(isBlocked(SIGINT, process));
  int open = 0;
  for (const auto& thread : std::filesystem::directory_iterator(process / "task")) open += !isBlocked(SIGINT, thread);
  EXPECT_GT(open, 0);
  node.signal(SIGINT);
  EXPECT_TRUE(node.hasEndedWithin(kPatience));
  EXPECT_EQ(node.exitCode(), 0);
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
    // Two of the monitor, for its rate and for what wakes it up; one of tf; and roscpp's poll thread.
    const int expected = priority > 0 ? 4 : 0;
    const pid_t process = processOf("/ready");
    EXPECT_TRUE(holdsWithin(kPatience, [&] { return realtimeThreads(process) == expected; }))
        << realtimeThreads(process);
  }
  ros::param::del("/ready");
}

// Regression: a node that started said 0 until the first transforms and joint_states came, and halted its robot.
TEST_F(Startup, IsSilentAboutTheVelocityScaleUntilItIsKnown) {
  ros::param::set("/early/max_deceleration", 2.0);
  Gantry gantry{ros::NodeHandle()};
  gantry.hold({0.9, 0.0, 0.0});
  JointStates joint_states;
  joint_states.hold(slidingAt(0.0));
  Inbox<std_msgs::Float64> inbox(ros::NodeHandle(), "/early/collision_velocity_scale");
  const auto start = std::chrono::steady_clock::now();
  const ChildProcess node({NODE_EXECUTABLE, "__name:=early"});
  const auto first = inbox.next();
  ASSERT_TRUE(first);
  // On a machine so busy that nothing is known after a second, the node says so.
  const bool is_late = std::chrono::steady_clock::now() - start >= std::chrono::seconds(1);
  EXPECT_TRUE(first->data == 1.0 || is_late) << first->data;
  ros::param::del("/early");
}

TEST_F(Startup, ReadsNoSrdfWhereItsNameIsEmpty) {
  ros::param::set("/robot_description_semantic", "<robot name=");  // refused if it were read
  ros::param::set("/ready/semantic_description", "");
  Inbox<ModelInfo> inbox(ros::NodeHandle(), "/ready/model_info");
  const ChildProcess node({NODE_EXECUTABLE, "__name:=ready"});
  EXPECT_TRUE(inbox.next());
  ros::param::del("/ready");
}

}  // namespace proximity_server::node::startup_test
