#include "proximity_server/scene/answers/deciding_pair.h"

#include "scene/posed_scene.h"
#include "scene/random_objects.h"
#include "scene/uncertainty/uncertain_states.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace proximity_server::scene::guaranteed_level_test {

/// Three balls of radius 0.1 on sliders along x, 0.3 m and 0.8 m apart.
const auto kRail = urdfOf(link("rail") + link("left", ball("0.1")) + link("middle", ball("0.1")) +
                          link("right", ball("0.1")) + slider("l", "rail", "left", "1 0 0") +
                          slider("m", "rail", "middle", "1 0 0") + slider("r", "rail", "right", "1 0 0"));

class GuaranteedLevel : public testing::Test {
 protected:
  GuaranteedLevel() {
    const BodyPoses poses = forwardKinematics(model_->robot, std::vector<double>{-1.0, 0.0, 0.5});
    scene_.update(poses);
  }
  /// With an uncertainty of the left joint only.
  DecidingPair deciding(double uncertainty) {
    Uncertainty within(model_->robot);
    within.positions[0] = uncertainty;
    distances_.assume(within);
    const Pairs pairs(scene_.candidates());
    const PairProximity closest = *scene_.minimum(pairs);
    const ListedPairs listed{&closest, &closest + 1, closest.result.lower_bound};
    return decidingPair(scene_.scene, scene_.state, pairs, closest, {thresholds_, {}, {}, &distances_, listed});
  }
  std::string nameOfA(const DecidingPair& deciding) const { return nameOf(deciding.pair.asked.a, model_->robot); }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kRail);
  PosedScene scene_{model_};
  GuaranteedDistances distances_{model_};
  LevelThresholds thresholds_;
};

TEST_F(GuaranteedLevel, IsThatOfThePairWithTheSmallestGuaranteedDistance) {
  EXPECT_EQ(nameOfA(deciding(0.1)), "middle");
  EXPECT_EQ(deciding(0.1).level.level, ClearanceLevel::Clear);
  const DecidingPair far = deciding(0.76);
  EXPECT_EQ(nameOfA(far), "left");
  EXPECT_NEAR(far.guaranteed, 0.04, 1e-9);
  EXPECT_EQ(far.level.level, ClearanceLevel::Warn);
  EXPECT_EQ(deciding(0.79).level.level, ClearanceLevel::Stop);
  EXPECT_EQ(deciding(0.9).level.level, ClearanceLevel::Stop);  // contact is possible, but there is none
}

TEST_F(GuaranteedLevel, HeedsTheThresholdsOfEachPair) {
  thresholds_.stop.setPair(2, 3, 0.31);
  thresholds_.warn.setPair(2, 3, 0.32);
  EXPECT_EQ(nameOfA(deciding(0.76)), "middle");
  EXPECT_EQ(deciding(0.76).level.level, ClearanceLevel::Stop);
  thresholds_.stop.setPair(2, 3, 0.0);
  EXPECT_EQ(deciding(0.76).level.level, ClearanceLevel::Warn);
}

TEST_F(GuaranteedLevel, IsACollisionOnlyInContact) {
  const BodyPoses poses = forwardKinematics(model_->robot, std::vector<double>{-1.0, 0.0, 0.15});
  scene_.update(poses);
  const DecidingPair contact = deciding(0.9);
  EXPECT_EQ(contact.level.level, ClearanceLevel::Collision);
  EXPECT_EQ(nameOfA(contact), "middle");
}

TEST(FrameSpeeds, AreByNameOrOfAllOthers) {
  const auto speeds = [](const std::string& yaml) { return frameSpeedsFrom(readYaml(yaml, "file"), "file"); };
  EXPECT_EQ(speedOf(speeds("{}"), "cart"), nullptr);
  EXPECT_EQ(speedOf(speeds("{cart: 0.5}"), "door"), nullptr);
  EXPECT_EQ(speedOf(speeds("{cart: 0.5}"), "cart")->translation, 0.5);
  EXPECT_EQ(speedOf(speeds("{translation: 1, angle: 2}"), "cart")->angle, 2.0);
  EXPECT_EQ(speedOf(speeds("{cart: 0.5, '*': 0}"), "door")->translation, 0.0);
  EXPECT_EQ(speedOf(speeds("0.25"), "door")->translation, 0.25);
  EXPECT_THROW(speeds("{cart: -1}"), std::invalid_argument);
}

TEST(UncertaintyOfNothing, IsZero) {
  const auto model = modelOf(kRail);
  EXPECT_TRUE(Uncertainty(model->robot).isZero());
  EXPECT_TRUE(uncertaintyFrom("{}", "text", model->robot).isZero());
  EXPECT_TRUE(uncertaintyFrom("0", "text", model->robot).isZero());
  EXPECT_FALSE(uncertaintyFrom("0.1", "text", model->robot).isZero());
  EXPECT_FALSE(uncertaintyFrom("object_uncertainty: {cup: 0.1}", "text", model->robot).isZero());
  EXPECT_FALSE(uncertaintyFrom("link_uncertainty: {left: 0.1}", "text", model->robot).isZero());
}

}  // namespace proximity_server::scene::guaranteed_level_test
