#include "tools/pair_audit/level_shares.h"
#include "robots/urdf.h"

#include "proximity_server/scene/levels/always_near.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::level_shares_test {

using namespace scene;

// The second ball is from -0.05 to 0.15 beside the first, and the third 0.04 above the second wherever that is.
const std::string kBalls = [] {
  using namespace robots;
  return urdfOf(
      link("first", ball("0.5")) + link("second", ball("0.5")) + link("third", ball("0.5")) +
          joint("slide", "prismatic", "first", "second", origin("1 0 0") + axis("1 0 0") + limits("-0.05", "0.15")) +
          hinge("turn", "second", "third", "0 0 1", "0 0 1.04"),
      "balls");
}();

std::shared_ptr<const SceneModel> ballsChecking(const std::string& enabled) {
  return std::make_shared<const SceneModel>(
      makeSceneModel(loadRobotModel(kBalls, packageResolver({})), "<robot name='balls'>" + enabled + "</robot>"));
}
const char* const kMoving = "<enable_collisions link1='first' link2='second'/>";
const char* const kBoth =
    "<enable_collisions link1='first' link2='second'/><enable_collisions link1='second' link2='third'/>";

constexpr StopAndWarn kUsual{0.02, 0.05};

LevelShares sharesOf(const std::shared_ptr<const SceneModel>& model, const LevelThresholds& thresholds,
                     const std::optional<Positions>& rest = std::nullopt) {
  return levelShares(model, thresholds, levelStates(model->robot, 1, rest));
}

// Three standard deviations of 500 states are 6 %.
void expectShares(const LevelShares& found, std::array<double, 4> shares) {
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_NEAR(found.counts()[level] / 500.0, shares[level], 0.06) << level;
  }
}

TEST(LevelShares, AreThoseOfAUniformDistance) {
  expectShares(sharesOf(ballsChecking(kMoving), thresholdsWith({}, kUsual)), {0.5, 0.15, 0.1, 0.25});
}

TEST(LevelShares, TheWorstPairDecidesByItsOwnThresholds) {
  const auto model = ballsChecking(kBoth);
  const LevelShares without = sharesOf(model, thresholdsWith({}, kUsual));
  EXPECT_EQ(without.counts()[0], 0);
  expectShares(without, {0.0, 0.65, 0.1, 0.25});
  const AlwaysNear third{{{model->robot.findLink("second"), 0}, {model->robot.findLink("third"), 0}}, 0.04, 0.04};
  expectShares(sharesOf(model, thresholdsWith({third}, kUsual)), {0.5, 0.15, 0.1, 0.25});
}

TEST(LevelShares, PairsAreCountedWhereTheySetStopOrCollision) {
  const auto model = ballsChecking(kBoth);
  const LevelShares shares = sharesOf(model, thresholdsWith({}, kUsual), Positions{-0.01, 0.0});
  ASSERT_EQ(shares.of_pairs.size(), 1U) << "the third is at WARN";
  const PairLevels& pair = shares.of_pairs[0];
  EXPECT_EQ(pair.pair.b.link(), model->robot.findLink("second"));
  EXPECT_EQ(pair.collisions, shares.counts()[3]);
  EXPECT_EQ(pair.stops, shares.counts()[2]);
  EXPECT_EQ(pair.at_rest, ClearanceLevel::Collision);
  EXPECT_TRUE(pair.isSuspect()) << "in contact at rest";
  EXPECT_EQ(contactText(pair), "in contact at rest and in " + shareText(pair.collisions) + " of random states");
  EXPECT_TRUE(sharesOf(model, thresholdsWith({}, kUsual), Positions{0.01, 0.0}).suspects().empty());
}

TEST(LevelShares, APairInContactInMoreThanHalfOfTheStatesIsSuspect) {
  PairLevels pair;
  pair.collisions = 250;
  EXPECT_FALSE(pair.isSuspect());
  pair.collisions = 251;
  EXPECT_TRUE(pair.isSuspect());
}

// A joint that cannot be at 0 rests in the middle of its range.
TEST(LevelShares, RestIsZeroOrTheMiddle) {
  std::string urdf = kBalls;
  urdf.replace(urdf.find("-0.05"), 5, "0.05");
  const RobotModel robot = loadRobotModel(urdf, packageResolver({}));
  const std::vector<Positions> states = levelStates(robot, 1);
  EXPECT_EQ(states.size(), 502U);
  EXPECT_EQ(states[0], (Positions{0.1, 0.0}));
  EXPECT_EQ(levelStates(robot, 1, Positions{0.15, 1.0})[0], (Positions{0.15, 1.0}));
}

TEST(LevelShares, AreATable) {
  const auto sharesWith = [](std::array<int, 4> counts) {
    LevelShares shares{{ClearanceLevel::Clear, ClearanceLevel::Clear}, {}};  // at rest and in the middle
    for (std::size_t level = 0; level < 4; ++level)
      shares.of_states.insert(shares.of_states.end(), counts[level], static_cast<ClearanceLevel>(level));
    return shares;
  };
  EXPECT_EQ(levelTable(sharesWith({0, 0, 450, 50}), sharesWith({250, 150, 50, 50})),
            "\nThe level in 500 random states:\n"
            "              CLEAR       WARN       STOP  COLLISION\n"
            "  before      0.0 %      0.0 %     90.0 %     10.0 %\n"
            "  after      50.0 %     30.0 %     10.0 %     10.0 %\n");
}

}  // namespace proximity_server::tools::level_shares_test
