#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/ModelInfo.h>
#include <proximity_server/ObjectList.h>
#include "node/answers.h"
#include "node/faults/running_node.h"
#include "node/gantry.h"

#include <rosgraph_msgs/Log.h>
#include <std_msgs/Float64.h>

#include <algorithm>
#include <csignal>
#include <optional>
#include <set>
#include <string>
#include <vector>

// The robot of ./dev demo picks up a bar, carries it past its body and a table, and puts it down.

namespace proximity_server::node::demo_objects_test {

const std::set<std::string> kObjects{"bar", "stand", "table", "table_leg"};

std::set<std::string> ids(const ObjectList& list) {
  std::set<std::string> result;
  for (const ObjectInfo& object : list.objects) result.insert(object.id);
  return result;
}

const ObjectInfo* bar(const ObjectList& list) {
  const auto is_bar = [](const ObjectInfo& object) { return object.id == "bar"; };
  const auto found = std::find_if(list.objects.begin(), list.objects.end(), is_bar);
  return found == list.objects.end() ? nullptr : &*found;
}
bool isHeld(const ObjectList& list) { return bar(list) && bar(list)->link == "left_hand"; }
bool stands(const ObjectList& list) { return bar(list) && bar(list)->link.empty(); }

/// The motion takes longer than a turn of Inbox::next(): 34 s pass from one time that the bar is held to the next.
template <class Message, class Accept>
std::optional<Message> nextOfMotion(Inbox<Message>& inbox, Accept accept) {
  std::optional<Message> found;
  for (int turn = 0; turn < 3 && !found; ++turn) found = inbox.next(accept);
  return found;
}

TEST(DemoObjects, BelongToARobotThatTheNodeWarnsOfNothing) {
  Inbox<ModelInfo> inbox(ros::NodeHandle(), "/demo/proximity_server/model_info");
  const auto info = inbox.next();
  ASSERT_TRUE(info);
  EXPECT_EQ(info->robot, "proximity_demo");
  EXPECT_EQ(info->warnings, std::vector<std::string>());
}

TEST(DemoObjects, ABarIsCarriedPastBodyAndTableAndPutBackWhereItStood) {
  Inbox<ObjectList> lists(ros::NodeHandle(), "/demo/proximity_server/objects");
  const auto before = nextOfMotion(lists, stands);
  ASSERT_TRUE(before);
  EXPECT_EQ(ids(*before), kObjects);
  EXPECT_TRUE(
      ros::param::has("/demo/demo_motion/boxes"));  // else launch_files_test would look for another name in vain
  Inbox<Clearance> clearances(ros::NodeHandle(), "/demo/proximity_server/clearance");
  const auto held = nextOfMotion(lists, isHeld);
  ASSERT_TRUE(held);
  EXPECT_EQ(bar(*held)->touch_links, std::vector<std::string>{"left_wrist"});

  std::set<std::string> met;  // by the bar, within the distance of WARN
  std::set<int> levels;
  ASSERT_TRUE(nextOfMotion(clearances, [&](const Clearance& clearance) {
    const Proximity& closest = clearance.object_minimum;
    if (clearance.objects_revision != held->revision || closest.state == Proximity::UNKNOWN) {
      return clearance.objects_revision > held->revision;
    }
    levels.insert(clearance.level);
    EXPECT_GT(closest.distance, 0.01) << closest.a.link << " - " << closest.b.link;
    if (closest.distance < 0.05) met.insert(closest.a.link == "bar" ? closest.b.link : closest.a.link);
    return false;
  })) << "it is not put down";
  EXPECT_EQ(met, (std::set<std::string>{"table", "torso"}));
  EXPECT_EQ(levels, (std::set<int>{Clearance::CLEAR, Clearance::WARN, Clearance::STOP}));

  const auto after = nextOfMotion(lists, stands);
  ASSERT_TRUE(after);
  const geometry_msgs::Point &from = bar(*before)->pose.position, &to = bar(*after)->pose.position;
  expectNear(to, from.x, from.y, from.z);
}

TEST(DemoObjects, AreSentAgainToANodeThatBeginsAnew) {
  const std::string node = "/respawn/proximity_server";
  Inbox<ObjectList> lists(ros::NodeHandle(), node + "/objects");
  const auto has_all = [](const ObjectList& list) { return ids(list) == kObjects; };
  const auto before = lists.next(has_all);
  ASSERT_TRUE(before);
  const pid_t process = processOf(node);
  ASSERT_GT(process, 0);
  ASSERT_EQ(kill(process, SIGKILL), 0);

  EXPECT_TRUE(
      lists.next([&](const ObjectList& list) { return list.node_start != before->node_start && has_all(list); }));
}

// Regression: the demo had no decelerations, so that the scale was 0 for ever.
TEST(DemoObjects, TheVelocityScaleOfTheMovingRobotIsNotAlwaysZero) {
  Inbox<std_msgs::Float64> scales(ros::NodeHandle(), "/demo/proximity_server/collision_velocity_scale");
  EXPECT_TRUE(nextOfMotion(scales, [](const std_msgs::Float64& scale) { return scale.data > 0.0; }));
}

/// Removes an object beside the demo; "*": all.
void remove(const std::string& node, const std::string& id) {
  ApplyObjectsRequest request;
  request.changes.changes.resize(1);
  request.changes.changes[0].operation = ObjectChange::REMOVE;
  request.changes.changes[0].id = id;
  EXPECT_TRUE(call<ApplyObjectsResponse>(node + "/apply_objects", request).success) << id;
}

// Regression: a bar that somebody had removed was refused as an error again and again.
TEST(DemoObjects, WhatOthersRemoveStaysAwayUntilTheMotionBeginsAnew) {
  const std::string node = "/removed/proximity_server";
  Inbox<rosgraph_msgs::Log> log(ros::NodeHandle(), "/rosout");
  Inbox<ObjectList> lists(ros::NodeHandle(), node + "/objects");
  const auto has_all = [](const ObjectList& list) { return ids(list) == kObjects; };
  for (const std::string removed : {"table", "bar", "*"}) {
    ASSERT_TRUE(lists.next(isHeld)) << "before " << removed;
    remove(node, removed);
    std::set<std::string> rest = kObjects;
    removed == "*" ? rest.clear() : void(rest.erase(removed));
    EXPECT_TRUE(lists.next([&](const ObjectList& list) { return ids(list) == rest; })) << removed;
    // Only all of them at once come back.
    EXPECT_TRUE(lists.next([&](const ObjectList& list) {
      EXPECT_TRUE(ids(list) == rest || has_all(list)) << removed;
      return has_all(list) && stands(list);
    })) << removed;
  }
  EXPECT_TRUE(lists.next(isHeld));
  ROS_INFO("that was all");
  EXPECT_TRUE(log.next([](const rosgraph_msgs::Log& entry) {
    EXPECT_FALSE(entry.name == "/removed/demo_motion" && entry.level >= rosgraph_msgs::Log::WARN) << entry.msg;
    return entry.msg == "that was all";
  }));
}

}  // namespace proximity_server::node::demo_objects_test
