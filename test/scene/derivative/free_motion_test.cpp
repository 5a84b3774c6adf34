#include "proximity_server/scene/derivative/free_motion.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "sanitized.h"
#include "scene/derivative/moved_robot.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene::free_motion_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// A ball of radius 0.1 on an arm: "swing" turns about z at the origin, "reach" moves it along x, the ball is at (2, 0,
/// 0); a post stands at (0, 3, 0), with a radius of 0.5.
const std::string kCrane =
    urdfOf(link("post", ball("0.5", "0 3 0")) + link("mast") + link("hook", ball("0.1")) +
           hinge("swing", "post", "mast", "0 0 1") + slider("reach", "mast", "hook", "1 0 0", "2 0 0.5"));

/// The weights of a pair in each column, with all joints at 0.
void expectWeights(const std::string& urdf, const char* a, const char* b, const std::vector<double>& expected) {
  const auto model = modelOf(urdf);
  FreeMotion free(model);
  State state(model);
  state.set(forwardKinematics(model->robot, {}));
  ASSERT_EQ(state.degreesOfFreedom().size(), static_cast<int>(expected.size()));
  VectorXd weights(state.degreesOfFreedom().size());
  for (const ShapeRefPair& pair : {pairOf(*model, a, b), pairOf(*model, b, a)}) {
    ASSERT_TRUE(free.weights(state, pair, weights));
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(weights[i], expected[i], expected[i] == 0.0 ? 0.0 : 1e-12) << i;
  }
}

TEST(FreeMotion, WeightOfARotationIsTheRadiusAboutItsAxisAndOfATranslationOne) {
  expectWeights(kCrane, "post", "hook", {2.1, 1.0});
}

TEST(FreeMotion, JointsThatCarryBothHaveNoWeight) {
  expectWeights(
      urdfOf(link("base", ball("0.1")) + link("table", ball("0.1", "0 0 1")) + link("lift", ball("0.1", "1 0 0")) +
             hinge("turn", "base", "table", "0 0 1") + slider("up", "table", "lift", "0 0 1")),
      "table", "lift", {0.0, 1.0});
}

TEST(FreeMotion, FollowerAddsItsRadiusTimesItsMultiplier) {
  expectWeights(urdfOf(link("palm") + link("left", ball("0.1", "0.3 0 0")) + link("right", ball("0.1", "0.4 0 0")) +
                       hinge("open", "palm", "left", "0 0 1") +
                       joint("follow", "continuous", "palm", "right", axis("0 0 1") + mimic("open", "-2"))),
                "left", "right", {0.4 + 2.0 * 0.5});
}

TEST(FreeMotion, PlanarJointTurnsAboutItsNormalAndAFloatingOneAboutItsOrigin) {
  const std::string urdf = urdfOf(
      link("floor", ball("0.1", "0 9 0")) + link("cart", ball("0.1", "0.3 0 7")) + link("kite", ball("0.1", "0 3 4")) +
      joint("drive", "planar", "floor", "cart", axis("0 0 1")) + joint("fly", "floating", "floor", "kite"));
  expectWeights(urdf, "floor", "cart", {1, 1, 0.4, 0, 0, 0, 0, 0, 0});
  expectWeights(urdf, "floor", "kite", {0, 0, 0, 1, 1, 1, 5.1, 5.1, 5.1});
}

TEST(FreeMotion, RadiusOfABoxIsThatOfItsFarthestCorner) {
  const auto plateAt = [](const std::string& place) {
    return urdfOf(link("base", ball("0.1")) + link("plate", box("0.6 0.8 5", place)) +
                  hinge("turn", "base", "plate", "0 0 1"));
  };
  expectWeights(plateAt("0 0 0"), "base", "plate", {0.5});
  for (const char* beside : {"1 1 0", "-1 1 0", "1 -1 0", "-1 -1 0"})
    expectWeights(plateAt(beside), "base", "plate", {std::hypot(1.3, 1.4)});
}

TEST(FreeMotion, PairIsUnknownWhileAPoseBetweenIsMissing) {
  const auto model = modelOf(kCrane);
  FreeMotion free(model);
  BodyPoses poses = forwardKinematics(model->robot, {});
  poses[bodyOf(model->robot, "mast")] = std::nullopt;
  State state(model);
  state.set(poses);
  VectorXd weights(2);
  EXPECT_FALSE(free.weights(state, pairOf(*model, "post", "hook"), weights));
  EXPECT_TRUE(weights.array().isNaN().all());
}

