#include "proximity_server/scene/levels/clearance_level.h"

#include "proximity_server/scene/answers/deciding_pair.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::clearance_level_test {

using namespace narrowphase;

using Level = ClearanceLevel;

Level level(double distance, const LevelBefore& before = {}) { return levelOf(distance, 0.02, 0.05, before).level; }

TEST(ClearanceLevel, StartsAtItsThreshold) {
  EXPECT_EQ(level(0.051), Level::Clear);
  EXPECT_EQ(level(0.05), Level::Warn);
  EXPECT_EQ(level(0.02), Level::Stop);
  EXPECT_EQ(level(0.0), Level::Collision);
  EXPECT_EQ(level(-0.1), Level::Collision);
}

TEST(ClearanceLevel, IsLeftOnlyBeyondTheHysteresis) {
  const auto after = [](double distance, Level before) { return level(distance, {before, 0.01}); };
  EXPECT_EQ(after(0.059, Level::Warn), Level::Warn);
  EXPECT_EQ(after(0.061, Level::Warn), Level::Clear);
  EXPECT_EQ(after(0.029, Level::Stop), Level::Stop);
  EXPECT_EQ(after(0.031, Level::Stop), Level::Warn);
  EXPECT_EQ(after(0.009, Level::Collision), Level::Collision);
  EXPECT_EQ(after(0.011, Level::Collision), Level::Stop);
}

TEST(ClearanceLevel, GetsWorseWithoutDelay) {
  EXPECT_EQ(level(0.02, {Level::Clear, 0.01}), Level::Stop);
  EXPECT_EQ(level(0.0, {Level::Warn, 0.01}), Level::Collision);
}

TEST(ClearanceLevel, OfWhatIsNoNumberIsTheWorst) {
  EXPECT_EQ(level(std::numeric_limits<double>::quiet_NaN(), {Level::Clear, 0.01}), Level::Collision);
}

TEST(ClearanceLevel, HasTheThresholdThatItIsAtOrAbove) {
  EXPECT_EQ(levelOf(1.0, 0.02, 0.05).threshold, 0.05);
  EXPECT_EQ(levelOf(0.04, 0.02, 0.05).threshold, 0.05);
  EXPECT_EQ(levelOf(0.01, 0.02, 0.05).threshold, 0.02);
  EXPECT_EQ(levelOf(-1.0, 0.02, 0.05).threshold, 0.0);
}

// --- the pair that decides

// Four balls of radius 0.1 on sliders along x. Where all joints stand at 0 the surfaces of neighbours are 0.1, 0.2 and
// 0.4 m apart.
const std::string kBalls =
    urdfOf(link("rail") + link("a", ball("0.1")) + link("b", ball("0.1")) + link("c", ball("0.1")) +
           link("d", ball("0.1")) + link("sign") + weld("to_sign", "rail", "sign") +
           slider("slide_a", "rail", "a", "1 0 0") + slider("slide_b", "rail", "b", "1 0 0", "0.3 0 0") +
           slider("slide_c", "rail", "c", "1 0 0", "0.7 0 0") + slider("slide_d", "rail", "d", "1 0 0", "1.3 0 0"));

const char* const kGroups = R"(<robot name="balls">
  <group name="left"><link name="a"/><joint name="slide_b"/></group>
  <group name="right"><joint name="slide_c"/><joint name="slide_d"/></group>
  <group name="inner"><joint name="slide_b"/><joint name="slide_c"/></group>
</robot>)";

class Balls : public testing::Test {
 protected:
  int link(const std::string& name) const { return model_->robot.findLink(name); }

  /// The pair that decides, as "a - b".
  std::string decide(const LevelThresholds& thresholds, const LevelBefore& before = {}) {
    scene_.update(forwardKinematics(model_->robot, {}));
    const PairProximity closest = *scene_.minimum(scene_.candidates());
    decided_ = decidingPair(scene_.scene, scene_.state, scene_.candidates(), closest, {thresholds, before});
    const ShapeRefPair& pair = decided_.pair.asked;
    return model_->robot.links[pair.a.link()].name + " - " + model_->robot.links[pair.b.link()].name;
  }

