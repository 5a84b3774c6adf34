#include "node/tf/tf_poses.h"

#include "node/asked_robot.h"
#include "node/threads/request_queue.h"
#include "proximity_server/QueryStatus.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <vector>

// The poses of the robot of gantry.urdf, and those of other frames, from transforms that the tests add. The ball is at
// (x, y, 0). max_tf_age has its default, 0.2 s.

namespace proximity_server::node::tf_poses_test {

class GantryInTf : public AskedGantry {
 protected:
  using AskedGantry::AskedGantry;

  const scene::RobotModel& model() const { return gantry_.robot().robotModel(); }
  PoseSnapshot look() { return gantry_.tf().await(gantry_.robot(), gantry_.robot().candidateBodies(), {}); }

  void expectBallAt(double x) {
    const PoseSnapshot found = look();
    ASSERT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
    EXPECT_EQ(found.poses[model().links[model().findLink("ball")].body].value().translation().x(), x);
  }
  void expectNoPoses(int code, const std::string& named) {
    const PoseSnapshot found = look();
    EXPECT_EQ(found.status.code, code);
    EXPECT_NE(found.status.message.find(named), std::string::npos) << found.status.message;
    EXPECT_FALSE(found.poses[model().links[model().findLink("ball")].body]);
  }
};

// ---- poses

using Poses = GantryInTf;

TEST_F(Poses, TellTheirAgeAndHowFarTheJointsAreApartInTime) {
  const ros::Time common = moveTo({0.5, 0.0, 0.0});
  gantry_.publish({Gantry::slide({0.9, 0.0, 0.0})}, common + ros::Duration(0.04));
  AskedRobot::wait(0.1);
  const PoseSnapshot found = look();
  EXPECT_EQ(found.stamp, common);
  EXPECT_EQ(found.age, ros::Duration(0.1));
  EXPECT_EQ(found.skew, ros::Duration(0.04));
  expectBallAt(0.5);
}

TEST_F(Poses, AreUnknownWhileOneTransformIsTooOldAndItsJointIsNamed) {
  moveTo({0.5, 0.0, 0.0});
  gantry_.publish({Gantry::slide({0.5, 0.0, 0.0}), Gantry::ball({0.5, 0.0, 0.0})}, AskedRobot::wait(0.15));
  expectBallAt(0.5);
  AskedRobot::wait(0.1);
  expectNoPoses(QueryStatus::TF_STALE, "joint 'lift': its latest transform is 0.25 s old, max_tf_age is 0.2 s");
}

TEST_F(Poses, AreUnknownAheadOfTheClockUntilTransformsComeWithItsTime) {
  gantry_.publish(Gantry::all({0.5, 0.0, 0.0}), ros::Time::now() + ros::Duration(0.3));
  expectNoPoses(QueryStatus::TF_STALE, "0.3 s ahead of the clock");
  moveTo({0.7, 0.0, 0.0});
  expectBallAt(0.7);
}

TEST_F(Poses, AreForgottenWhenTheClockJumpsBack) {
  moveTo({0.5, 0.0, 0.0});
  expectBallAt(0.5);
  AskedRobot::wait(-0.1);
  expectNoPoses(QueryStatus::TF_UNAVAILABLE, "joint '");
  moveTo({0.7, 0.0, 0.0});
  expectBallAt(0.7);
}

TEST_F(Poses, NeedAClock) {
  moveTo({0.5, 0.0, 0.0});
  ros::Time::setNow(ros::Time());
  expectNoPoses(QueryStatus::TF_UNAVAILABLE, "waiting for the clock");
}

TEST_F(Poses, OfJointsWithoutStampsAreUnknown) {
  gantry_.publish(Gantry::all({0.5, 0.0, 0.0}), ros::Time());
  expectNoPoses(QueryStatus::TF_UNAVAILABLE, "joint '");
}

TEST_F(Poses, OfStaticJointsHoldAtAnyTime) {
  gantry_.publish(Gantry::all({0.5, 0.0, 0.0}), ros::Time(), TfTree::Kind::Static);
  AskedRobot::wait(1000.0);
  expectBallAt(0.5);
  EXPECT_EQ(look().stamp, ros::Time::now());
}

// tf2 decides once for ever, by the first transform, that a frame is static.
TEST_F(Poses, OfAStaticJointThatMovesLaterGetStale) {
  const AskedRobot::Transforms still = Gantry::all({0.5, 0.0, 0.0});
  gantry_.publish(still, ros::Time(), TfTree::Kind::Static);
  for (int i = 0; i < 2; ++i) moveTo({0.7, 0.0, 0.0});  // each frame that turns out to move empties tf
  gantry_.publish(still, ros::Time(), TfTree::Kind::Static);
  expectBallAt(0.7);
  AskedRobot::wait(0.3);
  expectNoPoses(QueryStatus::TF_STALE, "0.3 s old");
}

TEST_F(Poses, ComeWithACallOfTheListenerForEachMessage) {
  int calls = 0;
  gantry_.tf().onChange([&] { ++calls; });
  moveTo({0.5, 0.0, 0.0});
  gantry_.publish({Gantry::post({0.0, 0.0, 0.0})}, ros::Time(), TfTree::Kind::Static);
  EXPECT_EQ(calls, 2);
}

TEST_F(Poses, ForWhichARequestWaitsDelayNoOtherRequest) {
  Config config = gantry_.robot().config();
  config.tf_timeout = 20.0;  // [s] much longer than the other request needs
  const Robot patient(robotText("gantry.urdf"), robotText("gantry.srdf"), config);
  std::promise<int> status;
  RequestQueue queue(0, {/*at_once=*/1, std::chrono::hours(1)});
  queue.addCallback(callbackOf([&] {
                      const PoseSnapshot found = gantry_.tf().await(patient, patient.candidateBodies(), {});
                      status.set_value(found.status.code);
                    }),
                    1);
  queue.addCallback(callbackOf([&] { moveTo({0.5, 0.0, 0.0}); }), 1);
  EXPECT_EQ(status.get_future().get(), QueryStatus::OK);
}

// ---- frames that carry objects

class Frames : public GantryInTf {
 protected:
  /// A frame at this height above the base, on /tf or, without a stamp, on /tf_static.
  void publishCamera(double z, const ros::Time& stamp) {
    geometry_msgs::TransformStamped camera = Gantry::post({0.0, 0.0, z});
    camera.child_frame_id = "camera";
    gantry_.publish({camera}, stamp, stamp.isZero() ? TfTree::Kind::Static : TfTree::Kind::Moving);
  }

