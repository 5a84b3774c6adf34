// Cycles of the monitor in poses that no tf would send.
#include "node/monitor/slider_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

namespace proximity_server::node::monitor_test {

TEST_F(MonitorOfSliders, ReportsTheClosestPair) {
  follow("");
  const Clearance& clearance = cycleWithTheRightSphereAt(0.5);
  EXPECT_EQ(clearance.status.code, QueryStatus::OK) << clearance.status.message;
  EXPECT_EQ(clearance.level, Clearance::CLEAR);
  EXPECT_NEAR(clearance.minimum.distance, 0.3, 1e-9);
}

// Regression: such a cycle reported NO_COLLISION_GEOMETRY, "the filter leaves no pair to check".
TEST_F(MonitorOfSliders, ReportsPairsWithoutUsablePoseAlthoughTfKnowsAllPoses) {
  follow("");
  const Clearance& clearance = cycleWithTheRightSphereAt(1e300);  // its square is not finite
  EXPECT_EQ(clearance.pairs_unknown, 2u);
  EXPECT_EQ(clearance.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_EQ(clearance.status.message, "2 of 3 pairs have no usable pose");
  EXPECT_EQ(clearance.level, Clearance::INVALID);
  EXPECT_TRUE(std::isnan(clearance.minimum.distance));
}

TEST_F(MonitorOfSliders, KeepsTheStatusOfTfWherePairsAreUnknown) {
  follow("");
  PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
  for (std::optional<Eigen::Isometry3d>& pose : snapshot.poses) pose.reset();
  snapshot.status.code = QueryStatus::TF_STALE;
  snapshot.status.message = "joint 'to_right' is 5 s old";
  const Clearance& clearance = monitor_.cycle(snapshot, {}, MonitorSettings());
  EXPECT_EQ(clearance.status.code, QueryStatus::TF_STALE);
  EXPECT_EQ(clearance.status.message, "joint 'to_right' is 5 s old");
}

TEST_F(MonitorOfSliders, SaysThatTheFilterLeavesNoPairOnlyWhereItDoes) {
  follow(R"(<robot name="sliders"><disable_collisions link1="left" link2="middle" reason="Never"/>
            <disable_collisions link1="left" link2="right" reason="Never"/>
            <disable_collisions link1="middle" link2="right" reason="Never"/></robot>)");
  const Clearance& clearance = cycleWithTheRightSphereAt(1e300);
  EXPECT_EQ(clearance.status.code, QueryStatus::NO_COLLISION_GEOMETRY);
  EXPECT_EQ(clearance.status.message, "the filter leaves no pair to check");
  EXPECT_EQ(clearance.level, Clearance::INVALID);
}

TEST_F(MonitorOfSliders, TellsTheSkewOfTheTransforms) {
  follow("");
  PoseSnapshot poses = snapshot();
  poses.skew = ros::Duration(0.03);
  EXPECT_EQ(monitor_.cycle(poses, {}, settings_).tf_skew, ros::Duration(0.03));
}

// Spheres 21 mm apart are within the hysteresis of the level STOP.
TEST_F(MonitorOfSliders, BeginsWithoutALevelAfterAReload) {
  follow("");
  EXPECT_EQ(cycleWithTheRightSphereAt(0.21).level, Clearance::STOP);
  EXPECT_EQ(cycleWithTheRightSphereAt(0.221).level, Clearance::STOP);
  follow("");
  EXPECT_EQ(cycleWithTheRightSphereAt(0.221).level, Clearance::WARN);
}

// --- objects

class MonitorOfObjects : public MonitorOfSliders {
 protected:
  void SetUp() override { follow(""); }
  const Clearance& cycleWithFrames(const FrameSnapshot& frames) {
    return monitor_.cycle(withTheRightSphereAt(*robot_, 0.5), {}, settings_, frames);
  }
};

TEST_F(MonitorOfObjects, ReportsTheMinimumOfEachKindAndOfBoth) {
  add(ballAt(standingAt(0.0, 0.25, 0.0)));
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_EQ(clearance.status.code, QueryStatus::OK) << clearance.status.message;
  EXPECT_NEAR(clearance.self_minimum.distance, 0.3, 1e-9);
  EXPECT_NEAR(clearance.object_minimum.distance, 0.05, 1e-9);
  EXPECT_NEAR(clearance.minimum.distance, 0.05, 1e-9);
  EXPECT_EQ(clearance.minimum.a.link, "middle");
  EXPECT_EQ(clearance.minimum.a.kind, ShapeRef::LINK);
  EXPECT_EQ(clearance.minimum.b.link, "ball");
  EXPECT_EQ(clearance.minimum.b.kind, ShapeRef::OBJECT);
  EXPECT_EQ(clearance.objects_revision, 1u);
  EXPECT_EQ(clearance.pairs_total, 6u);
}

TEST_F(MonitorOfObjects, KnowsNoMinimumOfAKindWithoutPairs) {
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_NEAR(clearance.self_minimum.distance, 0.3, 1e-9);
  EXPECT_EQ(clearance.object_minimum.state, Proximity::UNKNOWN);
  EXPECT_EQ(clearance.level, Clearance::CLEAR);
}

TEST_F(MonitorOfObjects, HasLevelsOfTheirOwnForObjects) {
  settings_.warn_distance = 0.4;  // the links are 0.3 m apart
  settings_.object_warn_distance = 0.3;
  settings_.object_stop_distance = 0.2;
  add(ballAt(standingAt(0.0, 0.55, 0.0)));
  EXPECT_EQ(cycleWithFrames({}).level, Clearance::WARN);
  add(ballAt(standingAt(0.0, -0.35, 0.0), "nearer"));
  EXPECT_EQ(cycleWithFrames({}).level, Clearance::STOP);
  settings_.warn_distance = settings_.object_warn_distance = settings_.object_stop_distance = 0.0;
  settings_.stop_distance = 0.0;
  EXPECT_EQ(cycleWithFrames({}).level, Clearance::CLEAR);
}

// The object is farther from the robot than the links are from each other, but its levels begin earlier.
TEST_F(MonitorOfObjects, HoldsTheLevelOfObjectsByThatOfObjects) {
  add(ballAt(standingAt(0.71, 0.0, 0.0)));
  EXPECT_EQ(cycleWithTheRightSphereAt(0.5).level, Clearance::STOP);
  EXPECT_EQ(cycleWithTheRightSphereAt(0.489).level, Clearance::STOP) << "21 mm are within the hysteresis";
}

TEST_F(MonitorOfObjects, AreDecidedByThePairFarthestBelowItsThreshold) {
  settings_.object_stop_distance = 0.1;
  settings_.object_warn_distance = 0.2;
  add(ballAt(standingAt(0.44, 0.0, 0.0)));
  const Clearance& clearance = monitor_.cycle(withTheRightSphereAt(*robot_, 0.21), {}, settings_);
  EXPECT_EQ(clearance.level, Clearance::STOP);
  EXPECT_NEAR(clearance.minimum.distance, 0.01, 1e-9) << "to the middle sphere";
  EXPECT_NEAR(clearance.deciding.distance, 0.03, 1e-9) << "to the ball";
  EXPECT_EQ(clearance.deciding_threshold, 0.1);
}

TEST_F(MonitorOfObjects, TakesTheWorseLevelOfTheTwoKinds) {
  settings_.object_warn_distance = settings_.object_stop_distance = 0.5;
  add(ballAt(standingAt(0.0, 0.6, 0.0)));
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_EQ(clearance.minimum.b.kind, ShapeRef::LINK);
  EXPECT_EQ(clearance.level, Clearance::STOP);
}

class MonitorWithThresholdsOfPairs : public MonitorOfObjects {
 protected:
  void SetUp() override {
    config_.monitor.influence_distance = 2.0;
    config_.thresholds.stop.of_pairs = {{{"middle", "left"}, 0.85}};
    config_.thresholds.warn.of_pairs = {{{"left", "middle"}, 0.9}};
    config_.thresholds.warn.of_links = {{"right", 0.35}};
    follow("");
    settings_.threshold = 1.0;
  }
};

TEST_F(MonitorWithThresholdsOfPairs, TellsThePairThatSetsTheLevelAlthoughAnotherIsCloser) {
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_EQ(clearance.level, Clearance::STOP);
  EXPECT_EQ(clearance.deciding.a.link, "left");
  EXPECT_EQ(clearance.deciding.b.link, "middle");
  EXPECT_NEAR(clearance.deciding.distance, 0.8, 1e-9);
  EXPECT_EQ(clearance.deciding_threshold, 0.85);
  EXPECT_NEAR(clearance.minimum.distance, 0.3, 1e-9);
  ASSERT_EQ(clearance.levels.size(), 2u);
  EXPECT_EQ(clearance.levels[0], Clearance::WARN);  // middle - right, at 0.3
  EXPECT_EQ(clearance.levels[1], Clearance::STOP);
}

TEST_F(MonitorWithThresholdsOfPairs, TakesAnObjectAtTheThresholdOfItsLink) {
  config_.thresholds.stop.of_pairs.clear();
  config_.thresholds.warn.of_pairs.clear();
  follow("");
  settings_.warn_distance = settings_.stop_distance = settings_.object_stop_distance = settings_.object_warn_distance =
      0.0;
  add(ballAt(standingAt(0.5, 0.5, 0.0)));
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_EQ(clearance.deciding.a.link, "middle");  // - right, 0.05 m below; the ball is 0.05 m below too, or above
  EXPECT_EQ(clearance.level, Clearance::WARN);
  add(ballAt(standingAt(0.5, -0.4, 0.0), "nearer"));
  EXPECT_EQ(cycleWithFrames({}).deciding.b.link, "nearer");
  EXPECT_EQ(cycleWithFrames({}).deciding_threshold, 0.35);
}

TEST_F(MonitorWithThresholdsOfPairs, KnowsNoDecidingPairWhileTheLevelIsInvalid) {
  const Clearance& clearance = cycleWithTheRightSphereAt(1e300);
  EXPECT_EQ(clearance.level, Clearance::INVALID);
  EXPECT_EQ(clearance.deciding.state, Proximity::UNKNOWN);
  EXPECT_TRUE(std::isnan(clearance.deciding_threshold));
}

TEST_F(MonitorOfObjects, FollowsAnObjectInItsFrame) {
  add(ballAt(scene::Moving{"camera", Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 1.0))}));
  EXPECT_EQ(monitor_.frames().names, std::vector<std::string>{"camera"});
  FrameSnapshot frames;
  frames.poses = {Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 1.0))};
  EXPECT_NEAR(cycleWithFrames(frames).object_minimum.distance, 1.8, 1e-9);
}

