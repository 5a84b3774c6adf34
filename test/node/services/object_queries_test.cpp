#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/object_messages.h"
#include "node/services/queries.h"

#include <cmath>
#include <set>
#include <string>
#include <vector>

// Questions about objects. The robot is that of gantry.urdf, with its ball at (1, 0, 0) and its block at (0, 1, 0).
// Objects are balls of radius 0.1 m.

namespace proximity_server::node::object_queries_test {

MinimumDistanceRequest between(const std::string& a, const std::string& b) {
  return node::between<MinimumDistanceRequest>(a, b);
}

constexpr double kMotionTolerance = 1e-6;  // [m] of the searches: the default of the requests

/// The ball slides along y at 0.5 m/s, for two seconds.
FirstContactRequest sliding(const std::string& a, const std::string& b) {
  FirstContactRequest request;
  request.a = shape(a);
  request.b = shape(b);
  request.joints.name = {"y_axis"};
  request.joints.velocity = {0.5};
  request.horizon = 2.0;
  return request;
}

/// The ball goes from (1, 0, 0) to (1, 0.5, 0) and on to (1, 1, 0), in a second each.
QueryTrajectoryRequest alongY(const std::string& a, const std::string& b) {
  QueryTrajectoryRequest request;
  request.a = shape(a);
  request.b = shape(b);
  request.trajectory.joint_names = {"x_axis", "y_axis"};
  for (int i = 0; i < 3; ++i) {
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = {1.0, 0.5 * i};
    point.time_from_start = ros::Duration(i);
    request.trajectory.points.push_back(point);
  }
  return request;
}

class Objects : public AskedGantry {
 protected:
  Objects() : AskedGantry("", /*max_batch=*/100) { moveTo({1.0, 0.0, 0.0}); }

  void add(const std::vector<ObjectChange>& changes) {
    const ApplyObjectsResponse response = ask(requestOf(changes));
    ASSERT_TRUE(response.success) << response.status.message;
  }

  /// A frame at this height above the base.
  void publishFrame(const std::string& name, double z, const ros::Time& stamp = ros::Time::now()) {
    geometry_msgs::TransformStamped frame = Gantry::post({0.0, 0.0, z});
    frame.child_frame_id = name;
    gantry_.publish({frame}, stamp);
  }
};

TEST_F(Objects, AreNamedInRequestsAsLinksAre) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0))});
  const auto response = ask(between("ball", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
  EXPECT_EQ(response.pair.a.kind, ShapeRef::LINK);
  EXPECT_EQ(response.pair.b.kind, ShapeRef::OBJECT);
  EXPECT_EQ(response.pair.b.link, "part");
  expectNear(response.pair.point_b, 1.0, 0.4, 0.0);
  EXPECT_TRUE(isNaN(response.pair.point_b_link)) << "no link holds it";
  EXPECT_EQ(links(ask(between("part", "")).pair), (std::set<std::string>{"ball", "part"}));
  EXPECT_EQ(links(ask(between("ball", "")).pair), (std::set<std::string>{"ball", "part"}));
  EXPECT_EQ(links(ask(between("", "")).pair), (std::set<std::string>{"ball", "part"}));
}

TEST_F(Objects, AreAskedAsAWhole) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0))});
  MinimumDistanceRequest request = between("ball", "part");
  const Proximity answer = ask(request).pair;
  EXPECT_EQ(answer.b.index, 1U);
  request.a = answer.a;
  request.b = answer.b;
  EXPECT_EQ(ask(request).pair.distance, answer.distance);
}

TEST_F(Objects, ThatStandStillAreNotCheckedAgainstTheBase) {
  add({addBall("part", poseAt(0.0, 0.0, 0.5))});
  MinimumDistanceRequest request = between("base", "part");
  expectRefusal(ask(request), QueryStatus::PAIR_EXCLUDED, "base");
  request.ignore_filter = true;
  EXPECT_NEAR(ask(request).pair.distance, 0.3, kTolerance);
}