  LevelThresholds thresholds(const DistanceRules& stop, const DistanceRules& warn = {}) const {
    return levelThresholds(model_->robot, {kGroups}, {stop, warn}, {{0.02, 0.03}, {0.9, 0.9}});
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kBalls);
  PosedScene scene_{model_};
  DecidingPair decided_;
};

TEST_F(Balls, ClosestPairDecidesWhereAllThresholdsAreEqual) {
  EXPECT_EQ(decide({}), "a - b");
  EXPECT_EQ(decided_.level.level, Level::Clear);
  EXPECT_EQ(decided_.level.threshold, 0.05);
}

TEST_F(Balls, PairBelowItsOwnStopDistanceDecidesBeforeACloserOneThatIsNot) {
  LevelThresholds thresholds;
  thresholds.stop.setPair(link("b"), link("c"), 0.25);
  thresholds.warn.setPair(link("b"), link("c"), 0.3);
  EXPECT_EQ(decide(thresholds), "b - c");
  EXPECT_EQ(decided_.level.level, Level::Stop);
  EXPECT_EQ(decided_.level.threshold, 0.25);
  EXPECT_NEAR(decided_.pair.result.distance, 0.2, 1e-9);
}

TEST_F(Balls, OfTwoPairsAtOneLevelTheOneWithTheSmallerDifferenceDecides) {
  LevelThresholds thresholds;
  thresholds.warn.setPair(link("a"), link("b"), 0.11);
  thresholds.warn.setPair(link("c"), link("d"), 0.45);
  EXPECT_EQ(decide(thresholds), "c - d");
  EXPECT_EQ(decided_.level.level, Level::Warn);
  EXPECT_EQ(decided_.level.threshold, 0.45);
}

TEST_F(Balls, WorseLevelDecidesBeforeASmallerDifference) {
  LevelThresholds thresholds;
  thresholds.stop.setPair(link("a"), link("b"), 0.1 + 1e-6);
  thresholds.warn.setPair(link("a"), link("b"), 0.2);
  thresholds.warn.setPair(link("c"), link("d"), 2.0);
  EXPECT_EQ(decide(thresholds), "a - b");
  EXPECT_EQ(decided_.level.level, Level::Stop);
}

TEST_F(Balls, LevelOfAPairIsKeptWithinTheHysteresis) {
  LevelThresholds thresholds;
  thresholds.stop.setPair(link("b"), link("c"), 0.195);
  thresholds.warn.setPair(link("b"), link("c"), 0.195);
  EXPECT_EQ(decide(thresholds, {Level::Stop, 0.01}), "b - c");
  EXPECT_EQ(decided_.level.level, Level::Stop);
  decide(thresholds, {Level::Stop, 0.004});
  EXPECT_EQ(decided_.level.level, Level::Clear);
}

TEST_F(Balls, HysteresisOfASmallThresholdIsSmaller) {
  scene_.update(forwardKinematics(model_->robot, {}));
  LevelThresholds thresholds;
  thresholds.stop.setPair(link("a"), link("b"), 0.002);
  thresholds.warn.setPair(link("a"), link("b"), 0.003);
  PairProximity pair;
  pair.asked = {{link("a")}, {link("b")}};
  pair.result.lower_bound = 0.0035;
  const LevelBefore before{Level::Warn, 0.002};  // at 0.02: a tenth
  EXPECT_EQ(levelOf(pair, thresholds, before).level, Level::Clear);
  pair.result.lower_bound = 0.0031;
  EXPECT_EQ(levelOf(pair, thresholds, before).level, Level::Warn);
}

// --- thresholds by name

TEST_F(Balls, PairGoesBeforeLinkBeforeGroupBeforeDefaultAndOfEqualsTheLarger) {
  DistanceRules rules;
  rules.of_pairs = {{{"c", "a"}, 0.5}, {{"a", "c"}, 0.4}};
  rules.of_links = {{"a", 0.1}, {"b", 0.2}};
  rules.of_groups = {{"right", 0.3}, {"inner", 0.7}};
  const PairDistances stop = thresholds(rules).stop;
  const auto of = [&](const char* a, const char* b) { return stop.of({{link(a)}, {link(b)}}); };
  EXPECT_EQ(of("a", "c"), 0.5);  // the pair, of two entries the larger
  EXPECT_EQ(of("a", "b"), 0.2);  // both have one: the larger
  EXPECT_EQ(of("d", "a"), 0.1);  // the link before the group
  EXPECT_EQ(of("d", "c"), 0.7);  // c is in both groups
  EXPECT_EQ(of("b", "c"), 0.2);
  EXPECT_EQ(of("a", "sign"), 0.02);  // without geometry
  EXPECT_EQ(stop.of({{link("a")}, ShapeRef::ofObject(3)}), 0.1);
  EXPECT_EQ(stop.of({ShapeRef::ofObject(3), {link("d")}}), 0.3);
  EXPECT_EQ(stop.of({ShapeRef::ofObject(3), ShapeRef::ofObject(1)}), 0.03);
}

