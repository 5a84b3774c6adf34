// The scale of ~collision_velocity_scale: that of the scene, to the last bit, or 0 with a reason.
#include "node/monitor/slider_robot.h"
#include "node/monitor/velocity_scale.h"
#include "proximity_server/scene/velocity_scale.h"
#include "scene/files.h"
#include "scene/posed_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::node::monitor_velocity_scale_test {

/// The sliders brake with 2 m/s^2. The middle sphere is 0.3 m from the right one, and 0.8 m from the left one.
class ScaleOfSliders : public MonitorOfSliders {
 protected:
  void SetUp() override {
    config_.max_deceleration.of_all = 2.0;
    follow("");
    settings_.rate = 0.1;  // a search may take 2.5 s
    settings_.stop_latency = 0.1;
  }

  static VelocitySnapshot velocities(double left, double middle, double right) {
    VelocitySnapshot velocities;
    velocities.velocities = {left, middle, right};
    return velocities;
  }
  StoppingScale scaleIn(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities) {
    monitor_.cycle(snapshot, velocities, settings_, frames_);
    return monitor_.velocityScale(snapshot, velocities, settings_, frames_);
  }
  StoppingScale scaleOf(double left, double middle, double right) {
    PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
    snapshot.age = ros::Duration(0.05);
    return scaleIn(snapshot, velocities(left, middle, right));
  }
  double middleAt(double velocity) {
    const StoppingScale found = scaleOf(0.0, velocity, 0.0);
    EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
    return found.scale;
  }
  static void expectZero(const StoppingScale& found, int code, const std::string& named) {
    EXPECT_EQ(found.scale, 0.0);
    EXPECT_EQ(found.status.code, code);
    EXPECT_NE(found.status.message.find(named), std::string::npos) << found.status.message;
  }
};

// At s times 1 m/s the middle sphere goes on for 0.15 s, the latency and the age of the poses, and brakes in 0.5 s s:
// 0.15 s + 0.25 s^2 = 0.3 - 0.02.
TEST_F(ScaleOfSliders, LeavesTheWayToStopAboveTheStopDistance) {
  EXPECT_NEAR(middleAt(1.0), 0.8, 1e-5);
  EXPECT_LE(middleAt(1.0), 0.8 + 1e-12);
}

// The two may be 0.06 m nearer than they seem. The bound counts the third joint, too.
TEST_F(ScaleOfSliders, LeavesTheWayToStopWithinTheUncertainty) {
  config_.uncertainty.joint = {0.03};
  follow("");
  const double scale = middleAt(1.0), way = 0.15 * scale + 0.25 * scale * scale;
  EXPECT_LE(way, 0.28 - 0.06);
  EXPECT_GE(way, 0.28 - 0.09 - 1e-5);
}

// A turn of the rail, which all spheres hang on, does not bring them together; that of an object does, and the farther
// the sphere goes the more.
TEST_F(ScaleOfSliders, CountsHowAnAngleActsWhereTheRobotStops) {
  config_.uncertainty.base = {scene::FileValue::Map{{"angle", {0.1}}}};
  follow("");
  add(ballAt(standingAt(0.0, 0.35, 0.0)));  // 0.15 m from the middle, and nearer to the side than any motion leads
  EXPECT_EQ(middleAt(0.0), 1.0);
  EXPECT_LT(middleAt(1.0), 0.8);
}

TEST_F(ScaleOfSliders, IsOneWhereTheRobotStopsInTime) {
  EXPECT_EQ(middleAt(0.5), 1.0);
  EXPECT_EQ(middleAt(0.0), 1.0);
}

TEST_F(ScaleOfSliders, DoesNotSlowTheWayBack) {
  settings_.stop_distance = settings_.warn_distance = 0.4;  // the right sphere is nearer already
  EXPECT_EQ(middleAt(-0.3), 1.0);
  EXPECT_EQ(middleAt(0.3), 0.0);
  EXPECT_EQ(middleAt(0.0), 1.0);  // at rest it does not come nearer; what is commanded next is not known
}

TEST_F(ScaleOfSliders, KeepsTheStopDistanceOfObjects) {
  settings_.object_stop_distance = 0.1;
  settings_.object_warn_distance = 0.1;
  add(ballAt(standingAt(-0.58, 0.0, 0.0)));  // 0.38 m left of the middle
  EXPECT_NEAR(middleAt(-1.0), 0.8, 1e-5);
}

TEST_F(ScaleOfSliders, CarriesWhatALinkHolds) {
  scene::Attached held{"middle"};
  held.link_T_object.translation().x() = -0.5;
  add(ballAt(held, "held"));  // 0.3 m from the left sphere
  EXPECT_NEAR(middleAt(-1.0), 0.8, 1e-5);
}

