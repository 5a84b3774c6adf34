#include "proximity_server/scene/velocity_scale.h"

#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace proximity_server::scene::velocity_scale_test {

using Eigen::Vector3d;
using narrowphase::Status;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// On the x axis a wall whose face stands at x = 0.5, and a box of edge 1 that "slide" carries from x = 3 on: the gap is
// 2 + slide. "aside" moves the box along y. "swing" turns a ball of radius 0.25, at (2, 5, 0), about the z axis through
// (0, 5, 0); "twin" follows "slide" at three times its speed, and carries a ball that is never near anything.
const std::string kRobot =
    urdfOf(link("frame") + link("wall", box("1 4 4")) + link("carriage") + link("sled", box("1 1 1")) +
           link("arm", ball("0.25", "2 0 0")) + link("tail", ball("0.25", "0 0 90")) + weld("weld", "frame", "wall") +
           slider("slide", "frame", "carriage", "1 0 0", "3 0 0") + link("sensor") +
           slider("pan", "frame", "sensor", "0 0 1") +
           joint("aside", "prismatic", "carriage", "sled", axis("0 1 0") + limits("-0.5", "9")) +
           hinge("swing", "frame", "arm", "0 0 1", "0 5 0") +
           joint("twin", "prismatic", "frame", "tail", axis("1 0 0") + limits("-99", "99") + mimic("slide", "3")));

class StoppingRobot : public testing::Test {
 protected:
  using ByName = std::map<std::string, double>;

  explicit StoppingRobot(const std::string& inequalities = "[]") : model_(limitedBy(inequalities)) {
    braking_.deceleration.assign(robot().joints.size(), kInfinity);
    state_.velocities.assign(robot().joints.size(), 0.0);
    stand({});
  }

  const RobotModel& robot() const { return model_->robot; }

  void stand(const ByName& positions) { poses_ = forwardKinematics(robot(), positions); }
  static void set(const RobotModel& robot, const ByName& by_name, std::vector<double>& values) {
    for (std::size_t i = 0; i < robot.joints.size(); ++i)
      if (const auto found = by_name.find(robot.joints[i].name); found != by_name.end()) values[i] = found->second;
  }
  void move(const ByName& velocities) { set(robot(), velocities, state_.velocities); }
  void brake(double latency, const ByName& decelerations) {
    braking_.latency = latency;
    set(robot(), decelerations, braking_.deceleration);
  }
  void placeObjects(const std::vector<Object>& objects) {
    std::vector<ObjectChange> changes;
    for (const Object& object : objects) changes.push_back(AddObject{object});
    const auto all = std::make_shared<const Objects>(Objects(model_).changed(changes));
    scene_.use(all);
    moving_.use(all);
  }
  VelocityScale ask(std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max()) {
    scene_.update(poses_);
    return velocityScale(moving_, scene_.scene, scene_.state, state_, braking_, stop_, deadline);
  }

  std::set<std::string> namesOf(const PairProximity& pair) const {
    return {robot().links[pair.asked.a.link()].name, robot().links[pair.asked.b.link()].name};
  }

  static std::shared_ptr<const SceneModel> limitedBy(const std::string& inequalities) {
    RobotModel robot = robotOf(kRobot);
    setJointInequalities(readYaml(inequalities, ""), "", robot);
    return modelOf(std::move(robot));
  }

  const std::shared_ptr<const SceneModel> model_;
  PosedScene scene_{model_};
  MotionSearch moving_{model_};
  BodyPoses poses_;
  MovingState state_;
  Braking braking_;
  PairDistances stop_;
};

TEST_F(StoppingRobot, IsNotSlowedWhereTheWholeStopIsFree) {
  brake(0.1, {{"slide", 2.0}});
  move({{"slide", -1.0}});  // 0.1 m and 0.25 m for a gap of 2 m
  const VelocityScale scale = ask();
  EXPECT_EQ(scale.status, Status::Converged);
  EXPECT_EQ(scale.scale, 1.0);
  EXPECT_EQ(scale.pair.result.status, Status::Unknown);
}

TEST_F(StoppingRobot, WayOfLatencyAndBrakingEndsAtTheStopDistance) {
  brake(0.1, {{"slide", 2.0}});
  stand({{"slide", -1.7}});
  move({{"slide", -1.0}});
  stop_.links = 0.1;
  const VelocityScale scale = ask();
  EXPECT_EQ(scale.status, Status::Converged);
  const double expected = (-0.1 + std::sqrt(0.1 * 0.1 + 0.2)) / 0.5;  // 0.1 s + 0.25 s^2 = 0.2
  EXPECT_NEAR(scale.scale, expected, 1e-6);
  EXPECT_LE(scale.scale, expected);
  EXPECT_EQ(namesOf(scale.pair), (std::set<std::string>{"sled", "wall"}));
  EXPECT_NEAR(scale.pair.result.distance, 0.1, 1e-6);
}