TEST_F(Balls, ThresholdsThatMakeNoSenseAreRefusedByName) {
  const auto refusal = [&](const DistanceRules& stop, const DistanceRules& warn = {}) {
    return errorOf([&] { thresholds(stop, warn); });
  };
  const auto pair = [](const char* a, const char* b, double distance) {
    DistanceRules rules;
    rules.of_pairs = {{{a, b}, distance}};
    return rules;
  };
  EXPECT_EQ(refusal(pair("a", "bb", 0.1)), "pair_stop_distance: no link \"bb\" (did you mean \"b\"?)");
  EXPECT_EQ(refusal({}, pair("a", "sign", 0.1)), "pair_warn_distance: the link \"sign\" has no collision geometry");
  EXPECT_EQ(refusal(pair("a", "b", -0.1)), "pair_stop_distance of a - b is -0.1, but must not be negative");
  EXPECT_EQ(refusal({{}, {{"a", std::numeric_limits<double>::infinity()}}, {}}),
            "link_stop_distance/a is inf, but must not be negative");
  EXPECT_EQ(
      refusal({{}, {}, {{"rigth", 0.1}}}),
      "group_stop_distance: the SRDF has no group \"rigth\" (did you mean \"right\"?); it has left, right, inner");
  EXPECT_EQ(
      refusal(pair("b", "a", 0.95)),
      "the stop distance of a - b is 0.95, above its warn distance, which is 0.9: the level WARN comes before STOP");
  EXPECT_EQ(refusal({}, {{}, {{"c", 0.025}}, {}}),
            "the stop distance of c and objects is 0.03, above its warn distance, which is 0.025: the level WARN comes "
            "before STOP");
}

// --- pairs that the SRDF disables

// Around the ball of the base turn, each behind a link without geometry, a ball at a distance of 15 mm, one in its
// middle and one at 1 m.
std::string carousel() {
  std::string parts = link("base", ball("0.1"));
  const std::pair<std::string, std::string> places[] = {
      {"near", "0.215 0 0"}, {"core", "0.01 0 0"}, {"far", "1.2 0 0"}};
  for (const auto& [name, place] : places)
    parts += link(name, ball("0.1", place)) + link("hub_of_" + name) +
             hinge("to_hub_of_" + name, "base", "hub_of_" + name, "0 0 1") +
             hinge("to_" + name, "hub_of_" + name, name, "0 0 1");
  return urdfOf(parts, "carousel");
}

TEST(DisabledPairs, AreNamedIfTheyComeWithinTheirStopDistanceAndAreNotAlwaysInContact) {
  std::string srdf = "<robot name='carousel'>";
  for (const std::string name : {"near", "core", "far"})
    srdf += "<disable_collisions link1='base' link2='" + name + "' reason='Never'/>";
  srdf += "<disable_collisions link1='near' link2='far' reason='Never'/></robot>";
  SceneModel model = makeSceneModel(robotOf(carousel()), srdf);
  const std::vector<DisabledPair> disabled = disabledPairsBelow(model, {0.02, 0.02});
  ASSERT_EQ(disabled.size(), 1u);
  EXPECT_EQ(disabled[0].pair, model.pairs.find(model.robot.findLink("base"), model.robot.findLink("near")));
  EXPECT_NEAR(disabled[0].smallest, 0.015, 1e-9);
  EXPECT_TRUE(disabledPairsBelow(model, {0.01, 0.02}).empty());
  const auto disabledAs = [](const std::string& reason) {
    const std::string entry = "<disable_collisions link1='base' link2='near' reason='" + reason + "'/>";
    return disabledPairsBelow(makeSceneModel(robotOf(carousel()), "<robot name='carousel'>" + entry + "</robot>"),
                              {0.02, 0.02})
        .size();
  };
  EXPECT_EQ(disabledAs("User"), 1u) << "without a reason";
  EXPECT_EQ(disabledAs("User: a cover of 5 mm"), 0u);
  const std::size_t warnings = model.pairs.warnings.size();
  warnOfNearPairs(model, {});
  ASSERT_EQ(model.pairs.warnings.size(), warnings + 1);
  EXPECT_NE(model.pairs.warnings.back().find("base - near (15.0 mm)"), std::string::npos)
      << model.pairs.warnings.back();
}

