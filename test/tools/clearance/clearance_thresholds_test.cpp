// Levels by thresholds: what --thresholds adds, held against all pairs.
#include "tools/program/clearance_command.h"
#include "tools/robot/robot_files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <map>

namespace proximity_server::tools::clearance_thresholds_test {

using namespace scene;

const std::vector<std::string> kLevels{"CLEAR", "WARN", "STOP", "COLLISION"};

/// The thresholds of the pairs in kFile, by the names of both links.
struct Thresholds {
  double stop, warn;
};
const std::map<std::string, Thresholds> kOwn{{"base|sled, left", {0.9, 1.7}}, {"ball|sled, left", {1.5, 3.0}}};
constexpr Thresholds kOthers{0.1, 3.2};
const char* const kFile = R"(stop_distance: 0.1
warn_distance: 3.2
pair_stop_distance: [{links: ["sled, left", base], distance: 0.9}, {links: [ball, "sled, left"], distance: 1.5}]
pair_warn_distance: [{links: [base, "sled, left"], distance: 1.7}, {links: [ball, "sled, left"], distance: 3}]
)";

/// A row as this test judges it, from the names and the bounds.
struct Judged {
  std::string state, links, level;
  double excess;  ///< [m] the distance less the threshold

  bool isWorseThan(const Judged& other) const {
    const auto rank = [](const std::string& name) { return std::find(kLevels.begin(), kLevels.end(), name); };
    return level != other.level ? rank(level) > rank(other.level) : excess < other.excess;
  }
};

Judged judge(const std::vector<std::string>& row) {
  const std::string links = std::min(row[1], row[2]) + "|" + std::max(row[1], row[2]);
  const auto own = kOwn.find(links);
  const Thresholds of = own == kOwn.end() ? kOthers : own->second;
  const double distance = std::stod(row[3]), lower = std::stod(row[4]);
  if (lower <= 0.0) return {row[0], links, "COLLISION", distance};
  if (lower <= of.stop) return {row[0], links, "STOP", distance - of.stop};
  return {row[0], links, lower <= of.warn ? "WARN" : "CLEAR", distance - of.warn};
}

/// The worst row of each state.
std::vector<Judged> worstOfEachState(const std::vector<std::vector<std::string>>& rows) {
  std::vector<Judged> worst;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Judged row = judge(rows[i]);
    if (worst.empty() || worst.back().state != row.state)
      worst.push_back(row);
    else if (row.isWorseThan(worst.back()))
      worst.back() = row;
  }
  return worst;
}

class ClearanceThresholds : public Clearance {
 protected:
  std::string thresholds(const std::string& text = kFile) {
    return " --thresholds " + files_.write("thresholds.yaml", text);
  }

  /// The slider at random places, also in contact with the base.
  static std::string states() { return wander(1000, -1.1, 3); }
};

TEST_F(ClearanceThresholds, EachPairHasTheLevelOfItsOwnThresholds) {
  for (const std::string pairs : {"all", "k:2", "below:2.9"}) {
    const auto rows = rowsOf(run(states(), "--no-filter --pairs " + pairs + thresholds()).output);
    ASSERT_GT(rows.size(), 500U) << pairs;
    EXPECT_EQ(rows[0].back(), "level");
    EXPECT_EQ(rows[0].size(), 18U);
    std::map<std::string, int> count;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      ASSERT_EQ(rows[i].back(), judge(rows[i]).level) << pairs << ", row " << i;
      ++count[rows[i].back()];
    }
    EXPECT_EQ(count.size(), 4U) << pairs;
  }
}

TEST_F(ClearanceThresholds, TheMinimumIsThePairThatSetsTheLevel) {
  const auto listed = rowsOf(run(states(), "--no-filter" + thresholds()).output);
  const auto closest = rowsOf(run(states(), "--no-filter").output);
  const std::vector<Judged> worst = worstOfEachState(rowsOf(run(states(), "--no-filter --pairs all").output));
  ASSERT_EQ(worst.size(), 1000U);
  ASSERT_EQ(listed.size(), 1001U);
  int others = 0;
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const Judged row = judge(listed[i + 1]);
    ASSERT_EQ(row.links + row.level, worst[i].links + worst[i].level) << "state " << i;
    ASSERT_EQ(listed[i + 1].back(), worst[i].level);
    ASSERT_NEAR(row.excess, worst[i].excess, 1e-9);
    others += judge(closest[i + 1]).links != row.links;
  }
  EXPECT_GT(others, 200);
  EXPECT_LT(others, 900);
}