TEST_F(StoppingRobot, RobotThatStopsAtOnceNeedsTheWayOfTheLatencyOnly) {
  brake(0.5, {});
  stand({{"slide", -1.8}});
  move({{"slide", -1.0}});
  EXPECT_NEAR(ask().scale, 0.2 / 0.5, 1e-6);
}

TEST_F(StoppingRobot, WeakestJointSlowsAllOthersWithIt) {
  brake(0.0, {{"slide", 4.0}, {"swing", 0.5}});
  stand({{"slide", -1.5}});
  move({{"slide", -1.0}, {"swing", 1.0}});  // the swing takes 2 s, in which the sled makes 1 m
  EXPECT_NEAR(ask().scale, std::sqrt(0.5), 1e-6);
}

TEST_F(StoppingRobot, FollowerNeedsItsOwnTimeToBrake) {
  brake(0.0, {{"slide", 4.0}, {"twin", 1.5}});
  stand({{"slide", -1.5}});
  move({{"slide", -1.0}});  // the twin takes 3 / 1.5 s
  EXPECT_NEAR(ask().scale, std::sqrt(0.5), 1e-6);
}

TEST_F(StoppingRobot, JointRestsFromItsLimitOn) {
  brake(1.0, {});
  move({{"aside", -1.0}});  // the limit is at -0.5, where the side of the sled is at -1
  placeObjects({makeObject("fence", {{HalfSpace{Vector3d::UnitY(), -1.2}}}, Fixed{})});
  EXPECT_EQ(ask().scale, 1.0);
  stop_.objects = 0.3;
  EXPECT_NEAR(ask().scale, 0.4, 1e-6);
}

/// The gap is 2 m where "slide" is at 0; "pan" moves nothing that has geometry.
class CoupledRobot : public StoppingRobot {
 protected:
  CoupledRobot() : StoppingRobot("- slide + 2*aside <= 3\n- pan - slide <= 17") {}
};

TEST_F(CoupledRobot, StopsWhereAnInequalityWouldBreak) {
  brake(0.1, {{"slide", 2.0}, {"aside", 4.0}});
  stand({{"slide", 1.0}, {"aside", 0.9}});  // 0.2 are left
  move({{"slide", 1.0}, {"aside", 0.5}});   // 2 by second
  const VelocityScale scale = ask();
  EXPECT_EQ(scale.status, Status::Converged);
  EXPECT_EQ(scale.pair.result.status, Status::Unknown);
  const double expected = (-0.1 + std::sqrt(0.1 * 0.1 + 0.1)) / 0.5;  // 0.1 s + 0.25 s^2 = 0.1
  EXPECT_NEAR(scale.scale, expected, 1e-12);
  EXPECT_LE(scale.scale, expected);
}

TEST_F(CoupledRobot, IsNotSlowedAlongAnInequality) {
  brake(0.5, {{"slide", 1.0}, {"aside", 1.0}});
  move({{"slide", 1.0}, {"aside", -0.5}});
  for (const double slide : {0.0, 1.0, 1.0 - 1e-9, 1.0 + 1e-9, 1.1}) {
    stand({{"slide", slide}, {"aside", 1.0}});
    EXPECT_EQ(ask().scale, 1.0) << slide;
  }
}

TEST_F(CoupledRobot, ThatIsOutsideMayReturnButNotGoFarther) {
  brake(0.5, {{"slide", 1.0}});
  stand({{"slide", 3.5}});
  move({{"slide", -1.0}});
  EXPECT_EQ(ask().scale, 1.0);
  move({{"slide", 1.0}});
  EXPECT_LT(ask().scale, 1e-5);  // the tolerance of 3e-6 for the latency of 0.5 s
}

TEST_F(CoupledRobot, CountsTheMotionSinceThePosesForInequalities) {
  brake(0.25, {});
  stand({{"slide", 2.8}});
  move({{"slide", 1.0}});
  EXPECT_NEAR(ask().scale, 0.8, 1e-12);
  state_.age = 0.25;
  EXPECT_NEAR(ask().scale, 0.4, 1e-12);
}

TEST_F(CoupledRobot, CountsTheStopsOfJointsAtTheirLimits) {
  brake(1.0, {});
  stand({{"slide", 8.9}, {"aside", -0.4}});
  move({{"slide", 1.0}, {"aside", -1.0}});  // both stop after 0.1 s
  EXPECT_EQ(ask().scale, 1.0);
  move({{"slide", 1.0}, {"aside", -0.4}});  // the sum grows by 0.2 each second from the start on
  EXPECT_LT(ask().scale, 1e-4);
}