TEST_F(MonitorOfObjects, IsInvalidAndNamesTheFrameWhileItIsUnknown) {
  add(ballAt(scene::Moving{"camera"}));
  FrameSnapshot frames;
  frames.poses = {std::nullopt};
  frames.status.code = QueryStatus::TF_STALE;
  frames.status.message = "frame 'camera' of objects: old";
  const Clearance& clearance = cycleWithFrames(frames);
  EXPECT_EQ(clearance.level, Clearance::INVALID);
  EXPECT_EQ(clearance.status.code, QueryStatus::TF_STALE);
  EXPECT_EQ(clearance.status.message, "frame 'camera' of objects: old");
  EXPECT_EQ(clearance.pairs_unknown, 3u);
  EXPECT_EQ(clearance.object_minimum.state, Proximity::UNKNOWN);
}

// --- the lookahead with objects: the middle sphere moves at 0.5 m/s towards the left one, which is 0.8 m away

class LookaheadWithObjects : public MonitorOfObjects {
 protected:
  void SetUp() override {
    follow("");
    settings_.lookahead = 2.0;
    settings_.rate = 0.1;  // a search may take 2.5 s
    settings_.object_stop_distance = 0.05;
  }
  Lookahead ahead(const FrameSnapshot& frames = {}) {
    VelocitySnapshot velocities;
    const auto& joints = robot_->robotModel().joints;
    for (const scene::Joint& joint : joints) velocities.velocities.push_back(joint.name == "to_middle" ? -0.5 : 0.0);
    return monitor_.cycle(withTheRightSphereAt(*robot_, 0.5), velocities, settings_, frames).lookahead;
  }
};

