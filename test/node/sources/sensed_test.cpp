#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/Sensed.h>
#include "chance.h"
#include "node/answers.h"
#include "node/gantry.h"
#include "node/object_messages.h"
#include "node/sources/octomap_message.h"

#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <std_srvs/Trigger.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

// A camera sees the ball of gantry.urdf, of radius 0.1 m, and what comes near to it. Its clouds are in the frame of the ball.
// A map has one voxel.

namespace ros::message_traits {
template <>
struct Definition<proximity_server::node::OctomapMessage> {
  static const char* value() { return "Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data"; }
  static const char* value(const proximity_server::node::OctomapMessage&) { return value(); }
};
}  // namespace ros::message_traits

namespace proximity_server::node::sensed_test {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

const std::string kNode = "/proximity_server/";

/// An octree with one smallest leaf, whose lower corner is at these multiples of the resolution.
OctomapMessage mapOf(const Eigen::Array3i& leaf) {
  OctomapMessage map;
  map.header.frame_id = "base";
  map.is_binary = 1;
  map.id = "OcTree";
  map.resolution = 0.02;
  const Eigen::Array3i key = leaf + (1 << 15);
  for (int bit = 15; bit >= 0; --bit) {
    const int child = (key.x() >> bit & 1) + 2 * (key.y() >> bit & 1) + 4 * (key.z() >> bit & 1);
    const unsigned node = (bit > 0 ? 3U : 2U) << (2 * child);
    map.data += static_cast<char>(node & 0xFFU);
    map.data += static_cast<char>(node >> 8U);
  }
  return map;
}
const Eigen::Array3i kFar(200, 200, 200);

/// [m] The diagonal of a voxel.
const double kVoxel = std::sqrt(3.0) * 0.02;

class Sensed : public testing::Test {
 protected:
  void SetUp() override {
    connectedGantry(1).hold({1.0, 0.0, 0.0});
    map_publisher_.publish(mapOf(kFar));
  }
  void TearDown() override {
    ticker_.stop();
    connectedGantry(1).release();
  }

  /// 500 points on the ball, up to 2 cm off.
  static Points ball() {
    Chance chance(5);
    Points points;
    for (int i = 0; i < 500; ++i) points.push_back(chance.between(0.1, 0.12) * chance.direction());
    return points;
  }
  /// 400 points of a plate at this distance [m] from the surface of the ball.
  static Points plateAt(double distance) {
    Points points;
    for (int i = 0; i < 400; ++i) points.emplace_back(0.1 + distance, 0.01 * (i % 20 - 10), 0.01 * (i / 20 - 10));
    return points;
  }
  static Points together(Points a, const Points& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }

  void see(const Points& points) {
    ticker_.stop();
    cloud_.header.frame_id = "ball";
    sensor_msgs::PointCloud2Modifier modifier(cloud_);
    modifier.setPointCloud2FieldsByString(1, "xyz");
    modifier.resize(points.size());
    if (!points.empty()) {  // an iterator needs a first byte
      sensor_msgs::PointCloud2Iterator<float> out(cloud_, "x");
      for (const Vector3d& point : points) {
        for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(point[axis]);
        ++out;
      }
    }
    ticker_.start();
  }
  std::optional<Clearance> withLevel(std::uint8_t level) {
    return clearances_.next([&](const Clearance& message) { return message.level == level; });
  }
  std::optional<Clearance> invalidBecause(const std::string& text) {
    return clearances_.next([&](const Clearance& message) {
      return message.level == Clearance::INVALID && message.status.message.find(text) != std::string::npos;
    });
  }