TEST_F(CoupledRobot, IsUnknownWithoutAPoseOfAnInequalityOfWhichAJointMoves) {
  brake(0.1, {});
  stand({});
  poses_[bodyOf(robot(), "sensor")].reset();  // no pair needs it
  move({{"swing", 0.1}});
  EXPECT_EQ(ask().status, Status::Converged);
  move({{"slide", 0.1}});
  EXPECT_EQ(ask().status, Status::Unknown);
}

TEST_F(StoppingRobot, RetreatFromWhatIsTooNearIsNotSlowed) {
  brake(0.5, {{"slide", 1.0}});
  move({{"slide", 1.0}});
  stop_.links = 0.1;
  for (const double gap : {0.1, 0.1 + 1e-7, 0.1 - 1e-7, 0.05, 1e-9, 0.0, -0.2}) {
    stand({{"slide", gap - 2.0}});
    const VelocityScale scale = ask();
    EXPECT_EQ(scale.scale, 1.0) << "gap " << gap;
    EXPECT_EQ(scale.status, Status::Converged) << "gap " << gap;
  }
}

TEST_F(StoppingRobot, WhatIsTooNearMustNotComeNearer) {
  brake(0.5, {{"slide", 1.0}});
  move({{"slide", -1.0}});
  stop_.links = 0.1;
  for (const double gap : {0.1, 0.1 + 1e-7, 0.05, 0.0, -0.2}) {
    stand({{"slide", gap - 2.0}});
    const VelocityScale scale = ask();
    EXPECT_EQ(scale.scale, 0.0) << "gap " << gap;
    EXPECT_EQ(scale.status, Status::Converged) << "gap " << gap;
    EXPECT_EQ(namesOf(scale.pair), (std::set<std::string>{"sled", "wall"}));
    EXPECT_NEAR(scale.pair.result.distance, gap, 1e-9);
  }
}

TEST_F(StoppingRobot, WhatIsTooNearMaySlideAlong) {
  brake(0.5, {{"aside", 1.0}});
  stand({{"slide", -1.95}});
  move({{"aside", 0.3}});
  stop_.links = 0.1;
  EXPECT_EQ(ask().scale, 1.0);
}

TEST_F(StoppingRobot, RestIsNotSlowedHoweverNear) {
  brake(0.5, {{"slide", 1.0}});
  stop_.links = 0.1;
  for (const double gap : {0.05, -0.2}) {
    stand({{"slide", gap - 2.0}});
    EXPECT_EQ(ask().scale, 1.0);
  }
}

TEST_F(StoppingRobot, RetreatIsLimitedByWhatIsBehind) {
  brake(1.0, {});
  stand({{"slide", -1.95}});  // the sled is between 0.55 and 1.55
  move({{"slide", 1.0}});
  stop_ = {0.1, 0.2};
  placeObjects({makeObject("fence", {{narrowphase::Box{{1, 1, 1}}}}, Fixed{at(2.55, 0, 0)})});
  const VelocityScale scale = ask();  // 0.5 m to the fence, of which 0.2 m have to stay
  EXPECT_NEAR(scale.scale, 0.3, 1e-6);
  EXPECT_GE(scale.pair.asked.b.object(), 0);
}

TEST_F(StoppingRobot, RetreatThatComesBackIsLimitedToWhereItIsAsNearAsBefore) {
  stop_.objects = 0.2;
  placeObjects({makeObject("post", {{narrowphase::Sphere{0.25}}}, Fixed{at(2.6, 5, 0)})});
  brake(1.0, {});
  stand({{"swing", 0.02}});  // past the post, 0.1 m from it
  move({{"swing", 7.0}});    // more than a turn
  const VelocityScale scale = ask();
  const double turn = 2.0 * M_PI;
  EXPECT_NEAR(scale.scale, (turn - 0.04) / 7.0, 1e-4);  // the same place on the other side of the post
  EXPECT_LT(scale.scale, (turn - 0.02) / 7.0);
}

TEST_F(StoppingRobot, FloorIsAnObjectToRetreatFrom) {
  stop_.objects = 0.2;
  placeObjects({makeObject("side", {{HalfSpace{Vector3d::UnitY(), -0.6}}}, Fixed{})});  // 0.1 m beside the sled
  brake(0.5, {});
  move({{"aside", 1.0}});
  EXPECT_EQ(ask().scale, 1.0);
  move({{"aside", -1.0}});
  EXPECT_EQ(ask().scale, 0.0);
}

