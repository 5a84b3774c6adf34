#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ObjectList.h>
#include <proximity_server/Separation.h>
#include "node/answers.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/object_messages.h"

#include <geometry_msgs/PoseArray.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Int64.h>
#include <std_srvs/Trigger.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// A person walks towards a robot, whose node knows only what a topic says. The robot is that of gantry.urdf, with its
// ball, of radius 0.1 m, at (1, 0, 0). The person is a ball of 0.3 m, seen from the frame of the robot's ball, which is
// turned by a quarter about z: x there is y of the base.

namespace proximity_server::node::tracked_test {

const std::string kNode = "/proximity_server/";

class Tracked : public testing::Test {
 protected:
  void SetUp() override { connectedGantry(2).hold({1.0, 0.0, 0.0}); }
  void TearDown() override {
    ticker_.stop();
    connectedGantry(2).release();
  }

  /// From now on messages have so many persons, each at this distance [m] from the surface of the ball.
  void walkTo(double distance, std::size_t persons = 1) {
    ticker_.stop();
    people_.header.frame_id = "ball";
    people_.poses.assign(persons, poseAt(0.4 + distance, 0.0, 0.0));
    ticker_.start();
  }
  std::optional<Clearance> withLevel(std::uint8_t level) {
    return clearances_.next([&](const Clearance& message) { return message.level == level; });
  }
  /// The next one that is INVALID because of this [part of the text].
  std::optional<Clearance> invalidBecause(const std::string& text) {
    return clearances_.next([&](const Clearance& message) {
      return message.level == Clearance::INVALID && message.status.message.find(text) != std::string::npos;
    });
  }

  ros::NodeHandle nh_;
  Inbox<Clearance> clearances_{nh_, kNode + "clearance"};
  geometry_msgs::PoseArray people_;
  ros::Publisher publisher_ = nh_.advertise<geometry_msgs::PoseArray>("/people", 10);
  Ticker ticker_{nh_, 50.0, [this] {
                   people_.header.stamp = ros::Time::now();
                   publisher_.publish(people_);
                 }};
};

TEST_F(Tracked, PersonIsInTheLevelFromFarToNearAndInvalidWhenNobodyTells) {
  ASSERT_TRUE(invalidBecause("tracked source 'person' on '/people'"));
  walkTo(0.8);
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  walkTo(0.4);
  const auto warned = withLevel(Clearance::WARN);
  ASSERT_TRUE(warned);
  EXPECT_EQ(warned->deciding.b.link, "person") << warned->status.message;
  EXPECT_NEAR(warned->deciding.distance, 0.4, 1e-6);
  EXPECT_EQ(warned->deciding_threshold, 0.5);
  walkTo(0.15);
  const auto stopped = withLevel(Clearance::STOP);
  ASSERT_TRUE(stopped);
  EXPECT_EQ(stopped->deciding_threshold, 0.2);
  ticker_.stop();
  const auto stale = invalidBecause("max_age is 0.5 s");
  ASSERT_TRUE(stale);
  EXPECT_EQ(stale->status.code, QueryStatus::TF_STALE);
  EXPECT_NE(stale->status.message.find("tracked source 'person' on '/people': its latest message is"),
            std::string::npos)
      << stale->status.message;
  walkTo(0.0, 0);
  ASSERT_TRUE(withLevel(Clearance::CLEAR)) << "nobody is there";
}

TEST_F(Tracked, SeparationSlowsTheRobotAndStopsItWhenNobodyTells) {
  JointStates joint_states;
  joint_states.hold({{"x_axis", 0.0}, {"y_axis", 1.0}, {"lift", 0.0}});  // towards the person
  Inbox<Separation> separations(nh_, kNode + "separation");
  Inbox<std_msgs::Float64> scales(nh_, kNode + "separation_scale");
  Inbox<std_msgs::Int64> overrides(nh_, kNode + "separation_override");
  walkTo(20.0);
  const auto far =
      separations.next([](const Separation& message) { return message.complete && message.distance > 10.0; });
  ASSERT_TRUE(far);
  EXPECT_EQ(far->source, "person");
  EXPECT_EQ(far->scale, 1.0);
  EXPECT_GT(far->margin, 10.0);
  EXPECT_TRUE(overrides.next([](const std_msgs::Int64& percent) { return percent.data == 100; }));
  walkTo(0.9);
  const auto near = separations.next(
      [](const Separation& message) { return message.complete && message.scale > 0.0 && message.scale < 1.0; });
  ASSERT_TRUE(near);
  EXPECT_EQ(near->shape.link, "ball");
  EXPECT_NEAR(near->distance, 0.9, 1e-6);
  EXPECT_NEAR(near->robot_speed, 1.0, 1e-6);
  EXPECT_LT(near->margin, 0.0);
  EXPECT_TRUE(overrides.next([](const std_msgs::Int64& percent) { return percent.data > 0 && percent.data < 100; }));
  ticker_.stop();
  EXPECT_TRUE(separations.next([](const Separation& message) {
    return message.scale == 0.0 && message.status.message.find("tracked source 'person'") != std::string::npos;
  }));
  EXPECT_TRUE(scales.next([](const std_msgs::Float64& scale) { return scale.data == 0.0; }));
  EXPECT_TRUE(overrides.next([](const std_msgs::Int64& percent) { return percent.data == 0; }));
}

TEST_F(Tracked, MessageThatCannotBeUsedIsNamed) {
  walkTo(0.8);
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  walkTo(0.8, 1001);
  ASSERT_TRUE(invalidBecause("it has more than 1000 points"));
  walkTo(0.8);
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  ticker_.stop();
  people_.header.frame_id = "nowhere";
  ticker_.start();
  ASSERT_TRUE(invalidBecause("frame 'nowhere' has no pose"));
}

TEST_F(Tracked, PersonAnswersToTheNameAndStaysAtAReload) {
  walkTo(0.4);
  ASSERT_TRUE(withLevel(Clearance::WARN));
  MinimumDistanceRequest request;
  request.a.link = "ball";
  request.b.link = "person";
  const auto distance = [&] { return call<MinimumDistanceResponse>(kNode + "minimum_distance", request); };
  EXPECT_NEAR(distance().pair.distance, 0.4, 1e-6) << distance().status.message;
  for (const ObjectChange& refused : {addBall("person"), change(ObjectChange::REMOVE, "person")}) {
    const auto response = call<ApplyObjectsResponse>(kNode + "apply_objects", requestOf({refused}));
    EXPECT_FALSE(response.success);
    EXPECT_NE(response.status.message.find("it is a tracked source"), std::string::npos) << response.status.message;
  }
  EXPECT_TRUE(
      call<ApplyObjectsResponse>(kNode + "apply_objects", requestOf({change(ObjectChange::REMOVE, "*")})).success);
  EXPECT_NEAR(distance().pair.distance, 0.4, 1e-6);
  EXPECT_TRUE(call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest()).success);
  EXPECT_NEAR(distance().pair.distance, 0.4, 1e-6);
  clearances_.clear();
  const auto after = withLevel(Clearance::WARN);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->deciding.b.link, "person");
  const auto list = Inbox<ObjectList>(nh_, kNode + "objects").next();
  ASSERT_TRUE(list);
  EXPECT_TRUE(list->objects.empty());
}

