#include <proximity_server/Clearance.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryTrajectory.h>
#include "node/gantry.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/robot_model.h"
#include "sanitized.h"

#include <sensor_msgs/JointState.h>

#include <cmath>
#include <string>

// Robots as they are, with robot_state_publisher between the joints and tf.

namespace proximity_server::node::robots_test {

using namespace scene;

/// All settable joints `swing` of their ranges from the middle, or that many radians where there is no range.
sensor_msgs::JointState swungBy(double swing, const RobotModel& robot) {
  sensor_msgs::JointState state;
  for (const Joint& joint : robot.joints) {
    if (joint.mimic || !hasOnePosition(joint)) continue;
    const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    state.name.push_back(joint.name);
    state.position.push_back(limited ? joint.lower + (0.5 + swing) * (joint.upper - joint.lower) : swing);
  }
  return state;
}

/// Swings all joints of a robot about the middle of their ranges, a hundred times a second.
class Swing {
 public:
  Swing(const std::string& ns, const RobotModel& robot)
      : robot_(robot),
        publisher_(ros::NodeHandle(ns).advertise<sensor_msgs::JointState>("joint_states", 10)),
        ticker_(ros::NodeHandle(ns), 100.0, [this] { publish(); }) {
    ticker_.start();
  }

 private:
  void publish() {
    const ros::Time now = ros::Time::now();
    sensor_msgs::JointState state = swungBy(0.1 * std::sin(now.toSec()), robot_);
    state.header.stamp = now;
    publisher_.publish(state);
  }

  RobotModel robot_;
  ros::Publisher publisher_;
  Ticker ticker_;  // last: it publishes what is above
};

class Robot : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(ros::param::get(ns_ + "/robot_description", urdf_));
    if (urdf_.empty()) GTEST_SKIP() << "the robots are not at hand";
#ifdef PROXIMITY_SANITIZED
    if (ns_ != "/panda") GTEST_SKIP() << "its meshes take minutes under a sanitizer";
#endif
  }

  RobotModel jointsOnly() const {
    ModelOptions without_meshes;
    without_meshes.allow_missing_meshes = true;
    return loadRobotModel(urdf_, packageResolver({}), without_meshes);
  }

  const std::string ns_ = std::string("/") + GetParam();
  std::string urdf_;
};

TEST_P(Robot, HasAValidClearanceWhileItMoves) {
  const Swing swing(ns_, jointsOnly());
  Inbox<Clearance> inbox(ros::NodeHandle(), ns_ + "/proximity_server/clearance");
  ASSERT_TRUE(inbox.next([](const Clearance& message) { return message.level != Clearance::INVALID; }));
  for (int n = 0; n < 100; ++n) {
    const auto message = inbox.next();
    ASSERT_TRUE(message);
    EXPECT_NE(message->level, Clearance::INVALID) << message->status.message;
    EXPECT_EQ(message->status.code, QueryStatus::OK) << message->status.message;
    EXPECT_LE(message->minimum.lower_bound, message->minimum.upper_bound);
    EXPECT_EQ(message->pairs_unknown, 0u);
  }
}

TEST_P(Robot, IsAsCloseInEveryStateOfATrajectoryAsTheTrajectorySays) {
  constexpr double kTolerance = 1e-6;        // [m]
  constexpr double kContactDistance = 0.01;  // [m]
  constexpr int kStates = 100;
  const RobotModel robot = jointsOnly();
  QueryTrajectoryRequest moving;
  moving.missing_joints = QueryTrajectoryRequest::ZERO;
  moving.contact_distance = kContactDistance;
  moving.tolerance = kTolerance;
  moving.time_budget = ros::Duration(30.0);
  moving.trajectory.joint_names = swungBy(0.0, robot).name;
  for (const double time : {0.0, 1.0}) {
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = swungBy(0.4 * time - 0.2, robot).position;
    point.time_from_start = ros::Duration(time);
    moving.trajectory.points.push_back(point);
  }
  QueryConfigurationRequest standing;
  standing.missing_joints = QueryConfigurationRequest::ZERO;
  for (int i = 0; i <= kStates; ++i) standing.states.push_back(swungBy(0.4 * i / kStates - 0.2, robot));

  const auto path = call<QueryTrajectoryResponse>(ns_ + "/proximity_server/query_trajectory", moving);
  const auto states = call<QueryConfigurationResponse>(ns_ + "/proximity_server/query_configuration", standing);
  ASSERT_TRUE(path.success) << path.status.message;
  ASSERT_TRUE(states.success) << states.status.message;
  ASSERT_EQ(path.segments.size(), 1u);
  EXPECT_LE(path.segments[0].lower_bound, path.segments[0].upper_bound);
  for (int i = 0; i <= kStates; ++i) {
    const Proximity& minimum = states.states[i].minimum;
    EXPECT_LE(path.segments[0].lower_bound, minimum.upper_bound) << i;
    EXPECT_LE(path.segments[0].upper_bound - kTolerance, minimum.upper_bound) << i;
    if (1.0 * i / kStates < path.t_free) {
      EXPECT_GT(minimum.upper_bound, kContactDistance) << i;
    }
  }
  if (path.contact) {
    QueryConfigurationRequest then;
    then.missing_joints = QueryConfigurationRequest::ZERO;
    then.states = {path.state};
    const auto contact = call<QueryConfigurationResponse>(ns_ + "/proximity_server/query_configuration", then);
    ASSERT_EQ(contact.states.size(), 1u);
    EXPECT_LE(contact.states[0].minimum.lower_bound, kContactDistance + 2.0 * kTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, Robot, testing::Values("panda", "ur5", "pr2"));

}  // namespace proximity_server::node::robots_test
