#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include "node/answers.h"
#include "node/diagnosis.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/state_publisher.h"

#include <set>

// Two robots of gantry.urdf, each with its robot_state_publisher, on one tf. With the ball at (x, 0, 0) it is x - 0.2
// from the base.

namespace proximity_server::node::two_robots_test {

constexpr double kLeft = 0.4, kRight = 0.7;  // [m] x of the balls

class TwoRobots : public testing::Test {
 protected:
  void SetUp() override {
    if (!statePublisherKnowsPrefixes()) GTEST_SKIP() << kStatePublisherWithoutPrefixes;
    static JointStates left("left"), right("right");
    left.hold(slidingAt(0.0), positionsAt(kLeft));
    right.hold(slidingAt(0.0), positionsAt(kRight));
  }

  /// The next one that is at this distance, of any number of nodes.
  static std::optional<Clearance> clearance(const std::string& node, double distance) {
    Inbox<Clearance> inbox(ros::NodeHandle(), node + "/clearance");
    return inbox.next([&](const Clearance& message) {
      return message.level != Clearance::INVALID && std::abs(message.minimum.distance - distance) <= kTolerance;
    });
  }
};

TEST_F(TwoRobots, EachHaveTheClearanceOfTheirOwnPoseInTheirOwnFrame) {
  const auto left = clearance("/left/proximity_server", kLeft - 0.2);
  const auto right = clearance("/right/proximity_server", kRight - 0.2);
  ASSERT_TRUE(left);
  ASSERT_TRUE(right);
  EXPECT_EQ(left->header.frame_id, "left/base");
  EXPECT_EQ(right->header.frame_id, "right/base");
  EXPECT_EQ(links(left->minimum), (std::set<std::string>{"base", "ball"}));
}

TEST_F(TwoRobots, AnswerRequestsThatNameLinksAsTheUrdfDoes) {
  const auto request = between<MinimumDistanceRequest>("base", "ball");
  for (const auto& [ns, x] : {std::pair<std::string, double>("left", kLeft), {"right", kRight}}) {
    ASSERT_TRUE(clearance("/" + ns + "/proximity_server", x - 0.2));
    const auto response = call<MinimumDistanceResponse>("/" + ns + "/proximity_server/minimum_distance", request);
    ASSERT_TRUE(response.success) << response.status.message;
    EXPECT_NEAR(response.pair.distance, x - 0.2, kTolerance);
    EXPECT_NEAR(response.pair.point_b.x, x - 0.1, kTolerance);
    EXPECT_EQ(response.header.frame_id, ns + "/base");
  }
}

TEST_F(TwoRobots, AnswerInTheFrameOfALinkNamedWithOrWithoutPrefix) {
  for (const std::string node : {"/left/in_ball", "/left/in_left_ball"}) {
    const auto message = clearance(node, kLeft - 0.2);
    ASSERT_TRUE(message) << node;
    EXPECT_EQ(message->header.frame_id, "left/ball");
    const bool base_first = message->minimum.a.link == "base";
    // Towards the base is +y in the turned frame.
    EXPECT_NEAR((base_first ? message->minimum.point_b : message->minimum.point_a).y, 0.1, kTolerance);
  }
}

TEST_F(TwoRobots, AnswerInAFrameOfNoRobotThatHasNoPrefix) {
  Gantry tf{ros::NodeHandle()};
  ASSERT_TRUE(tf.awaitListeners(1));
  geometry_msgs::TransformStamped world = Gantry::slide({0.0, 0.0, 0.0});
  world.header.frame_id = "world";
  world.child_frame_id = "left/base";
  world.transform.translation.z = 2.0;
  Inbox<Clearance> inbox(ros::NodeHandle(), "/left/in_world/clearance");
  const auto message = inbox.next([&](const Clearance& candidate) {
    tf.publish(world, ros::Time::now());
    return candidate.level != Clearance::INVALID;
  });
  ASSERT_TRUE(message);
  EXPECT_EQ(message->header.frame_id, "world");
  EXPECT_NEAR(message->minimum.point_a.z, 2.0, kTolerance);
}

// ---- what is said where the prefix is the reason

void expectHint(const std::string& node, const std::string& hint) {
  Inbox<Clearance> inbox(ros::NodeHandle(), "/" + node + "/clearance");
  const auto says = [&](const std::string& text) { return text.find(hint) != std::string::npos; };
  std::string last;
  EXPECT_TRUE(inbox.next([&](const Clearance& message) {
    EXPECT_EQ(message.level, Clearance::INVALID);
    last = message.status.message;
    return says(last);
  })) << "the last was: "
      << last;
  EXPECT_TRUE(Diagnosis(node + ": tf").next([&](const auto& status) { return says(status.message); }));
}

TEST_F(TwoRobots, AreNamedToANodeThatHasNoPrefix) {
  expectHint("bare", "frames left/base and right/base exist: set tf_prefix to 'left' or 'right'");
}

TEST_F(TwoRobots, AreNamedToANodeOfAnotherPrefix) {
  expectHint("misnamed", "frames left/base and right/base exist, but tf_prefix is 'lft'");
}

}  // namespace proximity_server::node::two_robots_test
