#include "tools/pair_audit/level_shares.h"

#include "proximity_server/scene/levels/always_near.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::level_shares_test {

using namespace scene;

// The second ball is from -0.05 to 0.15 beside the first, and the third 0.04 above the second wherever that is.
const char* const kBalls = R"(<robot name="balls">
  <link name="first"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="second"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="third"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="first"/><child link="second"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-0.05" upper="0.15" effort="1" velocity="1"/></joint>
  <joint name="turn" type="continuous"><parent link="second"/><child link="third"/><origin xyz="0 0 1.04"/><axis xyz="0 0 1"/>
  </joint></robot>)";

std::shared_ptr<const SceneModel> ballsChecking(const std::string& enabled) {
  return std::make_shared<const SceneModel>(
      makeSceneModel(loadRobotModel(kBalls, packageResolver({})), "<robot name='balls'>" + enabled + "</robot>"));
}
const char* const kMoving = "<enable_collisions link1='first' link2='second'/>";
const char* const kBoth =
    "<enable_collisions link1='first' link2='second'/><enable_collisions link1='second' link2='third'/>";

constexpr StopAndWarn kUsual{0.02, 0.05};

// Three standard deviations of 500 states are 6 %.
void expectShares(const LevelCounts& counts, std::array<double, 4> shares) {
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_NEAR(counts.states[level] / 500.0, shares[level], 0.06) << level;
  }
}

TEST(LevelShares, AreThoseOfAUniformDistance) {
  expectShares(countLevels(ballsChecking(kMoving), thresholdsWith({}, kUsual), 1), {0.5, 0.15, 0.1, 0.25});
}

TEST(LevelShares, TheWorstPairDecidesByItsOwnThresholds) {
  const auto model = ballsChecking(kBoth);
  const LevelCounts without = countLevels(model, thresholdsWith({}, kUsual), 1);
  EXPECT_EQ(without.states[0], 0);
  expectShares(without, {0.0, 0.65, 0.1, 0.25});
  const AlwaysNear third{{{model->robot.findLink("second"), 0}, {model->robot.findLink("third"), 0}}, 0.04, 0.04};
  expectShares(countLevels(model, thresholdsWith({third}, kUsual), 1), {0.5, 0.15, 0.1, 0.25});
}

TEST(LevelShares, AreATable) {
  EXPECT_EQ(levelTable({{0, 0, 450, 50}}, {{250, 150, 50, 50}}),
            "\nThe level in 500 random states:\n"
            "              CLEAR       WARN       STOP  COLLISION\n"
            "  before      0.0 %      0.0 %     90.0 %     10.0 %\n"
            "  after      50.0 %     30.0 %     10.0 %     10.0 %\n");
}

}  // namespace proximity_server::tools::level_shares_test