TEST_F(LookaheadWithObjects, MeetsAnObjectAtTheStopDistanceOfObjects) {
  add(ballAt(standingAt(-0.5, 0.0, 0.0)));
  const Lookahead lookahead = ahead();
  EXPECT_EQ(lookahead.status.code, QueryStatus::OK) << lookahead.status.message;
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NEAR(lookahead.time_to_contact, (0.3 - 0.05) / 0.5, 1e-5);
  EXPECT_LE(lookahead.time_free, 0.5);
  EXPECT_EQ(lookahead.pair.a.link, "middle");
  EXPECT_EQ(lookahead.pair.b.link, "ball");
  EXPECT_EQ(lookahead.pair.b.kind, ShapeRef::OBJECT);
  EXPECT_EQ(lookahead.object_contact_distance, 0.05);
}

TEST_F(LookaheadWithObjects, MeetsAnObjectThatCameAfterTheLastCycle) {
  add(ballAt(standingAt(-0.5, 0.0, 0.0)));
  EXPECT_NEAR(ahead().time_to_contact, (0.3 - 0.05) / 0.5, 1e-5);
  add(ballAt(standingAt(-0.4, 0.0, 0.0), "nearer"));
  EXPECT_NEAR(ahead().time_to_contact, (0.2 - 0.05) / 0.5, 1e-5);
}

