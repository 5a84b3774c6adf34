#include "node/robot/robot.h"

#include "node/answers/conversions.h"
#include "node/monitor/monitored_objects.h"
#include "node/robot/load_config.h"
#include "node/tf/joint_frames.h"
#include "proximity_server/scene/model/names.h"
#include "robots/urdf.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "scene/walker.h"

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <string>
#include <tuple>

// Several robots in one node: their parameters, frames and transforms.

namespace proximity_server::node::robot_test {

using XmlRpc::XmlRpcValue;

using namespace robots;

const std::string kArm = urdfOf(link("base", box("0.2 0.2 0.2")) + link("hand", ball("0.1")) +
                                    joint("slide", "prismatic", "base", "hand", axis("1 0 0") + limits("0", "2")),
                                "arm");

/// {left: {description: /left, tf_prefix: left}, right: the same}
XmlRpcValue leftAndRight() {
  XmlRpcValue values;
  for (const std::string name : {"left", "right"}) {
    values["robots"][name]["description"] = "/" + name;
    values["robots"][name]["tf_prefix"] = name;
  }
  return values;
}

Robot twoArms(const XmlRpcValue& values) {
  return {std::vector<RobotTexts>{{kArm, ""}, {kArm, ""}}, configFrom(values, "/node")};
}

void expectRefusal(const XmlRpcValue& values, const std::string& message) {
  EXPECT_EQ(scene::errorOf([&] { configFrom(values, "/node"); }), message);
}

// --- parameters

TEST(RobotsOfTheParameters, HaveDefaults) {
  XmlRpcValue values;
  values["robots"]["left"]["description"] = "/left/robot_description";
  const std::vector<RobotSource> robots = robotSources(configFrom(values, "/node"));
  ASSERT_EQ(robots.size(), 1U);
  EXPECT_EQ(robots[0].name, "left");
  EXPECT_EQ(robots[0].semantic, "/left/robot_description_semantic");
  EXPECT_FALSE(robots[0].needs_semantic);
  EXPECT_EQ(robots[0].tf_prefix, "");
  EXPECT_EQ(robots[0].joint_states, "joint_states");
}

TEST(RobotsOfTheParameters, AreTheSingleOneOfTheOtherParametersWhereThereAreNone) {
  XmlRpcValue values;
  values["tf_prefix"] = "left";
  values["semantic_description"] = "other";
  const std::vector<RobotSource> robots = robotSources(configFrom(values, "/node"));
  ASSERT_EQ(robots.size(), 1U);
  EXPECT_EQ(robots[0].name, "");
  EXPECT_EQ(robots[0].description, "robot_description");
  EXPECT_EQ(robots[0].semantic, "other");
  EXPECT_TRUE(robots[0].needs_semantic);
  EXPECT_EQ(robots[0].tf_prefix, "left");
}

TEST(RobotsOfTheParameters, AreRefusedByNameWhereTheyAreWrong) {
  const std::tuple<std::string, XmlRpcValue, std::string> kRefusals[] = {
      {"tf_prefx", "right", " is unknown: did you mean 'tf_prefix'?"},
      {"tf_prefix", 3, " must be a text"},
      {"description", "", " is missing: the name of the parameter with the robot's URDF"},
      {"joint_states", "joint states", " is no name of a topic: 'joint states'"}};
  for (const auto& [field, value, reason] : kRefusals) {
    XmlRpcValue values = leftAndRight();
    values["robots"]["right"][field] = value;
    expectRefusal(values, "parameter /node/robots/right/" + field + reason);
  }
  XmlRpcValue values = leftAndRight();
  values["robots"]["a/b"] = values["robots"]["left"];
  expectRefusal(values, "parameter /node/robots/a/b names a robot: letters, digits and underscores, a letter first");
  values = leftAndRight();
  values["robots"]["right"] = "/right/robot_description";
  expectRefusal(values, "parameter /node/robots/right must be of the form {description: ..., tf_prefix: ...}");
  values = leftAndRight();
  values["robot_description"] = "robot_description";
  expectRefusal(values, "parameter /node/robot_description has no effect beside robots, which describes each robot");
}

TEST(MaxDecelerationOfTheParameters, IsANumberOrAMap) {
  const auto with = [](const XmlRpcValue& value) {
    XmlRpcValue values;
    values["max_deceleration"] = value;
    return values;
  };
  EXPECT_EQ(configFrom(with(2), "/node").max_deceleration.of_all, 2.0);
  const std::string problem = "parameter /node/max_deceleration must be a number, or map names of joints to numbers";
  expectRefusal(with("hard"), problem);
}

// --- frames

TEST(SeveralRobots, HaveFramesWithTheirOwnPrefixes) {
  XmlRpcValue values = leftAndRight();
  values["robots"]["right"]["tf_prefix"] = "/cell/b";
  const Robot robot = twoArms(values);
  EXPECT_EQ(robot.frameOf(robot.robotModel().findLink("left/hand")), "left/hand");
  EXPECT_EQ(robot.frameOf(robot.robotModel().findLink("right/hand")), "cell/b/hand");
  EXPECT_EQ(robot.linkOfFrame("cell/b/hand"), robot.robotModel().findLink("right/hand"));
  EXPECT_EQ(robot.linkOfFrame("right/hand"), robot.robotModel().findLink("right/hand"));
  EXPECT_EQ(robot.linkOfFrame("hand"), -1);
}

TEST(SeveralRobots, AreRefusedWhereTheyHaveTheSameFrames) {
  XmlRpcValue values = leftAndRight();
  values["robots"]["right"]["tf_prefix"] = "left";
  EXPECT_EQ(scene::errorOf([&] { twoArms(values); }),
            "parameter robots/right/tf_prefix is 'left': the robots 'left' and 'right' both have the tf frame "
            "'left/base'");
}

TEST(SeveralRobots, AnswerInTheRootOfTheFirstOneByDefault) {
  const Robot robot = twoArms(leftAndRight());
  EXPECT_EQ(robot.referenceFrame(), "left/base");
  EXPECT_EQ(robot.rootEdge(0), -1);
  const TfEdge& edge = robot.tfEdges()->at(static_cast<std::size_t>(robot.rootEdge(1)));
  EXPECT_EQ(edge.parent, "left/base");
  EXPECT_EQ(edge.child, "right/base");
  EXPECT_EQ(edge.name, "frame 'right/base' of robot 'right' in 'left/base'");
}

// --- transforms

std::set<std::string> childrenOf(const Robot& robot, const std::vector<std::string>& links) {
  std::vector<int> bodies;
  for (const std::string& link : links)
    bodies.push_back(robot.robotModel().links[robot.robotModel().findLink(link)].body);
  std::set<std::string> children;
  for (const int edge : edgesTo(robot, bodies))
    children.insert(robot.tfEdges()->at(static_cast<std::size_t>(edge)).child);
  return children;
}

TEST(SeveralRobots, NeedTheRootsOfTheRobotsThatAreAskedFor) {
  XmlRpcValue values = leftAndRight();
  values["reference_frame"] = "world";
  const Robot robot = twoArms(values);
  using Frames = std::set<std::string>;
  EXPECT_EQ(childrenOf(robot, {"left/hand"}), (Frames{"left/base", "left/hand"}));
  EXPECT_EQ(childrenOf(robot, {"right/base"}), (Frames{"right/base"}));
  EXPECT_EQ(childrenOf(robot, {"left/base", "right/hand"}), (Frames{"left/base", "right/base", "right/hand"}));
}

TEST(SeveralRobots, StandWhereTheReferenceLinkOfOneOfThemSaysIt) {
  XmlRpcValue values = leftAndRight();
  values["reference_frame"] = "left/hand";
  const Robot robot = twoArms(values);
  const scene::RobotModel& model = robot.robotModel();
  const auto at = [](double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 0.0)); };
  const JointFrames joints = {at(0.5), at(0.7)};
  const RootPoses roots = {std::nullopt, at(3.0)};  // in left/base
  const scene::BodyPoses poses = inReference(robot, posesInRoot(model, joints), roots);
  const auto x = [&](const std::string& link) {
    return poses[model.links[model.findLink(link)].body].value().translation().x();
  };
  EXPECT_EQ(x("left/base"), -0.5);
  EXPECT_EQ(x("left/hand"), 0.0);
  EXPECT_EQ(x("right/base"), 2.5);
  EXPECT_DOUBLE_EQ(x("right/hand"), 3.2);
}

