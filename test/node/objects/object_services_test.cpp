#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ObjectList.h>
#include "node/answers.h"
#include "node/gantry.h"
#include "node/object_messages.h"
#include "node/settings.h"

#include <std_srvs/Trigger.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

// Objects of a node: its topics, its monitor and its reloads. object_queries_test asks about them without ROS. The robot
// is that of gantry.urdf, with its ball at (1, 0, 0). Objects are balls of radius 0.1 m.

namespace proximity_server::node::object_services_test {

const std::string kNode = "/proximity_server/";

template <class Response, class Request>
Response ask(const std::string& service, const Request& request) {
  return call<Response>(kNode + service, request);
}

ApplyObjectsResponse apply(const std::vector<ObjectChange>& changes) {
  return ask<ApplyObjectsResponse>("apply_objects", requestOf(changes));
}

class Objects : public testing::Test {
 protected:
  void SetUp() override {
    connectedGantry(1).hold({1.0, 0.0, 0.0});
    ApplyObjectsRequest request = requestOf({change(ObjectChange::REMOVE, "*")});
    request.changes.set_rules = true;
    ASSERT_TRUE(ask<ApplyObjectsResponse>("apply_objects", request).success);
  }
  void TearDown() override { connectedGantry(1).release(); }

  void add(const std::vector<ObjectChange>& changes) {
    const ApplyObjectsResponse response = apply(changes);
    ASSERT_TRUE(response.success) << response.status.message;
  }
};

TEST_F(Objects, InAFrameThatTfDoesNotKnowMakeTheClearanceInvalidAndTheFrameIsNamed) {
  add({addBallInFrame("other", "nowhere")});
  Inbox<Clearance> clearances{ros::NodeHandle(), kNode + "clearance"};
  const auto invalid = clearances.next([](const Clearance& clearance) {
    return clearance.level == Clearance::INVALID && clearance.status.code == QueryStatus::TF_UNAVAILABLE;
  });
  ASSERT_TRUE(invalid);
  EXPECT_NE(invalid->status.message.find("'nowhere'"), std::string::npos) << invalid->status.message;
}

TEST_F(Objects, AreInTheFirstClearanceOfTheirRevision) {
  Inbox<Clearance> clearances{ros::NodeHandle(), kNode + "clearance"};
  ASSERT_TRUE(clearances.next());
  const ApplyObjectsResponse applied = apply({addBall("part", poseAt(1.0, 0.21, 0.0))});
  ASSERT_TRUE(applied.success) << applied.status.message;
  const auto is_new = [&](const Clearance& clearance) { return clearance.objects_revision >= applied.revision; };
  const auto clearance = clearances.next(is_new);
  ASSERT_TRUE(clearance);
  EXPECT_EQ(clearance->level, Clearance::STOP);
  EXPECT_NEAR(clearance->object_minimum.distance, 0.01, kTolerance);
  EXPECT_NEAR(clearance->self_minimum.distance, 0.8, kTolerance);
}

class ObjectsBetweenCycles : public Objects {
 protected:
  void TearDown() override {
    set(kNode, "rate", 50.0);
    Objects::TearDown();
  }
};

TEST_F(ObjectsBetweenCycles, StartOneCycleAtOnceUntilTheNextOneOfTheRate) {
  Inbox<Clearance> clearances{ros::NodeHandle(), kNode + "clearance"};
  ASSERT_TRUE(clearances.next());
  set(kNode, "rate", 0.001);  // [Hz] its next cycle comes after the test
  const auto has = [](std::uint64_t revision) {
    return [revision](const Clearance& clearance) { return clearance.objects_revision >= revision; };
  };
  const ApplyObjectsResponse first = apply({addBall("first", poseAt(1.0, 0.5, 0.0))});
  ASSERT_TRUE(first.success) << first.status.message;
  EXPECT_TRUE(clearances.next(has(first.revision)));

  const ApplyObjectsResponse second = apply({addBall("second", poseAt(1.0, 0.8, 0.0))});
  ASSERT_TRUE(second.success) << second.status.message;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // for a message that must not come
  EXPECT_EQ(clearances.clear(), 0u);
  set(kNode, "rate", 50.0);
  EXPECT_TRUE(clearances.next(has(second.revision)));
}

TEST_F(Objects, AreToldOnALatchedTopic) {
  const ApplyObjectsResponse applied = apply({addBall("part", poseAt(1.0, 0.5, 0.0))});
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
  publisher.publish(messageOf({addBall("by_topic", poseAt(1.0, 0.5, 0.0))}));
  Inbox<ObjectList> lists{ros::NodeHandle(), kNode + "objects"};
  EXPECT_TRUE(
      lists.next([](const ObjectList& list) { return list.objects.size() == 1 && list.objects[0].id == "by_topic"; }));
}

TEST_F(Objects, StayWhenTheRobotIsReloaded) {
  add({addBall("part", poseAt(1.0, 0.5, 0.0))});
  ASSERT_TRUE(ask<std_srvs::TriggerResponse>("reload", std_srvs::TriggerRequest()).success);
  EXPECT_NEAR(
      ask<MinimumDistanceResponse>("minimum_distance", between<MinimumDistanceRequest>("ball", "part")).pair.distance,
      0.3, kTolerance);
}

TEST_F(Objects, AreAnnouncedInTheFramesOfAReloadedRobot) {
  ObjectChange held = addBall("part", poseAt(0.0, 0.5, 0.0));
  held.link = held.header.frame_id = "ball";
  add({held});
  Inbox<ObjectList> lists{ros::NodeHandle(), kNode + "objects"};
  const auto in = [&](const std::string& frame) {
    return lists
        .next([&](const ObjectList& list) { return list.objects.size() == 1 && list.objects[0].frame == frame; })
        .has_value();
  };
  EXPECT_TRUE(in("ball"));
  ros::param::set(kNode + "tf_prefix", "left");
  EXPECT_TRUE(ask<std_srvs::TriggerResponse>("reload", std_srvs::TriggerRequest()).success);
  EXPECT_TRUE(in("left/ball"));
  ros::param::del(kNode + "tf_prefix");
  EXPECT_TRUE(ask<std_srvs::TriggerResponse>("reload", std_srvs::TriggerRequest()).success);
}

}  // namespace proximity_server::node::object_services_test
