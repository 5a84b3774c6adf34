#include "proximity_server/scene/separation.h"

#include "laws/refusals.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::separation_test {

using narrowphase::Status;

// "slide" carries a box of edge 1 along x; its front is at x = 0.5 + slide. "pan" moves nothing that has geometry. The
// post at y = 5 is a part of the root.
const std::string kRobot =
    urdfOf(link("frame") + link("post", ball("0.1", "0 5 0")) + link("sled", box("1 1 1")) + link("sensor") +
           weld("weld", "frame", "post") + slider("slide", "frame", "sled", "1 0 0") +
           slider("pan", "frame", "sensor", "0 0 1"));

/// A ball of radius 0.2 m that stands still.
Object person(const std::string& id, double x, double y = 0.0) {
  return makeObject(id, {{narrowphase::Sphere{0.2}}}, Fixed{Eigen::Isometry3d(Eigen::Translation3d(x, y, 0.0))});
}

class SledBesidePersons : public testing::Test {
 protected:
  SledBesidePersons() {
    state_.velocities.assign(robot().joints.size(), 0.0);
    braking_ = {0.1, std::vector<double>(robot().joints.size(), 2.0)};
    stand({});
  }
  const RobotModel& robot() const { return model_->robot; }
  void stand(const std::map<std::string, double>& positions) { scene_.update(forwardKinematics(robot(), positions)); }
  void move(const std::string& name, double velocity) {
    for (std::size_t i = 0; i < robot().joints.size(); ++i)
      if (robot().joints[i].name == name) state_.velocities[i] = velocity;
  }
  void add(const Object& object, bool is_tracked = true) {
    objects_ = std::make_shared<const Objects>(objects_->changed({AddObject{object}}));
    scene_.use(objects_);
    moving_.use(objects_);
    stand({});
    if (!is_tracked) return;
    tracked_.push_back({objects_->find(object.id)});
    tracked_.back().intrusion = 0.1;
    tracked_.back().uncertainty = 0.05;
  }
  Separation ask() { return separation(moving_, scene_.scene, scene_.state, state_, braking_, tracked_); }

  const std::shared_ptr<const SceneModel> model_ = modelOf(robotOf(kRobot));
  std::shared_ptr<const Objects> objects_ = std::make_shared<const Objects>(model_);
  PosedScene scene_{model_};
  MotionSearch moving_{model_};
  MovingState state_;
  Braking braking_;
  std::vector<Tracked> tracked_;
};

TEST_F(SledBesidePersons, TermsAreThoseOfTheFormula) {
  add(person("far", 50.0));
  add(person("near", 4.2));
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_EQ(found.status, Status::Converged);
  EXPECT_EQ(found.tracked, 1);
  EXPECT_EQ(robot().links[found.pair.asked.a.link()].name, "sled");
  EXPECT_NEAR(found.distance, 4.2 - 0.2 - 0.5, 1e-8);
  EXPECT_EQ(found.human_speed, 2.0);
  EXPECT_NEAR(found.robot_speed, 1.0, 1e-8);
  EXPECT_EQ(found.reaction_time, 0.1);
  EXPECT_EQ(found.stopping_time, 0.5);
  EXPECT_NEAR(found.human_way, 2.0 * 0.6, 1e-12) << "less than 0.35 + 1.6 * 0.6";
  EXPECT_NEAR(found.reaction_way, 0.1, 1e-8);
  EXPECT_NEAR(found.stopping_way, 0.25, 1e-5);
  EXPECT_NEAR(found.protective_distance, 1.2 + 0.35 + 0.15, 1e-5);
  EXPECT_NEAR(found.margin, found.distance - found.protective_distance, 1e-12);
  EXPECT_EQ(found.scale, 1.0);
}

TEST_F(SledBesidePersons, ScaleIsTheOneWhoseOwnStopKeepsTheDistance) {
  add(person("near", 1.7));  // 1 m away
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_LT(found.margin, 0.0);
  const double expected = (std::sqrt(1.1 * 1.1 + 0.65) - 1.1) / 0.5;  // 1 - 0.1 s - 0.25 s^2 = 0.15 + 2 (0.1 + 0.5 s)
  EXPECT_LE(found.scale, expected);
  EXPECT_GT(found.scale, expected - kScaleTolerance);
}

TEST_F(SledBesidePersons, SlowPersonsCountOnlyOutsideOfHalfAMetre) {
  braking_.latency = 1.0;
  add(person("near", 4.2));
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_EQ(found.human_speed, 1.6);
  EXPECT_NEAR(found.human_way, 0.35 + 1.6 * 1.5, 1e-12) << "less than 2 * 1.5";
}