TEST(FreeMotion, SizesThatDoNotFitAndUnknownNamesAreRefused) {
  const auto model = modelOf(kCrane);
  FreeMotion free(model);
  PosedScene scene(model);
  scene.update(forwardKinematics(model->robot, {}));
  VectorXd three(3), two(2);
  EXPECT_THROW(free.weights(scene.state, pairOf(*model, "post", "hook"), three), std::invalid_argument);
  EXPECT_THROW(free.weights(scene.state, {{0}, ShapeRef::ofObject(4)}, two), std::invalid_argument);
  EXPECT_THROW(free.weights(scene.state, {{0}, {17}}, two), std::invalid_argument);
  EXPECT_THROW(free.scale(three), std::invalid_argument);
  EXPECT_THROW(free.alone(2), std::invalid_argument);
  FreeMotionQuestion question;
  question.thresholds.links = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(free.find(scene.scene, scene.state, question), std::invalid_argument);
}

// --- of a scene

/// The crane's hook is sqrt(2^2 + 3^2 + 0.5^2) - 0.6 from the post.
class CraneInAScene : public testing::Test {
 protected:
  CraneInAScene() { scene_.update(forwardKinematics(model_->robot, {})); }
  void find(double threshold, double influence) {
    FreeMotionQuestion question;
    question.thresholds = {threshold, threshold};
    question.influence_distance = influence;
    free_.find(scene_.scene, scene_.state, question);
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kCrane);
  PosedScene scene_{model_};
  FreeMotion free_{model_};
  const double distance_ = std::sqrt(13.25) - 0.6;
};

TEST_F(CraneInAScene, NearPairHasItsOwnDistance) {
  find(0.5, 10.0);
  ASSERT_TRUE(free_.isKnown());
  ASSERT_EQ(free_.size(), 2);
  EXPECT_NEAR(free_[0].free, distance_ - 0.5, 1e-9);
  EXPECT_NEAR(free_.alone(0), (distance_ - 0.5) / 2.1, 1e-9);
  EXPECT_NEAR(free_.alone(1), distance_ - 0.5, 1e-9);
}

TEST_F(CraneInAScene, FarPairsHaveTheInfluenceDistance) {
  find(0.5, 1.0);
  ASSERT_EQ(free_.size(), 1);
  EXPECT_NEAR(free_[0].free, 0.5, 1e-12);
  EXPECT_NEAR(free_.alone(0), 0.5 / 2.1, 1e-12);
}

TEST_F(CraneInAScene, ScaleIsHowMuchOfAMotionIsFree) {
  find(0.5, 10.0);
  const VectorXd motion = Eigen::Vector2d(-1.0, 0.5);
  const double scale = (distance_ - 0.5) / (2.1 + 0.5);
  EXPECT_NEAR(free_.scale(motion), scale, 1e-9);
  EXPECT_FALSE(free_.contains(motion));
  EXPECT_TRUE(free_.contains(0.999 * scale * motion));
  EXPECT_EQ(free_.scale(0.999 * scale * motion), 1.0);
  EXPECT_FALSE(free_.contains(Eigen::Vector2d(0.0, std::numeric_limits<double>::quiet_NaN())));
}

TEST_F(CraneInAScene, NothingIsFreeBelowTheThresholdButRest) {
  find(distance_ + 1.0, 10.0);
  EXPECT_TRUE(free_.isKnown());
  EXPECT_EQ(free_.alone(0), 0.0);
  EXPECT_EQ(free_.scale(Eigen::Vector2d(1e-9, 0.0)), 0.0);
  EXPECT_TRUE(free_.contains(Eigen::Vector2d::Zero()));
}

TEST_F(CraneInAScene, NothingIsFreeWhileAPairIsUnknown) {
  BodyPoses poses = forwardKinematics(model_->robot, {});
  poses[bodyOf(model_->robot, "hook")] = std::nullopt;
  scene_.update(poses);
  find(0.0, 1.0);
  EXPECT_FALSE(free_.isKnown());
  EXPECT_EQ(free_.alone(0), 0.0);
  EXPECT_FALSE(free_.contains(Eigen::Vector2d::Zero()));
}

TEST(FreeMotion, NoPairHasLargerWeightsThanTheBubbleOfAllOthers) {
  Chance chance(6);
  for (int i = 0; i < repeats(200); ++i) {
    const auto model = someRobot(chance);
    FreeMotion free(model);
    PosedScene scene(model);
    const BodyPoses poses = somePoses(model->robot, scene.state.degreesOfFreedom(), chance);
    scene.update(poses);
    FreeMotionQuestion question;
    question.influence_distance = -10.0;
    question.thresholds = {-10.0, -10.0};
    free.find(scene.scene, scene.state, question);
    ASSERT_TRUE(free.isKnown());
    ASSERT_EQ(free.size(), 1);
    VectorXd weights(scene.state.degreesOfFreedom().size());
    for (const ShapeRefPair& pair : scene.candidates()) {
      ASSERT_TRUE(free.weights(scene.state, pair, weights));
      EXPECT_TRUE((weights.array() <= free[0].weights.array()).all());
    }
  }
}