TEST_F(Objects, MayTouchWhatTheRulesAllow) {
  ApplyObjectsRequest request = requestOf({addBall("part", poseAt(1.0, 0.5, 0.0))});
  request.changes.set_rules = true;
  request.changes.rules.resize(1);
  request.changes.rules[0].a = "part";
  request.changes.rules[0].b = "*";
  request.changes.rules[0].allowed = true;
  ASSERT_TRUE(ask(request).success);
  expectRefusal(ask(between("ball", "part")), QueryStatus::PAIR_EXCLUDED, "'part'");
  expectRefusal(ask(between("part", "")), QueryStatus::INVALID_ARGUMENT, "no pair");
}

TEST_F(Objects, WithPlanesAlwaysMeetEachOther) {
  ObjectChange floor = change(ObjectChange::ADD, "floor"), wall = change(ObjectChange::ADD, "wall");
  floor.planes.resize(1);
  floor.planes[0].coef = {0.0, 0.0, 1.0, 0.5};
  wall.planes.resize(1);
  wall.planes[0].coef = {1.0, 0.0, 0.0, 5.0};
  add({floor, wall});
  EXPECT_NEAR(ask(between("ball", "floor")).pair.distance, 0.4, kTolerance);
  MinimumDistanceRequest request = between("floor", "wall");
  request.ignore_filter = true;
  expectRefusal(ask(request), QueryStatus::INVALID_ARGUMENT, "half-space");
  request = between("floor", "");
  request.ignore_filter = true;
  EXPECT_TRUE(ask(request).success);
}

TEST_F(Objects, ComeInBatches) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0)), addBall("far", poseAt(1.0, 0.0, 9.0))});
  QueryPairsRequest request;
  request.mode = QueryPairsRequest::K_CLOSEST;
  request.k = 100;
  auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  const std::size_t of_objects = 4;  // ball and block with each of the two
  const std::size_t of_all = response.pairs.size();
  EXPECT_EQ(links(response.pairs[0]), (std::set<std::string>{"ball", "part"}));
  request.mode = QueryPairsRequest::PER_PAIR;
  EXPECT_EQ(ask(request).pairs.size(), of_all);
  request.a = {shape("part"), shape("far")};
  EXPECT_EQ(ask(request).pairs.size(), of_objects);
  request.a = {ShapeRef()};
  EXPECT_EQ(ask(request).pairs.size(), of_all);
  request.ignore_filter = true;
  EXPECT_EQ(ask(request).pairs.size(), 3u + 6u);
}

TEST_F(Objects, MoveWithTheLinkInOtherStates) {
  ObjectChange bar = addBall("bar", poseAt(0.0, 0.0, 0.5));
  bar.link = bar.header.frame_id = "ball";
  add({bar, addBall("part", poseAt(2.0, 0.0, 0.5))});
  QueryConfigurationRequest request;
  request.a = {shape("bar")};
  request.b = {shape("part")};
  request.states.resize(2);
  for (sensor_msgs::JointState& state : request.states) state.name = {"x_axis", "y_axis", "lift"};
  request.states[0].position = {0.0, 0.0, 0.0};
  request.states[1].position = {1.5, 0.0, 0.0};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states[0].minimum.distance, 1.8, kTolerance);
  EXPECT_NEAR(response.states[1].minimum.distance, 0.3, kTolerance);
  expectNear(response.states[1].minimum.point_a_link, 0.0, -0.1, 0.5);  // the ball's frame is turned by a quarter
}

// The frame of the ball is turned by a quarter, so that the part is 1 m before it along x.
TEST_F(Objects, InTheFrameOfALinkStandWhereEachStateHasIt) {
  add({addBallInFrame("part", "ball", poseAt(0.0, -1.0, 0.0))});
  QueryConfigurationRequest request;
  request.a = {shape("base")};
  request.b = {shape("part")};
  request.states.resize(2);
  for (sensor_msgs::JointState& state : request.states) state.name = {"x_axis", "y_axis", "lift"};
  request.states[0].position = {0.0, 0.0, 0.0};
  request.states[1].position = {1.5, 0.0, 0.0};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states[0].minimum.distance, 0.8, kTolerance);
  EXPECT_NEAR(response.states[1].minimum.distance, 2.3, kTolerance);
}

