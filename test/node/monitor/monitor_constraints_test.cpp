// The rows of ~constraints: those of the scene, to the last bit, or none.
#include "node/monitor/slider_robot.h"
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "scene/files.h"
#include "scene/posed_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::node::monitor_constraints_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class ConstraintsOfSliders : public MonitorOfSliders {
 protected:
  void SetUp() override {
    follow("");
    settings_.influence_distance = 0.5;
    settings_.damping_gain = 0.25;
    settings_.max_constraints = 3;
  }
  const ConstraintRows& rows(const scene::FramePoses& poses = {}) { return rowsIn(snapshot(), poses); }
  const ConstraintRows& rowsIn(const PoseSnapshot& snapshot, const scene::FramePoses& poses = {}) {
    frames_.poses = poses;
    monitor_.cycle(snapshot, {}, settings_, frames_);
    return monitor_.constraints(snapshot, settings_);
  }
  static void expectNoRows(const ConstraintRows& rows, int code, const std::string& named) {
    EXPECT_EQ(rows.status.code, code);
    EXPECT_NE(rows.status.message.find(named), std::string::npos) << rows.status.message;
    EXPECT_TRUE(rows.matrix.empty());
    EXPECT_TRUE(rows.lower_bounds.empty());
    EXPECT_TRUE(rows.a.empty() && rows.b.empty() && rows.distances.empty() && rows.unique.empty());
  }
};

// Middle and right are 0.3 m apart, middle and left 0.8 m.
TEST_F(ConstraintsOfSliders, DampTheApproachOfThePairsWithinTheInfluenceDistance) {
  const ConstraintRows& message = rows();
  ASSERT_EQ(message.status.code, QueryStatus::OK) << message.status.message;
  EXPECT_EQ(message.header.stamp, ros::Time(1000.0));
  EXPECT_EQ(message.joint_names, (std::vector<std::string>{"to_left", "to_middle", "to_right"}));
  EXPECT_EQ(message.joint_positions, (std::vector<double>{-1.0, 0.0, 0.5}));
  EXPECT_EQ(message.matrix, (std::vector<double>{0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}));
  ASSERT_EQ(message.lower_bounds.size(), 3u);
  EXPECT_NEAR(message.lower_bounds[0], -0.25 * (0.3 - 0.02) / (0.5 - 0.02), 1e-9);
  EXPECT_EQ(message.a[0].link, "middle");
  EXPECT_EQ(message.b[0].link, "right");
  EXPECT_NEAR(message.distances[0], 0.3, 1e-9);
  EXPECT_LE(message.distances[0], 0.3);
  EXPECT_TRUE(message.unique[0]);
  EXPECT_EQ(message.left_out, 0u);
}

TEST_F(ConstraintsOfSliders, LeaveRowsThatAreNotUsedWithoutALimit) {
  const ConstraintRows& message = rows();
  ASSERT_EQ(message.lower_bounds.size(), 3u);
  for (const std::size_t row : {1u, 2u}) {
    EXPECT_EQ(message.lower_bounds[row], -kInfinity);
    EXPECT_TRUE(std::isnan(message.distances[row]));
    EXPECT_EQ(message.a[row].link, "");
    EXPECT_EQ(message.b[row].link, "");
  }
}

TEST_F(ConstraintsOfSliders, AreThoseOfTheSceneToTheLastBit) {
  scene::PosedScene scene(robot_->sharedModel());
  scene::ConstraintRows expected(robot_->sharedModel(), 3);
  int used = 0;
  for (int i = 0; i < 100; ++i) {
    const PoseSnapshot at = withTheRightSphereAt(*robot_, -0.9 + 0.017 * i);
    const ConstraintRows& message = rowsIn(at);
    scene.update(at.poses);
    expected.find(scene.scene, scene.state, {{0.02, 0.02}, 0.5, 0.25});
    const auto& matrix = expected.matrix();
    EXPECT_EQ(message.matrix, std::vector<double>(matrix.data(), matrix.data() + matrix.size()));
    for (int row = 0; row < 3; ++row) {
      EXPECT_EQ(message.lower_bounds[row], expected.bounds()[row]);
      if (!expected.rows()[row].is_used) continue;
      ++used;
      EXPECT_EQ(message.distances[row], expected.rows()[row].distance);
    }
  }
  EXPECT_GT(used, 100);
}

TEST_F(ConstraintsOfSliders, KeepTheStopDistanceOfObjects) {
  settings_.object_stop_distance = 0.1;
  settings_.object_warn_distance = 0.1;
  add(ballAt(standingAt(0.0, 0.4, 0.0)));  // 0.2 m from the middle, which cannot move towards it
  add(ballAt(standingAt(-1.4, 0.0, 0.0), "wall"));
  settings_.max_constraints = 1;
  settings_.influence_distance = 0.25;
  const ConstraintRows& message = rows();
  ASSERT_EQ(message.status.code, QueryStatus::OK) << message.status.message;
  EXPECT_NEAR(message.lower_bounds[0], -0.25 * (0.2 - 0.1) / (0.25 - 0.1), 1e-9);
  EXPECT_EQ(message.b[0].kind, ShapeRef::OBJECT);
  EXPECT_EQ(message.b[0].link, "wall");
  EXPECT_EQ(message.left_out, 0u);
  EXPECT_EQ(message.unneeded, 1u) << "the ball is as near, but stays so";
}