/// The parameters of two robots without a pair between them.
XmlRpcValue apart() {
  XmlRpcValue values = leftAndRight();
  const char* between[4][2] = {{"left/base", "right/base"},
                               {"left/base", "right/hand"},
                               {"left/hand", "right/base"},
                               {"left/hand", "right/hand"}};
  for (int i = 0; i < 4; ++i) {
    for (int end = 0; end < 2; ++end) values["exclude_pairs"][i][end] = between[i][end];
  }
  return values;
}

/// The roots that have to rest for the lookahead, with a ball there.
std::vector<int> rootsWithABall(const XmlRpcValue& values, const std::optional<scene::Placement>& placement) {
  const Robot robot = twoArms(values);
  scene::Objects objects = *robot.objects().get().all;
  if (placement) {
    const std::vector<scene::ObjectShape> ball = {{narrowphase::Shape(narrowphase::Sphere{0.1})}};
    objects = objects.changed({scene::AddObject{scene::makeObject("ball", ball, *placement)}});
  }
  return motionSourcesOf(robot, objects).roots;
}

TEST(SeveralRobots, HaveToRestAgainstEachOtherWhereAPairBetweenThemIsChecked) {
  EXPECT_EQ(rootsWithABall(leftAndRight(), std::nullopt), (std::vector<int>{0, 1}));
  EXPECT_TRUE(rootsWithABall(apart(), std::nullopt).empty());
}

