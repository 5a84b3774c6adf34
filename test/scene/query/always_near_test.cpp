#include "proximity_server/scene/query/always_near.h"

#include <gtest/gtest.h>

#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/object_files/file_value.h"

namespace proximity_server::scene::always_near_test {

constexpr StopAndWarn kUsual{0.02, 0.05};

AlwaysNear seen(double smallest, double largest) { return {{{0, 0}, {1, 0}}, smallest, largest}; }

struct Case {
  double smallest, largest, stop, warn;
};

TEST(FittingThresholds, AreBetweenContactAndTheUsualDistances) {
  const Case cases[] = {
      {0.0156, 0.0156, 0.0078, 0.011},  // half, and three quarters of the only distance, rounded down
      {0.011, 0.0205, 0.0055, 0.0082},  // of the smallest
      {0.0, 0.0177, 0.0044, 0.0066},    // may touch: of half of the largest
      {0.0003, 0.016, 0.004, 0.006},    // the same
      {0.0015, 0.0016, 0.00075, 0.0011},  // hardly moves: of the smallest
      {0.0455, 0.0455, 0.02, 0.034},    // not above what is usual
      {0.0, 0.0, 0.0, 0.0},
  };
  for (const Case& each : cases) {
    const StopAndWarn found = fittingThresholds(seen(each.smallest, each.largest), kUsual);
    EXPECT_DOUBLE_EQ(found.stop, each.stop) << each.smallest << " to " << each.largest;
    EXPECT_DOUBLE_EQ(found.warn, each.warn) << each.smallest << " to " << each.largest;
  }
}

TEST(FittingThresholds, StopIsBelowWarnAndWarnBelowWhatWasSeenForAnyLength) {
  for (double length = 2e-6; length < 0.05; length *= 1.37) {
    const StopAndWarn found = fittingThresholds(seen(length, length), kUsual);
    EXPECT_GT(found.stop, 0.0);
    EXPECT_LT(found.stop, found.warn) << length;
    EXPECT_LT(found.warn, length);
  }
}

TEST(AlwaysNear, SaysWhatWasSeen) {
  EXPECT_EQ(distancesText(seen(0.01562, 0.01563)), "stays at 15.6 mm");
  EXPECT_EQ(distancesText(seen(0.011, 0.0205)), "has 11 mm to 20.5 mm");
  EXPECT_EQ(distancesText(seen(0.0, 0.0177)), "has contact to 17.7 mm");
}

TEST(AlwaysNear, YamlHasBothThresholdsOfEachPair) {
  const RobotModel robot = loadRobotModel(
      R"(<robot name="r"><link name="wrist_2_link"/><link name="1.0"/><joint name="j" type="fixed"><parent link="wrist_2_link"/>
         <child link="1.0"/></joint></robot>)",
      [](const std::string& uri) { return uri; });
  const std::string yaml = thresholdsYaml(robot, {seen(2e-5, 2e-5)}, kUsual);
  EXPECT_EQ(yaml,
            "pair_stop_distance:\n- {links: [wrist_2_link, \"1.0\"], distance: 0.00001}  # stays at 0.02 mm\n"
            "pair_warn_distance:\n- {links: [wrist_2_link, \"1.0\"], distance: 0.000015}  # stays at 0.02 mm\n");
  const auto members = std::get<FileValue::Map>(readYaml(yaml, "thresholds").content);
  ASSERT_EQ(members.size(), 2U);
  EXPECT_EQ(members[1].name, "pair_warn_distance");
  EXPECT_EQ(thresholdsYaml(robot, {}, kUsual), "pair_stop_distance: []\npair_warn_distance: []\n");
}

TEST(AlwaysNear, NamesAreReadBackAsTexts) {
  for (const std::string name : {"base", "no", "Off", "link_1.0", "1.0", "~", "a b", "sled, left", "quo\"te", "back\\slash", ""}) {
    const FileValue value = readYaml("[" + yamlName(name) + "]", "names");
    EXPECT_EQ(std::get<std::string>(std::get<FileValue::List>(value.content).at(0).content), name);
  }
  EXPECT_EQ(yamlName("base"), "base");
  EXPECT_EQ(yamlName("Off"), "\"Off\"");  // the YAML of rosparam reads it as false
}

}  // namespace proximity_server::scene::always_near_test