TEST(FreeMotion, AttachedObjectHasTheRadiusOfItsPlace) {
  const auto model = modelOf(kCrane);
  FreeMotion free(model);
  PosedScene scene(model);
  const auto objects = std::make_shared<const Objects>(Objects(model).changed(
      {AddObject{makeObject("load", {{narrowphase::Sphere{0.1}}}, Attached{"hook", {}, at(1, 0, 0)})},
       AddObject{makeObject("wall", {{HalfSpace{Vector3d::UnitX(), -5.0}}}, Fixed{})}}));
  scene.use(objects);
  scene.update(forwardKinematics(model->robot, {}));
  VectorXd weights(2);
  ASSERT_TRUE(free.weights(
      scene.state, {ShapeRef::ofObject(objects->find("load")), ShapeRef::ofObject(objects->find("wall"))}, weights));
  EXPECT_NEAR(weights[0], 3.1, 1e-12);
  EXPECT_NEAR(weights[1], 1.0, 1e-12);
  FreeMotionQuestion question;
  question.influence_distance = 1.0;
  question.thresholds = {0.0, 0.25};
  free.find(scene.scene, scene.state, question);
  ASSERT_EQ(free.size(), 1);
  EXPECT_NEAR(free.alone(0), 0.75 / 3.1, 1e-12);
}

// The frame is that of a link 1 m from the origin of its body, and the geometry of objects is in that frame.
TEST(FreeMotion, ObjectsThatABodyCarriesHaveTheRadiusOfTheirPlace) {
  const auto model =
      modelOf(urdfOf(link("post", ball("0.5", "0 3 0")) + link("mast") + link("hook", ball("0.1")) + link("tip") +
                     hinge("swing", "post", "mast", "0 0 1") + slider("reach", "mast", "hook", "1 0 0", "2 0 0.5") +
                     joint("weld", "fixed", "hook", "tip", "<origin xyz=\"1 0 0\"/>")));
  FreeMotion free(model);
  PosedScene scene(model);
  const BodyPoses poses = forwardKinematics(model->robot, {});
  const auto expectWeights = [&](const Object& object, const std::vector<double>& expected) {
    SCOPED_TRACE(object.id);
    const auto objects = std::make_shared<const Objects>(Objects(model).changed({AddObject{object}}));
    const ShapeRefPair pair{{model->robot.findLink("post")}, ShapeRef::ofObject(objects->find(object.id))};
    scene.use(objects, carriersOnLinks(*objects));
    setPoses(scene.state, poses);
    VectorXd weights(2);
    ASSERT_TRUE(free.weights(scene.state, pair, weights));
    FreeMotionQuestion question;
    question.influence_distance = -10.0;
    question.thresholds = {-10.0, -10.0};
    free.find(scene.scene, scene.state, question);
    ASSERT_EQ(free.size(), 1);
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(weights[i], expected[static_cast<std::size_t>(i)], 1e-12);
      EXPECT_GE(free[0].weights[i], weights[i]);
    }
    scene.update(poses);  // without those of frames
    EXPECT_EQ(free.weights(scene.state, pair, weights), object.id == "wall");
  };
  expectWeights(makeObject("load", {{narrowphase::Sphere{0.1}}}, Moving{"tip", at(1, 0, 0)}), {4.1, 1.0});
  // Seen from the half-space, which turns with the mast, the post turns about the mast.
  expectWeights(makeObject("wall", {{HalfSpace{Vector3d::UnitX(), -9.0}}}, Moving{"tip"}), {3.5, 1.0});
}

// Regression: bubbles of the pairs before the one that threw were taken for those of all pairs.
TEST_F(CraneInAScene, NothingIsKnownAfterAFailure) {
  find(0.0, 10.0);
  ASSERT_TRUE(free_.isKnown());
  PairProximity unknown = *scene_.minimum(scene_.candidates());
  unknown.asked.b = ShapeRef::ofObject(0);
  EXPECT_THROW(free_.find(scene_.state, &unknown, &unknown + 1, {}), std::invalid_argument);
  EXPECT_FALSE(free_.isKnown());
  EXPECT_EQ(free_.alone(0), 0.0);
}

TEST_F(CraneInAScene, AnotherRobotIsRefused) {
  PosedScene other(modelOf(kCrane));
  other.update(forwardKinematics(model_->robot, {}));
  VectorXd weights(2);
  EXPECT_THROW(free_.find(other.scene, scene_.state, {}), std::invalid_argument);
  EXPECT_THROW(free_.find(scene_.scene, other.state, {}), std::invalid_argument);
  EXPECT_THROW(free_.find(other.scene, other.state, {}), std::invalid_argument);
  EXPECT_THROW(free_.find(other.state, nullptr, nullptr, {}), std::invalid_argument);
  EXPECT_THROW(free_.weights(other.state, pairOf(*model_, "post", "hook"), weights), std::invalid_argument);
  EXPECT_FALSE(free_.isKnown());
}

}  // namespace proximity_server::scene::free_motion_test
