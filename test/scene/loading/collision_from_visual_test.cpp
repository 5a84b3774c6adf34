// Robots of which most links have only a <visual>, with the one line of YAML that makes it count.
#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/filter/links_of_groups.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"
#include "scene/walker.h"

#include <gtest/gtest.h>

#include <set>

namespace proximity_server::scene::collision_from_visual_test {

using Names = std::set<std::string>;

class WalkerFromVisual : public ::testing::Test {
 protected:
  RobotModel load(const std::string& yaml) const { return load(yaml, {{"", urdf_}}); }
  static RobotModel load(const std::string& yaml, const std::vector<NamedUrdf>& robots) {
    const ModelOptions options = configFrom(yaml, "cell.yaml").robot.model;
    const std::vector<std::string> srdfs(robots.size(), kWalkerGroups);
    return loadRobots(robots, packageResolver({}), withLinksOfGroups(options, robots, srdfs));
  }
  std::string refusal(const std::string& yaml) const {
    return errorOf([&] { load(yaml); });
  }

  /// The links whose geometry is that of their <visual>.
  static Names taken(const RobotModel& model) {
    Names names;
    for (const Collision& collision : model.collisions)
      if (collision.is_visual) names.insert(model.links[collision.link].name);
    return names;
  }

  /// The closest pair where all joints are at 0.
  static PairProximity closest(const RobotModel& model) {
    PosedScene scene(modelOf(model));
    scene.update(forwardKinematics(model, std::vector<double>(model.joints.size(), 0.0)));
    return *scene.minimum(scene.candidates());
  }

  TemporaryFiles files_;
  std::string urdf_ = walker(files_);
};

// The walker has 7 links, so 21 pairs. The 6 pairs of neighbours are not checked.
TEST_F(WalkerFromVisual, OneLineMakesAWholeRobotCount) {
  const RobotModel model = load("collision_from_visual: all");
  EXPECT_EQ(taken(model), (Names{"pelvis", "left_thigh", "left_shank", "right_thigh", "right_shank"}));
  EXPECT_TRUE(model.warnings.empty()) << model.warnings[0];
  EXPECT_EQ(modelOf(model)->pairs.checked.size(), 15U);
  const PairProximity pair = closest(model);
  EXPECT_EQ(model.links[pair.asked.a.link()].name, "left_thigh");
  EXPECT_EQ(model.links[pair.asked.b.link()].name, "right_thigh");
  EXPECT_NEAR(pair.result.distance, 0.125, 1e-12);
}

TEST_F(WalkerFromVisual, WithoutThatLineOnlyTheFeetAreChecked) {
  const RobotModel model = load("tolerance: 1e-9");
  EXPECT_EQ(taken(model), Names());
  EXPECT_EQ(modelOf(model)->pairs.checked.size(), 1U);
  EXPECT_NEAR(closest(model).result.distance, 0.21875, 1e-12);
  ASSERT_EQ(model.warnings.size(), 1U);
  EXPECT_EQ(model.warnings[0],
            "Seen, but not checked, as they have no <collision>: 5 of 5 links with a <visual>: pelvis, left_thigh, "
            "left_shank, right_thigh, right_shank. The parameter collision_from_visual makes them count.");
}

TEST_F(WalkerFromVisual, OfAGroupIsThatOfTheLinksThatItMoves) {
  const RobotModel model = load("collision_from_visual: [pelvis, left_leg]");
  EXPECT_EQ(taken(model), (Names{"pelvis", "left_thigh", "left_shank"}));
  ASSERT_EQ(model.warnings.size(), 1U);
  EXPECT_NE(model.warnings[0].find("2 of 5 links with a <visual>: right_thigh, right_shank."), std::string::npos);
  EXPECT_EQ(taken(load("collision_from_visual: [legs]")).size(), 4U);
}

TEST_F(WalkerFromVisual, OfANameOfBothIsThatOfTheLink) {
  EXPECT_EQ(taken(load("collision_from_visual: [left_thigh]")), Names{"left_thigh"});
}

TEST_F(WalkerFromVisual, OfSeveralRobotsNamesTheGroupsOfEach) {
  const std::vector<NamedUrdf> robots = {{"a", urdf_}, {"b", urdf_}};
  EXPECT_EQ(taken(load("collision_from_visual: [a/left_leg, b/pelvis]", robots)),
            (Names{"a/left_thigh", "a/left_shank", "b/pelvis"}));
  EXPECT_EQ(taken(load("collision_from_visual: all", robots)).size(), 10U);
  EXPECT_NE(errorOf([&] {
              load("collision_from_visual: [left_leg]", robots);
            }).find("the SRDF has no group \"left_leg\" (did you mean \"a/left_leg\"?)"),
            std::string::npos);
}

TEST_F(WalkerFromVisual, OfANameThatIsNeitherLinkNorGroupIsRefused) {
  EXPECT_EQ(refusal("collision_from_visual: [left_lg]"),
            "collision_from_visual: no link \"left_lg\": the SRDF has no group \"left_lg\" (did you mean "
            "\"left_leg\"?); it has left_leg, right_leg, legs, left_thigh");
  EXPECT_NE(refusal("collision_from_visual: [all, pelviss]").find("no link \"pelviss\" (did you mean \"pelvis\"?)"),
            std::string::npos);
}

TEST_F(WalkerFromVisual, OfAMeshThatIsTooFineIsRefusedByLinkWithTheCure) {
  TriangleMesh fine = boxMesh({-0.25, -0.25, -0.25}, {0.5, 0.5, 0.5});
  fine.triangles.resize(200001, fine.triangles.front());
  const std::string file = files_.write("pelvis.stl", stlOf(fine));
  EXPECT_EQ(refusal("collision_from_visual: all"),
            "URDF: link \"pelvis\", <collision> 1, of its <visual>: mesh " + file +
                ": it has 200001 triangles, more than 200000. Give the link a coarser <visual> or a <collision> of "
                "its own, or leave it out of collision_from_visual");
  EXPECT_EQ(refusal("collision_from_visual: [legs]"), "");
  const RobotModel model = load("collision_from_visual: all\nallow_missing_meshes: true");
  EXPECT_EQ(taken(model).size(), 5U);
  ASSERT_EQ(model.warnings.size(), 1U);
  EXPECT_EQ(model.warnings[0], "link \"pelvis\", <collision> 1, of its <visual>: no geometry: mesh " + file +
                                   ": it has 200001 triangles, more than 200000.");
}

}  // namespace proximity_server::scene::collision_from_visual_test
