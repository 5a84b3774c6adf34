#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/object_messages.h"
#include "node/services/queries.h"
#include "proximity_server/ShapeKind.h"

#include <cmath>
#include <string>
#include <vector>

// Points and rays beside the robot of gantry.urdf, with its ball at (1, 0, 0) and its blocks at (0, 1, 0) and (0, 1, 0.5).

namespace proximity_server::node::point_queries_test {

geometry_msgs::Point point(double x, double y, double z) {
  geometry_msgs::Point result;
  result.x = x;
  result.y = y;
  result.z = z;
  return result;
}

QueryPointsRequest about(const std::vector<geometry_msgs::Point>& points) {
  QueryPointsRequest request;
  request.points = points;
  return request;
}

QueryRaysRequest along(const geometry_msgs::Point& origin, double x, double y, double z) {
  QueryRaysRequest request;
  request.origins = {origin};
  request.directions.resize(1);
  request.directions[0].x = x;
  request.directions[0].y = y;
  request.directions[0].z = z;
  return request;
}

class Points : public AskedGantry {
 protected:
  Points() { moveTo({1.0, 0.0, 0.0}); }
};
using Rays = Points;

TEST_F(Points, HaveTheClosestShapeInTheOrderOfTheRequest) {
  const auto response = ask(about({point(1.0, 0.4, 0.0), point(0.0, 1.0, 0.7), point(0.0, 0.0, 0.05)}));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.frame_id, "base");
  ASSERT_EQ(response.points.size(), 3u);
  EXPECT_EQ(response.points[0].a.link, "ball");
  EXPECT_EQ(response.points[0].a.name, "skin");
  EXPECT_NEAR(response.points[0].distance, 0.3, kTolerance);
  expectNear(response.points[0].point_a, 1.0, 0.1, 0.0);
  expectNear(response.points[0].point_b, 1.0, 0.4, 0.0);
  EXPECT_NEAR(response.points[0].normal.y, 1.0, kTolerance);
  expectNear(response.points[0].point_a_link, 0.1, 0.0, 0.0);
  EXPECT_TRUE(isNaN(response.points[0].point_b_link));
  EXPECT_EQ(response.points[1].a.name, "high");
  EXPECT_NEAR(response.points[1].distance, 0.1, kTolerance);
  EXPECT_EQ(response.points[2].state, Proximity::PENETRATING);
  EXPECT_NEAR(response.points[2].distance, -0.05, kTolerance);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(response.points[i].b.kind, ShapeKind::POINT);
    EXPECT_EQ(response.points[i].b.index, i + 1);
    EXPECT_EQ(response.points[i].b.link, "");
  }
  EXPECT_TRUE(response.joint_names.empty());
}

TEST_F(Points, TakeRadiiAndNamedShapes) {
  QueryPointsRequest request = about({point(1.0, 0.4, 0.0)});
  request.radii = {0.05};
  EXPECT_NEAR(ask(request).points.at(0).distance, 0.25, kTolerance);
  request.shapes = {shape("block")};
  request.shapes[0].name = "low";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.points.at(0).distance, std::hypot(0.9, 0.5) - 0.05, kTolerance);
}

TEST_F(Points, OfAnotherFrameStandWhereThatFrameIs) {
  QueryPointsRequest request = about({point(0.3, 0.0, 0.0)});
  request.header.frame_id = "ball";  // turned by a quarter
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.points.at(0).distance, 0.2, kTolerance);
  expectNear(response.points[0].point_b, 1.0, 0.3, 0.0);
  request.header.frame_id = "camera";
  expectRefusal(ask(request), QueryStatus::TF_UNAVAILABLE, "frame 'camera'");
  geometry_msgs::TransformStamped camera = Gantry::post({0.0, 0.0, 0.5});
  camera.child_frame_id = "camera";
  gantry_.publish({camera}, ros::Time::now());
  EXPECT_NEAR(ask(request).points.at(0).distance, std::hypot(0.2, 0.4), kTolerance);
}

