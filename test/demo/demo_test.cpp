#include <proximity_server/Clearance.h>
#include "node/gantry.h"
#include "node/robot/level_name.h"
#include "tools/program/run_command.h"

#include <pty.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/JointState.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

// The programs of ./dev demo beside the node, with the robot of odd_names.urdf.

namespace proximity_server::node::demo_test {

// Regression: a parameter was named after each joint, which ROS refuses with an exception.
TEST(DemoMotion, MovesJointsWhoseNamesAreNoNamesOfRos) {
  for (const std::string node : {"sweep", "script"}) {
    Inbox<sensor_msgs::JointState> inbox(ros::NodeHandle(), "/" + node + "/joint_states");
    const auto state = inbox.next();
    ASSERT_TRUE(state) << node;
    EXPECT_EQ(state->name, (std::vector<std::string>{"shoulder.pan", "elbow flex", "håndled"}));
    if (node == "script") {
      EXPECT_EQ(state->position, (std::vector<double>{0.0, 1.0, 0.0}));
    }
  }
}

/// Runs demo_motion with these parameters.
std::string demoMotionWith(const std::string& joints, const std::string& keyframes) {
  return "rosparam set /ending \"{joints: " + joints + ", keyframes: " + keyframes +
         "}\" && exec timeout --signal=INT 60 " DEMO_MOTION " __name:=ending joint_states:=/ending/joint_states";
}

/// Runs demo_motion with parameters that it refuses, and returns its output.
std::string lastWordsWith(const std::string& joints, const std::string& keyframes) {
  const auto [code, output, _] = tools::runCommand(demoMotionWith(joints, keyframes) + " 2>&1");
  EXPECT_EQ(code, 1) << output;
  return output;
}

/// Runs a command, ends it at the first line that contains `part`, and returns its output.
std::string outputUntil(const std::string& command, const std::string& part) {
  FILE* pipe = popen(("echo $$; " + command + " 2>&1").c_str(), "r");
  std::string output, line;
  pid_t process = 0;
  for (int byte = fgetc(pipe); byte != EOF; byte = fgetc(pipe)) {
    line += static_cast<char>(byte);
    if (byte != '\n') continue;
    if (process == 0) process = std::stoi(line);
    if (line.find(part) != std::string::npos) kill(process, SIGTERM);
    output += std::exchange(line, "");
  }
  pclose(pipe);
  return output;
}

void expectIn(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "not '" << part << "' in: " << text;
}

// Regression: it published 0 of every joint, and tests of a robot that should move passed.
TEST(DemoMotion, EndsWhereTheScriptNamesAJointThatTheRobotDoesNotHave) {
  expectIn(lastWordsWith("[elbow flx]", "[[0, 0], [1, 1]]"),
           "~joints: 'elbow flx' is no joint of the robot that can be driven: did you mean 'elbow flex'?");
}

TEST(DemoMotion, EndsWhereAPositionIsBeyondTheLimits) {
  expectIn(lastWordsWith("[shoulder.pan, elbow flex]", "[[0, 0, 1], [1, 1, 9.9]]"),
           "row 2 of ~keyframes: 'elbow flex' is at 9.9 rad, beyond its limits, which are -1 and 1 rad");
}

TEST(DemoMotion, WarnsOfAScriptThatDoesNotMove) {
  const std::string warning = "the robot does not move: every row of ~keyframes";
  expectIn(outputUntil(demoMotionWith("[elbow flex]", "[[0, 1], [1, 1]]"), warning), warning);
}

/// The view that RViz gets for the robot of a namespace, and its options.
std::string viewIn(const std::string& name_space) {
  char folder[] = "/tmp/demo_view_XXXXXX";
  EXPECT_NE(mkdtemp(folder), nullptr);
  const std::string place = folder, view = PROXIMITY_SOURCE_DIR "/config/demo/view.rviz";
  std::ofstream(place + "/rviz") << "#!/bin/sh\ncat \"$2\"; echo \"options: $3\"\n";
  std::filesystem::permissions(place + "/rviz", std::filesystem::perms::owner_all);
  const std::string shown = tools::runCommand("ROS_HOME=" + place + " ROS_NAMESPACE=" + name_space + " PATH=" + place +
                                              ":$PATH " DEMO_VIEW " " + view + " --fullscreen 2>&1")
                                .output;
  std::filesystem::remove_all(place);
  return shown;
}

// Regression: the camera stood where it fits the robot of the demo, and the fixed frame was a link of that robot.
TEST(DemoView, HasACameraThatFitsTheRobot) {
  const std::string shown = viewIn("/");
  // The box of odd_names.urdf is 0.2 m wide, from z = -0.1 m to the top of the hand at 1.45 m: its diagonal is
  // sqrt(0.08 + 1.55^2) =
  // 1.5756 m, of which a fifth stays for the texts above it. A ball around both, of radius 0.9432 m, is seen with 45
  // degrees from
  // 0.9432 / sin(22.5 deg) m.
  for (const std::string line :
       {"Distance: 2.465", "Focal Point: {X: 0, Y: 0, Z: 0.833}", "Target Frame: \"base\"", "Fixed Frame: \"base\"",
        "Cell Size: 0.1", "Class: rviz/RobotModel", "Collision Enabled: false", "options: --fullscreen"})
    expectIn(shown, line + "\n");
}

// Regression: of robots whose visual meshes are elsewhere nothing was seen.
TEST(DemoView, ShowsCollisionGeometryWhereMeshesAreMissing) {
  ros::param::set(
      "/lacking/robot_description",
      "<robot name='lacking'><link name='base'><visual><geometry>"
      "<mesh scale='1 1 1' filename='package://no_such_package/base.dae'/></geometry></visual></link></robot>");
  expectIn(viewIn("/lacking"), "Collision Enabled: true\n");
}

/// The lines of a table that runs, which ends with its reader.
class Table {
 public:
  Table() : lines_(popen("exec timeout 40 " CLEARANCE_TABLE " clearance:=/slow/clearance", "r")) {}
  ~Table() { pclose(lines_); }

