// What --config takes from a file of the node's parameters, on paper.
#include "robots/urdf.h"
#include "tools/program/clearance_command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace proximity_server::tools::clearance_config_test {

/// Three balls of radius 0.1 on one rail, each with a joint of its own: a and b are 0.1 m apart, b and c 0.12 m.
class ClearanceConfig : public Clearance {
 protected:
  ClearanceConfig() {
    const std::string ball = robots::ball("0.1");
    urdf_ = files_.write("balls.urdf", robots::onRail({{"a", ball}, {"b", ball}, {"c", ball}}));
  }

  CommandResult runWith(const std::string& yaml, const std::string& arguments = "") {
    return run("to_a,to_b,to_c\n0,0.3,0.62\n", "--config " + files_.write("cell.yaml", yaml) + " " + arguments);
  }

  /// The first row, by the names of the columns.
  std::map<std::string, std::string> rowWith(const std::string& yaml, const std::string& arguments = "") {
    const CommandResult result = runWith(yaml, arguments);
    const auto rows = rowsOf(result.output);
    std::map<std::string, std::string> row;
    if (rows.size() < 2) ADD_FAILURE() << result.errors;
    for (std::size_t i = 0; rows.size() > 1 && i < rows[0].size(); ++i) row[rows[0][i]] = rows[1][i];
    return row;
  }

  void expectPair(const std::map<std::string, std::string>& row, const std::string& links, double distance) {
    EXPECT_EQ(row.at("link_a") + row.at("link_b"), links);
    EXPECT_NEAR(std::stod(row.at("distance")), distance, 1e-12);
  }
};

TEST_F(ClearanceConfig, PaddingAndPairsAreThoseOfTheNode) {
  expectPair(rowWith("link_padding: {b: 0.02}"), "ab", 0.08);
  expectPair(rowWith("default_padding: 0.01\npair_padding: [{links: [c, b], padding: 0.05}]"), "bc", 0.12 - 0.07);
  expectPair(rowWith("exclude_pairs: [[a, b]]"), "bc", 0.12);
  expectPair(rowWith("only_pairs: [[a, c]]"), "ac", 0.42);
}

TEST_F(ClearanceConfig, VisualsCountAsInTheNode) {
  std::string urdf = readFile(urdf_);
  for (const std::string kind : {"collision", "/collision"})
    urdf.replace(urdf.find("<" + kind + ">", urdf.find("name='b'")) + kind.size() - 8, 9, "visual");
  files_.write("balls.urdf", urdf);
  const std::string srdf =
      "--srdf " +
      files_.write("balls.srdf", "<robot name='sliders'><group name='middle'><link name='b'/></group></robot>");
  expectPair(rowWith("rate: 50"), "ac", 0.42);
  EXPECT_TRUE(says(runWith("rate: 50").errors, "1 of 1 links with a <visual>: b. The parameter collision_from_visual"));
  expectPair(rowWith("collision_from_visual: all"), "ab", 0.1);
  expectPair(rowWith("collision_from_visual: [b]"), "ab", 0.1);
  expectPair(rowWith("collision_from_visual: [middle]", srdf), "ab", 0.1);
}

TEST_F(ClearanceConfig, LevelsAreThoseOfTheNodeWithItsDefaults) {
  EXPECT_EQ(rowWith("rate: 50").at("level"), "CLEAR");
  EXPECT_EQ(rowWith("warn_distance: 0.11").at("level"), "WARN");
  const auto row = rowWith("pair_warn_distance: [{links: [b, c], distance: 0.13}]");
  EXPECT_EQ(row.at("level"), "WARN");
  expectPair(row, "bc", 0.12);
  EXPECT_EQ(rowWith("warn_distance: 0.2", "--thresholds " + files_.write("t.yaml", "warn_distance: 0.05")).at("level"),
            "CLEAR");
}

TEST_F(ClearanceConfig, LevelsAreDecidedWithinTheUncertainty) {
  const std::string levels = "warn_distance: 0.09\n";
  EXPECT_EQ(rowWith(levels).at("level"), "CLEAR");
  const auto row = rowWith(levels + "joint_uncertainty: {to_c: 0.04}");
  EXPECT_EQ(row.at("level"), "WARN");
  expectPair(row, "bc", 0.12);
  EXPECT_NEAR(std::stod(row.at("guaranteed")), 0.08, 1e-12);
  for (const std::string pairs : {"all", "k:3", "below:1"}) {
    const auto rows = rowsOf(runWith(levels + "joint_uncertainty: {to_c: 0.04}", "--pairs " + pairs).output);
    ASSERT_EQ(rows.size(), 4U) << pairs;
    const auto level = std::find(rows[0].begin(), rows[0].end(), "level") - rows[0].begin();
    for (std::size_t i = 1; i < rows.size(); ++i)
      EXPECT_EQ(rows[i][level], rows[i][1] + rows[i][2] == "bc" ? "WARN" : "CLEAR") << pairs;
  }
}

TEST_F(ClearanceConfig, ObjectsStandThereFromTheStart) {
  const std::string ball =
      "objects: [{id: ball, pose: {position: [0, 0.25, 0]}, primitives: [{type: SPHERE, "
      "dimensions: [0.1]}]}]\n";
  expectPair(rowWith(ball), "aball", 0.05);
  expectPair(rowWith(ball, "--objects " + files_.write("none.yaml", "[]")), "ab", 0.1);
  EXPECT_EQ(rowWith(ball + "object_warn_distance: 0.06").at("level"), "WARN");
  expectPair(rowWith(ball + "reference_frame: c"), "cball", 0.05);  // c is at 0.62
}

}  // namespace proximity_server::tools::clearance_config_test