TEST_F(Points, BeyondTheThresholdAreProvenFarOrLeftOut) {
  QueryPointsRequest request = about({point(0.0, 0.0, 3.0), point(1.0, 0.4, 0.0)});
  request.threshold = 0.35;
  auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.points.size(), 2u);
  EXPECT_EQ(response.points[0].state, Proximity::BEYOND_THRESHOLD);
  EXPECT_GE(response.points[0].distance, 0.35);
  EXPECT_EQ(response.points[0].a.link, "");
  EXPECT_NEAR(response.points[1].distance, 0.3, kTolerance);
  request.only_near = true;
  response = ask(request);
  ASSERT_EQ(response.points.size(), 1u);
  EXPECT_EQ(response.points[0].b.index, 2u);
}

TEST_F(Points, HaveGradientsIfTheyAreWanted) {
  QueryPointsRequest request = about({point(1.0, 0.4, 0.0), point(0.0, 1.0, 0.7)});
  request.want_gradient = true;
  const auto response = ask(request);
  ASSERT_EQ(response.joint_names, (std::vector<std::string>{"lift", "x_axis", "y_axis"}));
  ASSERT_EQ(response.points[0].gradient.size(), 3u);
  EXPECT_NEAR(response.points[0].gradient[2], -1.0, kTolerance);
  ASSERT_EQ(response.points[1].gradient.size(), 3u);
  EXPECT_NEAR(response.points[1].gradient[0], -1.0, kTolerance);
}

TEST_F(Points, AreMeasuredFromWhatLinksHold) {
  ASSERT_TRUE(ask(requestOf({addBall("free", poseAt(1.0, 0.4, 0.5)), addBall("tool", poseAt(1.0, 0.4, 0.0))})).success);
  ASSERT_TRUE(ask(requestOf({attach("tool", "ball")})).success);
  const auto response = ask(about({point(1.0, 0.4, 0.3)}));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.points.at(0).a.link, "tool");
  EXPECT_EQ(response.points.at(0).a.kind, ShapeRef::OBJECT);
  EXPECT_NEAR(response.points.at(0).distance, 0.2, kTolerance);
}

TEST_F(Points, AreAtMostMaxBatch) {
  expectRefusal(ask(about(std::vector<geometry_msgs::Point>(11))), QueryStatus::OVER_BUDGET, "points: 11 points");
  EXPECT_TRUE(ask(about({})).success);
}

TEST_F(Rays, MeetWhatIsFirst) {
  const auto hit = ask(along(point(-1.0, 0.0, 0.0), 3.0, 0.0, 0.0));
  ASSERT_TRUE(hit.success) << hit.status.message;
  ASSERT_EQ(hit.hits.size(), 1u);
  EXPECT_EQ(hit.hits[0].state, RayHit::HIT);
  EXPECT_EQ(hit.hits[0].shape.link, "base");
  EXPECT_NEAR(hit.hits[0].distance, 0.9, kTolerance);
  EXPECT_LE(hit.hits[0].free_until, hit.hits[0].distance);
  expectNear(hit.hits[0].point, -0.1, 0.0, 0.0);
  EXPECT_NEAR(hit.hits[0].normal.x, -1.0, kTolerance);
  QueryRaysRequest request = along(point(-1.0, 0.0, 0.0), 1.0, 0.0, 0.0);
  request.ranges = {0.5};
  const auto free = ask(request);
  EXPECT_EQ(free.hits.at(0).state, RayHit::FREE);
  EXPECT_EQ(free.hits.at(0).free_until, 0.5);
  EXPECT_EQ(free.hits.at(0).shape.link, "");
  EXPECT_TRUE(std::isnan(free.hits.at(0).distance));
}

TEST_F(Rays, MeetObjectsAndStandInTheirFrame) {
  ASSERT_TRUE(ask(requestOf({addBall("part", poseAt(1.0, 0.0, 1.0))})).success);
  QueryRaysRequest request = along(point(0.0, 0.0, 0.2), 0.0, 0.0, 1.0);
  request.header.frame_id = "ball";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.hits.at(0).shape.link, "part");
  EXPECT_EQ(response.hits.at(0).shape.kind, ShapeRef::OBJECT);
  EXPECT_NEAR(response.hits.at(0).distance, 0.7, kTolerance);
  request.shapes = {shape("base")};
  EXPECT_EQ(ask(request).hits.at(0).state, RayHit::FREE);
}

}  // namespace proximity_server::node::point_queries_test