  /// The next line, or "" at the end.
  std::string next() {
    char line[512];
    return fgets(line, sizeof line, lines_) ? line : "";
  }

 private:
  FILE* lines_;
};

TEST(ClearanceTable, SaysWhatTheNodeSaidLastWhileNothingArrives) {
  ros::Publisher log = ros::NodeHandle().advertise<rosgraph_msgs::Log>("/rosout", 10);
  rosgraph_msgs::Log words;
  words.name = "/slow";
  words.msg = "Loading: link 'arm'\nand more of it";
  rosgraph_msgs::Log others = words;
  others.name = "/somebody";
  others.msg = "unheard";

  auto table = std::make_unique<Table>();
  std::string line;
  do {
    log.publish(words);
    log.publish(others);
    line = table->next();
  } while (!line.empty() && line.find("the node says") == std::string::npos);
  EXPECT_NE(line.find("nothing has arrived on /slow/clearance"), std::string::npos) << line;
  EXPECT_NE(line.find("; the node says: Loading: link 'arm'\n"), std::string::npos) << line;
}

/// A table in a terminal of this many columns.
class Terminal {
 public:
  explicit Terminal(int columns) {
    winsize size{};
    size.ws_col = static_cast<unsigned short>(columns);
    size.ws_row = 40;
    process_ = forkpty(&terminal_, nullptr, nullptr, &size);
    if (process_ == 0) {
      execl(CLEARANCE_TABLE, CLEARANCE_TABLE, "clearance:=/shown/clearance", nullptr);
      _exit(1);
    }
  }
  ~Terminal() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    close(terminal_);
  }

  /// The next line without escape sequences; nullopt at the end.
  std::optional<std::string> next() {
    std::string line;
    char byte = 0;
    for (;;) {
      if (read(terminal_, &byte, 1) != 1) return std::nullopt;
      if (byte == '\n') break;
      line += byte;
    }
    return std::regex_replace(line, std::regex("\x1b\\[[0-9;]*[A-Za-z]|\r"), "");
  }

 private:
  int terminal_ = -1;
  pid_t process_ = -1;
};