// SceneBatch answers where there is a filter: the robot has four balls on rails, 0.1 and 0.2 m apart.
TEST_F(ClearanceThresholds, TheMinimumIsThePairThatSetsTheLevelWithTheFilterToo) {
  std::string links = "<link name='base'/>";
  for (const char* name : {"a", "b", "c", "d"})
    links += std::string("<link name='") + name +
             "'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>" + "<joint name='to_" + name +
             "' type='prismatic'><parent link='base'/><child link='" + name +
             "'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>";
  urdf_ = files_.write("balls.urdf", "<robot name='balls'>" + links + "</robot>");
  const std::string place = "to_a,to_b,to_c,to_d\n0,0.3,0.7,2\n0,0.3,0.6,2\n0,0.15,0.7,2\n0,0.9,1.8,2.7\n";
  const std::string own = thresholds(R"(
pair_stop_distance: [{links: [b, c], distance: 0.15}]
pair_warn_distance: [{links: [c, b], distance: 0.25}])");
  const auto rows = rowsOf(run(place, own).output);
  ASSERT_EQ(rows.size(), 5U);
  const auto told = [&](std::size_t i) { return rows[i][1] + rows[i][2] + " " + rows[i].back(); };
  EXPECT_EQ(told(1), "bc WARN");       // at 0.2, and a - b, at 0.1, is clear
  EXPECT_EQ(told(2), "bc STOP");       // both are at 0.1
  EXPECT_EQ(told(3), "ab COLLISION");  // by 0.05, and b - c is clear at 0.35
  EXPECT_EQ(told(4), "bc CLEAR");      // 0.7 less 0.25, and a - b is at 0.7 less 0.05
  EXPECT_EQ(run(place, own + " --no-skip").output, run(place, own).output);

  // Between two states the worst level, from when on, and the pair.
  const auto segments = rowsOf(run("time,to_a,to_b,to_c,to_d\n0,0,0.3,0.7,2\n1,0,0.3,0.6,2\n2,0,0.15,0.7,2\n"
                                   "3,0,0.9,1.8,2.7\n4,0,0.9,1.8,2.7\n",
                                   own + " --trajectory")
                                   .output);
  ASSERT_EQ(segments.size(), 5U);
  const auto expectLevel = [&](std::size_t segment, const std::string& level, double time, const std::string& pair) {
    const std::vector<std::string>& row = segments[segment + 1];
    EXPECT_EQ(row[25] + " " + row[27] + row[28], level + " " + pair) << "segment " << segment;
    EXPECT_NEAR(std::stod(row[26]), time, 1e-5) << "segment " << segment;
  };
  expectLevel(0, "STOP", 0.5, "bc");  // from 0.2 to 0.1, and a - b stays at 0.1
  expectLevel(1, "COLLISION", 1.0 + 2.0 / 3.0, "ab");
  expectLevel(2, "COLLISION", 2.0, "ab");
  EXPECT_EQ(segments[4][25] + segments[4][27], "CLEAR");
}

TEST_F(ClearanceThresholds, PairsWithObjectsHaveThoseOfTheirLink) {
  files_.write("cell.yaml", R"(objects:
- {id: wall, pose: {position: [2, 3, 0]}, primitives: [{type: BOX, dimensions: [1, 1, 1]}]}
)");
  // The sled is at 2 m from the wall, and 2.25 m from the ball.
  const std::string own = thresholds(R"(
object_stop_distance: 1
object_warn_distance: 1
link_stop_distance: {"sled, left": 2.05}
link_warn_distance: {"sled, left": 2.1})");
  const std::string arguments = "--objects " + files_.path("cell.yaml") + own;
  const auto rows = rowsOf(run("slide\n0\n", arguments).output);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][1] + "|" + rows[1][2] + "|" + rows[1].back(), "sled, left|wall|STOP");
}

