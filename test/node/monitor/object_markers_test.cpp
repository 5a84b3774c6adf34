#include "node/monitor/object_markers.h"

#include "node/object_messages.h"
#include "node/objects/object_store.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node::object_markers_test {

using visualization_msgs::Marker;

const std::string kRobot =
    robots::urdfOf(robots::link("base") + robots::link("hand") + robots::slider("slide", "base", "hand", "1 0 0"));

/// The markers of one object besides the one that deletes those of before.
std::vector<Marker> markersOf(ObjectChange change) {
  Config config;
  config.tf_prefix = "left";
  const auto robot = std::make_shared<const Robot>(kRobot, "", config);
  ObjectStore store(robot, 1, {});
  change.id = "thing";
  store.apply(messageOf({change}));
  std::vector<Marker> markers = objectMarkers(*robot, *robot->objects().get().all).markers;
  EXPECT_FALSE(markers.empty());
  EXPECT_EQ(markers.front().action, Marker::DELETEALL);
  markers.erase(markers.begin());
  return markers;
}

TEST(ObjectMarkers, AreFixedInTheFrameThatCarriesTheObject) {
  ObjectChange held;
  held.link = held.header.frame_id = "hand";
  held.pose.position.z = 0.5;
  held.primitives = {primitive(shape_msgs::SolidPrimitive::BOX, {1.0, 2.0, 3.0})};
  held.primitive_poses.resize(1);
  held.primitive_poses[0].position.z = 0.25;
  const std::vector<Marker> markers = markersOf(held);
  ASSERT_EQ(markers.size(), 1u);
  EXPECT_EQ(markers[0].header.frame_id, "left/hand");
  EXPECT_TRUE(markers[0].frame_locked);
  EXPECT_EQ(markers[0].ns, "thing");
  EXPECT_EQ(markers[0].type, Marker::CUBE);
  EXPECT_EQ(markers[0].pose.position.z, 0.75);
  EXPECT_EQ(markers[0].pose.orientation.w, 1.0);
  EXPECT_EQ(markers[0].scale.y, 2.0);
}

TEST(ObjectMarkers, DrawEachKindOfShape) {
  ObjectChange change;
  change.primitives = {primitive(shape_msgs::SolidPrimitive::SPHERE, {0.5}),
                       primitive(shape_msgs::SolidPrimitive::CYLINDER, {2.0, 0.5}),
                       primitive(shape_msgs::SolidPrimitive::CONE, {2.0, 0.5})};
  change.meshes.resize(1);
  change.meshes[0].vertices.resize(3);
  change.meshes[0].vertices[1].x = change.meshes[0].vertices[2].y = 1.0;
  change.meshes[0].triangles.resize(1);
  change.meshes[0].triangles[0].vertex_indices = {0, 1, 2};
  change.planes.resize(1);
  change.planes[0].coef = {0.0, 0.0, -2.0, 1.0};  // all above z = 0.5
  const std::vector<Marker> markers = markersOf(change);
  ASSERT_EQ(markers.size(), 5u);
  EXPECT_EQ(markers[0].type, Marker::SPHERE);
  EXPECT_EQ(markers[0].scale.z, 1.0);
  EXPECT_EQ(markers[1].type, Marker::CYLINDER);
  EXPECT_EQ(markers[1].scale.x, 1.0);
  EXPECT_EQ(markers[1].scale.z, 2.0);
  for (const geometry_msgs::Point& corner : markers[2].points)
    EXPECT_LE(std::hypot(corner.x, corner.y), 0.25 * (1.0 - corner.z) + 1e-12) << "the apex is up";
  EXPECT_EQ(markers[3].points.size(), 3u);
  EXPECT_EQ(markers[4].type, Marker::CUBE);
  EXPECT_NEAR(markers[4].pose.position.z, 0.5, 0.002);
}

}  // namespace proximity_server::node::object_markers_test
