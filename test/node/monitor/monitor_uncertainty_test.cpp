// Levels where positions are not known exactly. The sliders move along x, so that each uncertainty of a joint counts in
// full: between "middle" and "right", 0.3 m apart, that of both joints.
#include "node/answers/guarantees.h"
#include "node/monitor/slider_robot.h"
#include "proximity_server/scene/model/names.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::node::monitor_uncertainty_test {

class UncertainMonitor : public MonitorOfSliders {
 protected:
  UncertainMonitor() {
    settings_.warn_distance = 0.25;
    settings_.stop_distance = 0.2;
    settings_.threshold = 1.0;
    config_.monitor = settings_;
    config_.monitor.influence_distance = 1.0;
    velocities_.velocities.assign(3, 0.0);
    velocities_.stamps.assign(3, ros::Time(1000.0));
  }
  const Clearance& cycleWith(double joint_uncertainty) {
    config_.uncertainty.joint = {joint_uncertainty};
    follow("");
    return cycle();
  }
  const Clearance& cycleAged(double age) {
    PoseSnapshot aged = snapshot();
    aged.age = ros::Duration(age);
    return monitor_.cycle(aged, velocities_, settings_, frames_);
  }
  int joint(const std::string& name) const { return scene::findNamed(robot_->robotModel().joints, name); }

  VelocitySnapshot velocities_;
};

TEST_F(UncertainMonitor, GuaranteesTheLowerBoundWithoutUncertainty) {
  const Clearance& clearance = cycleWith(0.0);
  EXPECT_FALSE(clearance.by_guaranteed);
  EXPECT_EQ(clearance.level, Clearance::CLEAR);
  EXPECT_EQ(clearance.minimum.guaranteed, clearance.minimum.lower_bound);
  EXPECT_EQ(clearance.deciding.guaranteed, clearance.deciding.lower_bound);
}

TEST_F(UncertainMonitor, DecidesLevelsByTheGuaranteedDistance) {
  EXPECT_EQ(cycleWith(0.02).level, Clearance::CLEAR);
  EXPECT_NEAR(monitor_.latest().deciding.guaranteed, 0.26, 1e-9);
  const Clearance& clearance = cycleWith(0.03);
  EXPECT_TRUE(clearance.by_guaranteed);
  EXPECT_EQ(clearance.level, Clearance::WARN);
  EXPECT_NEAR(clearance.minimum.distance, 0.3, 1e-9);
  EXPECT_NEAR(clearance.minimum.guaranteed, 0.24, 1e-9);
  ASSERT_FALSE(clearance.below_threshold.empty());
  EXPECT_NEAR(clearance.below_threshold[0].guaranteed, 0.24, 1e-9);
  EXPECT_EQ(clearance.levels[0], Clearance::WARN);
  EXPECT_EQ(cycleWith(0.055).level, Clearance::STOP);
}

TEST_F(UncertainMonitor, TellsThatAStateWithinTheUncertaintyIsAtTheThreshold) {
  EXPECT_TRUE(cycleWith(0.055).deciding_reached);
  EXPECT_FALSE(cycleWith(0.02).deciding_reached);
}

TEST_F(UncertainMonitor, StopsWhereContactIsPossibleButCollidesOnlyInContact) {
  EXPECT_EQ(cycleWith(0.2).level, Clearance::STOP);
  settings_.stop_distance = 0.0;
  EXPECT_EQ(cycle().level, Clearance::STOP);
  EXPECT_EQ(monitor_.cycle(withTheRightSphereAt(*robot_, 0.1), {}, settings_).level, Clearance::COLLISION);
}

TEST_F(UncertainMonitor, TakesThePairWithTheSmallestGuaranteedDistance) {
  settings_.object_warn_distance = settings_.warn_distance;
  config_.uncertainty.object = {0.2};
  follow("");
  add(ballAt(standingAt(0.0, 0.55, 0.0)));  // 0.35 from the middle, guaranteed 0.15
  const Clearance& clearance = cycle();
  EXPECT_NEAR(clearance.minimum.distance, 0.3, 1e-9);
  EXPECT_EQ(clearance.deciding.b.link, "ball");
  EXPECT_NEAR(clearance.deciding.guaranteed, 0.15, 1e-9);
  EXPECT_NEAR(clearance.object_minimum.guaranteed, 0.15, 1e-9);
}

