// The executable from end to end, on a robot whose distances are worked out on paper.
#include "robots/urdf.h"
#include "tools/program/clearance_command.h"
#include "tools/robot/robot_files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <map>
#include <string>

namespace proximity_server::tools::clearance_test {

using namespace scene;

TEST_F(Clearance, WritesTheClosestPairOfEachState) {
  // Left out are the neighbours base - sled and base - ball. Of the others sled and ball are the closest, 2.25 + slide
  // apart.
  const CommandResult result = run("slide\n0\n0.5\n", "");
  const auto rows = rowsOf(result.output);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"state", "link_a", "link_b", "distance", "lower", "upper", "point_a_x",
                                               "point_a_y", "point_a_z", "point_b_x", "point_b_y", "point_b_z",
                                               "normal_x", "normal_y", "normal_z", "status", "representation"}));
  EXPECT_EQ(rows[2][0], "1");
  EXPECT_EQ(rows[2][15], "converged");
  EXPECT_EQ(rows[2][16], "exact");
  EXPECT_NEAR(std::stod(rows[1][3]), 2.25, 1e-9);
  EXPECT_NEAR(std::stod(rows[2][3]), 2.75, 1e-9);
}

// Regression: mast and arm are on bodies that a joint joins, so they were taken for neighbours and never checked. At pi
// the arm, 0.1 wide, lies in the mast, 0.1 wide: the way out is 0.1 to either side.
TEST_F(Clearance, AMastFixedToTheBaseIsCheckedAgainstTheArm) {
  using namespace robots;
  urdf_ = files_.write("mast.urdf",
                       urdfOf(link("base", box("0.2 0.2 0.1")) + link("mast", box("0.1 0.1 1")) +
                              link("arm", box("0.8 0.1 0.1", "0.4 0 0")) + weld("weld", "base", "mast", "-0.4 0 0.5") +
                              hinge("joint1", "base", "arm", "0 0 1", "0 0 0.5")));
  const auto rows = rowsOf(run("joint1\n3.141592653589793\n", "").output);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][1] + "|" + rows[1][2], "arm|mast");
  EXPECT_NEAR(std::stod(rows[1][3]), -0.1, 1e-9);
}

TEST_F(Clearance, WithoutFilterNeighboursComeToo) {
  const auto rows = rowsOf(run("slide\n-0.75\n", "--no-filter").output);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][1] + "|" + rows[1][2], "base|sled, left");
  EXPECT_NEAR(std::stod(rows[1][3]), 0.25, 1e-9);
}

TEST_F(Clearance, SelectsPairs) {
  const auto rowsFor = [&](const std::string& pairs) {
    return rowsOf(run("slide\n0\n", "--no-filter --pairs " + pairs).output).size() - 1;
  };
  EXPECT_EQ(rowsFor("all"), 5U);  // of 4 links, less base - mast
  EXPECT_EQ(rowsFor("k:2"), 2U);
  EXPECT_EQ(rowsFor("below:1.5"), 1U);  // base - sled, 1 m
  EXPECT_EQ(rowsFor("below:0.5"), 0U);
}

TEST_F(Clearance, BoundsTheMinimumWithinAnAccuracy) {
  const std::string states = wander(3000);
  const auto exact = rowsOf(run(states, "").output), within = rowsOf(run(states, "--accuracy 1e-4").output);
  ASSERT_EQ(exact.size(), 3001U);
  ASSERT_EQ(within.size(), exact.size());
  for (std::size_t i = 1; i < exact.size(); ++i) {
    const double distance = std::stod(exact[i][3]), lower = std::stod(within[i][4]), upper = std::stod(within[i][5]);
    ASSERT_LE(lower, distance + 1e-9);
    ASSERT_GE(upper, distance - 1e-9);
    ASSERT_LE(upper - lower, 1e-4);
    ASSERT_EQ(within[i][15], "threshold");
  }
  EXPECT_EQ(rowsOf(run(states, "--pairs minimum:1e-4").output), within);
  const std::string out = files_.path("parts"), whole = files_.path("whole.csv"), merged = files_.path("merged.csv");
  ASSERT_EQ(run(states, "--accuracy 1e-4 --out " + whole).exit_code, 0);
  for (const std::string part : {"1/2", "2/2"})
    ASSERT_EQ(run(states, "--accuracy 1e-4 --out " + out + " --shard " + part).exit_code, 0);
  ASSERT_EQ(runCommandApart(CLEARANCE " --merge " + out + " --out " + merged).exit_code, 0);
  EXPECT_EQ(readTextFile(merged), readTextFile(whole));
  EXPECT_EQ(run("slide\n0\n", "--accuracy 1e-4 --assert-above 2.2").exit_code, 0);
  EXPECT_EQ(run("slide\n0\n", "--accuracy 1e-4 --assert-above 2.3").exit_code, 2);
}

