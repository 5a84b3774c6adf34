// Joint inequalities in the monitor: their text, their rows, and the velocity scale.
#include "node/monitor/slider_robot.h"
#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "robots/robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::node::monitor_inequalities_test {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Left is at -1, middle at 0, right at 0.5.
class CoupledSliders : public MonitorOfSliders {
 protected:
  void limit(const std::string& inequalities) {
    config_.joint_inequalities = scene::readYaml(inequalities, "");
    follow("");
  }
};

TEST_F(CoupledSliders, ABrokenInequalityIsNamedAndLeavesTheLevel) {
  follow("");
  const auto level = cycle().level;
  limit("- to_right <= 0.6\n- to_right - to_left <= 1.2\n- to_right <= 0.4");
  const Clearance& clearance = cycle();
  EXPECT_EQ(clearance.level, level);
  EXPECT_EQ(clearance.status.code, QueryStatus::OK);
  EXPECT_TRUE(has(clearance.status.message, "mm from right")) << clearance.status.message;
  EXPECT_TRUE(has(clearance.status.message, "; 'to_right - to_left <= 1.2' is broken by 0.3"))
      << clearance.status.message;
  ASSERT_TRUE(monitor_.broken().has_value());
  EXPECT_NEAR(monitor_.broken()->excess, 0.3, 1e-12);
}

TEST_F(CoupledSliders, AnInequalityThatHoldsIsNotNamed) {
  limit("- to_right - to_left <= 1.5");
  EXPECT_FALSE(has(cycle().status.message, "broken")) << cycle().status.message;
  EXPECT_FALSE(monitor_.broken().has_value());
  limit("- to_right - to_left <= 1.2");
  cycle();
  EXPECT_TRUE(monitor_.broken().has_value());
  follow("");
  EXPECT_FALSE(monitor_.broken().has_value()) << "it was one of the robot before";
}

TEST_F(CoupledSliders, JointsOfAnInequalityAreNeededAlsoWithoutAPair) {
  config_.filter.only_pairs = {{"middle", "right"}};
  follow("");
  EXPECT_EQ(monitor_.joints(), (std::vector<int>{1, 2}));
  EXPECT_EQ(monitor_.bodies().size(), 2u);
  limit("- to_right - to_left <= 1.2");
  EXPECT_EQ(monitor_.joints(), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(monitor_.bodies().size(), 3u);
}

TEST_F(CoupledSliders, RowsOfInequalitiesStandBehindThoseOfPairs) {
  limit("- to_right - 2*to_left <= 3");
  settings_.influence_distance = 0.5;
  settings_.damping_gain = 0.24;
  settings_.max_constraints = 2;
  cycle();
  const ConstraintRows& rows = monitor_.constraints(snapshot(), settings_);
  ASSERT_EQ(rows.status.code, QueryStatus::OK) << rows.status.message;
  ASSERT_EQ(rows.lower_bounds.size(), 3u);
  ASSERT_EQ(rows.matrix.size(), 9u);
  EXPECT_EQ(std::vector<double>(rows.matrix.begin() + 6, rows.matrix.end()), (std::vector<double>{2.0, 0.0, -1.0}));
  EXPECT_NEAR(rows.lower_bounds[2], 0.24 / (0.5 - 0.02) * (0.5 + 2.0 - 3.0), 1e-12);
  EXPECT_EQ(rows.a[2].link + rows.b[2].link, "");
  EXPECT_TRUE(std::isnan(rows.distances[2]));
  EXPECT_EQ(rows.a.size() + rows.b.size() + rows.distances.size() + rows.unique.size(), 12u);
}

TEST_F(CoupledSliders, RowsNeedThePoseOfEachJoint) {
  config_.filter.only_pairs = {{"middle", "right"}};
  limit("- to_right - to_left <= 3");
  PoseSnapshot without_left = snapshot();
  without_left.poses[1].reset();
  monitor_.cycle(without_left, {}, settings_, frames_);
  const ConstraintRows& rows = monitor_.constraints(without_left, settings_);
  EXPECT_EQ(rows.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_TRUE(has(rows.status.message, "inequality")) << rows.status.message;
}

// At 6 rad tf shows 6 - 2 pi, which obeys. Regression: joint_states were read for the lookahead and the scale only.
TEST(CoupledTurns, AreThoseOfJointStates) {
  Config config;
  config.joint_inequalities = scene::readYaml("- turn + run <= 6", "");
  config.monitor.influence_distance = 0.5;
  const auto robot = std::make_shared<const Robot>(robotText("limits.urdf"), "", config);
  Monitor monitor;
  monitor.follow(robot);
  const std::vector<scene::Joint>& joints = robot->robotModel().joints;
  const int turn = scene::findNamed(joints, "turn");
  std::vector<double> positions(joints.size(), 0.0);
  positions[scene::findNamed(joints, "run")] = 1.0;
  positions[turn] = 6.0;
  PoseSnapshot snapshot;
  snapshot.poses = scene::forwardKinematics(robot->robotModel(), positions);
  const auto bound = [&] {
    monitor.cycle(snapshot, {}, config.monitor);
    const ConstraintRows& rows = monitor.constraints(snapshot, config.monitor);
    return rows.lower_bounds.empty() ? kNaN : rows.lower_bounds.back();
  };
  const double rate = config.monitor.damping_gain / (0.5 - config.monitor.stop_distance);
  EXPECT_NEAR(bound(), rate * (6.0 - 2.0 * M_PI + 1.0 - 6.0), 1e-9);
  EXPECT_FALSE(monitor.broken());
  snapshot.stated.resize(joints.size());
  snapshot.stated[turn] = 6.0;
  EXPECT_NEAR(bound(), rate * 1.0, 1e-9);
  ASSERT_TRUE(monitor.broken());
  EXPECT_NEAR(monitor.broken()->excess, 1.0, 1e-9);
}

// Joints brake with 2 m/s^2 after 0.15 s, the latency and the age of the poses: 0.15 s + 0.25 s^2 = 0.28 for s = 0.8.
class ScaleOfCoupledSliders : public CoupledSliders {
 protected:
  double scaleOf(PoseLatency latency) {
    config_.max_deceleration.of_all = 2.0;
    config_.max_acceleration.of_all = 1e-3;
    config_.pose_latency = latency;
    limit("- to_middle - to_left <= 1.28");
    settings_.rate = 0.1;  // a search may take 2.5 s
    settings_.stop_latency = 0.1;
    PoseSnapshot at = withTheRightSphereAt(*robot_, 5.0);
    at.age = ros::Duration(0.05);
    VelocitySnapshot velocities;
    velocities.velocities = {0.0, 1.0, 0.0};
    velocities.stamps.assign(3, at.stamp);
    monitor_.cycle(at, velocities, settings_, frames_);
    const StoppingScale found = monitor_.velocityScale(at, velocities, settings_, frames_);
    EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
    EXPECT_TRUE(found.is_complete);
    return found.scale;
  }
};

TEST_F(ScaleOfCoupledSliders, StopsBeforeAnInequalityBreaks) { EXPECT_NEAR(scaleOf(PoseLatency::Off), 0.8, 1e-9); }

TEST_F(ScaleOfCoupledSliders, CountsTheAgeOfThePosesThatTheUncertaintyHas) {
  EXPECT_NEAR(scaleOf(PoseLatency::Velocity), 0.8, 1e-9);
}

}  // namespace proximity_server::node::monitor_inequalities_test