TEST_F(UncertainMonitor, SaysWhereALimitEndsTheGuaranteedDistances) {
  EXPECT_EQ(cycleWith(0.03).status.message.find("coarse"), std::string::npos);
  const double whole = monitor_.latest().deciding.guaranteed;
  const auto expectCoarse = [&](const std::string& end) {
    const Clearance& clearance = cycle();
    EXPECT_EQ(clearance.level, Clearance::WARN);
    EXPECT_LE(clearance.deciding.guaranteed, whole);
    EXPECT_NE(clearance.status.message.find("; guaranteed distances are coarse: " + end), std::string::npos)
        << clearance.status.message;
    EXPECT_EQ(monitor_.constraints(snapshot(), settings_).status.message, endIn(clearance.status.message));
  };
  settings_.influence_distance = 0.4;
  monitor_.endTimeAfter(0);
  expectCoarse("their time was over after ");
  EXPECT_GE(stepsOfTimeOver(monitor_.latest().status.message), 0);
  monitor_.endTimeAfter(std::numeric_limits<std::int64_t>::max());
  settings_.rate = 1e9;  // a quarter of the period has no step
  expectCoarse("the steps of a cycle are too few");
  EXPECT_EQ(stepsOfTimeOver(monitor_.latest().status.message), std::nullopt);
}

TEST_F(UncertainMonitor, HasConstraintRowsOfGuaranteedDistances) {
  settings_.influence_distance = 0.25;  // 0.3 m apart, guaranteed 0.24
  settings_.stop_distance = 0.1;
  cycleWith(0.03);
  const ConstraintRows& rows = monitor_.constraints(snapshot(), settings_);
  ASSERT_EQ(rows.status.code, QueryStatus::OK) << rows.status.message;
  EXPECT_EQ(rows.a[0].link, "middle");
  EXPECT_NEAR(rows.distances[0], 0.24, 1e-9);
  EXPECT_NEAR(rows.lower_bounds[0], -settings_.damping_gain * (0.24 - 0.1) / (0.25 - 0.1), 1e-9);
  EXPECT_TRUE(std::isnan(rows.distances[1]));
}

// The base of the robot stands not exactly where the object is measured from.
TEST_F(UncertainMonitor, AddsThatOfTheBaseToPairsWithObjects) {
  config_.uncertainty.base = {0.05};
  follow("");
  add(ballAt(standingAt(0.0, 0.55, 0.0)));
  const Clearance& clearance = cycle();
  EXPECT_NEAR(clearance.self_minimum.guaranteed, 0.3, 1e-9);
  EXPECT_NEAR(clearance.object_minimum.guaranteed, 0.3, 1e-9);
}

TEST_F(UncertainMonitor, GrowsWithTheAgeOfThePosesByTheVelocityLimits) {
  config_.pose_latency = PoseLatency::Limit;
  config_.message_latency = 0.02;
  follow("");
  const double limit = robot_->robotModel().joints[joint("to_right")].max_velocity;
  ASSERT_TRUE(std::isfinite(limit));
  EXPECT_NEAR(cycleAged(0.03).minimum.guaranteed, 0.3 - 2.0 * 0.05 * limit, 1e-9);
}

TEST_F(UncertainMonitor, GrowsWithTheAgeOfThePosesByVelocityAndAcceleration) {
  config_.pose_latency = PoseLatency::Velocity;
  config_.max_acceleration.of_all = 4.0;
  follow("");
  velocities_.velocities[joint("to_right")] = -0.5;
  // |v| T of one joint, and a T^2 / 2 of both.
  EXPECT_NEAR(cycleAged(0.1).minimum.guaranteed, 0.3 - 0.05 - 2.0 * 0.02, 1e-9);
  // The velocity is 0.05 s older than the poses.
  velocities_.stamps[joint("to_right")] = ros::Time(999.95);
  EXPECT_NEAR(cycleAged(0.1).minimum.guaranteed, 0.3 - 0.05 - 2.0 * 0.02 - 4.0 * 0.05 * 0.1, 1e-9);
}

