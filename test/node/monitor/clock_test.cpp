#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include "node/gantry.h"

#include <rosgraph_msgs/Clock.h>

// The clock of a ROS graph is one, and it can be unset only before the first test sets it: the order matters.

namespace proximity_server::node::clock_test {

constexpr double kTolerance = 1e-9;  // of the answers: the node's default

// The node promises two periods of the keep-alive, and as much for a busy machine.
constexpr std::chrono::seconds kFrozenAfter{4};

MinimumDistanceResponse askBaseAndBall() {
  MinimumDistanceRequest request;
  request.a.link = "base";
  request.b.link = "ball";
  return call<MinimumDistanceResponse>("/proximity_server/minimum_distance", request);
}

/// A simulation: time, and the robot of gantry.urdf in it.
class Simulation : public testing::Test {
 protected:
  static Gantry& gantry() {
    static Gantry gantry{ros::NodeHandle()};
    static const bool connected = gantry.awaitListeners(2);
    EXPECT_TRUE(connected);
    return gantry;
  }

  static void setTime(double seconds) {
    static ros::Publisher publisher = ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", 1, /*latch=*/true);
    rosgraph_msgs::Clock message;
    message.clock = ros::Time(seconds);
    publisher.publish(message);
  }

  /// Lets the time run from `start` until a message is accepted, with the ball at `x`.
  template <class Accept>
  std::optional<Clearance> runUntil(double start, double x, Accept accept) {
    double now = start;
    return inbox_.next([&](const Clearance& message) {
      now += 0.01;
      setTime(now);
      gantry().publish({x, 0.0, 0.0}, ros::Time(now));
      return accept(message);
    });
  }

  Inbox<Clearance> inbox_{ros::NodeHandle(), "/proximity_server/clearance"};
};

TEST_F(Simulation, WithoutAClockTheNodeSaysThatItWaits) {
  const auto message = inbox_.next();
  ASSERT_TRUE(message) << "the topic must stay alive without a clock";
  EXPECT_EQ(message->level, Clearance::INVALID);
  EXPECT_NE(message->status.message.find("clock"), std::string::npos) << message->status.message;

  const auto response = askBaseAndBall();
  EXPECT_EQ(response.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_NE(response.status.message.find("clock"), std::string::npos) << response.status.message;
}

TEST_F(Simulation, StartsWithTheClock) {
  const auto message =
      runUntil(1000.0, 0.4, [](const Clearance& candidate) { return candidate.level == Clearance::CLEAR; });
  ASSERT_TRUE(message);
  EXPECT_GE(message->header.stamp, ros::Time(1000.0));
  EXPECT_NEAR(message->minimum.distance, 0.2, kTolerance);
}

TEST_F(Simulation, RecoversWhenTheClockJumpsBack) {
  const auto message = runUntil(10.0, 0.5, [](const Clearance& candidate) {
    return candidate.level == Clearance::CLEAR && candidate.header.stamp < ros::Time(1000.0);
  });
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, 0.3, kTolerance);
}

TEST_F(Simulation, ForgetsTransformsThatComeFromBeforeTheJump) {
  // Late ones of the old time, which tf would keep and because of which it would refuse all of the new time.
  gantry().publish({0.9, 0.0, 0.0}, ros::Time(1000.0));
  const auto message = runUntil(20.0, 0.5, [](const Clearance& candidate) {
    return candidate.level == Clearance::CLEAR && candidate.header.stamp > ros::Time(20.0) &&
           candidate.header.stamp < ros::Time(1000.0);
  });
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, 0.3, kTolerance);
}

TEST_F(Simulation, AClockThatStandsStillMeansInvalidUntilItRunsOn) {
  const auto running =
      runUntil(30.0, 0.5, [](const Clearance& candidate) { return candidate.level == Clearance::CLEAR; });
  ASSERT_TRUE(running);
  const auto stopped = std::chrono::steady_clock::now();
  const auto first = inbox_.next([](const Clearance& message) { return message.level == Clearance::INVALID; });
  ASSERT_TRUE(first);
  EXPECT_LE(std::chrono::steady_clock::now() - stopped, kFrozenAfter);
  EXPECT_NE(first->status.message.find("clock"), std::string::npos) << first->status.message;
  const auto second = inbox_.next();
  ASSERT_TRUE(second) << "the topic must stay alive";
  EXPECT_EQ(second->level, Clearance::INVALID);
  EXPECT_GT(second->cycle, first->cycle);

  EXPECT_TRUE(runUntil(running->header.stamp.toSec() + 1.0, 0.5,
                       [](const Clearance& candidate) { return candidate.level == Clearance::CLEAR; }));
}

// Regression: with the rate 0, each message on /tf let the monitor judge the last poses anew.
TEST_F(Simulation, AMonitorOnTfIsInvalidAllTheTimeThatTheClockStandsStill) {
  Inbox<Clearance> on_tf(ros::NodeHandle(), "/on_tf/clearance");
  double now = 40.0;
  const auto is_clear = [&](const Clearance& message) {
    setTime(now += 0.01);
    gantry().publish({0.5, 0.0, 0.0}, ros::Time(now));
    return message.level == Clearance::CLEAR;
  };
  setTime(now);
  gantry().publish({0.5, 0.0, 0.0}, ros::Time(now));
  ASSERT_TRUE(on_tf.next(is_clear));
  ASSERT_TRUE(on_tf.next([](const Clearance& message) { return message.level == Clearance::INVALID; }));
  int messages = 0;
  const auto end = std::chrono::steady_clock::now() + kFrozenAfter;
  EXPECT_TRUE(on_tf.next([&](const Clearance& message) {
    ++messages;
    EXPECT_EQ(message.level, Clearance::INVALID) << "message " << messages;
    for (int i = 0; i < 5; ++i) gantry().publish({0.4, 0.0, 0.0}, ros::Time(now));
    return std::chrono::steady_clock::now() > end;
  }));
  EXPECT_GE(messages, 2);
}

TEST_F(Simulation, AnswersAboutTheLastPosesWhileTheClockStandsStill) {
  ASSERT_TRUE(runUntil(50.0, 0.5, [](const Clearance& candidate) { return candidate.level == Clearance::CLEAR; }));
  ASSERT_TRUE(inbox_.next([](const Clearance& message) { return message.level == Clearance::INVALID; }));
  EXPECT_NEAR(askBaseAndBall().pair.distance, 0.3, kTolerance);
}

}  // namespace proximity_server::node::clock_test