TEST_F(Objects, InAFrameThatTfDoesNotKnowAreUnknownAndTheFrameIsNamed) {
  publishFrame("camera", 1.0);
  add({addBallInFrame("part", "camera"), addBallInFrame("other", "nowhere")});
  expectRefusal(ask(between("ball", "other")), QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  const auto response = ask(between("ball", "part"));
  EXPECT_TRUE(response.success) << response.status.message << ": the frame of another object does not matter";
  EXPECT_NEAR(response.pair.distance, std::hypot(1.0, 1.0) - 0.2, kTolerance);

  QueryPairsRequest request;
  request.mode = QueryPairsRequest::PER_PAIR;
  const auto pairs = ask(request);
  EXPECT_FALSE(pairs.success);
  EXPECT_NE(pairs.status.message.find("'nowhere'"), std::string::npos) << pairs.status.message;
  for (const Proximity& pair : pairs.pairs)
    EXPECT_EQ(pair.state == Proximity::UNKNOWN, links(pair).count("other") > 0) << pair.a.link << " " << pair.b.link;
}

// An old transform is no statement about now.
TEST_F(Objects, InAStaleFrameAreUnknown) {
  publishFrame("drone", 0.0, ros::Time::now() - ros::Duration(6.0));
  add({addBallInFrame("part", "drone")});
  expectRefusal(ask(between("ball", "part")), QueryStatus::TF_STALE, "'drone'");
  expectRefusal(ask(sliding("ball", "part")), QueryStatus::TF_STALE, "'drone'");
}

// A client that waits for tf tells this refusal from others by its code.
TEST_F(Objects, AreRefusedWithACodeOfTheirOwnWhereTfDoesNotKnowTheFrameOfTheirPose) {
  ObjectChange part = addBall("part", poseAt(1.0, 0.5, 0.0));
  part.header.frame_id = "nowhere";
  const ApplyObjectsResponse response = ask(requestOf({part}));
  expectRefusal(response, QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  EXPECT_NE(response.status.message.find("changes[0]: object \"part\""), std::string::npos) << response.status.message;
}

TEST_F(Objects, ThatAreRemovedWithoutBeingThereAreNamedInASuccess) {
  add({addBall("part")});
  const auto removed = [&](const std::vector<std::string>& ids) {
    std::vector<ObjectChange> changes;
    for (const std::string& id : ids) changes.push_back(change(ObjectChange::REMOVE, id));
    const ApplyObjectsResponse response = ask(requestOf(changes));
    EXPECT_TRUE(response.success);
    EXPECT_EQ(response.status.code, QueryStatus::OK);
    return response.status.message;
  };
  EXPECT_EQ(removed({"gone", "part"}), "REMOVE: there was no object \"gone\"");
  EXPECT_EQ(removed({"part", "part"}), "REMOVE: there was no object \"part\" (and 1 more)");
  EXPECT_EQ(removed({"*"}), "");
}

// --- motions

TEST_F(Objects, AreMetInMotions) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0))});
  for (const auto& request : {sliding("ball", "part"), sliding("part", ""), sliding("", "")}) {
    const auto response = ask(request);
    ASSERT_TRUE(response.success) << response.status.message;
    ASSERT_TRUE(response.contact);
    EXPECT_NEAR(response.t_contact, 0.3 / 0.5, 1.01 * kMotionTolerance / 0.5);
    EXPECT_LE(response.t_free, 0.6);
    EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "part"}));
    const bool ball_is_first = response.pair.a.link == "ball";
    EXPECT_EQ((ball_is_first ? response.pair.b : response.pair.a).kind, ShapeRef::OBJECT);
    EXPECT_EQ((ball_is_first ? response.pair.a : response.pair.b).kind, ShapeRef::LINK);
    expectNear(response.pair.point_a, 1.0, 0.4, 0.0, 1e-5);
  }
}