TEST_F(StoppingRobot, WayOutOfAClosedMeshIsNotSlowed) {
  ObjectOptions options;
  options.meshes.tolerance = 0.0;
  const TriangleMesh mesh = scaled(bracket(), 10.0);
  // Its face is at y = -0.3, 0.2 m inside of the sled.
  placeObjects({makeObject("solid", {{mesh}}, Fixed{at(0, -20.3, -5)}, options)});
  brake(0.5, {});
  move({{"aside", 1.0}});
  EXPECT_EQ(ask().scale, 1.0);
  EXPECT_EQ(ask().status, Status::Converged);
  move({{"aside", -0.5}});
  EXPECT_EQ(ask().scale, 0.0);
}

// Regression: a contact on the way let an overlap that gets no deeper stop the robot.
TEST_F(StoppingRobot, OverlapThatStaysIsNotSlowedBesideWhatIsAhead) {
  Attached held;
  held.link = "carriage";
  held.link_T_object = at(-3, -20.3, -5);
  held.touch_links = {"wall", "arm", "tail"};
  ObjectOptions options;
  options.meshes.tolerance = 0.0;
  const Object solid = makeObject("solid", {{scaled(bracket(), 10.0)}}, held, options);  // 0.2 m deep in the sled
  const Object ahead =
      makeObject("ahead", {{narrowphase::Box{{0.5, 0.5, 0.5}}}}, Fixed{at(0.75, 0.25, 0)});  // at 1.5 m
  brake(1.9, {});
  move({{"slide", -1.0}});
  placeObjects({solid});
  EXPECT_EQ(ask().scale, 1.0);
  placeObjects({ahead});
  EXPECT_NEAR(ask().scale, 1.5 / 1.9, 1e-6);
  placeObjects({solid, ahead});
  EXPECT_NEAR(ask().scale, 1.5 / 1.9, 1e-6);
}

TEST_F(StoppingRobot, AttachedObjectStopsWithItsLink) {
  Attached held;
  held.link = "sled";
  held.link_T_object = at(-0.75, 0, 0);
  held.touch_links = {"sled"};
  placeObjects({makeObject("tool", {{narrowphase::Box{{0.5, 0.2, 0.2}}}}, held)});
  stop_.objects = 0.1;
  brake(1.0, {});
  stand({{"slide", -1.0}});  // the tool is 0.5 m from the wall
  move({{"slide", -1.0}});
  EXPECT_NEAR(ask().scale, 0.4, 1e-6);
}

TEST_F(StoppingRobot, MissingPoseOrVelocityIsUnknown) {
  brake(0.5, {});
  move({{"slide", kNaN}});
  EXPECT_EQ(ask().status, Status::Unknown);
  EXPECT_EQ(ask().scale, 0.0);
  move({{"slide", 0.0}});
  poses_[bodyOf(robot(), "sled")] = std::nullopt;
  EXPECT_EQ(ask().status, Status::Unknown);
  EXPECT_EQ(ask().scale, 0.0);
}

TEST_F(StoppingRobot, VelocityOfAMimicJointIsIgnored) {
  brake(0.5, {});
  move({{"twin", kNaN}});
  EXPECT_EQ(ask().scale, 1.0);
}

TEST_F(StoppingRobot, DeadlineThatHasPassedProvesNothing) {
  brake(0.5, {});
  stand({{"slide", -1.7}});
  move({{"slide", -1.0}});
  const VelocityScale scale = ask(std::chrono::steady_clock::now() - std::chrono::seconds(1));
  EXPECT_EQ(scale.status, Status::IterationLimit);
  EXPECT_EQ(scale.scale, 0.0);
}

TEST_F(StoppingRobot, IllegalBrakesAreRefused) {
  brake(0.5, {{"swing", 0.0}});
  EXPECT_NE(errorOf([&] { ask(); }).find("swing"), std::string::npos);
  brake(-0.1, {{"swing", 1.0}});
  EXPECT_THROW(ask(), std::invalid_argument);
  brake(0.1, {});
  braking_.deceleration.pop_back();
  EXPECT_THROW(ask(), std::invalid_argument);
}

TEST_F(StoppingRobot, ObjectThatMovesOnItsOwnIsRefused) {
  brake(0.1, {});
  Moving belt;
  belt.frame = "belt";
  placeObjects({makeObject("parcel", {{narrowphase::Sphere{0.1}}}, belt)});
  RobotMotion::Twist twist;
  twist.linear.x() = 1.0;
  state_.frames.moving = {RobotMotion::withTwist(at(0, 0, 50), twist)};
  scene_.update(poses_, {at(0, 0, 50)});
  EXPECT_THROW(velocityScale(moving_, scene_.scene, scene_.state, state_, braking_, stop_), std::invalid_argument);
}

}  // namespace proximity_server::scene::velocity_scale_test