  ros::NodeHandle nh_;
  Inbox<Clearance> clearances_{nh_, kNode + "clearance"};
  sensor_msgs::PointCloud2 cloud_;
  ros::Publisher publisher_ = nh_.advertise<sensor_msgs::PointCloud2>("/camera/points", 10);
  ros::Publisher map_publisher_ = nh_.advertise<OctomapMessage>("/octomap_binary", 1, /*latch=*/true);
  Ticker ticker_{nh_, 20.0, [this] {
                   cloud_.header.stamp = ros::Time::now();
                   publisher_.publish(cloud_);
                 }};
};

TEST_F(Sensed, ObstacleIsInTheLevelAndTheRobotIsNot) {
  ASSERT_TRUE(invalidBecause("sensed source 'camera' on '/camera/points': no message yet"));
  see(ball());
  ASSERT_TRUE(withLevel(Clearance::CLEAR)) << "the robot alone";
  const auto expectLevel = [&](std::uint8_t level, double distance, double threshold) {
    see(together(ball(), plateAt(distance)));
    const auto clearance = withLevel(level);
    ASSERT_TRUE(clearance) << int{level};
    EXPECT_EQ(clearance->deciding.a.link, "ball") << clearance->status.message;
    EXPECT_EQ(clearance->deciding.b.link, "camera") << clearance->status.message;
    EXPECT_EQ(clearance->deciding_threshold, threshold);
    EXPECT_LE(clearance->deciding.lower_bound, distance + 1e-6) << "of each point";
    EXPECT_GE(clearance->deciding.lower_bound, distance - kVoxel);
  };
  expectLevel(Clearance::WARN, 0.15, 0.2);
  expectLevel(Clearance::STOP, 0.09, 0.1);
  ticker_.stop();
  const auto stale = invalidBecause("sensed source 'camera' on '/camera/points': its latest message is");
  ASSERT_TRUE(stale);
  EXPECT_EQ(stale->status.code, QueryStatus::TF_STALE);
  see({});
  ASSERT_TRUE(withLevel(Clearance::CLEAR)) << "an empty cloud is empty space";
}

TEST_F(Sensed, PointsAreCountedAndTheOthersPublished) {
  Inbox<proximity_server::Sensed> seen(nh_, kNode + "sensed");
  Inbox<sensor_msgs::PointCloud2> left(nh_, kNode + "sensed_points");
  Points points = together(ball(), plateAt(0.3));
  points.emplace_back(4.0, 0.0, 0.0);
  points.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0);
  points.emplace_back(std::numeric_limits<double>::infinity(), 0.0, 0.0);
  see(points);
  const auto message = seen.next([](const proximity_server::Sensed& of) {
    return of.sources.size() == 2 && of.sources[0].out_of_range == 1 && of.status.code == QueryStatus::OK;
  });
  ASSERT_TRUE(message);
  const SensedSource& source = message->sources[0];
  EXPECT_EQ(source.name, "camera");
  EXPECT_EQ(source.points, 901U);
  EXPECT_EQ(source.on_robot, 500U);
  EXPECT_GE(source.voxels, 100U);
  EXPECT_GE(source.boxes, 1U);
  EXPECT_LT(source.boxes, source.voxels);
  EXPECT_EQ(source.minimum.b.link, "camera");
  EXPECT_LE(source.minimum.lower_bound, 0.3 + 1e-6);
  EXPECT_GE(source.minimum.lower_bound, 0.3 - kVoxel);
  const auto cloud = left.next([](const sensor_msgs::PointCloud2& of) { return of.width == 400; });
  ASSERT_TRUE(cloud) << "without the robot, and without what is out of range";
  EXPECT_EQ(cloud->header.frame_id, "ball") << "that of the camera";
  sensor_msgs::PointCloud2ConstIterator<float> first(*cloud, "x");
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(first[axis], plateAt(0.3)[0][axis], 1e-6);
}

TEST_F(Sensed, CloudThatCannotBeUsedIsNamed) {
  see(plateAt(0.5));
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  ticker_.stop();
  cloud_.row_step *= 2;
  ticker_.start();
  ASSERT_TRUE(invalidBecause("row_step times height is more than its data"));
  see(plateAt(0.5));
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  ticker_.stop();
  cloud_.header.frame_id = "nowhere";
  ticker_.start();
  ASSERT_TRUE(invalidBecause("frame 'nowhere' has no pose"));
}

TEST_F(Sensed, MapIsInTheLevelUntilAnotherReplacesIt) {
  see({});
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  map_publisher_.publish(mapOf({59, 0, 0}));
  const auto near = withLevel(Clearance::STOP);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->deciding.b.link, "map");
  EXPECT_NEAR(near->deciding.distance, 0.08, 1e-6);
  map_publisher_.publish(mapOf(kFar));
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  OctomapMessage broken = mapOf({59, 0, 0});
  broken.data.pop_back();
  map_publisher_.publish(broken);
  ASSERT_TRUE(
      invalidBecause("sensed source 'map' on '/octomap_binary': a message is left out: byte 31: the octree ends"));
  map_publisher_.publish(mapOf(kFar));
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  OctomapMessage elsewhere = mapOf(kFar);
  elsewhere.header.frame_id = "nowhere";
  map_publisher_.publish(elsewhere);
  ASSERT_TRUE(invalidBecause("nowhere"));
}

TEST_F(Sensed, ObstacleMustBeSeenBeforeTheRobotStops) {
  const std::string parameter = kNode + "sensed";
  XmlRpc::XmlRpcValue before, sensed;
  ASSERT_TRUE(ros::param::get(parameter, before));
  const auto refusal = [&](const char* field, const XmlRpc::XmlRpcValue& value) {
    sensed = before;
    sensed[0][field] = value;
    ros::param::set(parameter, sensed);
    const auto response = call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest());
    EXPECT_FALSE(response.success);
    return response.message;
  };
  EXPECT_EQ(
      refusal("self_padding", 0.07),
      "the model stays as it was: sensed_stop_distance is 0.1, not above 0.105, the self padding of sensed source "
      "'camera' plus the diagonal of its voxels");
  XmlRpc::XmlRpcValue links;
  links["bal"] = 0.01;
  EXPECT_EQ(refusal("link_self_padding", links),
            "the model stays as it was: parameter sensed: link_self_padding: there is no link \"bal\" (did you mean "
            "\"ball\"?)");
  ros::param::set(parameter, before);
  EXPECT_TRUE(call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest()).success);
}

TEST_F(Sensed, ClientsCannotChangeWhatIsSeen) {
  see(plateAt(0.5));
  ASSERT_TRUE(withLevel(Clearance::CLEAR));
  for (const ObjectChange& refused : {addBall("camera"), change(ObjectChange::REMOVE, "camera")}) {
    const auto response = call<ApplyObjectsResponse>(kNode + "apply_objects", requestOf({refused}));
    EXPECT_FALSE(response.success);
    EXPECT_NE(response.status.message.find("it is a sensed source: only messages on '/camera/points' change it"),
              std::string::npos)
        << response.status.message;
  }
}

}  // namespace proximity_server::node::sensed_test
