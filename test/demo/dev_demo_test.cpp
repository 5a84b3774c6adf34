#include "node/patience.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

// ./dev demo as a user runs it, with the robot of odd_names.urdf. However it ends, nothing of it is left.

namespace proximity_server::node::dev_demo_test {

constexpr std::chrono::seconds kEnd{40};  // roslaunch gives each of its nodes 15 s

class Demo {
 public:
  explicit Demo(const std::string& options) {
    const std::string command = "cd " PROXIMITY_SOURCE_DIR
                                "; echo $$; exec ./dev demo --no-rviz --robot "
                                "test/robots/odd_names.urdf " +
                                options + " 2>&1";
    output_ = popen(command.c_str(), "r");
    pid_ = std::stoi(next());
  }
  ~Demo() {
    if (output_) kill(pid_, SIGTERM);
    if (output_) pclose(output_);
  }

  std::string next() {
    char line[1024];
    return fgets(line, sizeof line, output_) ? line : "";
  }
  /// The next line that has this in it; "" if none does to the end.
  std::string next(const std::string& part) {
    std::string line;
    do line = next();
    while (!line.empty() && line.find(part) == std::string::npos);
    return line;
  }

  void signal(int number) const { kill(pid_, number); }

  /// Reads to the end.
  int exitCode() {
    while (!next().empty()) {
    }
    const int status = pclose(output_);
    output_ = nullptr;
    return WEXITSTATUS(status);
  }

  /// roslaunch and what it started.
  std::vector<pid_t> processes() const {
    const std::string mark = "PROXIMITY_DEMO=" + std::to_string(pid_) + ".";
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      const std::string name = entry.path().filename();
      if (name.find_first_not_of("0123456789") != std::string::npos) continue;
      if (scene::readFile(entry.path() / "environ").find(mark) != std::string::npos) found.push_back(std::stoi(name));
    }
    return found;
  }

 private:
  FILE* output_;
  pid_t pid_;
};

/// The changes in the sources that git shows as not committed.
std::string statusOfSources() {
  FILE* pipe = popen("git -C " PROXIMITY_SOURCE_DIR " status --porcelain 2>&1", "r");
  std::string status;
  for (int byte = fgetc(pipe); byte != EOF; byte = fgetc(pipe)) status += static_cast<char>(byte);
  pclose(pipe);
  return status;
}

void expectNothingLeft(const Demo& demo) {
  EXPECT_TRUE(holdsWithin(kEnd, [&] { return demo.processes().empty(); })) << demo.processes().size() << " are left";
}

// Regression: the demo ended with an abort, as a parameter was named after each joint.
TEST(DevDemo, ShowsARobotWhoseNamesAreNoNamesOfRos) {
  const std::string before = statusOfSources();
  Demo demo("--seconds 10");
  EXPECT_NE(demo.next(" pairs: "), "") << "there is no line of the table";
  EXPECT_EQ(demo.exitCode(), 0);
  expectNothingLeft(demo);
  EXPECT_EQ(statusOfSources(), before);
}

TEST(DevDemo, LeavesNothingBehindWhereItIsEndedBeforeItBegan) {
  Demo demo("");
  EXPECT_NE(demo.next("To look closer"), "");
  EXPECT_TRUE(holdsWithin(kEnd, [&] { return !demo.processes().empty(); }));
  demo.signal(SIGTERM);
  EXPECT_EQ(demo.exitCode(), 143);
  expectNothingLeft(demo);
}

// Regression: a master stayed behind, as roslaunch gives it a session of its own.
TEST(DevDemo, LeavesNothingBehindWhereRoslaunchIsKilled) {
  Demo demo("");
  EXPECT_NE(demo.next(" pairs: "), "");
  ASSERT_GT(demo.processes().size(), 4u);  // roslaunch, master, rosout and three nodes
  for (const pid_t process : demo.processes()) {
    const std::string command = scene::readFile("/proc/" + std::to_string(process) + "/cmdline");
    if (command.find("roslaunch") != std::string::npos && command.find("demo.launch") != std::string::npos) {
      kill(process, SIGKILL);
    }
  }
  EXPECT_EQ(demo.exitCode(), 1);
  expectNothingLeft(demo);
}

}  // namespace proximity_server::node::dev_demo_test