TEST_F(ConstraintsOfSliders, MoveWhatIsInTheFrameOfALinkWithTheLink) {
  follow("");
  add(ballAt(scene::Moving{"middle", Eigen::Isometry3d(Eigen::Translation3d(-0.7, 0.0, 0.0))}));
  settings_.influence_distance = 0.2;
  const ConstraintRows& message = rows({Eigen::Isometry3d::Identity()});
  ASSERT_EQ(message.status.code, QueryStatus::OK) << message.status.message;
  EXPECT_EQ(message.a[0].link, "left");
  EXPECT_EQ((std::vector<double>{message.matrix[0], message.matrix[1], message.matrix[2]}),
            (std::vector<double>{-1.0, 1.0, 0.0}));
}

TEST_F(ConstraintsOfSliders, HaveNoRowsWhileTheLevelIsInvalid) {
  PoseSnapshot missing = snapshot();
  missing.poses.back().reset();
  missing.status.code = QueryStatus::TF_STALE;
  missing.status.message = "joint 'to_right' is 5 s old";
  ASSERT_EQ(rows().status.code, QueryStatus::OK);
  expectNoRows(rowsIn(missing), QueryStatus::TF_STALE, "'to_right'");
  const ConstraintRows& again = rows();
  EXPECT_EQ(again.status.code, QueryStatus::OK);
  EXPECT_EQ(again.lower_bounds.size(), 3u);
}

TEST_F(ConstraintsOfSliders, HaveNoRowsIfTheInfluenceDistanceIsNotAboveTheStopDistances) {
  settings_.influence_distance = settings_.stop_distance;
  expectNoRows(rows(), QueryStatus::INVALID_ARGUMENT,
               "influence_distance is 0.02, not above stop_distance, which is 0.02");
  settings_.influence_distance = 0.03;
  settings_.object_stop_distance = 0.04;
  expectNoRows(rows(), QueryStatus::INVALID_ARGUMENT, "not above object_stop_distance, which is 0.04");
  settings_.influence_distance = 0.05;
  EXPECT_EQ(rows().status.code, QueryStatus::OK);
}

TEST_F(ConstraintsOfSliders, AreAsManyAsTheSettingsSayFromTheNextCycleOn) {
  EXPECT_EQ(rows().lower_bounds.size(), 3u);
  settings_.max_constraints = 5;
  EXPECT_EQ(rows().lower_bounds.size(), 5u);
  EXPECT_EQ(rows().matrix.size(), 15u);
  settings_.max_constraints = 1;
  EXPECT_EQ(rows().a.size(), 1u);
}

TEST_F(ConstraintsOfSliders, AreThoseOfTheJointsThatTheControllerMoves) {
  config_.constraint_joints = {"to_left"};
  follow("");
  const ConstraintRows& message =
      rowsIn(withTheRightSphereAt(*robot_, -0.7));  // 0.1 m from the left one, 0.5 m from the middle
  ASSERT_EQ(message.status.code, QueryStatus::OK) << message.status.message;
  EXPECT_EQ(message.joint_names.size(), 3u);
  EXPECT_EQ(message.matrix, (std::vector<double>{-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}));
  EXPECT_EQ(message.unneeded, 1u) << "right and middle";
}

TEST_F(ConstraintsOfSliders, NameThePairsThatTheJointsDoNotPart) {
  config_.constraint_joints = {"to_left"};
  follow("");
  const ConstraintRows& message = rowsIn(withTheRightSphereAt(*robot_, 0.21));
  ASSERT_EQ(message.status.code, QueryStatus::OK) << message.status.message;
  EXPECT_EQ(message.stuck, 1u);
  ASSERT_EQ(message.stuck_a.size(), 1u);
  EXPECT_EQ(message.stuck_a[0].link, "middle");
  EXPECT_EQ(message.stuck_b[0].link, "right");
  EXPECT_NEAR(message.stuck_distances[0], 0.01, 1e-9);
  EXPECT_EQ(message.stuck_rates[0], 0.0);
  EXPECT_EQ(message.lower_bounds[0], -kInfinity);
  EXPECT_EQ(rowsIn(withTheRightSphereAt(*robot_, 0.5)).stuck, 0u);
}

TEST_F(ConstraintsOfSliders, RefuseJointsThatAreNot) {
  config_.constraint_joints = {"to_left", "to_midle"};
  EXPECT_EQ(scene::errorOf([&] { follow(""); }),
            "parameter constraint_joints: 'to_midle': the robot has no such movable joint: did you mean 'to_middle'?");
}

TEST_F(ConstraintsOfSliders, DoNotDependOnWhetherGradientsAreAsked) {
  const std::vector<double> matrix = rows().matrix, bounds = rows().lower_bounds;
  settings_.gradients = true;
  EXPECT_EQ(rows().matrix, matrix);
  EXPECT_EQ(rows().lower_bounds, bounds);
}

}  // namespace proximity_server::node::monitor_constraints_test
