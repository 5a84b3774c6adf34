// Sweeps by GNU parallel over two hosts, and by Slurm, with faults. The programs in Python beside this file do it.
#include "sanitized.h"
#include "tools/program/run_command.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::engines_test {

constexpr int kUnusable = 77;  // exit code where this machine cannot have what the program needs

const std::string kRobot = PROXIMITY_SOURCE_DIR "/config/demo/robot.urdf --srdf " PROXIMITY_SOURCE_DIR
                                                "/config/demo/robot.srdf --pairs any:0.05 --format npy --sample ";

std::string program(const std::string& name) {
  return "ROS_PACKAGE_PATH=" PROXIMITY_SOURCE_DIR " python3 " PROXIMITY_SOURCE_DIR "/test/tools/sweep/" + name +
         " " CLEARANCE;
}

void expectSuccess(const CommandResult& result) {
  if (result.exit_code == kUnusable) GTEST_SKIP() << result.errors;
  EXPECT_EQ(result.exit_code, 0) << result.output << result.errors;
}

// 10 parts of 400 kB; the disk holds four of them at first.
TEST(Engines, ASweepOverTwoHostsSurvivesKillsAFullDiskAndALostConnection) {
  if (kIsSanitized)
    GTEST_SKIP() << "a sanitizer makes it many times slower, and finds what it finds in sweep_tool_test";
  expectSuccess(
      runCommandApart(program("sweep_over_hosts.py") + " --shards 10 --first-disk 1800000 -- " + kRobot + "4000000"));
}

TEST(Engines, ASweepBySlurmSurvivesKills) {
  if (kIsSanitized)
    GTEST_SKIP() << "a sanitizer makes it many times slower, and finds what it finds in sweep_tool_test";
  expectSuccess(runCommandApart(program("sweep_by_slurm.py") +
                                " " PROXIMITY_SOURCE_DIR "/src/tools/sweep/clearance_sweep.sbatch --shards 6 -- " +
                                kRobot + "1500000"));
}

}  // namespace proximity_server::tools::engines_test