TEST(SeveralRobots, HaveToRestAgainstWhatAnotherOneHolds) {
  EXPECT_EQ(rootsWithABall(apart(), scene::Attached{"left/hand"}), (std::vector<int>{0, 1}));
}

TEST(SeveralRobots, HaveToRestAgainstTheReferenceFrameWhereObjectsStandInIt) {
  XmlRpcValue in_world = apart();
  in_world["reference_frame"] = "world";
  const int world = TfPoses::kReferenceFrame;
  EXPECT_EQ(rootsWithABall(in_world, scene::Fixed{}), (std::vector<int>{world, 0, 1}));
  EXPECT_EQ(rootsWithABall(in_world, scene::Moving{"camera"}), (std::vector<int>{world, 0, 1}));
  EXPECT_TRUE(rootsWithABall(in_world, std::nullopt).empty());
  EXPECT_EQ(rootsWithABall(apart(), scene::Fixed{}), (std::vector<int>{0, 1})) << "it is that of the left base";
}

// --- answers

TEST(SeveralRobots, AreNamedInAnswers) {
  const Robot robot = twoArms(leftAndRight());
  const auto robotNamed = [](const Robot& asked, const std::string& a, const std::string& b) {
    scene::PairProximity pair;
    pair.asked = {{asked.robotModel().findLink(a)}, {asked.robotModel().findLink(b)}};
    const Proximity message =
        toMessage(asked.robotModel(), scene::BodyPoses(asked.robotModel().bodies.size()), pair, {});
    return message.a.robot + " " + message.b.robot;
  };
  EXPECT_EQ(robotNamed(robot, "right/hand", "left/hand"), "right left");
  EXPECT_EQ(robotNamed(Robot(kArm, "", Config()), "hand", "base"), " ");
}

// --- thresholds of single pairs

TEST(ThresholdsOfPairs, StayWhereTheDefaultsOfSettingsChange) {
  Config config;
  config.thresholds.stop.of_links = {{"hand", 0.03}};
  const Robot robot(kArm, "", config);
  MonitorSettings settings;
  settings.stop_distance = 0.01;
  settings.object_stop_distance = 0.015;
  robot.useDefaults(settings);
  const int base = robot.robotModel().findLink("base"), hand = robot.robotModel().findLink("hand");
  EXPECT_EQ(robot.thresholds()->stop.of({{base}, {hand}}), 0.03);
  EXPECT_EQ(robot.thresholds()->stop.of({{base}, scene::ShapeRef::ofObject(0)}), 0.015);
  EXPECT_EQ(robot.thresholds()->stop.of({{hand}, scene::ShapeRef::ofObject(0)}), 0.03);
}