TEST_F(UncertainMonitor, IsInvalidAndNamesTheJointWhereNothingLimitsItsMotion) {
  config_.pose_latency = PoseLatency::Velocity;
  const std::string urdf = robots::urdfOf(
      robots::link("base", robots::ball("0.1")) + robots::link("column") + robots::link("arm", robots::ball("0.1")) +
      robots::hinge("turn", "base", "column", "0 0 1") + robots::hinge("elbow", "column", "arm", "0 0 1", "0.5 0 0"));
  robot_ = std::make_shared<const Robot>(urdf, "", config_);
  monitor_.follow(robot_);
  PoseSnapshot straight;
  straight.stamp = ros::Time(1000.0);
  straight.poses = scene::forwardKinematics(robot_->robotModel(), std::vector<double>{0.0, 0.0});
  const auto message = [&] { return monitor_.cycle(straight, velocities_, settings_).status.message; };
  const std::string unknown = "guaranteed distances are unknown: joint 'turn' has no velocity limit in the URDF, and ";
  EXPECT_EQ(message(), unknown + "max_acceleration has no number for it");
  EXPECT_EQ(monitor_.latest().level, Clearance::INVALID);
  EXPECT_EQ(monitor_.latest().status.code, QueryStatus::NO_VELOCITY);
  ASSERT_FALSE(monitor_.latest().below_threshold.empty());
  EXPECT_TRUE(std::isnan(monitor_.latest().below_threshold[0].guaranteed));
  config_.max_acceleration.of_all = 1.0;
  robot_ = std::make_shared<const Robot>(urdf, "", config_);
  monitor_.follow(robot_);
  velocities_.velocities[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(), unknown + "its velocity is not known");
  velocities_.velocities[0] = 0.0;
  EXPECT_EQ(message(), "base is 300.0 mm from arm, guaranteed 300.0 mm; warn below 250 mm");
}

TEST_F(UncertainMonitor, NeedsTheSpeedOfAFrameThatMayMove) {
  config_.pose_latency = PoseLatency::Limit;
  follow("");
  add(ballAt(scene::Moving{"camera", Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 1.0))}));
  frames_.poses = {Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.0))};
  frames_.may_move = {0};
  EXPECT_EQ(
      cycleAged(0.1).status.message,
      "guaranteed distances are unknown: object 'ball' may move with frame 'camera', and object_speed does not tell "
      "how fast");
  config_.object_speed = {0.5};
  follow("");
  add(ballAt(scene::Moving{"camera", Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 1.0))}));
  const Clearance& clearance = cycleAged(0.1);
  EXPECT_EQ(clearance.status.code, QueryStatus::OK) << clearance.status.message;
  EXPECT_LE(clearance.object_minimum.guaranteed, 0.8 - 0.05);
}

TEST_F(UncertainMonitor, NeedsTheSpeedOfABaseThatMayMove) {
  config_.pose_latency = PoseLatency::Limit;
  config_.reference_frame = "map";
  follow("");
  add(ballAt(standingAt(0.0, 0.55, 0.0)));
  velocities_.roots.code = QueryStatus::NO_VELOCITY;
  velocities_.roots.message = "the robot: its base 'rail' may move against 'map', as /tf_static does not join them";
  EXPECT_EQ(cycleAged(0.1).status.message, "guaranteed distances are unknown: " + velocities_.roots.message +
                                               ", and base_speed does not tell how fast");
  config_.base_speed = {1.0};
  follow("");
  add(ballAt(standingAt(0.0, 0.55, 0.0)));
  EXPECT_EQ(cycleAged(0.1).status.code, QueryStatus::OK);
  const double with_motion = monitor_.latest().object_minimum.guaranteed;
  velocities_.roots = {};  // the base stands still now
  EXPECT_NEAR(cycleAged(0.1).object_minimum.guaranteed, with_motion + 0.1, 1e-9);
}

}  // namespace proximity_server::node::monitor_uncertainty_test