TEST_F(LookaheadWithObjects, MeetsALinkAtTheStopDistanceOfLinksIfThatIsFirst) {
  add(ballAt(standingAt(-1.0, 0.0, 0.5)));
  const Lookahead lookahead = ahead();
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NEAR(lookahead.time_to_contact, (0.8 - 0.02) / 0.5, 1e-5);
  EXPECT_LE(lookahead.time_free, 1.56);
  EXPECT_EQ(lookahead.pair.b.kind, ShapeRef::LINK);
}

TEST_F(LookaheadWithObjects, MeetsAPairAtItsOwnStopDistance) {
  config_.monitor.influence_distance = 1.0;
  config_.thresholds.stop.of_pairs = {{{"left", "middle"}, 0.4}};
  config_.thresholds.warn.of_pairs = {{{"left", "middle"}, 0.4}};
  follow("");
  const Lookahead lookahead = ahead();
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NEAR(lookahead.time_to_contact, (0.8 - 0.4) / 0.5, 1e-5);
  EXPECT_EQ(lookahead.pair_contact_distance, 0.4);
  EXPECT_EQ(lookahead.contact_distance, 0.02);
}

TEST_F(LookaheadWithObjects, IsFreeOnlyIfBothKindsAre) {
  settings_.lookahead = 1.0;
  add(ballAt(standingAt(-0.5, 0.5, 0.0)));
  const Lookahead lookahead = ahead();
  EXPECT_EQ(lookahead.state, Lookahead::FREE);
  EXPECT_EQ(lookahead.time_free, 1.0);
}

TEST_F(LookaheadWithObjects, CarriesWhatALinkHolds) {
  scene::Attached held{"middle"};
  held.link_T_object.translation().x() = -0.2;
  add(ballAt(held, "held"));
  add(ballAt(standingAt(-0.7, 0.0, 0.0)));
  EXPECT_NEAR(ahead().time_to_contact, (0.3 - 0.05) / 0.5, 1e-5);
}