TEST_F(ScaleOfSliders, CarriesWhatIsInTheFrameOfALink) {
  add(ballAt(scene::Moving{"middle", Eigen::Isometry3d(Eigen::Translation3d(-0.5, 0.0, 0.0))}));
  frames_.poses = {Eigen::Isometry3d::Identity()};
  EXPECT_NEAR(middleAt(-1.0), 0.8, 1e-5);
}

// The frame of the answers is the middle sphere: what is fixed there moves with it.
TEST_F(ScaleOfSliders, CarriesWhatIsFixedInAReferenceFrameThatMoves) {
  config_.reference_frame = "middle";
  follow("");
  add(ballAt(standingAt(-0.5, 0.0, 0.0)));
  EXPECT_NEAR(middleAt(-1.0), 0.8, 1e-5);
}

TEST_F(ScaleOfSliders, CountsTheAgeOfThePosesAsLatency) {
  settings_.stop_latency = 0.15;
  const PoseSnapshot fresh = withTheRightSphereAt(*robot_, 0.5);  // of age 0
  EXPECT_NEAR(scaleIn(fresh, velocities(0.0, 1.0, 0.0)).scale, 0.8, 1e-5);
}

// Regression: on a busy machine the scale of a robot at rest went to and fro between 0 and what was found in time.
// With pose_latency the age of 0.05 s is in the uncertainty alone: 0.05 m of the middle sphere, 0 of those at rest. At
// s times 1 m/s the middle sphere goes on for 0.1 s.
TEST_F(ScaleOfSliders, CountsTheAgeOfThePosesOnce) {
  config_.pose_latency = PoseLatency::Velocity;
  config_.max_acceleration.of_all = 0.0;
  follow("");
  VelocitySnapshot measured = velocities(0.0, 1.0, 0.0);
  measured.stamps.assign(3, ros::Time(1000.0));
  PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
  snapshot.age = ros::Duration(0.05);
  const double scale = scaleIn(snapshot, measured).scale;
  EXPECT_NEAR(0.1 * scale + 0.25 * scale * scale, 0.28 - 0.05, 1e-5);
}

TEST_F(ScaleOfSliders, OfAnUnchangedStateIsNotLoweredByASearchThatRanOutOfTime) {
  const double in_time = middleAt(1.0);
  settings_.rate = 1e9;
  EXPECT_EQ(middleAt(1.0), in_time);
  EXPECT_LT(middleAt(1.01), 0.1) << "another state";
  settings_.rate = 0.1;
  EXPECT_EQ(middleAt(1.0), in_time);
  settings_.rate = 1e9;
  settings_.stop_distance = 0.021;
  EXPECT_LT(middleAt(1.0), 0.1) << "another distance";
  settings_.stop_distance = 0.02;
  EXPECT_EQ(middleAt(1.0), in_time);
  PoseSnapshot older = withTheRightSphereAt(*robot_, 0.5);
  older.age = ros::Duration(0.06);
  EXPECT_LT(scaleIn(older, velocities(0.0, 1.0, 0.0)).scale, 0.1) << "older by more than a period";
  follow("");
  EXPECT_LT(middleAt(1.0), 0.1) << "a robot that begins";
}

TEST_F(ScaleOfSliders, IsThatOfTheSceneToTheLastBit) {
  scene::PosedScene scene(robot_->sharedModel());
  scene::MotionSearch moving(robot_->sharedModel());
  int between = 0;
  for (int i = 0; i < 50; ++i) {
    const double speed = 0.15 * i - 3.5;
    const PoseSnapshot at = withTheRightSphereAt(*robot_, 0.5);
    const StoppingScale found = scaleIn(at, velocities(-speed, speed, 0.5 * speed));
    scene.update(at.poses);
    const scene::MovingState state{{-speed, speed, 0.5 * speed}, {}, {}};
    const scene::VelocityScale expected =
        scene::velocityScale(moving, scene.scene, scene.state, state, {0.1, {2.0, 2.0, 2.0}}, {0.02, 0.02});
    EXPECT_EQ(found.scale, expected.scale) << speed;
    between += found.scale > 0.0 && found.scale < 1.0;
  }
  EXPECT_GT(between, 5);
}