Proximity pairOf(const std::string& a, const std::string& b) {
  Proximity pair;
  pair.a.link = a;
  pair.b.link = b;
  pair.distance = -0.0123;
  return pair;
}

/// The lines of one whole table that shows this.
std::vector<std::string> tableOf(const Clearance& clearance, int columns) {
  ros::Publisher publisher = ros::NodeHandle().advertise<Clearance>("/shown/clearance", 1, /*latch=*/true);
  publisher.publish(clearance);
  Terminal terminal(columns);
  std::vector<std::string> lines;
  // The table is redrawn every 0.1 s; it begins with the level, and one that nobody publishes any more ends after a
  // second.
  const auto begins = [&](const std::string& line) { return line.find(levelName(clearance.level)) == 3; };
  std::optional<std::string> line = terminal.next();
  while (line && !begins(*line)) line = terminal.next();
  do {
    if (!line) {
      ADD_FAILURE() << "the table has ended";
      break;
    }
    lines.push_back(*line);
    line = terminal.next();
  } while (!line || !begins(*line));
  return lines;
}

std::size_t columnsOf(const std::string& line) {
  return static_cast<std::size_t>(std::count_if(
      line.begin(), line.end(), [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0u) != 0x80u; }));
}

// Regression: the terminal broke lines with long names, and each table left a part of the one before.
TEST(ClearanceTable, FitsTheTerminalAndShowsTheEndsOfLongNames) {
  const std::string finger = "left_gripper_adapter_with_force_sensor_r_finger_tip_pad_link",
                    wheel = "mobile_base_back_right_caster_r_wheel_collision_hånd_link";
  Clearance clearance;
  clearance.level = Clearance::STOP;
  clearance.deciding = clearance.self_minimum = pairOf(finger, wheel);
  clearance.deciding_threshold = 0.02;
  clearance.object_minimum = pairOf("a", wheel);
  clearance.below_threshold = {pairOf(finger, "a"), pairOf("short", "pair")};
  clearance.levels = {Clearance::COLLISION, Clearance::WARN};
  clearance.pairs_below_threshold = 2;
  clearance.pairs_at_rest = clearance.pairs_by_motion = clearance.pairs_by_bounds = clearance.pairs_computed = 1234567;
  clearance.pairs_total = 4 * 1234567;
  for (const int columns : {100, 60}) {
    const std::vector<std::string> lines = tableOf(clearance, columns);
    for (const std::string& line : lines) EXPECT_LE(columnsOf(line), static_cast<std::size_t>(columns)) << line;
    ASSERT_GT(lines.size(), 4u);
    EXPECT_EQ(lines[0].find("   STOP          -0.0123 m  left_"), 0u) << lines[0];
    expectIn(lines[0], columns == 100 ? "_link (STOP at 0.0200 m)" : "_link");
    expectIn(lines[2], "links      -0.0123 m  left_");
    EXPECT_EQ(lines[2].substr(lines[2].size() - 5), "_link");
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                            [](const std::string& line) { return line == "    -0.0123 m  short - pair  WARN"; }));
  }
  clearance.by_guaranteed = true;
  clearance.deciding.guaranteed = -0.0145;
  expectIn(tableOf(clearance, 200)[0], "_link (guaranteed -0.0145 m, STOP at 0.0200 m)");
  // Names for which there is room are not cut.
  expectIn(tableOf(clearance, 100)[3], "  a - " + wheel);
  expectIn(tableOf(clearance, 200)[0], finger + " - " + wheel);
}

TEST(ClearanceTable, ShowsTheFirstLineOfAReasonAndNoMoreThanFits) {
  Clearance clearance;
  clearance.level = Clearance::INVALID;
  clearance.status.message = "joint '" + std::string(120, 'j') + "' is 3 s old\nand more";
  const std::vector<std::string> lines = tableOf(clearance, 100);
  EXPECT_EQ(columnsOf(lines[0]), 100u) << lines[0];
  EXPECT_EQ(lines[0].substr(lines[0].size() - 4), "j...");
}

}  // namespace proximity_server::node::demo_test