  FrameSnapshot lookUp(const CarrierFrames& frames) {
    return gantry_.tf().lookUpFrames(gantry_.robot(), frames, look());
  }
};

double z(const std::optional<Eigen::Isometry3d>& pose) { return pose.value().translation().z(); }

TEST_F(Frames, StandWhereTheyWereAtTheTimeOfTheRobot) {
  const ros::Time robot = moveTo({0.5, 0.0, 0.0});
  publishCamera(1.0, robot - ros::Duration(0.01));
  publishCamera(3.0, robot + ros::Duration(0.01));
  const FrameSnapshot found = lookUp({{"camera"}, {0}});
  EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
  EXPECT_NEAR(z(found.poses.at(0)), 2.0, 1e-12);
  EXPECT_EQ(found.may_move, std::vector<int>{0});
}

TEST_F(Frames, ThatTfDoesNotKnowAtThatTimeStandWhereTheyAreNow) {
  publishCamera(1.0, moveTo({0.5, 0.0, 0.0}) + ros::Duration(0.01));
  EXPECT_EQ(z(lookUp({{"camera"}, {0}}).poses.at(0)), 1.0);
}

TEST_F(Frames, OfLinksAndOfStaticTransformsDoNotMoveByThemselves) {
  moveTo({0.5, 0.2, -0.3});
  publishCamera(1.0, ros::Time());
  const FrameSnapshot found = lookUp({{"camera", "block"}, {0, 1}});
  EXPECT_EQ(z(found.poses.at(0)), 1.0);
  EXPECT_EQ(z(found.poses.at(1)), -0.3);
  EXPECT_TRUE(found.may_move.empty());
}

TEST_F(Frames, AreLookedUpWhereTheyAreNeededOnly) {
  moveTo({0.5, 0.0, 0.0});
  publishCamera(1.0, ros::Time());
  const CarrierFrames frames{{"nowhere", "camera"}, {1}};
  EXPECT_EQ(lookUp(frames).status.code, QueryStatus::OK);
  EXPECT_FALSE(lookUp(frames).poses.at(0));
  const FrameSnapshot found = lookUp({frames.names, {0, 1}});
  EXPECT_EQ(found.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_EQ(found.status.message.rfind("frame 'nowhere': ", 0), 0u) << found.status.message;
  EXPECT_EQ(z(found.poses.at(1)), 1.0) << "the others stand where they are";
}

// ---- a reference frame that is not that of a link

class GantryInTheWorld : public GantryInTf {
 protected:
  GantryInTheWorld() : GantryInTf("world") {}
};

TEST_F(GantryInTheWorld, StandsStillWhereStaticTransformsSayIt) {
  const auto status = [&] { return gantry_.tf().standingStill(gantry_.robot(), {TfPoses::kReferenceFrame, 0}); };
  geometry_msgs::TransformStamped base = Gantry::slide({0.0, 0.0, 0.0});
  base.header.frame_id = "world";
  base.child_frame_id = "base";
  gantry_.publish({base}, ros::Time(), TfTree::Kind::Static);
  EXPECT_EQ(status().code, QueryStatus::OK);
  gantry_.moveTo({base});
  EXPECT_EQ(status().code, QueryStatus::NO_VELOCITY);
  EXPECT_EQ(status().message, "the robot: its base 'base' may move against 'world', as /tf_static does not join them");
}

}  // namespace proximity_server::node::tf_poses_test
