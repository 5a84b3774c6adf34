#include "node/tf/frame_health.h"

#include "allocations.h"
#include "node/asked_robot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

// The faults of tf by their kind, for the robot of gantry.urdf below a frame "odom" in "world". max_tf_age has its
// default, 0.2 s.

namespace proximity_server::node::frame_health_test {

class Health : public AskedGantry {
 protected:
  using Transforms = AskedRobot::Transforms;

  Health() : AskedGantry("world") { run(0.1); }

  static geometry_msgs::TransformStamped frame(const std::string& parent, const std::string& child) {
    geometry_msgs::TransformStamped transform = Gantry::slide({0.0, 0.0, 0.0});
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    return transform;
  }

  /// All transforms that the robot needs, except the one of a frame.
  static Transforms allBut(const std::string& without) {
    Transforms transforms = Gantry::all({0.5, 0.0, 0.0});
    transforms.push_back(frame("world", "odom"));
    transforms.push_back(frame("odom", "base"));
    const auto is_left_out = [&](const auto& transform) { return transform.child_frame_id == without; };
    transforms.erase(std::remove_if(transforms.begin(), transforms.end(), is_left_out), transforms.end());
    return transforms;
  }

  /// For so many seconds all of these come a hundred times a second, and `each` is called then.
  template <class Each>
  void run(double seconds, const std::string& without, Each each) {
    for (int i = 0; i < std::lround(seconds * 100.0); ++i) {
      gantry_.publish(allBut(without), AskedRobot::wait(0.01));
      each();
    }
  }
  void run(double seconds, const std::string& without = "") {
    run(seconds, without, [] {});
  }

