#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ObjectList.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include <std_srvs/Trigger.h>

#include <set>
#include <string>

#include "node/answers.h"
#include "node/gantry.h"

// The robot is that of gantry.urdf, with its ball at (1, 0, 0) and its block at (0, 1, 0). Objects are balls of radius
// 0.1 m.

namespace proximity_server::node {
namespace {

const std::string kNode = "/proximity_server/";

template <class Response, class Request>
Response ask(const std::string& service, const Request& request) {
  return call<Response>(kNode + service, request);
}

ObjectChange change(std::uint8_t operation, const std::string& id) {
  ObjectChange result;
  result.operation = operation;
  result.id = id;
  return result;
}

ObjectChange addBall(const std::string& id, double x, double y, double z) {
  ObjectChange result = change(ObjectChange::ADD, id);
  result.primitives.resize(1);
  result.primitives[0].type = shape_msgs::SolidPrimitive::SPHERE;
  result.primitives[0].dimensions = {0.1};
  result.pose.position.x = x;
  result.pose.position.y = y;
  result.pose.position.z = z;
  return result;
}

ApplyObjectsResponse apply(const std::vector<ObjectChange>& changes) {
  ApplyObjectsRequest request;
  request.changes.changes = changes;
  return ask<ApplyObjectsResponse>("apply_objects", request);
}

MinimumDistanceRequest between(const std::string& a, const std::string& b) {
  MinimumDistanceRequest request;
  request.a = shape(a);
  request.b = shape(b);
  return request;
}
MinimumDistanceResponse distance(const MinimumDistanceRequest& request) {
  return ask<MinimumDistanceResponse>("minimum_distance", request);
}

void publishCamera(double z) {
  geometry_msgs::TransformStamped camera;
  camera.header.frame_id = "base";
  camera.child_frame_id = "camera";
  camera.transform.translation.z = z;
  camera.transform.rotation.w = 1.0;
  connectedGantry(1).publish(camera, ros::Time::now());
}

class Objects : public testing::Test {
 protected:
  void SetUp() override {
    connectedGantry(1).hold({1.0, 0.0, 0.0});
    ApplyObjectsRequest request;
    request.changes.changes = {change(ObjectChange::REMOVE, "*")};
    request.changes.set_rules = true;
    ASSERT_TRUE(ask<ApplyObjectsResponse>("apply_objects", request).success);
  }
  void TearDown() override { connectedGantry(1).release(); }

