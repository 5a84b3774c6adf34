#include "node/tf/joint_jumps.h"

#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <cmath>

// Two publishers of one joint, and what looks like them. "slide" moves along x at up to 1 m/s, "arm" turns about z at
// up to 2 rad/s, "flap" within one radian and "wheel" without end have no velocity limit.

namespace proximity_server::node::joint_jumps_test {

using namespace narrowphase;

using Clock = JointJumps::Clock;

using namespace robots;

const std::string kUrdf =
    urdfOf(link("base") + link("slide") + link("arm") + link("flap") + link("wheel") +
           joint("slide_joint", "prismatic", "base", "slide", axis("1 0 0") + limits("-2", "2")) +
           joint("arm_joint", "revolute", "base", "arm", axis("0 0 1") + limits("-3", "3", "2")) +
           joint("flap_joint", "revolute", "base", "flap", axis("0 0 1") + limits("0", "1", "0")) +
           hinge("wheel_joint", "base", "wheel", "0 0 1"));

std::shared_ptr<const Robot> robot(const Config& config = {}) {
  return std::make_shared<const Robot>(kUrdf, "", config);
}

geometry_msgs::TransformStamped at(const std::string& child, double position, double time) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "base";
  transform.header.stamp = ros::Time(time);
  transform.child_frame_id = child;
  transform.transform.rotation.w = 1.0;
  if (child == "slide") {
    transform.transform.translation.x = position;
  } else {
    transform.transform.rotation.z = std::sin(0.5 * position);
    transform.transform.rotation.w = std::cos(0.5 * position);
  }
  return transform;
}

class Jumps : public testing::Test {
 protected:
  Jumps() { jumps_.watch(*robot_); }

  /// A joint comes with this position, at `time` [s] by its stamp and by the wall clock.
  void see(const std::string& child, double position, double time) {
    now_ = start_ + std::chrono::microseconds(std::lround(1e6 * time));
    jumps_.add(at(child, position, time), now_);
  }
  std::vector<std::string> recent() const { return jumps_.recent(now_); }

  const std::shared_ptr<const Robot> robot_ = robot();
  JointJumps jumps_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point now_ = start_;
};

using Sentences = std::vector<std::string>;

TEST_F(Jumps, OfTwoPublishersAreReportedWithTheJoint) {
  for (int i = 0; i < 3; ++i) {
    see("slide", 0.1, 10.0 + 0.01 * i);
    see("slide", 0.6, 10.004 + 0.01 * i);
  }
  EXPECT_EQ(recent(), (Sentences{"joint 'slide_joint': transforms jump by 0.5 m within 0.004 s: two publishers?"}));
}

TEST_F(Jumps, OfTwoPublishersWithTheSameStampsAreReported) {
  for (int i = 0; i < 2; ++i) {
    see("arm", 0.0, 10.0 + 0.01 * i);
    see("arm", 1.0, 10.0 + 0.01 * i);
  }
  EXPECT_EQ(recent(), (Sentences{"joint 'arm_joint': transforms jump by 1 rad within 0 s: two publishers?"}));
}

TEST_F(Jumps, OfASlowAndAFastPublisherAreReported) {
  for (int i = 0; i <= 100; ++i) {
    see("slide", 0.0, 10.0 + 0.01 * i);
    if (i == 50) see("slide", 0.7, 10.505);
  }
  EXPECT_EQ(recent().size(), 1u);
}

TEST_F(Jumps, OfAJointWithoutVelocityLimitAreReportedBeyondHalfOfItsRange) {
  for (int i = 0; i < 4; ++i) see("flap", i % 2 ? 0.45 : 0.0, 10.0 + 0.01 * i);
  EXPECT_TRUE(recent().empty());
  for (int i = 0; i < 4; ++i) see("flap", i % 2 ? 0.55 : 0.0, 11.0 + 0.01 * i);
  EXPECT_EQ(recent().size(), 1u);
}

TEST_F(Jumps, AreForgottenSomeSecondsAfterTheLast) {
  see("slide", 0.0, 10.0);
  see("slide", 0.5, 10.005);
  see("slide", 0.0, 10.01);
  see("slide", 0.0, 14.0);
  EXPECT_EQ(recent().size(), 1u);
  see("slide", 0.0, 16.0);
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, FromOnePlaceToAnotherAreARobotThatWasPutThere) {
  see("slide", 0.0, 10.0);
  see("slide", 0.5, 10.01);
  see("slide", 0.5, 10.02);
  EXPECT_TRUE(recent().empty());
  see("slide", 1.0, 10.03);
  EXPECT_TRUE(recent().empty()) << "it does not lead back";
}

TEST_F(Jumps, WhereTheStampsGoBackAreABagThatBeginsAgain) {
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 30; ++i) {  // in 0.3 s from 0 to 0.3 m
      jumps_.add(at("slide", 0.01 * i, 10.0 + 0.01 * i), now_);
    }
    now_ += std::chrono::milliseconds(300);
  }
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, AfterALongGapOfTheStampsAreAClockThatJumped) {
  for (int i = 0; i < 6; ++i) jumps_.add(at("slide", i % 2 ? 1.9 : -1.9, 10.0 + 5.0 * i), now_);
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, AreNotSeenWhereTheClockJumpedBackInBetween) {
  for (int i = 0; i < 6; ++i) {
    see("slide", i % 2 ? 0.5 : 0.0, 10.0 + 0.001 * i);
    jumps_.forget();
  }
  EXPECT_TRUE(recent().empty());
}

/// Stamps that are wrong by up to 10 ms, and a joint that goes forth and back as fast as it may.
TEST_F(Jumps, AreNoMotionWithinTheLimit) {
  double position = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double jitter = 0.01 * std::sin(12.9898 * i);
    see("slide", position, 10.0 + 0.01 * i + jitter);
    position += i / 10 % 2 ? 0.01 : -0.01;
  }
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, AreNoMotionThatIsFasterThanTheUrdfSays) {
  for (int i = 0; i < 100; ++i) see("slide", 0.2 * i, 10.0 + 0.01 * i);
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, AreNoWheelThatSpins) {
  for (int i = 0; i < 100; ++i) see("wheel", 2.9 * i, 10.0 + 0.01 * i);
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, OfFramesThatAreNotTheRobotsAreNobodysBusiness) {
  for (int i = 0; i < 4; ++i) {
    geometry_msgs::TransformStamped other = at("slide", i % 2 ? 0.5 : 0.0, 10.0 + 0.001 * i);
    other.header.frame_id = "elsewhere";
    jumps_.add(other, now_);
    jumps_.add(at("somebody", 0.0, 10.0), now_);
  }
  EXPECT_TRUE(recent().empty());
}

TEST_F(Jumps, AreFoundInPrefixedFramesAndBehindALeadingSlash) {
  Config config;
  config.tf_prefix = "left";
  const auto left = robot(config);
  jumps_.watch(*left);
  for (int i = 0; i < 4; ++i) {
    geometry_msgs::TransformStamped transform = at("slide", i % 2 ? 0.5 : 0.0, 10.0 + 0.001 * i);
    transform.header.frame_id = "/left/base";
    transform.child_frame_id = "left/slide";
    jumps_.add(transform, now_);
  }
  EXPECT_EQ(recent().size(), 1u);
}

TEST_F(Jumps, WithoutAPoseAreNone) {
  for (int i = 0; i < 4; ++i) see("slide", i % 2 ? std::nan("") : 0.0, 10.0 + 0.001 * i);
  EXPECT_TRUE(recent().empty());
}

}  // namespace proximity_server::node::joint_jumps_test
