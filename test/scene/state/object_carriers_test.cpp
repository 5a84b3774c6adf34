// The carriers of objects decide which joints change their distances.
#include "proximity_server/scene/derivative/derivatives.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::object_carriers_test {

class CarriedObjects : public testing::Test {
 protected:
  static Object ball(const std::string& id, const Placement& placement) {
    return makeObject(id, {{narrowphase::Shape(narrowphase::Sphere{0.1})}}, placement);
  }
  int body(const std::string& link) const { return bodyOf(model_->robot, link); }
  /// The gradient of the left sphere, at x = -1 m, to an object on its right.
  std::vector<double> gradientTo(const std::string& id) {
    const BodyPoses poses = forwardKinematics(model_->robot, std::vector<double>{-1.0, 1.0});
    scene_.update(poses, {Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()});
    const ShapeRefPair pair{{model_->robot.findLink("left")}, ShapeRef::ofObject(objects_->find(id))};
    Eigen::VectorXd row(2);
    EXPECT_TRUE(gradient(scene_.state, scene_.proximity(pair), row));
    return {row[0], row[1]};
  }

  std::shared_ptr<const SceneModel> model_ =
      modelOf(onRail({{"left", robots::ball("0.1")}, {"right", robots::ball("0.1")}}));
  /// In the order of their frames: "a", "b".
  std::shared_ptr<const Objects> objects_ = std::make_shared<const Objects>(
      Objects(model_).changed({AddObject{ball("standing", Fixed{at(0, 0, 0)})}, AddObject{ball("in_b", Moving{"b"})},
                               AddObject{ball("in_a", Moving{"a"})}}));
  PosedScene scene_{model_};
};

TEST_F(CarriedObjects, RestUnlessSomethingCarriesThem) {
  scene_.use(objects_);
  for (const char* id : {"standing", "in_a", "in_b"}) EXPECT_EQ(gradientTo(id), (std::vector<double>{-1.0, 0.0})) << id;
}

TEST_F(CarriedObjects, MoveWithTheBodyOfTheirFrame) {
  scene_.use(objects_, {-1, {body("right"), -1}});
  EXPECT_EQ(gradientTo("standing"), (std::vector<double>{-1.0, 0.0}));
  EXPECT_EQ(gradientTo("in_a"), (std::vector<double>{-1.0, 1.0}));
  EXPECT_EQ(gradientTo("in_b"), (std::vector<double>{-1.0, 0.0}));
}

TEST_F(CarriedObjects, MoveWithTheBodyInWhoseFrameTheyStand) {
  scene_.use(objects_, {body("right"), {-1, body("left")}});
  EXPECT_EQ(gradientTo("standing"), (std::vector<double>{-1.0, 1.0}));
  EXPECT_EQ(gradientTo("in_a"), (std::vector<double>{-1.0, 0.0}));
  EXPECT_EQ(gradientTo("in_b"), (std::vector<double>{0.0, 0.0})) << "both are on one body";
}

TEST_F(CarriedObjects, NeedOneCarrierForEachFrame) {
  EXPECT_THROW(scene_.use(objects_, {-1, {-1}}), std::invalid_argument);
  EXPECT_THROW(scene_.use(objects_, {-1, {}}), std::invalid_argument);
}

TEST_F(CarriedObjects, RefuseACarrierThatIsNoBody) {
  EXPECT_THROW(scene_.use(objects_, {3, {-1, -1}}), std::invalid_argument);
  EXPECT_THROW(scene_.use(objects_, {-1, {-2, -1}}), std::invalid_argument);
}

}  // namespace proximity_server::scene::object_carriers_test
