#include "proximity_server/scene/levels/always_near.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

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
  const RobotModel robot = robotOf(urdfOf(link("wrist_2_link") + link("1.0") + weld("j", "wrist_2_link", "1.0")));
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

// The eye is 0.01 from the face, whatever "turn" does, and the nose from -0.02 to 0.06 by "slide". The plug is always
// in the face, and the fly has no limits.
const std::string kHead = urdfOf(
    link("face", ball("0.5")) + link("eye", ball("0.1")) + link("nose", ball("0.1")) + link("plug", ball("0.1")) +
        link("fly", ball("0.1")) + hinge("turn", "face", "eye", "0 0 1", "0 0 0.61") +
        joint("slide", "prismatic", "face", "nose", origin("0.6 0 0") + axis("1 0 0") + limits("-0.02", "0.06")) +
        hinge("spin", "face", "plug", "0 0 1", "0 -0.5 0") +
        joint("buzz", "floating", "face", "fly", origin("0 0.61 0")),
    "head");

SceneModel headChecking(const std::vector<std::string>& links) {
  std::string enabled;
  for (const std::string& link : links) enabled += "<enable_collisions link1='face' link2='" + link + "'/>";
  return makeSceneModel(robotOf(kHead), "<robot name='head'>" + enabled + "</robot>");
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