TEST_F(SledBesidePersons, AgeIsTimeForThePerson) {
  add(person("near", 4.2));
  tracked_[0].older = 0.4;
  move("slide", 1.0);
  EXPECT_NEAR(ask().human_way, 0.35 + 1.6 * 1.0, 1e-12);
  tracked_[0].older = -5.0;  // seen after the poses
  EXPECT_EQ(ask().human_way, 0.0);
}

TEST_F(SledBesidePersons, RetreatAndRestAreNotSlowed) {
  add(person("near", 0.8));  // 0.1 m away
  move("slide", -1.0);
  const Separation found = ask();
  EXPECT_LT(found.margin, 0.0);
  EXPECT_EQ(found.robot_speed, 0.0);
  EXPECT_EQ(found.scale, 1.0);
  move("slide", 0.0);
  move("pan", 1.0);
  EXPECT_EQ(ask().scale, 1.0);
  move("slide", 1.0);
  EXPECT_EQ(ask().scale, 0.0);
}

TEST_F(SledBesidePersons, ContactStopsTheRobotUnlessItRetreats) {
  add(person("touching", 0.6));
  move("slide", 1.0);
  EXPECT_NEAR(ask().distance, -0.1, 1e-8);
  EXPECT_LT(ask().margin, -0.1);
  EXPECT_EQ(ask().scale, 0.0);
  move("slide", -1.0);
  EXPECT_EQ(ask().scale, 1.0);
}

TEST_F(SledBesidePersons, TheWorstOfTwoPersonsCounts) {
  add(person("behind", -0.8));  // 0.1 m behind the sled
  add(person("ahead", 1.7));
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_EQ(found.tracked, 0) << "has the smallest margin";
  EXPECT_GT(found.scale, 0.5) << "slowed by the other one only";
  EXPECT_LT(found.scale, 0.55);
}

TEST_F(SledBesidePersons, PartsThatNoJointMovesAreNoHazard) {
  add(person("beside the post", 0.0, 5.0));
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_GT(found.distance, 3.0);
  EXPECT_EQ(robot().links[found.pair.asked.a.link()].name, "sled");
}

TEST_F(SledBesidePersons, WhatALinkHoldsIsAHazard) {
  add(makeObject("pole", {{narrowphase::Sphere{0.1}}},
                 Attached{"sled", {}, Eigen::Isometry3d(Eigen::Translation3d(1.0, 0.0, 0.0))}),
      false);
  add(person("near", 1.7));
  const Separation found = ask();
  EXPECT_NEAR(found.distance, 0.4, 1e-8);
  EXPECT_EQ(objects_->object(found.pair.asked.a.object())->id, "pole");
}

TEST_F(SledBesidePersons, NobodyLeavesTheRobotFree) {
  move("slide", 1.0);
  const Separation found = ask();
  EXPECT_EQ(found.status, Status::Converged);
  EXPECT_EQ(found.scale, 1.0);
  EXPECT_EQ(found.tracked, -1);
  EXPECT_EQ(found.margin, std::numeric_limits<double>::infinity());
}

TEST_F(SledBesidePersons, UncertaintyOfTheRobotIsATerm) {
  add(person("near", 4.2));
  state_.largest_loss = 0.02;
  const Separation found = ask();
  EXPECT_EQ(found.robot_uncertainty, 0.02);
  EXPECT_NEAR(found.protective_distance, 2.0 * 0.1 + 0.17, 1e-9) << "at rest";
}

TEST_F(SledBesidePersons, NothingIsPromisedOfWhatIsNotKnown) {
  add(person("near", 4.2));
  move("slide", std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(ask().status, Status::Unknown);
  EXPECT_EQ(ask().scale, 0.0);
  move("slide", 1.0);
  scene_.update(BodyPoses(robot().bodies.size()));
  EXPECT_EQ(ask().status, Status::Unknown);
  EXPECT_EQ(ask().scale, 0.0);
}

TEST_F(SledBesidePersons, RefusesWhatMakesNoSense) {
  add(person("near", 4.2));
  const auto refuses = [&](Tracked who, const std::string& text) {
    tracked_ = {who};
    EXPECT_TRUE(isRefused([&] { ask(); }, text));
  };
  const int number = objects_->find("near");
  refuses({number + 1}, "there is no object");
  refuses({number, -1.0}, "the speed of 'near' is -1");
  refuses({number, 1.6, 1.0}, "the speed near the robot of 'near' is 1");
  refuses({number, 1.6, 2.0, std::nan("")}, "the age of 'near' is");
  refuses({number, 1.6, 2.0, 0.0, -0.1}, "the intrusion of 'near' is -0.1");
}

}  // namespace proximity_server::scene::separation_test
