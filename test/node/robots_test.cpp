#include <proximity_server/Clearance.h>
#include <sensor_msgs/JointState.h>

#include <cmath>
#include <string>

#include "gantry.h"
#include "proximity_server/scene/robot_model.h"

// Robots as they are, with robot_state_publisher between the joints and tf.

namespace proximity_server {
namespace {

/// Swings all joints of a robot about the middle of their ranges, a hundred times a second.
class Swing {
 public:
  Swing(const std::string& ns, const RobotModel& robot) : robot_(robot) {
    ros::NodeHandle nh(ns);
    publisher_ = nh.advertise<sensor_msgs::JointState>("joint_states", 10);
    timer_ = nh.createWallTimer(ros::WallDuration(0.01), [this](const ros::WallTimerEvent&) { publish(); });
  }

 private:
  void publish() {
    sensor_msgs::JointState state;
    state.header.stamp = ros::Time::now();
    const double swing = 0.1 * std::sin(state.header.stamp.toSec());
    for (const Joint& joint : robot_.joints) {
      if (joint.mimic || joint.type == Joint::Type::Floating || joint.type == Joint::Type::Planar) continue;
      const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
      state.name.push_back(joint.name);
      state.position.push_back(limited ? joint.lower + (0.5 + swing) * (joint.upper - joint.lower) : swing);
    }
    publisher_.publish(state);
  }

  RobotModel robot_;
  ros::Publisher publisher_;
  ros::WallTimer timer_;
};

class Robot : public testing::TestWithParam<const char*> {};

TEST_P(Robot, HasAValidClearanceWhileItMoves) {
  const std::string ns = std::string("/") + GetParam();
  std::string urdf;
  ASSERT_TRUE(ros::param::get(ns + "/robot_description", urdf));
  if (urdf.empty()) GTEST_SKIP() << "the robots are not at hand";

  ModelOptions without_meshes;  // only the joints are of interest here
  without_meshes.allow_missing_meshes = true;
  const Swing swing(ns, loadRobotModel(urdf, packageResolver({}), without_meshes));
  Inbox<Clearance> inbox(ros::NodeHandle(), ns + "/proximity_server/clearance");
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

INSTANTIATE_TEST_SUITE_P(Shared, Robot, testing::Values("panda", "ur5", "pr2"));

}  // namespace
}  // namespace proximity_server

PROXIMITY_SERVER_ROSTEST_MAIN("robots_test")