  std::string status() {
    const PoseSnapshot found = gantry_.tf().await(gantry_.robot(), gantry_.robot().candidateBodies(), {});
    EXPECT_EQ(found.status.code, QueryStatus::TF_STALE);
    return found.status.message;
  }
  void expectCause(const std::string& cause) {
    const std::string message = status();
    EXPECT_EQ(message.substr(message.find("max_tf_age is 0.2 s") + 19), ": " + cause) << message;
  }
  std::vector<std::string> warnings(double rate = 0.0) { return gantry_.tf().warnings(gantry_.robot(), rate); }
  void expectWarnings(const std::vector<std::string>& expected) { EXPECT_EQ(warnings(), expected); }
};

// ---- why transforms are too old

TEST_F(Health, NamesTheFrameOfWhichNoMessageComes) {
  run(0.5, "slide");
  expectCause("no message of frame 'slide' has come for 0.5 s");
}

TEST_F(Health, NamesTheOneOldFrameOfAChain) {
  run(0.5, "odom");
  expectCause("no message of frame 'odom' has come for 0.5 s");
}

TEST_F(Health, NamesAFrameWhoseStampStandsStillWhileMessagesCome) {
  const ros::Time frozen = ros::Time::now();
  run(0.5, "odom", [&] { gantry_.publish({frame("world", "odom")}, frozen); });
  char stamp[32];
  std::snprintf(stamp, sizeof stamp, "%.3f", frozen.toSec());
  expectCause(std::string("messages of frame 'odom' come, but their stamp stands still at ") + stamp);
}

TEST_F(Health, NamesAFrameWhoseStampsAreLate) {
  run(0.5, "odom", [&] { gantry_.publish({frame("world", "odom")}, ros::Time::now() - ros::Duration(0.4)); });
  expectCause("messages of frame 'odom' come, but their stamps are 0.4 s behind the clock");
}

TEST_F(Health, NamesAFrameWhoseTransformsTfRefuses) {
  geometry_msgs::TransformStamped broken = frame("world", "odom");
  broken.transform.rotation.w = 0.0;
  run(0.5, "odom", [&] { gantry_.publish({broken}, ros::Time::now()); });
  expectCause("messages of frame 'odom' come, but tf refuses their transforms");
}

TEST_F(Health, NamesAFrameWithoutStamps) {
  run(0.5, "odom", [&] { gantry_.publish({frame("world", "odom")}, ros::Time()); });
  expectCause("messages of frame 'odom' come, but without a stamp");
}

TEST_F(Health, NamesTheOldFrameOfObjects) {
  run(0.1, "", [&] { gantry_.publish({frame("odom", "cart"), frame("cart", "camera")}, ros::Time::now()); });
  run(0.5, "", [&] { gantry_.publish({frame("cart", "camera")}, ros::Time::now()); });
  const PoseSnapshot robot = gantry_.tf().await(gantry_.robot(), gantry_.robot().candidateBodies(), {});
  const std::string message = gantry_.tf().lookUpFrames(gantry_.robot(), {{"camera"}, {0}}, robot).status.message;
  EXPECT_NE(message.find(": no message of frame 'cart' has come for 0.5 s"), std::string::npos) << message;
}

// ---- warnings

TEST_F(Health, IsGoodWhereAllFramesComeInTime) {
  run(1.0);
  EXPECT_TRUE(warnings(100.0).empty());
}

TEST_F(Health, WarnsOfTwoParentsOfAFrame) {
  run(0.1, "", [&] { gantry_.publish({frame("world", "base")}, ros::Time::now() + ros::Duration(0.005)); });
  expectWarnings({"frame 'base' has two parents: 'odom' and 'world'"});
}

TEST_F(Health, WarnsOfTwoPublishersOfAFrameByTheirNames) {
  const Transforms twice = {frame("odom", "base"), Gantry::slide({0.5, 0.0, 0.0})};
  run(0.1, "", [&] { gantry_.publish(twice, ros::Time::now(), TfTree::Kind::Moving, "/rival"); });
  expectWarnings({"frame 'base' has two publishers: '/robot' and '/rival' (and 1 more)"});
  run(6.0);
  expectWarnings({});
}

TEST_F(Health, IsGoodAfterAnotherParentOrPublisherHasTakenOver) {
  run(0.1, "base",
      [&] { gantry_.publish({frame("world", "base")}, ros::Time::now(), TfTree::Kind::Moving, "/successor"); });
  expectWarnings({});
}

TEST_F(Health, WarnsOfARateBelowThatOfTheMonitor) {
  warnings(50.0);
  int i = 0;
  run(1.0, "odom", [&] {
    if (++i % 4 == 0) gantry_.publish({frame("world", "odom")}, ros::Time::now());
  });
  EXPECT_EQ(warnings(50.0), std::vector<std::string>{"frame 'odom' comes at 25 Hz, the monitor runs at 50 Hz"});
  EXPECT_TRUE(warnings(0.0).empty());
  EXPECT_TRUE(warnings(25.0).empty());
}

TEST_F(Health, IsNotAboutFramesThatTheRobotDoesNotNeed) {
  const auto publish = [&](const std::string& parent) {
    gantry_.publish({frame(parent, "cart")}, ros::Time::now(), TfTree::Kind::Moving, "/of_" + parent);
  };
  run(0.1, "", [&] {
    publish("odom");
    publish("base");
  });
  EXPECT_TRUE(warnings(50.0).empty());
}

TEST_F(Health, TakesNoMemoryForFramesAndPublishersThatItKnows) {
  tf2_msgs::TFMessage message;
  message.transforms = {frame("a_parent_with_a_long_name", "a_frame_with_a_long_name")};
  const std::string publisher = "/robot_state_publisher_of_the_robot";
  FrameHealth health;
  health.add(message, publisher, AskedRobot::wait(0.01));
  const long before = allocations();
  for (int i = 0; i < 1000; ++i) {
    message.transforms[0].header.stamp = AskedRobot::wait(0.001);
    health.add(message, publisher, message.transforms[0].header.stamp);
  }
  EXPECT_EQ(allocations(), before);
}

TEST_F(Health, KnowsNothingOfTheTimeBeforeTheClockJumpedBack) {
  run(0.1, "", [&] { gantry_.publish({frame("world", "base")}, ros::Time::now() + ros::Duration(0.005)); });
  AskedRobot::wait(-1.0);
  gantry_.tf().await(gantry_.robot(), gantry_.robot().candidateBodies(), {});  // reads the clock
  run(0.1);
  expectWarnings({});
  AskedRobot::wait(1.0);
}

}  // namespace proximity_server::node::frame_health_test
