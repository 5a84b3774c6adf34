// How long runs of the executables end: at Ctrl-C, and when their time is over.
#include "scene/files.h"
#include "scene/solids.h"
#include "tools/program/run_command.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace proximity_server::tools::long_runs_test {

const std::string kTools = "env ROS_PACKAGE_PATH=" PROXIMITY_SOURCE_DIR " ";
const std::string kDemo = PROXIMITY_SOURCE_DIR "/config/demo/robot.urdf --srdf " PROXIMITY_SOURCE_DIR
                                               "/config/demo/robot.srdf --quiet --threads 2 ";

/// Runs that would take hours. The joints of the trajectory make tens of thousands of turns in each segment.
class LongRun : public testing::Test {
 protected:
  std::string trajectory() const {
    std::string rows = "time,left_shoulder_pan,left_shoulder_pan.velocity,left_elbow_flex,left_elbow_flex.velocity\n";
    for (int i = 0; i < 100; ++i) {
      const std::string velocity = i % 2 == 0 ? "1e5" : "-1e5";
      rows += std::to_string(i) + ",0.5," + velocity + ",-1," + velocity + "\n";
    }
    return kTools + CLEARANCE " " + kDemo + "--trajectory --interpolation cubic --states " +
           files_.write("way.csv", rows);
  }
  const std::string states_ = kTools + CLEARANCE " " + kDemo + "--sample 1000000000 --pairs all";
  const std::string audit_ =
      kTools + PAIR_AUDIT " " + kDemo + "--samples 1000000000 --boxes 1000000000 --write-safe-limits ";
  const std::string proof_ = kTools + PROVE " " + kDemo + "--boxes 1000000000";
  const TemporaryFiles files_;
};

/// The exit code of `timeout` tells whether SIGINT was enough.
void expectEndAtCtrlC(const std::string& command) {
  const std::string within_two_minutes = "env --default-signal=INT timeout --signal=INT --kill-after=120 2 ";
  EXPECT_EQ(runCommand(within_two_minutes + command + " > /dev/null 2>&1").exit_code, 124) << command;
}

TEST_F(LongRun, EndsAtCtrlC) {
  for (const std::string& command : {trajectory(), states_, audit_ + files_.path("limits.yaml"), proof_})
    expectEndAtCtrlC(command);
}

TEST_F(LongRun, EndsAtCtrlCWhileItLoads) {
  const std::string cache = files_.path("cache");
  const std::string robot =
      files_.write("ball.urdf", "<robot name='r'><link name='a'><collision><geometry><mesh filename='" +
                                    files_.write("ball.stl", scene::stlOf(scene::bumpyBall(64, 128))) +
                                    "'/></geometry></collision></link></robot>");
  for (const std::string tool : {CLEARANCE " --zero", PAIR_AUDIT, PROVE, MODEL_CHECK}) {
    expectEndAtCtrlC("env XDG_CACHE_HOME=" + cache + " " + tool + " " + robot);
    EXPECT_FALSE(std::filesystem::exists(cache)) << tool;
  }
}

TEST_F(LongRun, EndsWhenItsTimeIsOver) {
  for (const std::string& command : {trajectory(), states_, audit_ + files_.path("limits.yaml")}) {
    const CommandResult result = runCommandApart(command + " --time-budget 0.5 > /dev/null");
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_NE(result.errors.find("the time is over: --time-budget is 0.5 s"), std::string::npos) << result.errors;
  }
  EXPECT_EQ(runCommandApart(proof_ + " --time-budget 0.5").exit_code, 2);
  const CommandResult none = runCommandApart(proof_ + " --time-budget 1e-9");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.output.find("left_wrist - right_wrist: not examined before the time was over\n"), std::string::npos)
      << none.output;
}

TEST_F(LongRun, WritesCompleteRowsUpToThen) {
  const std::string options = kTools + CLEARANCE " " + kDemo + "--sample 20000 --pairs k:3 --seed 5 ";
  const std::string whole = runCommand(options).output;
  for (const char* const seconds : {"1e-9", "0.02", "0.1", "0.3"}) {
    const CommandResult part = runCommandApart(options + "--time-budget " + seconds);
    EXPECT_EQ(part.exit_code, part.output == whole ? 0 : 1) << part.errors;
    EXPECT_EQ(part.output, whole.substr(0, part.output.size()));
    EXPECT_EQ(part.output.back(), '\n');
    const CommandResult json = runCommandApart(options + "--format json --time-budget " + seconds);
    EXPECT_TRUE(nlohmann::json::accept(json.output)) << json.errors;
  }
  const CommandResult none =
      runCommandApart(kTools + CLEARANCE " " + kDemo + "--sample 20000 --pairs any:0.05 --format npy --out " +
                      files_.path("rows.npy") + " --time-budget 1e-9");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_TRUE(readFile(files_.path("rows.npy")).empty());
}

TEST_F(LongRun, AStudyThatIsCutShortSaysSoAndClaimsNothing) {
  const std::string srdf = files_.path("proposed.srdf");
  const CommandResult result =
      runCommandApart(kTools + PAIR_AUDIT " " + kDemo + "--write " + srdf + " --time-budget 0.05");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_NE(result.output.find("The time was over: "), std::string::npos) << result.output;
  EXPECT_EQ(readFile(srdf).find("Never"), std::string::npos) << readFile(srdf);
}

}  // namespace proximity_server::tools::long_runs_test