TEST_F(Objects, AreMetOnTrajectories) {
  add({addBall("part", poseAt(1.0, 0.9, 0.0))});
  const auto response = ask(alongY("ball", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_TRUE(response.contact);
  EXPECT_NEAR(response.t_contact, 0.7 / 0.5, 1.01 * kMotionTolerance / 0.5);
  EXPECT_EQ(response.segment, 1);
  ASSERT_EQ(response.segments.size(), 2u);
  EXPECT_NEAR(response.segments[0].upper_bound, 0.2, 1.01 * kMotionTolerance);
  EXPECT_NEAR(response.segments[1].upper_bound, -0.2, 1.01 * kMotionTolerance) << "the centres meet at 1.8 s";
}

TEST_F(Objects, AreMetByBodiesThatMoveAtATwist) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0))});
  FirstContactRequest request = sliding("ball", "part");
  request.joints = {};
  request.links = {"ball"};
  request.twists.resize(1);
  request.twists[0].linear.y = 0.5;
  const auto response = ask(request);
  ASSERT_TRUE(response.contact) << response.status.message;
  EXPECT_NEAR(response.t_contact, 0.6, 1.01 * kMotionTolerance / 0.5);
}

TEST_F(Objects, MoveWithTheLinkThatHoldsThem) {
  add({addBall("held", poseAt(1.0, 0.25, 0.0)), attach("held", "ball"), addBall("part", poseAt(1.0, 0.75, 0.0))});
  const auto response = ask(sliding("held", "part"));
  ASSERT_TRUE(response.contact) << response.status.message;
  EXPECT_NEAR(response.t_contact, 0.3 / 0.5, 1.01 * kMotionTolerance / 0.5);
  const auto on_the_way = ask(alongY("", ""));
  ASSERT_TRUE(on_the_way.contact) << on_the_way.status.message;
  EXPECT_NEAR(on_the_way.t_contact, 0.6, 1.01 * kMotionTolerance / 0.5);
  EXPECT_EQ(links(on_the_way.pair), (std::set<std::string>{"held", "part"}));
  EXPECT_FALSE(isNaN(on_the_way.pair.a.link == "held" ? on_the_way.pair.point_a_link : on_the_way.pair.point_b_link));
}

// The camera stands 1 m above the base, and nothing tells that it would move.
TEST_F(Objects, RestWithTheirFrameDuringAMotion) {
  publishFrame("camera", 1.0);
  add({addBallInFrame("part", "camera", poseAt(1.0, 0.5, -1.0))});
  EXPECT_NEAR(ask(sliding("ball", "part")).t_contact, 0.6, 1.01 * kMotionTolerance / 0.5);
  const auto response = ask(alongY("ball", "part"));
  EXPECT_NEAR(response.t_contact, 0.6, 1.01 * kMotionTolerance / 0.5) << response.status.message;
}

// In the frame of the slide, which the first joint moves and the second does not.
TEST_F(Objects, MoveWithTheLinkWhoseFrameCarriesThem) {
  add({addBallInFrame("part", "slide", poseAt(-0.5, 0.0, 0.0))});
  FirstContactRequest request = sliding("part", "base");
  request.joints.name = {"x_axis"};
  request.joints.velocity = {-0.5};
  const auto response = ask(request);
  ASSERT_TRUE(response.contact) << response.status.message;
  EXPECT_NEAR(response.t_contact, 0.3 / 0.5, 1.01 * kMotionTolerance / 0.5);
  EXPECT_FALSE(ask(sliding("part", "base")).contact);
}

TEST_F(Objects, WithoutAFrameLeaveAMotionUnknownAndTheFrameIsNamed) {
  add({addBallInFrame("part", "nowhere", poseAt(1.0, 0.5, 0.0))});
  expectRefusal(ask(sliding("ball", "part")), QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  expectRefusal(ask(sliding("", "")), QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  expectRefusal(ask(alongY("ball", "part")), QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  EXPECT_TRUE(ask(sliding("ball", "base")).success) << "the frame of another object does not matter";
}

}  // namespace proximity_server::node::object_queries_test
