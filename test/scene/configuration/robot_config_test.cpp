// What a file with the node's parameters says about a robot.

#include "proximity_server/scene/configuration/robot_config.h"
#include "scene/files.h"

#include <gtest/gtest.h>

namespace proximity_server::scene::robot_config_test {

using Lines = std::vector<std::string>;

std::string refusalOf(const std::string& yaml) {
  return errorOf([&] { configFrom(yaml, "cell.yaml"); });
}

// --- thresholds alone

TEST(ThresholdFile, HasTheNamesOfTheParameters) {
  const ConfigFile file = thresholdsFrom(R"(
stop_distance: 0.01
object_warn_distance: 0.2
pair_stop_distance: [{links: [a, b], distance: 0.003}, {links: [c, a], distance: 0}]
link_warn_distance: {a: 0.3}
group_stop_distance: {left: 0.02}
)",
                                         "cell.yaml");
  EXPECT_EQ(file.levels.stop_distance, 0.01);
  EXPECT_EQ(file.levels.object_stop_distance, 0.02);
  EXPECT_EQ(file.levels.object_warn_distance, 0.2);
  const ThresholdRules& rules = file.robot.thresholds;
  ASSERT_EQ(rules.stop.of_pairs.size(), 2u);
  EXPECT_EQ(rules.stop.of_pairs[0].first.second, "b");
  EXPECT_EQ(rules.stop.of_pairs[0].second, 0.003);
  EXPECT_EQ(rules.warn.of_links.at("a"), 0.3);
  EXPECT_EQ(rules.stop.of_groups.at("left"), 0.02);
}

TEST(ThresholdFile, IsRefusedWithTheLineAndTheField) {
  const auto refusal = [](const std::string& yaml) { return errorOf([&] { thresholdsFrom(yaml, "cell.yaml"); }); };
  EXPECT_EQ(refusal("pair_stop_distances: []"),
            "cell.yaml, line 1: pair_stop_distances is unknown: did you mean 'pair_stop_distance'?");
  EXPECT_EQ(refusal("link_stop_distance:\n  a: -0.1"),
            "cell.yaml, line 2: link_stop_distance/a is -0.1, outside of [0, 100]");
  EXPECT_EQ(refusal("pair_warn_distance: [{links: [a], distance: 1}]"),
            "cell.yaml, line 1: pair_warn_distance must name two links per pair");
  EXPECT_EQ(refusal("stop_distance: 0.1"),
            "cell.yaml: stop_distance is 0.1, above warn_distance, which is 0.05: the level WARN comes before STOP");
  EXPECT_EQ(refusal("[0.1]"), "cell.yaml: must map names to distances");
}

// --- all that is about a robot

TEST(ConfigFile, HasWhatTheNodeWouldReadAboutTheRobot) {
  const ConfigFile file = configFrom(R"(
default_padding: 0.01
link_padding: {wrist: 0.02}
link_mesh_tolerance: {hand: 0.001}
collision_from_visual: all
pair_padding: [{links: [wrist, torso], padding: 0.05}]
exclude_pairs: [[wrist, torso]]
only_pairs: [[hand, torso]]
group: arm
joint_inequalities: ["2*j1 - j2 <= 1.7"]
tolerance: 1.0e-6
stop_distance: 0.03
link_warn_distance: {wrist: 0.4}
joint_uncertainty: {"*": 0.001}
objects: [{id: ball, primitives: [{type: SPHERE, dimensions: [0.1]}]}]
check_free_objects: true
)",
                                     "cell.yaml");
  const RobotConfig& robot = file.robot;
  EXPECT_EQ(file.warnings, Lines());
  EXPECT_EQ(robot.model.paddingOf("elbow"), 0.01);
  EXPECT_EQ(robot.model.paddingOf("wrist"), 0.02);
  EXPECT_EQ(robot.model.meshToleranceOf("hand"), 0.001);
  EXPECT_EQ(robot.model.collision_from_visual, Lines{"all"});
  ASSERT_EQ(robot.filter.pair_padding.size(), 1u);
  EXPECT_EQ(robot.filter.pair_padding[0].second, 0.05);
  ASSERT_EQ(robot.filter.exclude_pairs.size(), 1u);
  EXPECT_EQ(robot.filter.only_pairs.at(0).first, "hand");
  EXPECT_EQ(robot.filter.group, "arm");
  EXPECT_EQ(robot.tolerance, 1e-6);
  EXPECT_EQ(file.levels.stop_distance, 0.03);
  EXPECT_EQ(robot.thresholds.warn.of_links.at("wrist"), 0.4);
  ASSERT_EQ(robot.objects.objects.size(), 1u);
  EXPECT_EQ(robot.objects.objects[0].id, "ball");
  EXPECT_EQ(robot.free_objects, ObjectRules::FreeObjects::Checked);
  EXPECT_TRUE(std::holds_alternative<FileValue::Map>(robot.uncertainty.joint.content));
}

TEST(ConfigFile, SaysWhatOnlyANodeUsesAndWhatNothingUses) {
  EXPECT_EQ(configFrom("rate: 100\nlink_pading: {a: 0.1}\ntf_prefix: left\nstop_distance: 0.01", "cell.yaml").warnings,
            (Lines{R"(cell.yaml: parameter "link_pading" (did you mean "link_padding"?) has no effect)",
                   "cell.yaml: only a running node uses rate, tf_prefix"}));
}

TEST(ConfigFile, MayBeADumpOfTheParameterServer) {
  const ConfigFile file = configFrom(
      "robot_description: \"<robot/>\"\nrun_id: 7\ncell:\n  proximity_server:\n    default_padding: 0.02\n    rate: "
      "50.0",
      "dump.yaml");
  EXPECT_EQ(file.robot.model.default_padding, 0.02);
  EXPECT_EQ(file.warnings, Lines{"dump.yaml: only a running node uses rate"});
}

TEST(ConfigFile, IsRefusedWithTheLineAndTheName) {
  EXPECT_EQ(refusalOf("rate: 50\nlink_padding:\n  hand: 0.1\n  wrist: -1"),
            "cell.yaml, line 4: link_padding/wrist is -1, outside of [0, 10]");
  EXPECT_EQ(refusalOf("exclude_pairs: [wrist, torso]"),
            "cell.yaml, line 1: exclude_pairs must be a list of pairs, with brackets around each of them: "
            "[[wrist, torso]]");
  EXPECT_EQ(refusalOf("rate: 50\nrobots: {left: {description: /left}}"),
            "cell.yaml, line 2: robots describes several robots, but the URDF is one");
  EXPECT_EQ(refusalOf("colour: red"), "cell.yaml: there is no parameter of the node in it");
  EXPECT_EQ(refusalOf("a: {group: arm}\nb: {tolerance: 2}"),
            "cell.yaml: lines 1 and 2 both begin parameters of a node; rosparam dump FILE /NODE writes those of one");
  EXPECT_EQ(refusalOf("default_padding: null"), "cell.yaml, line 1: default_padding must be a number");
  EXPECT_EQ(refusalOf("stop_distance: 0.2"),
            "cell.yaml: stop_distance is 0.2, above warn_distance, which is 0.05: the level WARN comes before STOP");
}

}  // namespace proximity_server::scene::robot_config_test
