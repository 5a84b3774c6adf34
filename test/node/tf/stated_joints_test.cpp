#include "node/tf/stated_joints.h"

#include "allocations.h"
#include "node/tf/joint_frames.h"
#include "proximity_server/scene/model/kinematics.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// The robot whose joint_states are read: "arm" turns within 6.25 rad at up to 1 rad/s, "wheel" without end or limit of
// its velocity, "slide" moves by 2 m, and "echo" follows "arm". max_tf_age has its default, 0.2 s.

namespace proximity_server::node::stated_joints_test {

using namespace robots;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const std::string kTopic = "joint_states";

const std::string kUrdf =
    urdfOf(link("base") + link("l_arm") + link("l_wheel") + link("l_slide") + link("l_echo") +
           joint("arm", "revolute", "base", "l_arm", axis("0 0 1") + limits("-6.25", "6.25", "1")) +
           hinge("wheel", "base", "l_wheel", "0 0 1") +
           joint("slide", "prismatic", "base", "l_slide", axis("1 0 0") + limits("-2", "2")) +
           joint("echo", "revolute", "base", "l_echo", axis("0 0 1") + limits("-1", "1") + mimic("arm")));

sensor_msgs::JointState stateAt(double time, const std::vector<std::string>& names,
                                const std::vector<double>& positions, const std::vector<double>& velocities = {}) {
  sensor_msgs::JointState state;
  state.header.stamp = ros::Time(time);
  state.name = names;
  state.position = positions;
  state.velocity = velocities;
  return state;
}

class JointsInStates : public testing::Test {
 protected:
  void SetUp() override { stated_.follow(*robot_); }

  /// Robots with these names on one topic.
  static std::shared_ptr<const Robot> robotOf(const std::vector<std::string>& names, const std::string& topic) {
    Config config;
    config.reference_frame = "world";
    for (const std::string& name : names) {
      config.robots.emplace_back();
      config.robots.back().name = config.robots.back().tf_prefix = name;
      config.robots.back().joint_states = topic;
    }
    return std::make_shared<const Robot>(std::vector<RobotTexts>(names.size(), {kUrdf, ""}), config);
  }

  int joint(const std::string& name) const {
    const std::vector<scene::Joint>& joints = robot_->robotModel().joints;
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (joints[i].name == name) return static_cast<int>(i);
    ADD_FAILURE() << name;
    return -1;
  }

  StatedJoints::Entry entryOf(const std::string& name) const {
    const StatedJoints::View view = stated_.view();
    const StatedJoints::Entry* const entry = view.find(*robot_, joint(name));
    return entry ? *entry : StatedJoints::Entry{};
  }

  /// The position of a joint whose transform at 10 s is that of `in_tf`.
  std::optional<double> onTurn(const std::string& name, double in_tf) const {
    const scene::Joint& model = robot_->robotModel().joints[joint(name)];
    const Eigen::Isometry3d frame = model.parent_T_joint * scene::jointMotion(model, in_tf);
    return onStatedTurn(*robot_, joint(name), frame, ros::Time(10.0), entryOf(name));
  }
  std::optional<double> onTurn(const std::string& name, double in_tf, double stated, double time) {
    stated_.add(stateAt(time, {name}, {stated}), kTopic);
    return onTurn(name, in_tf);
  }

  std::string beyond(double time = 10.0) const {
    const std::optional<JointBeyond> found = farthestBeyond(*robot_, stated_, ros::Time(time));
    std::string text;
    if (found) append(text, *robot_, *found);
    return text;
  }