TEST_F(Clearance, JsonSaysTheSameAsCsv) {
  const auto json = nlohmann::json::parse(run("slide\n0\n0.5\n", "--format json --no-filter --pairs all").output);
  const auto rows = rowsOf(run("slide\n0\n0.5\n", "--no-filter --pairs all").output);
  ASSERT_EQ(json.size() + 1, rows.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    EXPECT_EQ(json[i]["link_a"], rows[i + 1][1]);
    EXPECT_EQ(json[i]["distance"].get<double>(), std::stod(rows[i + 1][3]));
  }
  EXPECT_EQ(nlohmann::json::parse(run("slide\n0\n", "--format json --pairs below:0").output).size(), 0U);
}

TEST_F(Clearance, SaysTheSameForAnyNumberOfThreads) {
  const std::string states = wander(2000);
  const CommandResult alone = run(states, "--no-filter --pairs all --threads 1");
  EXPECT_EQ(rowsOf(alone.output).size(), 1U + 5U * 2000U);
  EXPECT_EQ(run(states, "--no-filter --pairs all --threads 3").output, alone.output);
}

// An L with legs of 3 x 1 x 1 and a ball of radius 0.1 at (2.5, 2.5, 0.5): 1.5 from either leg, 1 / sqrt(2) from the
// bridge of the hull.
TEST_F(Clearance, MeshToleranceDecidesWhatStandsForAMesh) {
  files_.write("angle.obj",
               "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\n"
               "v 0 3 1\nf 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\n"
               "f 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n");
  urdf_ =
      files_.write("angle.urdf",
                   "<robot name='angle'><link name='angle'><collision><geometry><mesh filename='angle.obj'/></geometry>"
                   "</collision></link><link name='ball'><collision><geometry><sphere radius='0.1'/></geometry>"
                   "</collision></link><joint name='slide' type='prismatic'><parent link='angle'/><child link='ball'/>"
                   "<origin xyz='2.5 2.5 0.5'/><axis xyz='1 0 0'/><limit lower='0' upper='1' effort='1' velocity='1'/>"
                   "</joint></robot>");
  const auto answer = [&](const std::string& arguments) {
    const std::vector<std::vector<std::string>> rows = rowsOf(run("slide\n0\n", "--no-filter " + arguments).output);
    return std::make_pair(std::stod(rows.back()[3]), rows.back()[16]);
  };
  EXPECT_NEAR(answer("--mesh-tolerance 1.1").first, std::sqrt(0.5) - 0.1, 1e-9);
  EXPECT_EQ(answer("--mesh-tolerance 1.1").second, "convex_hull");
  EXPECT_NEAR(answer("--mesh-tolerance 0").first, 1.4, 1e-9);
  EXPECT_EQ(answer("--mesh-tolerance 0").second, "triangles");
  EXPECT_NEAR(answer("").first, 1.4, 1e-9);
}

TEST_F(Clearance, ReadsStandardInputAndWritesAFile) {
  const std::string out = files_.path("out.csv");
  const CommandResult result = runCommand("printf 'slide\\n0\\n' | " CLEARANCE " " + urdf_ + " --out " + out);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.output, "");
  EXPECT_EQ(runCommand("cat " + out).output, run("slide\n0\n", "").output);
}

TEST_F(Clearance, WritesTheStatesBeforeAnError) {
  const CommandResult result = run("slide\n0\n1\nnan\n", "");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(rowsOf(result.output).size(), 3U);
  EXPECT_TRUE(says(result.errors, "s.csv, line 4: column \"slide\": \"nan\" is no finite number")) << result.errors;
}

TEST_F(Clearance, EndsQuietlyWhereNobodyReadsOn) {
  files_.write("s.csv", wander(5000));
  const std::string errors = files_.path("errors");
  const CommandResult result = runCommand(CLEARANCE " " + urdf_ + " --no-filter --pairs all --states " +
                                          files_.path("s.csv") + " 2> " + errors + " | head -1");
  EXPECT_EQ(readFile(errors), run("slide\n0\n", "--no-filter").errors) << "nothing but the warnings of the model";
  EXPECT_EQ(rowsOf(result.output).size(), 1U);
}

}  // namespace proximity_server::tools::clearance_test
