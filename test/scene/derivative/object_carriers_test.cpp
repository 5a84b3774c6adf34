// What carries objects decides which joints change their distances.
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene::object_carriers_test {

/// Two spheres of radius 0.1 m on a rail along x.
const char* const kRail = R"(<robot name="rail"><link name="rail"/>
  <link name="left"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="right"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="to_left" type="prismatic"><parent link="rail"/><child link="left"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
  <joint name="to_right" type="prismatic"><parent link="rail"/><child link="right"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>)";

class CarriedObjects : public testing::Test {
 protected:
  static Object ball(const std::string& id, const Placement& placement) {
    return makeObject(id, {{narrowphase::Shape(narrowphase::Sphere{0.1})}}, placement);
  }
  int body(const std::string& link) const {
    return model_->robot.links[static_cast<std::size_t>(model_->robot.findLink(link))].body;
  }
  /// Of the left sphere, at x = -1 m, and an object to the right of it.
  std::vector<double> gradientTo(const std::string& id) {
    scene_.use(objects_);
    const BodyPoses poses = forwardKinematics(model_->robot, std::vector<double>{-1.0, 1.0});
    scene_.update(poses, {Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()});
    derivatives_.update(poses);
    const ShapeRefPair pair{{model_->robot.findLink("left")}, ShapeRef::ofObject(objects_->find(id))};
    Eigen::VectorXd row(2);
    EXPECT_TRUE(derivatives_.gradient(scene_.proximity(pair), row));
    return {row[0], row[1]};
  }

  std::shared_ptr<const SceneModel> model_ =
      std::make_shared<const SceneModel>(makeSceneModel(loadRobotModel(kRail, packageResolver({})), std::string()));
  /// In the order of their frames: "a", "b".
  std::shared_ptr<const Objects> objects_ = std::make_shared<const Objects>(Objects(model_).changed(
      {AddObject{ball("standing", Fixed{Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.0))})},
       AddObject{ball("in_b", Moving{"b"})}, AddObject{ball("in_a", Moving{"a"})}}));
  Scene scene_{model_};
  Derivatives derivatives_{model_};
};

TEST_F(CarriedObjects, RestUnlessSomethingCarriesThem) {
  derivatives_.use(objects_);
  for (const char* id : {"standing", "in_a", "in_b"}) EXPECT_EQ(gradientTo(id), (std::vector<double>{-1.0, 0.0})) << id;
}

TEST_F(CarriedObjects, MoveWithTheBodyOfTheirFrame) {
  derivatives_.use(objects_, {-1, {body("right"), -1}});
  EXPECT_EQ(gradientTo("standing"), (std::vector<double>{-1.0, 0.0}));
  EXPECT_EQ(gradientTo("in_a"), (std::vector<double>{-1.0, 1.0}));
  EXPECT_EQ(gradientTo("in_b"), (std::vector<double>{-1.0, 0.0}));
}

TEST_F(CarriedObjects, MoveWithTheBodyInWhoseFrameTheyStand) {
  derivatives_.use(objects_, {body("right"), {-1, body("left")}});
  EXPECT_EQ(gradientTo("standing"), (std::vector<double>{-1.0, 1.0}));
  EXPECT_EQ(gradientTo("in_a"), (std::vector<double>{-1.0, 0.0}));
  EXPECT_EQ(gradientTo("in_b"), (std::vector<double>{0.0, 0.0})) << "both are on one body";
}

TEST_F(CarriedObjects, NeedOneCarrierForEachFrame) {
  EXPECT_THROW(derivatives_.use(objects_, {-1, {-1}}), std::invalid_argument);
  EXPECT_THROW(derivatives_.use(objects_, {-1, {}}), std::invalid_argument);
}

TEST_F(CarriedObjects, RefuseACarrierThatIsNoBody) {
  EXPECT_THROW(derivatives_.use(objects_, {3, {-1, -1}}), std::invalid_argument);
  EXPECT_THROW(derivatives_.use(objects_, {-1, {-2, -1}}), std::invalid_argument);
}

}  // namespace proximity_server::scene::object_carriers_test