  void add(const std::vector<ObjectChange>& changes) {
    const ApplyObjectsResponse response = apply(changes);
    ASSERT_TRUE(response.success) << response.status.message;
  }
};

TEST_F(Objects, AreNamedInRequestsAsLinksAre) {
  add({addBall("part", 1.0, 0.5, 0.0)});
  const auto response = distance(between("ball", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
  EXPECT_EQ(response.pair.a.kind, ShapeRef::LINK);
  EXPECT_EQ(response.pair.b.kind, ShapeRef::OBJECT);
  EXPECT_EQ(response.pair.b.link, "part");
  expectNear(response.pair.point_b, 1.0, 0.4, 0.0);
  EXPECT_TRUE(isNaN(response.pair.point_b_link)) << "no link holds it";
  EXPECT_EQ(links(distance(between("part", "")).pair), (std::set<std::string>{"ball", "part"}));
  EXPECT_EQ(links(distance(between("ball", "")).pair), (std::set<std::string>{"ball", "part"}));
  EXPECT_EQ(links(distance(between("", "")).pair), (std::set<std::string>{"ball", "part"}));
}

TEST_F(Objects, OfUnknownNamesTheNearestOfLinksAndObjectsIsNamed) {
  add({addBall("part", 1.0, 0.5, 0.0)});
  expectRefusal(distance(between("ball", "pert")), QueryStatus::UNKNOWN_LINK, "'part'");
  expectRefusal(distance(between("ball", "blok")), QueryStatus::UNKNOWN_LINK, "'block'");
}

TEST_F(Objects, AreAskedAsAWhole) {
  add({addBall("part", 1.0, 0.5, 0.0)});
  MinimumDistanceRequest request = between("ball", "part");
  request.b.index = 1;
  expectRefusal(distance(request), QueryStatus::INVALID_ARGUMENT, "'part'");
}

TEST_F(Objects, ThatStandStillAreNotCheckedAgainstTheBase) {
  add({addBall("part", 0.0, 0.0, 0.5)});
  MinimumDistanceRequest request = between("base", "part");
  expectRefusal(distance(request), QueryStatus::PAIR_EXCLUDED, "base");
  request.ignore_filter = true;
  EXPECT_NEAR(distance(request).pair.distance, 0.3, kTolerance);
}

TEST_F(Objects, MayTouchWhatTheRulesAllow) {
  ApplyObjectsRequest request;
  request.changes.changes = {addBall("part", 1.0, 0.5, 0.0)};
  request.changes.set_rules = true;
  request.changes.rules.resize(1);
  request.changes.rules[0].a = "part";
  request.changes.rules[0].b = "*";
  request.changes.rules[0].allowed = true;
  ASSERT_TRUE(ask<ApplyObjectsResponse>("apply_objects", request).success);
  expectRefusal(distance(between("ball", "part")), QueryStatus::PAIR_EXCLUDED, "'part'");
  expectRefusal(distance(between("part", "")), QueryStatus::INVALID_ARGUMENT, "no pair");
}

TEST_F(Objects, WithPlanesAlwaysMeetEachOther) {
  ObjectChange floor = change(ObjectChange::ADD, "floor"), wall = change(ObjectChange::ADD, "wall");
  floor.planes.resize(1);
  floor.planes[0].coef = {0.0, 0.0, 1.0, 0.5};
  wall.planes.resize(1);
  wall.planes[0].coef = {1.0, 0.0, 0.0, 5.0};
  add({floor, wall});
  EXPECT_NEAR(distance(between("ball", "floor")).pair.distance, 0.4, kTolerance);
  MinimumDistanceRequest request = between("floor", "wall");
  request.ignore_filter = true;
  expectRefusal(distance(request), QueryStatus::INVALID_ARGUMENT, "half-space");
  request = between("floor", "");
  request.ignore_filter = true;
  EXPECT_TRUE(distance(request).success);
}

TEST_F(Objects, ComeInBatches) {
  add({addBall("part", 1.0, 0.5, 0.0), addBall("far", 1.0, 0.0, 9.0)});
  QueryPairsRequest request;
  request.mode = QueryPairsRequest::K_CLOSEST;
  request.k = 100;
  auto response = ask<QueryPairsResponse>("query_pairs", request);
  ASSERT_TRUE(response.success) << response.status.message;
  const std::size_t of_objects = 4;  // ball and block with each of the two
  const std::size_t of_all = response.pairs.size();
  EXPECT_EQ(links(response.pairs[0]), (std::set<std::string>{"ball", "part"}));
  request.mode = QueryPairsRequest::PER_PAIR;
  EXPECT_EQ(ask<QueryPairsResponse>("query_pairs", request).pairs.size(), of_all);
  request.a = {shape("part"), shape("far")};
  EXPECT_EQ(ask<QueryPairsResponse>("query_pairs", request).pairs.size(), of_objects);
  request.a = {ShapeRef()};
  EXPECT_EQ(ask<QueryPairsResponse>("query_pairs", request).pairs.size(), of_all);
  request.ignore_filter = true;
  EXPECT_EQ(ask<QueryPairsResponse>("query_pairs", request).pairs.size(), 3u + 6u);
}

TEST_F(Objects, MoveWithTheLinkInOtherStates) {
  ObjectChange bar = addBall("bar", 0.0, 0.0, 0.5);
  bar.link = bar.header.frame_id = "ball";
  add({bar, addBall("part", 2.0, 0.0, 0.5)});
  QueryConfigurationRequest request;
  request.a = {shape("bar")};
  request.b = {shape("part")};
  request.states.resize(2);
  for (sensor_msgs::JointState& state : request.states) state.name = {"x_axis", "y_axis", "lift"};
  request.states[0].position = {0.0, 0.0, 0.0};
  request.states[1].position = {1.5, 0.0, 0.0};
  const auto response = ask<QueryConfigurationResponse>("query_configuration", request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states[0].minimum.distance, 1.8, kTolerance);
  EXPECT_NEAR(response.states[1].minimum.distance, 0.3, kTolerance);
  expectNear(response.states[1].minimum.point_a_link, 0.0, -0.1, 0.5);  // the ball's frame is turned by a quarter
}

TEST_F(Objects, AreHeldWhereTheyAreAndPutDownWhereTheyAre) {
  ObjectChange attach = change(ObjectChange::ATTACH, "part");
  attach.link = "ball";
  attach.keep_pose = true;
  add({addBall("part", 1.0, 0.5, 0.0), attach});
  MinimumDistanceRequest request = between("part", "base");
  request.stamp = connectedGantry(1).moveTo({1.5, 0.0, 0.0});
  connectedGantry(1).hold({1.5, 0.0, 0.0});
  EXPECT_NEAR(distance(request).pair.point_a.x, 1.5 - 0.1 * 1.4 / std::hypot(1.4, 0.4), 1e-6);
  add({change(ObjectChange::DETACH, "part")});
  connectedGantry(1).hold({1.0, 0.0, 0.0});
  request.stamp = ros::Time();
  request.ignore_filter = true;
  EXPECT_NEAR(distance(request).pair.distance, std::hypot(1.4, 0.4) - 0.1, 1e-6);
}

TEST_F(Objects, InAFrameThatTfDoesNotKnowAreUnknownAndTheFrameIsNamed) {
  publishCamera(1.0);
  ObjectChange part = addBall("part", 0.0, 0.0, 0.0);
  part.frame = part.header.frame_id = "camera";
  ObjectChange other = addBall("other", 0.0, 0.0, 0.0);
  other.frame = other.header.frame_id = "nowhere";
  add({part, other});
  expectRefusal(distance(between("ball", "other")), QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  publishCamera(1.0);
  const auto response = distance(between("ball", "part"));
  EXPECT_TRUE(response.success) << response.status.message << ": the frame of another object does not matter";
  EXPECT_NEAR(response.pair.distance, std::hypot(1.0, 1.0) - 0.2, kTolerance);

  QueryPairsRequest request;
  request.mode = QueryPairsRequest::PER_PAIR;
  const auto pairs = ask<QueryPairsResponse>("query_pairs", request);
  EXPECT_FALSE(pairs.success);
  EXPECT_NE(pairs.status.message.find("'nowhere'"), std::string::npos) << pairs.status.message;
  for (const Proximity& pair : pairs.pairs)
    EXPECT_EQ(pair.state == Proximity::UNKNOWN, links(pair).count("other") > 0) << pair.a.link << " " << pair.b.link;

  Inbox<Clearance> clearances{ros::NodeHandle(), kNode + "clearance"};
  const auto invalid = clearances.next([](const Clearance& clearance) {
    return clearance.level == Clearance::INVALID && clearance.status.code == QueryStatus::TF_UNAVAILABLE;
  });
  ASSERT_TRUE(invalid);
  EXPECT_NE(invalid->status.message.find("'nowhere'"), std::string::npos) << invalid->status.message;
}

// An old transform is no statement about now.
TEST_F(Objects, InAStaleFrameAreUnknown) {
  geometry_msgs::TransformStamped drone;
  drone.header.frame_id = "base";
  drone.child_frame_id = "drone";
  drone.transform.rotation.w = 1.0;
  connectedGantry(1).publish(drone, ros::Time::now() - ros::Duration(6.0));
  ObjectChange part = addBall("part", 0.0, 0.0, 0.0);
  part.frame = part.header.frame_id = "drone";
  add({part});
  expectRefusal(distance(between("ball", "part")), QueryStatus::TF_STALE, "'drone'");
}

TEST_F(Objects, AreInTheFirstClearanceOfTheirRevision) {
  Inbox<Clearance> clearances{ros::NodeHandle(), kNode + "clearance"};
  ASSERT_TRUE(clearances.next());
  const ApplyObjectsResponse applied = apply({addBall("part", 1.0, 0.21, 0.0)});
  ASSERT_TRUE(applied.success) << applied.status.message;
  const auto is_new = [&](const Clearance& clearance) { return clearance.objects_revision >= applied.revision; };
  const auto clearance = clearances.next(is_new);
  ASSERT_TRUE(clearance);
  EXPECT_EQ(clearance->level, Clearance::STOP);
  EXPECT_NEAR(clearance->object_minimum.distance, 0.01, kTolerance);
  EXPECT_NEAR(clearance->self_minimum.distance, 0.8, kTolerance);
}

TEST_F(Objects, AreToldOnALatchedTopic) {
  const ApplyObjectsResponse applied = apply({addBall("part", 1.0, 0.5, 0.0)});
  Inbox<ObjectList> lists{ros::NodeHandle(), kNode + "objects"};
  const auto list = lists.next([&](const ObjectList& found) { return found.revision == applied.revision; });
  ASSERT_TRUE(list);
  EXPECT_EQ(list->node_start, applied.node_start);
  EXPECT_NE(list->node_start, 0u);
  EXPECT_EQ(list->header.frame_id, "base");
  ASSERT_EQ(list->objects.size(), 1u);
  EXPECT_EQ(list->objects[0].id, "part");
}

TEST_F(Objects, ComeByTopic) {
  ros::Publisher publisher = ros::NodeHandle().advertise<ObjectChanges>(kNode + "apply_objects", 10, /*latch=*/true);
  ObjectChanges changes;
  changes.changes = {addBall("by_topic", 1.0, 0.5, 0.0)};
  publisher.publish(changes);
  Inbox<ObjectList> lists{ros::NodeHandle(), kNode + "objects"};
  EXPECT_TRUE(
      lists.next([](const ObjectList& list) { return list.objects.size() == 1 && list.objects[0].id == "by_topic"; }));
}

TEST_F(Objects, AreRefusedAsAWholeMessage) {
  const ApplyObjectsResponse response = apply({addBall("part", 1.0, 0.5, 0.0), addBall("ball", 0.0, 0.0, 0.0)});
  expectRefusal(response, QueryStatus::INVALID_ARGUMENT, "\"ball\"");
  expectRefusal(distance(between("ball", "part")), QueryStatus::UNKNOWN_LINK, "'part'");
}

// A client that waits for tf tells this refusal from others by its code.
TEST_F(Objects, AreRefusedWithACodeOfTheirOwnWhereTfDoesNotKnowTheFrameOfTheirPose) {
  ObjectChange part = addBall("part", 1.0, 0.5, 0.0);
  part.header.frame_id = "nowhere";
  const ApplyObjectsResponse response = apply({part});
  expectRefusal(response, QueryStatus::TF_UNAVAILABLE, "'nowhere'");
  EXPECT_NE(response.status.message.find("changes[0]: object \"part\""), std::string::npos) << response.status.message;
}

TEST_F(Objects, AreNotPartOfMotionsYet) {
  add({addBall("part", 1.0, 0.5, 0.0)});
  FirstContactRequest request;
  request.a = shape("ball");
  request.b = shape("part");
  request.horizon = 1.0;
  expectRefusal(ask<FirstContactResponse>("time_of_contact", request), QueryStatus::INVALID_ARGUMENT, "'part'");
}

TEST_F(Objects, StayWhenTheRobotIsReloaded) {
  add({addBall("part", 1.0, 0.5, 0.0)});
  ASSERT_TRUE(ask<std_srvs::TriggerResponse>("reload", std_srvs::TriggerRequest()).success);
  EXPECT_NEAR(distance(between("ball", "part")).pair.distance, 0.3, kTolerance);
}

}  // namespace
}  // namespace proximity_server::node

PROXIMITY_SERVER_ROSTEST_MAIN("object_services_test")