TEST_F(Tracked, PersonIsInARecordAndItsReplay) {
  const std::pair<double, std::uint8_t> steps[] = {{0.4, Clearance::WARN}, {0.15, Clearance::STOP}};
  for (const auto& [distance, level] : steps) {
    walkTo(distance);
    ASSERT_TRUE(withLevel(level));
  }
  ticker_.stop();
  ASSERT_TRUE(withLevel(Clearance::INVALID));
  const auto saved = call<std_srvs::TriggerResponse>(kNode + "save_record", std_srvs::TriggerRequest());
  ASSERT_TRUE(saved.success) << saved.message;
  const std::string replay = std::filesystem::path(NODE_EXECUTABLE).parent_path() / "replay";
  EXPECT_EQ(std::system((replay + " --replay " + saved.message).c_str()), 0);
  std::filesystem::remove_all("/tmp/proximity_tracked");
}

TEST_F(Tracked, PointsOfACloudHaveTheNameOfTheirTopic) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "base";
  cloud.height = cloud.width = 1;
  cloud.point_step = cloud.row_step = 12;
  cloud.data.resize(12);
  for (std::uint32_t i = 0; i < 3; ++i) {
    sensor_msgs::PointField& field = cloud.fields.emplace_back();
    field.name = std::string(1, static_cast<char>('x' + i));
    field.offset = 4 * i;
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    const float value = i == 0 ? 1.0F : i == 1 ? 0.45F : 0.0F;
    std::memcpy(cloud.data.data() + field.offset, &value, sizeof value);
  }
  const ros::Publisher tags = nh_.advertise<sensor_msgs::PointCloud2>("/seen/tags", 10);
  Ticker ticker(nh_, 50.0, [&] {
    cloud.header.stamp = ros::Time::now();
    tags.publish(cloud);
  });
  ticker.start();
  Inbox<Clearance> clearances(nh_, "/with_cloud/clearance");
  const auto near = clearances.next([](const Clearance& message) { return message.level == Clearance::STOP; });
  ASSERT_TRUE(near);
  EXPECT_EQ(near->deciding.b.link, "seen/tags");
  EXPECT_NEAR(near->deciding.distance, 0.25, 1e-6);
}

}  // namespace proximity_server::node::tracked_test
