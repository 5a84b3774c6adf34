// --points: rows about points, and what is refused. test/python/point_test.py holds the numbers against the module.
#include "tools/program/clearance_command.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::tools::clearance_points_test {

using Table = std::vector<std::vector<std::string>>;

class ClearancePoints : public Clearance {
 protected:
  std::string points(const std::string& csv) { return "--points " + files_.write("points.csv", csv) + " "; }

  Table rows(const std::string& csv, const std::string& arguments = "") {
    const CommandResult result = run("slide\n0\n0.5\n", points(csv) + arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return rowsOf(result.output);
  }
};

/// A row as it can be worked out on paper.
struct Expected {
  std::string state, link, point;
  double distance;
};

void expectRows(const Table& rows, const std::vector<Expected>& expected) {
  ASSERT_EQ(rows.size(), expected.size() + 1);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const std::vector<std::string>& row = rows[i + 1];
    EXPECT_EQ(row[0], expected[i].state);
    EXPECT_EQ(row[1], expected[i].link);
    EXPECT_EQ(row[2], expected[i].point);
    EXPECT_NEAR(std::stod(row[3]), expected[i].distance, 1e-12);
  }
}

// The sled begins at 1.5 and at 2, and the ball is about 5 and 6. The third one is a ball of 1 m, 3 m above the mast.
const std::string kPoints = "x,y,z,radius\n1.125,0,0,0\n\n5,0,0,0\n0,4,3,1\n";

TEST_F(ClearancePoints, TheClosestPointOfEachStateHasARow) {
  const Table found = rows(kPoints);
  expectRows(found, {{"0", "ball", "1", -0.25}, {"1", "base", "0", 0.625}});
  EXPECT_EQ(found[0][1], "link_a");
  EXPECT_EQ(found[0][2], "point");
  expectRows(rows("x,y,z\n0,4,3\n"), {{"0", "mast", "0", 2.5}, {"1", "mast", "0", 2.5}});
}

TEST_F(ClearancePoints, PairsAllHasARowForEachPointInTheOrderOfTheFile) {
  expectRows(rows(kPoints, "--pairs all"), {{"0", "sled, left", "0", 0.375},
                                            {"0", "ball", "1", -0.25},
                                            {"0", "mast", "2", 1.5},
                                            {"1", "base", "0", 0.625},
                                            {"1", "ball", "1", 0.75},
                                            {"1", "mast", "2", 1.5}});
}

TEST_F(ClearancePoints, BelowAndTheClosestAreSorted) {
  expectRows(rows(kPoints, "--pairs below:0.7"),
             {{"0", "ball", "1", -0.25}, {"0", "sled, left", "0", 0.375}, {"1", "base", "0", 0.625}});
  expectRows(rows(kPoints, "--pairs k:2"), {{"0", "ball", "1", -0.25},
                                            {"0", "sled, left", "0", 0.375},
                                            {"1", "base", "0", 0.625},
                                            {"1", "ball", "1", 0.75}});
}

TEST_F(ClearancePoints, WhatALinkHoldsCounts) {
  const std::string held = files_.write(
      "held.yaml",
      "objects:\n- {id: cup, link: \"sled, left\", pose: {position: [0, 2, 0]}, primitives: "
      "[{type: SPHERE, dimensions: [0.5]}]}\n- {id: table, primitives: [{type: SPHERE, dimensions: [0.5]}], "
      "pose: {position: [2, -9, 0]}}\n");
  expectRows(rows("x,y,z\n2,3,0\n2,-8,0\n", "--pairs all --objects " + held),
             {{"0", "cup", "0", 0.5},
              {"0", "sled, left", "1", 7.5},
              {"1", "cup", "0", std::hypot(0.5, 1.0) - 0.5},
              {"1", "sled, left", "1", 7.5}});
}

TEST_F(ClearancePoints, AStateWithoutAnAnswerHasARowWithoutAPoint) {
  const std::string far = "slide\n1e308\n";
  const auto json = nlohmann::json::parse(run(far, points(kPoints) + "--format json").output);
  ASSERT_EQ(json.size(), 1U);
  EXPECT_TRUE(json[0].at("point").is_null());
  EXPECT_EQ(json[0].at("status"), "unknown");
  EXPECT_EQ(run(far, points(kPoints) + "--assert-above 0 --out /dev/null").exit_code, 2);
  const Table all = rowsOf(run(far, points(kPoints) + "--pairs all").output);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[3][2], "2");
  EXPECT_EQ(all[3][15], "unknown");
}

TEST_F(ClearancePoints, AnAssertionIsAboutTheClosestPoint) {
  const std::string at_half = "slide\n0.5\n";
  for (const std::string pairs : {"minimum", "all", "below:0.1"}) {
    const std::string arguments = points(kPoints) + "--pairs " + pairs + " --out /dev/null --assert-above ";
    EXPECT_EQ(run(at_half, arguments + "0.62").exit_code, 0) << pairs;
    const CommandResult refuted = run(at_half, arguments + "0.63");
    EXPECT_EQ(refuted.exit_code, 2) << pairs;
    EXPECT_TRUE(says(refuted.errors, "state 0: base - point 0 at 0.625 m")) << refuted.errors;
  }
}

}  // namespace proximity_server::tools::clearance_points_test