TEST(ThresholdsOfPairs, RefuseSettingsThatContradictThemAndStayAsTheyWere) {
  Config config;
  config.thresholds.stop.of_links = {{"hand", 0.03}};
  const Robot robot(kArm, "", config);
  const auto before = robot.thresholds();
  const auto refusal = [&](double warn, double influence) {
    MonitorSettings settings;
    settings.warn_distance = settings.object_warn_distance = warn;
    settings.influence_distance = influence;
    return scene::errorOf([&] { robot.useDefaults(settings); });
  };
  EXPECT_NE(refusal(0.025, 0.1).find("base - hand is 0.03, above its warn distance, which is 0.025"),
            std::string::npos);
  EXPECT_EQ(refusal(0.05, 0.03),
            "the stop distance of hand and objects is 0.03, not below influence_distance, which is 0.03");
  EXPECT_EQ(robot.thresholds(), before);
}

TEST(ThresholdsOfPairs, OfSeveralRobotsHaveTheWholeNamesOfLinks) {
  XmlRpcValue values = leftAndRight();
  values["pair_stop_distance"][0]["links"][0] = "left/hand";
  values["pair_stop_distance"][0]["links"][1] = "right/hand";
  values["pair_stop_distance"][0]["distance"] = 0.04;
  const Robot robot = twoArms(values);
  const auto link = [&](const char* name) { return scene::ShapeRef{robot.robotModel().findLink(name)}; };
  EXPECT_EQ(robot.thresholds()->stop.of({link("right/hand"), link("left/hand")}), 0.04);
  EXPECT_EQ(robot.thresholds()->stop.of({link("right/hand"), link("left/base")}), 0.02);
}

// --- visuals that count

/// The first shape of a link.
std::string shapeOf(const ModelInfo& info, const std::string& link) {
  for (const LinkInfo& each : info.links)
    if (each.name == link) return each.shapes.empty() ? "none" : each.shapes.front().description;
  return "no such link";
}

TEST(CollisionFromVisual, OfAWalkerWithoutItMakesItCountAsAWhole) {
  const scene::TemporaryFiles files;
  XmlRpcValue values;
  values["collision_from_visual"] = "all";
  const Robot robot(scene::walker(files), scene::kWalkerGroups, configFrom(values, "/node"));
  EXPECT_EQ(robot.candidates().size(), 15U);
  const ModelInfo info = toMessage(robot, ros::Time());
  EXPECT_EQ(shapeOf(info, "pelvis"), "mesh file://" + files.path("pelvis.stl") + ", of its <visual>");
  EXPECT_EQ(shapeOf(info, "left_foot"), "box 0.2 x 0.03125 x 0.05");
}

TEST(CollisionFromVisual, OfSeveralRobotsNamesTheirGroups) {
  const scene::TemporaryFiles files;
  const RobotTexts texts{scene::walker(files), scene::kWalkerGroups};
  XmlRpcValue values = leftAndRight();
  values["collision_from_visual"][0] = "left/right_leg";
  const Robot robot({texts, texts}, configFrom(values, "/node"));
  const ModelInfo info = toMessage(robot, ros::Time());
  EXPECT_EQ(shapeOf(info, "left/right_thigh"), "mesh file://" + files.path("thigh.stl") + ", of its <visual>");
  for (const char* link : {"left/pelvis", "left/left_thigh", "right/right_thigh"})
    EXPECT_EQ(shapeOf(info, link), "none");
}

// 20 of the 55 pairs of a Panda are checked, and 11 links of each have geometry.
TEST(TwoPandas, AreOneModelOfTheNode) {
  const scene::MeshResolver resolve = scene::exampleRobotsResolver();
  if (!scene::findsExampleRobots(resolve)) GTEST_SKIP() << scene::kExampleRobotsMissing;
  const scene::ExampleRobot& panda = scene::kExampleRobots[0];
  const RobotTexts texts{scene::readFile(scene::exampleRobotFile(resolve, panda.urdf)),
                         scene::readFile(scene::exampleRobotFile(resolve, panda.srdf))};
  XmlRpcValue values = leftAndRight();
  values["mesh_roots"][0] = PROXIMITY_SOURCE_DIR "/../shared/robots";
  values["reference_frame"] = "world";
  const Robot cell({texts, texts}, configFrom(values, "/node"));
  EXPECT_EQ(cell.candidates().size(), 20U + 20U + 11U * 11U);
  const ModelInfo info = toMessage(cell, ros::Time());
  EXPECT_EQ(info.robot, "left (panda), right (panda)");
  EXPECT_EQ(info.pairs.size(), 55U + 55U + 121U);
  EXPECT_EQ(cell.frameOf(cell.robotModel().findLink("right/panda_hand")), "right/panda_hand");
}

}  // namespace proximity_server::node::robot_test