TEST_F(ScaleOfSliders, KeepsTheStopDistanceOfAPair) {
  const double before = middleAt(1.0);
  config_.monitor.influence_distance = 1.0;
  config_.thresholds.stop.of_pairs = {{{"middle", "right"}, 0.2}};
  config_.thresholds.warn.of_pairs = {{{"middle", "right"}, 0.2}};
  follow("");
  scene::PosedScene scene(robot_->sharedModel());
  scene::MotionSearch moving(robot_->sharedModel());
  const PoseSnapshot at = withTheRightSphereAt(*robot_, 0.5);
  scene.update(at.poses);
  const scene::MovingState state{{0.0, 1.0, 0.0}, {}, {}};
  const scene::VelocityScale expected =
      scene::velocityScale(moving, scene.scene, scene.state, state, {0.1, {2.0, 2.0, 2.0}}, {0.2, 0.2});
  EXPECT_LT(middleAt(1.0), before);
  EXPECT_EQ(scaleIn(at, velocities(0.0, 1.0, 0.0)).scale, expected.scale);
}

TEST_F(ScaleOfSliders, TakesTheDecelerationOfEachJoint) {
  config_.max_deceleration.of_all.reset();
  config_.max_deceleration.of_joint = {{"to_left", 1.0}, {"to_middle", 2.0}, {"to_right", 0.001}};
  follow("");
  EXPECT_NEAR(middleAt(1.0), 0.8, 1e-5);
  EXPECT_EQ(scaleOf(1.0, 0.0, 0.0).status.code, QueryStatus::OK);
}

TEST_F(ScaleOfSliders, IsZeroWithoutADecelerationOfAJointThatMovesAPair) {
  config_.max_deceleration.of_all.reset();
  config_.max_deceleration.of_joint = {{"to_left", 1.0}, {"to_middle", 2.0}};
  follow("");
  expectZero(scaleOf(0.0, 0.1, 0.0), QueryStatus::INVALID_ARGUMENT,
             "max_deceleration has no number for joint 'to_right'");
}

// Velocities are missing for a moment whenever somebody begins to listen; the parameter stays as it is.
TEST_F(ScaleOfSliders, NamesTheMissingDecelerationBeforeTheMissingVelocity) {
  config_.max_deceleration.of_all.reset();
  follow("");
  VelocitySnapshot none = velocities(0.0, 0.0, 0.0);
  none.status.code = QueryStatus::NO_VELOCITY;
  expectZero(scaleIn(withTheRightSphereAt(*robot_, 0.5), none), QueryStatus::INVALID_ARGUMENT, "max_deceleration");
}

TEST_F(ScaleOfSliders, IsZeroWithoutVelocities) {
  VelocitySnapshot none = velocities(0.0, 0.0, 0.0);
  none.status.code = QueryStatus::NO_VELOCITY;
  none.status.message = "joint 'to_left': old";
  expectZero(scaleIn(withTheRightSphereAt(*robot_, 0.5), none), QueryStatus::NO_VELOCITY, "'to_left'");
}

TEST_F(ScaleOfSliders, IsZeroForAVelocityThatIsNotFinite) {
  EXPECT_EQ(scaleOf(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0).scale, 0.0);
  EXPECT_EQ(scaleOf(0.0, std::numeric_limits<double>::infinity(), 0.0).scale, 0.0);
}

TEST_F(ScaleOfSliders, IsSafeForAVelocityBeyondAllMeasure) {
  for (const double velocity : {1e100, 1e200, 1e300, 1.7e308}) {
    EXPECT_GE(scaleOf(0.0, velocity, 0.0).scale, 0.0) << velocity;
    EXPECT_LE(scaleOf(0.0, velocity, 0.0).scale, 1e-50) << velocity;
  }
}

TEST_F(ScaleOfSliders, IsZeroWhileTheLevelIsInvalid) {
  PoseSnapshot missing = withTheRightSphereAt(*robot_, 0.5);
  missing.poses.back().reset();
  missing.status.code = QueryStatus::TF_STALE;
  missing.status.message = "joint 'to_right' is 5 s old";
  expectZero(scaleIn(missing, velocities(0.0, 0.0, 0.0)), QueryStatus::TF_STALE, "'to_right'");
}

TEST_F(ScaleOfSliders, RefusesDecelerationsOfJointsThatAreNot) {
  const auto refusalOf = [&](const std::string& joint) {
    config_.max_deceleration.of_joint = {{joint, 1.0}};
    return scene::errorOf([&] { follow(""); });
  };
  EXPECT_EQ(refusalOf("to_midle"),
            "parameter max_deceleration/to_midle: the robot has no such movable joint: did you mean 'to_middle'?");
  EXPECT_EQ(refusalOf("to_left"), "");
}

}  // namespace proximity_server::node::monitor_velocity_scale_test