TEST(CheckedPairs, ThatAreAlwaysAtStopAreNamedWithTheThresholdsThatFit) {
  SceneModel model = makeSceneModel(robotOf(carousel()), "");
  const auto found = [&](const LevelThresholds& thresholds) {
    SceneModel copy = model;
    warnOfNearPairs(copy, thresholds);
    std::string text;
    for (const std::string& warning : copy.pairs.warnings)
      if (warning.find("Always at STOP: ") == 0) text += warning + "\n";
    return text;
  };
  const std::string text = found({});
  EXPECT_NE(text.find("base - near stays at 15 mm"), std::string::npos) << text;
  EXPECT_NE(text.find("pair_stop_distance: [{links: [base, near], distance: 0.0075}]"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;  // not of near - far
  LevelThresholds fitting;
  fitting.stop.setPair(model.robot.findLink("base"), model.robot.findLink("near"), 0.0075);
  EXPECT_EQ(found(fitting), "");
}

// --- beside all pairs

TEST(DecidingPair, IsTheWorstOfAllPairsWithObjectsToo) {
  const auto model = arm();
  Chance chance(5);
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 3; ++i) {
    const Fixed place{Eigen::Isometry3d(Eigen::Translation3d(chance.between(0.8, 1.3) * chance.direction()))};
    changes.push_back(AddObject{makeObject("ball " + std::to_string(i), {{Shape(Sphere{0.08})}}, place)});
  }
  const auto objects = std::make_shared<const Objects>(Objects(model).changed(changes));
  PosedScene scene(model), everything(model, Skipping::Off);
  scene.use(objects);
  everything.use(objects);
  int of_level[4] = {}, not_closest = 0;
  for (int state = 0; state < 2000; ++state) {
    LevelThresholds thresholds{{chance.between(0.0, 0.02), 0.05}, {chance.between(0.02, 0.05), 0.1}};
    for (int own = 0; own < 5; ++own) {
      const int a = chance.below(static_cast<int>(model->robot.links.size())),
                b = chance.below(static_cast<int>(model->robot.links.size()));
      const double stop = chance.between(0.0, 0.3);
      thresholds.stop.setPair(a, b, stop);
      thresholds.warn.setPair(a, b, stop + chance.between(0.0, 0.3));
      thresholds.warn.setWithObjects(a, chance.between(0.05, 0.5));
    }
    std::vector<double> positions;
    for (std::size_t i = 0; i < model->robot.joints.size(); ++i) positions.push_back(chance.between(-3.0, 3.0));
    const BodyPoses poses = forwardKinematics(model->robot, positions);
    scene.update(poses);
    everything.update(poses);
    Level worst = Level::Clear;
    double smallest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : everything.all(everything.candidates())) {
      const DistanceLevel level =
          levelOf(pair.result.lower_bound, thresholds.stop.of(pair.asked), thresholds.warn.of(pair.asked));
      const double excess = pair.result.lower_bound - level.threshold;
      if (level.level > worst || (level.level == worst && excess < smallest)) smallest = excess;
      worst = std::max(worst, level.level);
    }
    const PairProximity closest = *scene.minimum(scene.candidates());
    const DecidingPair decided = decidingPair(scene.scene, scene.state, scene.candidates(), closest, {thresholds});
    ASSERT_EQ(decided.level.level, worst);
    ASSERT_NEAR(decided.pair.result.lower_bound - decided.level.threshold, smallest, 2e-9);
    ++of_level[static_cast<int>(worst)];
    not_closest += decided.pair.result.distance > closest.result.distance + 1e-9;
  }
  for (const int states : of_level) EXPECT_GT(states, 20);
  EXPECT_GT(not_closest, 100);
}

}  // namespace proximity_server::scene::clearance_level_test