TEST_F(ClearanceThresholds, JsonHasTheLevelToo) {
  const auto json = nlohmann::json::parse(run("slide\n0\n", "--format json" + thresholds()).output);
  EXPECT_EQ(json[0]["level"], "WARN");  // sled and ball at 2.25
}

TEST_F(ClearanceThresholds, AStateWithoutAnAnswerIsInvalid) {
  const auto rows = rowsOf(run("slide\n1.7e308\n", thresholds()).output);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1].back(), "INVALID");
}

TEST_F(ClearanceThresholds, AssertAboveIsAboutTheClosestPairStill) {
  // At -0.95 base and sled are 0.05 apart, but the ball, 1.3 m from the sled, is farther below its threshold.
  const std::string own = thresholds(R"(
pair_stop_distance: [{links: [ball, "sled, left"], distance: 2}]
pair_warn_distance: [{links: [ball, "sled, left"], distance: 2}])");
  const CommandResult result = run("slide\n-0.95\n", "--no-filter --assert-above 0.04" + own);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(rowsOf(result.output)[1][1], "ball");
  EXPECT_EQ(run("slide\n-0.95\n", "--no-filter --assert-above 0.06" + thresholds()).exit_code, 2);
}

TEST_F(ClearanceThresholds, TheSummaryCountsStatesByLevel) {
  const std::vector<Judged> worst = worstOfEachState(rowsOf(run(states(), "--no-filter --pairs all").output));
  std::map<std::string, int> expected;
  for (const Judged& state : worst) ++expected[state.level];
  ASSERT_EQ(expected.size(), 4U);
  for (const std::string pairs : {"minimum", "all"}) {
    const CommandResult result =
        run(states(), "--no-filter --pairs " + pairs + " --summary " + files_.path("summary.json") + thresholds());
    const auto summary = nlohmann::json::parse(readTextFile(files_.path("summary.json")));
    EXPECT_EQ((summary["levels"].get<std::map<std::string, int>>()), expected) << pairs;
    EXPECT_TRUE(says(result.errors, ", " + std::to_string(expected["STOP"]) + " STOP")) << result.errors;
  }
  run(states(), "--pairs k:1 --summary " + files_.path("summary.json") + thresholds());
  EXPECT_FALSE(says(readTextFile(files_.path("summary.json")), "levels"));
}

TEST_F(ClearanceThresholds, MergedPartsHaveTheBytesOfOneRunAndOthersAreRefused) {
  const std::string out = files_.path("parts"), whole = files_.path("whole");
  for (const std::string format : {"csv", "json"}) {
    std::filesystem::remove_all(out);
    const std::string question = "--format " + format + thresholds();
    for (const std::string shard : {"1/2", "2/2"})
      ASSERT_EQ(run(states(), question + " --shard " + shard + " --out " + out).exit_code, 0);
    ASSERT_EQ(run(states(), question + " --out " + whole + " --summary " + whole + ".json").exit_code, 0);
    const CommandResult merged = runCommandApart(CLEARANCE " --merge " + out + " --out " + files_.path("merged") +
                                                 " --summary " + files_.path("merged.json"));
    ASSERT_EQ(merged.exit_code, 0) << merged.errors;
    EXPECT_EQ(readTextFile(files_.path("merged")), readTextFile(whole));
    EXPECT_EQ(readTextFile(files_.path("merged.json")), readTextFile(whole + ".json"));
  }
  const std::string again = "--format json --shard 2/2 --out " + out;
  const auto expectDifference = [&](const CommandResult& result) {
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(says(result.errors, "question.thresholds")) << result.errors;
  };
  expectDifference(run(states(), again));
  expectDifference(run(states(), again + thresholds("stop_distance: 0.01\n")));
}

}  // namespace proximity_server::tools::clearance_thresholds_test
