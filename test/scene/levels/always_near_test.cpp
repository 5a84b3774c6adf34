#include "proximity_server/scene/levels/always_near.h"

#include <gtest/gtest.h>

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/object_files/file_value.h"

namespace proximity_server::scene::always_near_test {

constexpr StopAndWarn kUsual{0.02, 0.05};

AlwaysNear seen(double smallest, double largest) { return {{{0, 0}, {1, 0}}, smallest, largest}; }

struct Case {
  double smallest, largest, stop, warn;
};

TEST(FittingThresholds, AreBetweenContactAndTheUsualDistances) {
  const Case cases[] = {
      {0.0156, 0.0156, 0.0078, 0.011},    // half, and three quarters of the only distance, rounded down
      {0.011, 0.0205, 0.0055, 0.0082},    // of the smallest
      {0.0, 0.0177, 0.0044, 0.0066},      // may touch: of half of the largest
      {0.0003, 0.016, 0.004, 0.006},      // the same
      {0.0015, 0.0016, 0.00075, 0.0011},  // hardly moves: of the smallest
      {0.0455, 0.0455, 0.02, 0.034},      // not above what is usual
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
  EXPECT_EQ(distancesText(seen(0.011, 0.0205)), "stays between 11 mm and 20.5 mm");
  EXPECT_EQ(distancesText(seen(0.0, 0.0177)), "stays between contact and 17.7 mm");
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
  for (const std::string name :
       {"base", "no", "Off", "link_1.0", "1.0", "~", "a b", "sled, left", "quo\"te", "back\\slash", ""}) {
    const FileValue value = readYaml("[" + yamlName(name) + "]", "names");
    EXPECT_EQ(std::get<std::string>(std::get<FileValue::List>(value.content).at(0).content), name);
  }
  EXPECT_EQ(yamlName("base"), "base");
  EXPECT_EQ(yamlName("Off"), "\"Off\"");  // the YAML of rosparam reads it as false
}

// The eye is 0.01 from the face, whatever "turn" does, and the nose from -0.02 to 0.06 by "slide". The plug is always in the face, and
// the fly has no limits.
const char* const kHead = R"(<robot name="head">
  <link name="face"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="eye"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="nose"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="plug"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="fly"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="face"/><child link="eye"/><origin xyz="0 0 0.61"/><axis xyz="0 0 1"/></joint>
  <joint name="slide" type="prismatic"><parent link="face"/><child link="nose"/><origin xyz="0.6 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-0.02" upper="0.06" effort="1" velocity="1"/></joint>
  <joint name="spin" type="continuous"><parent link="face"/><child link="plug"/><origin xyz="0 -0.5 0"/><axis xyz="0 0 1"/></joint>
  <joint name="buzz" type="floating"><parent link="face"/><child link="fly"/><origin xyz="0 0.61 0"/></joint>
</robot>)";

SceneModel headChecking(const std::vector<std::string>& links) {
  std::string enabled;
  for (const std::string& link : links) enabled += "<enable_collisions link1='face' link2='" + link + "'/>";
  return makeSceneModel(loadRobotModel(kHead, packageResolver({})), "<robot name='head'>" + enabled + "</robot>");
}

TEST(FindAlwaysNear, FindsPairsThatNoStateTakesApart) {
  const SceneModel head = headChecking({"eye", "nose", "plug", "fly"});
  const std::vector<AlwaysNear> found = findAlwaysNear(head, 0.02);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(
      adviceText(head.robot, found[0], kUsual),
      "face - eye stays at 10 mm whatever turn does: pair_stop_distance: [{links: [face, eye], distance: 0.005}], "
      "pair_warn_distance: [{links: [face, eye], distance: 0.0075}]");
}

TEST(FindAlwaysNear, MeasuresTheDistancesOfTheStates) {
  const SceneModel head = headChecking({"nose"});
  EXPECT_TRUE(findAlwaysNear(head, 0.05).empty());
  const std::vector<AlwaysNear> found = findAlwaysNear(head, 0.06);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].smallest, 0.0);
  EXPECT_GT(found[0].largest, 0.055);
  EXPECT_LE(found[0].largest, 0.06);
}

TEST(FindAlwaysNear, LooksOnlyAtWhatIsChecked) { EXPECT_TRUE(findAlwaysNear(headChecking({}), 0.02).empty()); }

}  // namespace proximity_server::scene::always_near_test
