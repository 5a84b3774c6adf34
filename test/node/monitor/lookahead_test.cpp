#include <proximity_server/Clearance.h>
#include "node/answers.h"
#include "node/diagnosis.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/limited_robot.h"
#include "node/settings.h"
#include "node/ticker.h"

#include <trajectory_msgs/JointTrajectory.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

// The robot of gantry.urdf stands at (0.9, 0, 0), 0.7 m from the base, and says that it moves. The stop distance is 0.1
// m.

namespace proximity_server::node::lookahead_test {

/// A control_msgs/FollowJointTrajectoryActionGoal without tolerances.
struct ActionGoal {
  std_msgs::Header header;
  ros::Time stamp;
  std::string id;
  trajectory_msgs::JointTrajectory trajectory;
  std::uint32_t path_tolerances = 0, goal_tolerances = 0;
  ros::Duration goal_time_tolerance;
};

/// An actionlib_msgs/GoalID.
struct GoalId {
  ros::Time stamp;
  std::string id;
};

}  // namespace proximity_server::node::lookahead_test

namespace ros::message_traits {
using proximity_server::node::lookahead_test::ActionGoal;
using proximity_server::node::lookahead_test::GoalId;
template <>
struct MD5Sum<GoalId> {
  static const char* value() { return "302881f31927c1df708a2dbab0e80ee8"; }
  static const char* value(const GoalId&) { return value(); }
};
template <>
struct DataType<GoalId> {
  static const char* value() { return "actionlib_msgs/GoalID"; }
  static const char* value(const GoalId&) { return value(); }
};
template <>
struct Definition<GoalId> {
  static const char* value() { return "time stamp\nstring id"; }
  static const char* value(const GoalId&) { return value(); }
};
template <>
struct MD5Sum<ActionGoal> {
  static const char* value() { return "cff5c1d533bf2f82dd0138d57f4304bb"; }
  static const char* value(const ActionGoal&) { return value(); }
};
template <>
struct DataType<ActionGoal> {
  static const char* value() { return "control_msgs/FollowJointTrajectoryActionGoal"; }
  static const char* value(const ActionGoal&) { return value(); }
};
template <>
struct Definition<ActionGoal> {
  static const char* value() { return "Header header"; }
  static const char* value(const ActionGoal&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<message_traits::GoalId> {
  template <typename Stream, typename Goal>
  static void allInOne(Stream& stream, Goal goal) {
    stream.next(goal.stamp);
    stream.next(goal.id);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
template <>
struct Serializer<message_traits::ActionGoal> {
  template <typename Stream, typename Goal>
  static void allInOne(Stream& stream, Goal goal) {
    stream.next(goal.header);
    stream.next(goal.stamp);
    stream.next(goal.id);
    stream.next(goal.trajectory);
    stream.next(goal.path_tolerances);
    stream.next(goal.goal_tolerances);
    stream.next(goal.goal_time_tolerance);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
}  // namespace ros::serialization

namespace proximity_server::node::lookahead_test {

class LookaheadOfTheMonitor : public testing::Test {
 protected:
  static Gantry& gantry() { return connectedGantry(2); }

  void SetUp() override { gantry().hold({0.9, 0.0, 0.0}); }
  void TearDown() override { gantry().release(); }

  /// The next lookahead that is accepted.
  std::optional<Lookahead> next(const std::function<bool(const Lookahead&)>& accept) {
    const auto message = inbox_.next([&](const Clearance& candidate) { return accept(candidate.lookahead); });
    return message ? std::optional<Lookahead>(message->lookahead) : std::nullopt;
  }
  std::optional<Lookahead> withState(std::uint8_t state) {
    return next([&](const Lookahead& lookahead) { return lookahead.state == state; });
  }

  static void expectUnknown(const std::optional<Lookahead>& lookahead, int code, const std::string& named) {
    ASSERT_TRUE(lookahead);
    EXPECT_EQ(lookahead->state, Lookahead::UNKNOWN);
    EXPECT_EQ(lookahead->status.code, code);
    EXPECT_NE(lookahead->status.message.find(named), std::string::npos) << lookahead->status.message;
    EXPECT_TRUE(std::isnan(lookahead->time_free) && std::isnan(lookahead->time_to_contact));
    EXPECT_TRUE(saysNothing(lookahead->pair));
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), "/proximity_server/clearance"};
  JointStates joint_states_;
};

TEST_F(LookaheadOfTheMonitor, IsUnknownBeforeAnybodyTellsTheVelocities) {
  const auto lookahead =
      next([](const Lookahead& candidate) { return candidate.status.code == QueryStatus::NO_VELOCITY; });
  expectUnknown(lookahead, QueryStatus::NO_VELOCITY, "joint_states has no velocity");
}

TEST_F(LookaheadOfTheMonitor, TellsTheTimeToTheStopDistanceAndThePair) {
  joint_states_.hold(slidingAt(-0.5));
  const auto lookahead = withState(Lookahead::CONTACT);
  ASSERT_TRUE(lookahead);
  EXPECT_EQ(lookahead->status.code, QueryStatus::OK) << lookahead->status.message;
  EXPECT_EQ(lookahead->lookahead, 2.0);
  EXPECT_EQ(lookahead->contact_distance, 0.1);
  EXPECT_NEAR(lookahead->time_to_contact, 1.2, 1e-5);  // 0.6 m at 0.5 m/s
  EXPECT_LE(lookahead->time_free, 1.2 + 1e-12);
  EXPECT_GE(lookahead->time_free, 1.2 - 1e-4);
  EXPECT_EQ(links(lookahead->pair), (std::set<std::string>{"base", "ball"}));
  EXPECT_NEAR(lookahead->pair.distance, 0.1, 1.01e-6);
}

TEST_F(LookaheadOfTheMonitor, IsAContactNowBelowTheStopDistance) {
  gantry().hold({0.25, 0.0, 0.0});
  joint_states_.hold(slidingAt(0.5));
  const auto lookahead = withState(Lookahead::CONTACT);
  ASSERT_TRUE(lookahead);
  EXPECT_EQ(lookahead->time_to_contact, 0.0);
  EXPECT_EQ(lookahead->time_free, 0.0);
}

TEST_F(LookaheadOfTheMonitor, ProvesThatThereIsNoContactWithinItsTime) {
  joint_states_.hold(slidingAt(-0.25));  // 0.6 m in 2.4 s
  const auto lookahead = withState(Lookahead::FREE);
  ASSERT_TRUE(lookahead);
  EXPECT_EQ(lookahead->time_free, 2.0);
  EXPECT_TRUE(std::isnan(lookahead->time_to_contact));
  EXPECT_TRUE(saysNothing(lookahead->pair));
}

TEST_F(LookaheadOfTheMonitor, IsUnknownWhenTheVelocitiesAreOld) {
  joint_states_.hold(slidingAt(-0.25));
  ASSERT_TRUE(withState(Lookahead::FREE));
  joint_states_.release();
  expectUnknown(withState(Lookahead::UNKNOWN), QueryStatus::NO_VELOCITY, "old");
  joint_states_.hold(slidingAt(-0.25));
  EXPECT_TRUE(withState(Lookahead::FREE));
}

TEST_F(LookaheadOfTheMonitor, IsUnknownWithoutAStampOrANumber) {
  joint_states_.hold(slidingAt(-0.25));
  ASSERT_TRUE(withState(Lookahead::FREE));
  joint_states_.release();
  joint_states_.publish(ros::Time());
  expectUnknown(withState(Lookahead::UNKNOWN), QueryStatus::NO_VELOCITY, "old");
  joint_states_.hold(slidingAt(std::numeric_limits<double>::quiet_NaN()));
  expectUnknown(next([](const Lookahead& lookahead) {
                  return lookahead.status.message.find("no velocity") != std::string::npos;
                }),
                QueryStatus::NO_VELOCITY, "'x_axis'");
}

TEST_F(LookaheadOfTheMonitor, IsUnknownWhileOneJointIsMissing) {
  joint_states_.hold(slidingAt(-0.25));
  ASSERT_TRUE(withState(Lookahead::FREE));
  joint_states_.hold({{"x_axis", -0.25}, {"y_axis", 0.0}});
  expectUnknown(withState(Lookahead::UNKNOWN), QueryStatus::NO_VELOCITY, "'lift'");
}

TEST_F(LookaheadOfTheMonitor, IsUnknownWithoutPoses) {
  joint_states_.hold(slidingAt(-0.25));
  ASSERT_TRUE(withState(Lookahead::FREE));
  gantry().release();
  expectUnknown(withState(Lookahead::UNKNOWN), QueryStatus::TF_STALE, "joint '");
}

TEST_F(LookaheadOfTheMonitor, IsOffUntilItIsAskedFor) {
  joint_states_.hold(slidingAt(-0.5));
  Inbox<Clearance> inbox(ros::NodeHandle(), "/off/clearance");
  int cycles = 0;  // while the node hears joint_states
  const auto off =
      inbox.next([&](const Clearance& message) { return ++cycles > 20 && message.level != Clearance::INVALID; });
  ASSERT_TRUE(off);
  EXPECT_EQ(off->lookahead.state, Lookahead::OFF);
  EXPECT_TRUE(std::isnan(off->lookahead.time_to_contact));

  set("/off/", "lookahead", 2.0);
  const auto on = inbox.next([](const Clearance& message) {  // the first search may end at its budget
    return message.lookahead.state == Lookahead::CONTACT;
  });
  ASSERT_TRUE(on);
  EXPECT_NEAR(on->lookahead.time_to_contact, 1.36, 1e-5);  // the stop distance is 0.02
}

/// The robot stands still, and gets a trajectory that leads to the stop distance.
class LookaheadAlongTrajectories : public LookaheadOfTheMonitor {
 protected:
  void SetUp() override {
    LookaheadOfTheMonitor::SetUp();
    joint_states_.hold(slidingAt(0.0));
    ASSERT_TRUE(withState(Lookahead::FREE));
    trajectory_.joint_names = {"x_axis"};
    trajectory_.points.resize(1);
    trajectory_.points[0].time_from_start = ros::Duration(2.0);
    trajectory_.points[0].positions = {0.2};
  }

  /// Sends the message every 0.5 s until the node follows it, and then no more. A cycle of a busy machine may end the
  /// search before it is through the ways in which the robot may move.
  template <class Message>
  void expectFollowed(const std::string& topic, const Message& message) {
    ros::Publisher publisher = ros::NodeHandle().advertise<Message>(topic, 1);
    Ticker ticker(ros::NodeHandle(), 2.0, [&] { publisher.publish(message); });
    ticker.start();
    const auto contact = next([&](const Lookahead& lookahead) {
      return lookahead.state == Lookahead::CONTACT &&
             lookahead.status.message.find("along the trajectory of " + topic) == 0;
    });
    ticker.stop();
    ASSERT_TRUE(contact);
    EXPECT_NEAR(contact->time_to_contact, 2.0 * 0.6 / 0.7, 0.2);
    const auto off = next([](const Lookahead& lookahead) {
      return lookahead.status.message.find("joint 'x_axis' is ") == 0 && lookahead.state == Lookahead::FREE;
    });
    ASSERT_TRUE(off);
    EXPECT_NE(off->status.message.find(" m off the trajectory of " + topic), std::string::npos) << off->status.message;
    const auto velocities = next([](const Lookahead& lookahead) { return lookahead.status.message.empty(); });
    EXPECT_TRUE(velocities) << "the trajectory is over";
  }

  trajectory_msgs::JointTrajectory trajectory_;
};

TEST_F(LookaheadAlongTrajectories, FollowsTheCommandsOfAController) {
  expectFollowed("/arm_controller/command", trajectory_);
}

TEST_F(LookaheadAlongTrajectories, FollowsTheGoalsOfAnAction) {
  ActionGoal goal;
  goal.trajectory = trajectory_;
  expectFollowed("/arm_controller/follow_joint_trajectory/goal", goal);
}

TEST_F(LookaheadAlongTrajectories, HearsThatAGoalIsCanceled) {
  ros::NodeHandle nh;
  const std::string action = "/arm_controller/follow_joint_trajectory/";
  ros::Publisher goals = nh.advertise<ActionGoal>(action + "goal", 1);
  ros::Publisher cancels = nh.advertise<GoalId>(action + "cancel", 1);
  ActionGoal goal;
  goal.trajectory = trajectory_;
  goal.trajectory.points[0].time_from_start = ros::Duration(60.0);
  goal.trajectory.points[0].positions = {0.9};  // where it stands
  const auto says = [](const std::string& text, bool is_said) {
    return [=](const Lookahead& lookahead) {
      const std::string& message = lookahead.status.message;
      return message.find("along") == 0 && (message.find(text) != std::string::npos) == is_said;
    };
  };
  Ticker ticker(nh, 2.0, [&] { goals.publish(goal); });
  ticker.start();
  ASSERT_TRUE(next(says("velocities", true)));
  ticker.stop();
  ASSERT_TRUE(next(says("velocities", false)));
  while (cancels.getNumSubscribers() == 0) ros::WallDuration(0.01).sleep();
  cancels.publish(GoalId());
  EXPECT_TRUE(next(says("velocities", true)));
}

// followers.urdf: with "lead" at x the ball is at (x, 0, 0) and the shadow at (0, 2 x + 0.5, 0); its joint follows.
TEST(LookaheadOfFollowers, TakesTheVelocityOfTheirLeader) {
  Gantry tf(ros::NodeHandle(), "/followers/tf");
  ASSERT_TRUE(tf.awaitListeners(2));
  const auto place = [&](const std::string& link, double y, double z) {
    geometry_msgs::TransformStamped transform = Gantry::slide({0.0, 0.0, 0.0});
    transform.child_frame_id = link;
    transform.transform.translation.y = y;
    transform.transform.translation.z = z;
    tf.publish(transform, ros::Time::now());
  };
  JointStates joint_states("/followers");
  joint_states.hold({{"lead", -0.2}});
  Inbox<Clearance> one_pair(ros::NodeHandle(), "/followers/one_pair/clearance");
  const auto known = one_pair.next([&](const Clearance& message) {
    place("ball", 0.0, 0.0);
    place("shadow", 0.5, 0.0);
    place("drone", 0.0, 3.0);
    return message.lookahead.state == Lookahead::CONTACT;
  });
  ASSERT_TRUE(known);
  // The centres are 0.3 apart, the two 0.1, when x^2 + (2 x + 0.5)^2 = 0.09.
  const double x = (std::sqrt(0.8) - 2.0) / 10.0;
  EXPECT_NEAR(known->lookahead.time_to_contact, x / -0.2, 1e-5);

  Inbox<Clearance> all_pairs(ros::NodeHandle(), "/followers/all_pairs/clearance");
  const auto unknown = all_pairs.next([&](const Clearance& message) { return message.level != Clearance::INVALID; });
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->lookahead.state, Lookahead::UNKNOWN);
  EXPECT_EQ(unknown->lookahead.status.code, QueryStatus::NO_VELOCITY);
  EXPECT_NE(unknown->lookahead.status.message.find("joint 'flight': it is floating"), std::string::npos)
      << unknown->lookahead.status.message;
}

/// The robot of limits.urdf: the stop distance is 0.1 m, it looks 2 s ahead.
class LookaheadWithinLimits : public testing::Test {
 protected:
  static LimitedRobot& robot() { return connectedLimitedRobot(); }

  void TearDown() override { robot().release(); }

  std::optional<Lookahead> withState(std::uint8_t state) {
    const auto message = inbox_.next([&](const Clearance& candidate) { return candidate.lookahead.state == state; });
    return message ? std::optional<Lookahead>(message->lookahead) : std::nullopt;
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), "/limits/proximity_server/clearance"};
  JointStates joint_states_{"/limits"};
};

TEST_F(LookaheadWithinLimits, StopsJointsWithTheirFollowers) {
  robot().hold(1.0, 0.0);
  joint_states_.hold({{"run", -0.5}, {"turn", 0.0}});
  const auto lookahead = withState(Lookahead::FREE);  // without a limit there would be contact after 1.4 s
  ASSERT_TRUE(lookahead);
  EXPECT_EQ(lookahead->time_free, 2.0);
  EXPECT_EQ(lookahead->joints_at_limit, std::vector<std::string>{"run"});
  ASSERT_EQ(lookahead->limit_times.size(), 1u);
  EXPECT_NEAR(lookahead->limit_times[0], 1.0, 1e-9);
}

// At 6 rad, 0.25 before the limit, the hand stands as it does at 6 - 2 pi, from where it would reach the pin.
TEST_F(LookaheadWithinLimits, TakesTheTurnFromThePositionsOfJointStates) {
  robot().hold(1.0, 6.0);
  joint_states_.hold({{"run", 0.0}, {"turn", 0.5}});
  const auto contact = withState(Lookahead::CONTACT);
  ASSERT_TRUE(contact);
  EXPECT_TRUE(contact->joints_at_limit.empty());
  joint_states_.hold({{"run", 0.0}, {"turn", 0.5}}, {{"run", 1.0}, {"turn", 6.0}});
  const auto free = withState(Lookahead::FREE);
  ASSERT_TRUE(free);
  EXPECT_EQ(free->joints_at_limit, std::vector<std::string>{"turn"});
  for (const double stated : {8.0, 9.5}) {  // neither agrees with tf
    joint_states_.hold({{"run", 0.0}, {"turn", 0.5}}, {{"run", 1.0}, {"turn", stated}});
    EXPECT_TRUE(withState(Lookahead::CONTACT)) << stated;
    joint_states_.hold({{"run", 0.0}, {"turn", 0.5}}, {{"run", 1.0}, {"turn", 6.0}});
    EXPECT_TRUE(withState(Lookahead::FREE));
  }
}

// 257.8 is 4.5 rad in degrees, where tf has the hand, too. The level is that of tf.
TEST_F(LookaheadWithinLimits, IsBesideAWarningOfPositionsInDegrees) {
  robot().hold(1.0, 257.8);
  joint_states_.hold({{"run", 0.0}, {"turn", 0.0}}, {{"run", 1.0}, {"turn", 257.8}});
  const std::string text =
      "joint 'turn' is at 257.8 rad in joint_states, beyond its limits of -6.25 and 6.25: in degrees?";
  const auto warned = inbox_.next(
      [&](const Clearance& message) { return message.status.message.find("; " + text) != std::string::npos; });
  ASSERT_TRUE(warned);
  EXPECT_EQ(warned->level, Clearance::CLEAR);
  EXPECT_EQ(warned->status.code, QueryStatus::OK);
  Diagnosis diagnosis("limits/proximity_server: clearance");
  const auto found = diagnosis.next([&](const Diagnosis::Status& status) {
    return status.message.find(text) != std::string::npos && status.level == Diagnosis::Status::WARN;
  });
  ASSERT_TRUE(found);
  EXPECT_TRUE(std::any_of(found->values.begin(), found->values.end(), [&](const diagnostic_msgs::KeyValue& value) {
    return value.key == "joint_states" && value.value == text;
  }));
  joint_states_.hold({{"run", 0.0}, {"turn", 0.0}}, {{"run", 1.0}, {"turn", 4.5}});
  EXPECT_TRUE(inbox_.next(
      [](const Clearance& message) { return message.status.message.find("joint_states") == std::string::npos; }));
}

}  // namespace proximity_server::node::lookahead_test