TEST_F(LookaheadWithObjects, TakesMovingObjectsToRest) {
  add(ballAt(scene::Moving{"camera"}));
  FrameSnapshot frames;
  frames.poses = {Eigen::Isometry3d(Eigen::Translation3d(-0.5, 0.0, 0.0))};
  EXPECT_NEAR(ahead(frames).time_to_contact, 0.5, 1e-5);
}

TEST_F(LookaheadWithObjects, SaysThatMovingObjectsAreTakenToRest) {
  settings_.lookahead = 0.5;
  add(ballAt(scene::Moving{"camera"}));
  FrameSnapshot frames;
  frames.poses = {Eigen::Isometry3d(Eigen::Translation3d(-0.5, 0.5, 0.0))};
  EXPECT_EQ(ahead(frames).status.message, "") << "tf joins the frames by static transforms";
  frames.may_move = {0};
  const Lookahead lookahead = ahead(frames);
  EXPECT_EQ(lookahead.state, Lookahead::FREE);
  EXPECT_EQ(lookahead.status.code, QueryStatus::OK);
  EXPECT_EQ(lookahead.status.message, "objects in frame 'camera' are taken to rest where they are");
}

TEST_F(LookaheadWithObjects, MovesObjectsInTheFrameOfALinkWithTheLink) {
  add(ballAt(scene::Moving{"middle", Eigen::Isometry3d(Eigen::Translation3d(-0.4, 0.0, 0.0))}));
  FrameSnapshot frames;
  frames.poses = {Eigen::Isometry3d::Identity()};
  const Lookahead lookahead = ahead(frames);
  EXPECT_NEAR(lookahead.time_to_contact, (0.4 - 0.05) / 0.5, 1e-5) << "of the object and the left sphere";
  EXPECT_EQ(lookahead.pair.a.link, "left");
}

TEST_F(LookaheadWithObjects, IsUnknownAndNamesTheFrameThatIsMissing) {
  add(ballAt(scene::Moving{"camera"}));
  FrameSnapshot frames;
  frames.poses = {std::nullopt};
  frames.status.code = QueryStatus::TF_UNAVAILABLE;
  frames.status.message = "frame 'camera' of objects: missing";
  const Lookahead lookahead = ahead(frames);
  EXPECT_EQ(lookahead.state, Lookahead::UNKNOWN);
  EXPECT_EQ(lookahead.status.message, "frame 'camera' of objects: missing");
}

// No pair of links is checked, so that no velocity would matter without the object.
TEST_F(LookaheadWithObjects, NeedsTheVelocitiesOfWhatMayMeetAnObject) {
  follow(R"(<robot name="sliders"><disable_default_collisions link="left"/><disable_default_collisions link="middle"/>
            <disable_default_collisions link="right"/></robot>)");
  EXPECT_TRUE(monitor_.joints().empty());
  add(ballAt(standingAt(-0.5, 0.0, 0.0)));
  EXPECT_EQ(monitor_.joints().size(), 3u);
  EXPECT_NEAR(ahead().time_to_contact, 0.5, 1e-5);
  follow("");
  add(ballAt(scene::Attached{"left"}, "held"));
  EXPECT_EQ(monitor_.joints().size(), 3u);
}

TEST_F(MonitorOfObjects, ChecksARobotOfWhichTheFilterLeavesNoPairAgainstObjects) {
  follow(R"(<robot name="sliders"><disable_default_collisions link="left"/><disable_default_collisions link="middle"/>
            <disable_default_collisions link="right"/></robot>)");
  add(ballAt(standingAt(0.0, 0.5, 0.0)));
  const Clearance& clearance = cycleWithFrames({});
  EXPECT_EQ(clearance.status.code, QueryStatus::OK) << clearance.status.message;
  EXPECT_NEAR(clearance.minimum.distance, 0.3, 1e-9);
  EXPECT_EQ(clearance.self_minimum.state, Proximity::UNKNOWN);
  EXPECT_EQ(clearance.level, Clearance::CLEAR);
}

}  // namespace proximity_server::node::monitor_test