  std::shared_ptr<const Robot> robot_ = std::make_shared<const Robot>(kUrdf, "", Config());
  StatedJoints stated_;
};

TEST_F(JointsInStates, HavePositionsWithoutVelocities) {
  stated_.add(stateAt(1.0, {"arm", "slide"}, {0.5, 0.1}, {2.0, 3.0}), kTopic);
  stated_.add(stateAt(2.0, {"arm"}, {0.7}), kTopic);
  stated_.add(stateAt(3.0, {"arm"}, {}, {4.0}), kTopic);
  EXPECT_EQ(entryOf("arm").position.value, 0.7);
  EXPECT_EQ(entryOf("arm").position.stamp, ros::Time(2.0));
  EXPECT_EQ(entryOf("arm").velocity.value, 4.0);
  EXPECT_EQ(entryOf("arm").velocity.stamp, ros::Time(3.0));
  EXPECT_EQ(entryOf("slide").velocity.value, 3.0);
  EXPECT_TRUE(std::isnan(entryOf("wheel").position.value));
  stated_.add(stateAt(4.0, {"arm", "slide"}, {0.9}, {5.0}), kTopic);  // too few numbers
  EXPECT_EQ(entryOf("arm").position.value, 0.7);
  EXPECT_EQ(entryOf("arm").velocity.value, 4.0);
}

TEST_F(JointsInStates, AreForgottenWithTheirTopic) {
  stated_.add(stateAt(1.0, {"arm"}, {0.5}), kTopic);
  stated_.follow(*std::make_shared<const Robot>(kUrdf, "", Config()));
  EXPECT_EQ(entryOf("arm").position.value, 0.5);
  stated_.follow(*robotOf({"left"}, "others"));
  stated_.add(stateAt(1.0, {"arm"}, {0.5}), kTopic);
  EXPECT_TRUE(std::isnan(entryOf("arm").position.value));
}

TEST_F(JointsInStates, TakeNoMemoryForNamesThatNoRobotHas) {
  std::vector<std::string> names{"arm"};
  for (int i = 0; i < 100; ++i) names.push_back("a joint of a gripper that is not in the URDF " + std::to_string(i));
  robot_ = robotOf({"left"}, kTopic);
  stated_.follow(*robot_);
  const auto state = stateAt(1.0, names, std::vector<double>(names.size(), 0.5));
  const std::string other_topic = "the states of another robot";
  const int joint_of_left = joint("left/arm");
  const long before = allocations();
  stated_.add(state, kTopic);
  stated_.add(state, other_topic);
  EXPECT_EQ(stated_.view().find(*robot_, joint_of_left)->position.value, 0.5);
  EXPECT_EQ(allocations(), before);
}

TEST_F(JointsInStates, OfSeveralRobotsOnOneTopicNeedTheNameOfTheModel) {
  const auto tell = [&](const std::vector<std::string>& robots) {
    robot_ = robotOf(robots, kTopic);
    stated_.follow(*robot_);
    stated_.add(stateAt(1.0, {"left/arm", "arm"}, {0.7, 0.5}), kTopic);
  };
  tell({"left", "right"});
  EXPECT_EQ(entryOf("left/arm").position.value, 0.7);
  EXPECT_TRUE(std::isnan(entryOf("right/arm").position.value)) << "the other one has such a joint, too";
  tell({"right"});
  EXPECT_EQ(entryOf("right/arm").position.value, 0.5);
}

// ---- turns

TEST_F(JointsInStates, TellTheTurn) {
  EXPECT_NEAR(onTurn("arm", 6.0, 6.0, 10.0).value(), 6.0, 1e-12);
  EXPECT_NEAR(onTurn("arm", 6.0, 6.0 - 2.0 * M_PI, 10.0).value(), 6.0 - 2.0 * M_PI, 1e-12);
  EXPECT_NEAR(onTurn("arm", 0.1, 0.12, 10.0).value(), 0.1, 1e-12) << "that of the transform, which the poses have";
  EXPECT_NEAR(onTurn("wheel", 0.1, 0.1 + 200.0 * M_PI, 10.0).value(), 0.1 + 200.0 * M_PI, 1e-10);
  EXPECT_FALSE(onTurn("slide", 0.1, 0.1, 10.0)) << "it does not turn";
  EXPECT_FALSE(onTurn("echo", 0.1, 0.1, 10.0)) << "its leader tells it";
}

TEST_F(JointsInStates, TellNoTurnWhileTheyAreOld) {
  EXPECT_FALSE(onTurn("arm", 6.0)) << "nothing was heard";
  for (const double time : {9.85, 10.15}) EXPECT_TRUE(onTurn("arm", 6.0, 6.0, time)) << time;
  for (const double time : {9.75, 10.25}) EXPECT_FALSE(onTurn("arm", 6.0, 6.0, time)) << time;
}

TEST_F(JointsInStates, TellNoTurnAgainstTf) {
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_TRUE(onTurn("arm", 6.0, 6.0 + 0.04 * sign, 10.0));
    EXPECT_FALSE(onTurn("arm", 6.0, 6.0 + 0.06 * sign, 10.0));
    EXPECT_TRUE(onTurn("arm", 6.0, 6.0 + 0.24 * sign, 9.9)) << "it moves by 0.2 at twice its velocity limit";
    EXPECT_FALSE(onTurn("arm", 6.0, 6.0 + 0.26 * sign, 9.9));
    EXPECT_FALSE(onTurn("wheel", 0.1, 0.1 + 0.06 * sign, 10.0));
    EXPECT_TRUE(onTurn("wheel", 0.1, 0.1 + 1.5 * sign, 9.9)) << "its velocity has no limit";
    EXPECT_FALSE(onTurn("wheel", 0.1, 0.1 + 1.6 * sign, 9.9)) << "more than a quarter turn";
  }
  EXPECT_FALSE(onTurn("arm", 6.0, kNaN, 10.0));
}

TEST_F(JointsInStates, TellNoTurnMoreThanHalfATurnBeyondTheLimits) {
  EXPECT_NEAR(onTurn("arm", 9.3, 9.3, 10.0).value(), 9.3, 1e-12);
  EXPECT_FALSE(onTurn("arm", 9.5, 9.5, 10.0));
  EXPECT_FALSE(onTurn("arm", 257.8, 257.8, 10.0)) << "4.5 rad in degrees, which robot_state_publisher believes";
}

// ---- positions beyond limits

TEST_F(JointsInStates, BeyondTheirLimitsAreNamedWithTheirPosition) {
  stated_.add(stateAt(10.0, {"arm", "wheel", "slide", "echo"}, {6.29, 1e5, 2.04, 50.0}), kTopic);
  EXPECT_EQ(beyond(), "") << "within what an encoder may report; one has no limits, one follows";
  stated_.add(stateAt(10.0, {"slide"}, {2.1}), kTopic);
  EXPECT_EQ(beyond(), "joint 'slide' is at 2.1 m in joint_states, beyond its limits of -2 and 2");
  stated_.add(stateAt(10.0, {"arm"}, {-6.6}), kTopic);
  EXPECT_EQ(beyond(), "joint 'arm' is at -6.6 rad in joint_states, beyond its limits of -6.25 and 6.25: in degrees?");
  EXPECT_EQ(beyond(10.3), "") << "it is old";
}

TEST_F(JointsInStates, AreTakenForDegreesOnlyIfTheyWouldBeWithinTheLimits) {
  stated_.add(stateAt(10.0, {"arm"}, {257.83}), kTopic);
  EXPECT_EQ(beyond(), "joint 'arm' is at 257.8 rad in joint_states, beyond its limits of -6.25 and 6.25: in degrees?");
  stated_.add(stateAt(10.0, {"arm"}, {400.0}), kTopic);
  EXPECT_EQ(beyond(), "joint 'arm' is at 400 rad in joint_states, beyond its limits of -6.25 and 6.25");
}

}  // namespace proximity_server::node::stated_joints_test
