// The expected values are those that MoveIt's documentation gives to the fields.
#include "proximity_server/scene/object_files/object_file.h"

#include "scene/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace proximity_server::scene::moveit_scene_test {

using narrowphase::Shape;

ObjectFile read(const std::string& text) { return readMoveitScene(text, "cell.scene"); }
std::string refusal(const std::string& text) {
  return errorOf([&] { read(text); });
}
const Shape& shapeOf(const ObjectEdit& object, std::size_t index) {
  return std::get<Shape>(object.shapes.at(index).geometry);
}

// As written since objects have poses and subframes.
const char* const kNew = R"((noname)
* work table
0.5 0 -0.1
0 0 0.707107 0.707107
2
box
1 2 0.1
0 0 0
0 0 0 1
0.5 0.5 0.5 1
cylinder
0.05 0.7
0.1 0 -0.4
0 0 0 1
0 0 0 0
1
corner of it
0.5 1 0
0 0 0 1
* tip
0 0 1
0 0 0 1
2
cone
0.1 0.3
0 0 0
0 0 0 1
0 0 0 0
sphere
0.2
0 0 0
0 0 0 1
0 0 0 0
0
.
)";

TEST(MoveitScene, ReadsObjectsWithPosesAndSubframes) {
  const ObjectFile file = read(kNew);
  ASSERT_EQ(file.objects.size(), 2U);
  const ObjectEdit& table = file.objects[0];
  EXPECT_EQ(table.id, "work table");
  EXPECT_EQ(table.source, "cell.scene, line 2: object \"work table\"");
  EXPECT_EQ(table.place.frame, "");
  EXPECT_EQ(table.place.pose.translation(), Eigen::Vector3d(0.5, 0.0, -0.1));
  const Eigen::Vector3d x = table.place.pose.linear() * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d::UnitY(), 1e-12)) << "a quarter turn about z, written in six digits";
  ASSERT_EQ(table.shapes.size(), 2U);
  EXPECT_EQ(shapeOf(table, 0).halfExtents(), Eigen::Vector3d(0.5, 1.0, 0.05));
  EXPECT_EQ(shapeOf(table, 1).kind(), Shape::Kind::Cylinder);
  EXPECT_EQ(shapeOf(table, 1).halfExtents(), Eigen::Vector3d(0.05, 0.05, 0.35)) << "radius, then length";
  EXPECT_EQ(table.shapes[1].object_T_shape.translation(), Eigen::Vector3d(0.1, 0.0, -0.4));
  ASSERT_EQ(file.objects[1].shapes.size(), 2U);
  EXPECT_EQ(shapeOf(file.objects[1], 0).kind(), Shape::Kind::Cone);
  EXPECT_EQ(shapeOf(file.objects[1], 1).margin(), 0.2);
}

// As written before: the poses of shapes are in the frame of the scene.
TEST(MoveitScene, ReadsObjectsWithoutPoses) {
  const ObjectFile file = read(R"(cell
* wall
1
box
0.1 2 1
1 0 0.5
0 0 0 1
0 0 0 0
* lid
1
mesh
3 1
0 0 0
1 0 0
0 1 0.5
0 1 2
0 0 0
0 0 0 1
0 0 0 0
.
)");
  ASSERT_EQ(file.objects.size(), 2U);
  EXPECT_TRUE(file.objects[0].place.pose.isApprox(Eigen::Isometry3d::Identity(), 0.0));
  EXPECT_EQ(file.objects[0].shapes.at(0).object_T_shape.translation(), Eigen::Vector3d(1.0, 0.0, 0.5));
  const auto& mesh = std::get<TriangleMesh>(file.objects[1].shapes.at(0).geometry);
  ASSERT_EQ(mesh.vertices.size(), 3U);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(0.0, 1.0, 0.5));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}}));
}

TEST(MoveitScene, APlaneIsTheHalfSpaceBelowIt) {
  const ObjectFile file = read("c\n* floor\n1\nplane\n0 0 2 1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n");
  const auto& plane = std::get<HalfSpace>(file.objects.at(0).shapes.at(0).geometry);
  EXPECT_EQ(plane.normal, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(plane.offset, -0.5);
}

TEST(MoveitScene, LineEndsOfOtherSystemsAndEmptyLinesDoNotMatter) {
  std::string text;
  for (const char letter : std::string(kNew)) text += letter == '\n' ? std::string(" \r\n") : std::string(1, letter);
  const ObjectFile file = read(text);
  ASSERT_EQ(file.objects.size(), 2U);
  EXPECT_EQ(file.objects[0].id, "work table");
  EXPECT_EQ(file.objects[1].id, "tip");
}

TEST(MoveitScene, TheNameOfTheSceneMayBeEmpty) {
  EXPECT_EQ(read("\n* a\n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n").objects.size(), 1U);
  EXPECT_TRUE(read("(noname)\n.\n").objects.empty());
}

TEST(MoveitScene, WhatStandsBehindTheDotIsNotRead) { EXPECT_TRUE(read("(noname)\n.\n* a\n").objects.empty()); }

struct Refusal {
  const char* text;
  const char* reason;
};

TEST(MoveitScene, RefusesWithLineObjectAndReason) {
  const Refusal refusals[] = {
      {"", "cell.scene, line 1: it is cut off: the scene ends with a dot"},
      {"c\nbox\n", "cell.scene, line 2: an object begins with * and its id, the scene ends with a dot"},
      {"c\n* a\n", "cell.scene, line 3: object \"a\": it is cut off"},
      {"c\n* a\n0\n.\n", "cell.scene, line 3: object \"a\": it has no shape"},
      {"c\n* a\n-1\n.\n", "cell.scene, line 3: object \"a\": the number of shapes is expected, not \"-1\""},
      {"c\n* a\n1\nbox\n1 1 x\n", "cell.scene, line 5: object \"a\": a finite number is expected, not \"x\""},
      {"c\n* a\n1\nbox\n1 1 nan\n", "cell.scene, line 5: object \"a\": a finite number is expected, not \"nan\""},
      {"c\n* a\n1\nbox\n1 1\n", "cell.scene, line 6: object \"a\": it is cut off"},
      {"c\n* a\n1\noctree\n", "cell.scene, line 4: object \"a\": octrees are not read"},
      {"c\n* a\n1\nbal\n", "cell.scene, line 4: object \"a\": there is no shape \"bal\""},
      {"c\n* a\n1\nsphere\n1\n0 0 0\n0 0 0 0\n", "cell.scene, line 7: object \"a\": the quaternion of a pose is zero"},
      {"c\n* a\n1\nmesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n0 1 3\n",
       "cell.scene, line 9: object \"a\": triangles[0] names vertex 3 of 3"},
      {"c\n* a\n1\nmesh\n2000000000 1\n0 0 0\n", "cell.scene, line 7: object \"a\": it is cut off"},
      {"c\n* a\n1\nplane\n0 0 0 1\n",
       "cell.scene, line 5: object \"a\": coef: a number is not finite, or a, b and c are zero"},
      {"c\n* a\n0 0 0\n0 0 0 1\n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n1\n",
       "cell.scene, line 12: object \"a\": it is cut off in the subframes"},
  };
  for (const Refusal& expected : refusals) EXPECT_EQ(refusal(expected.text), expected.reason) << expected.text;
  const std::string size = refusal("c\n* a\n1\nsphere\n-1\n");
  EXPECT_EQ(size.rfind("cell.scene, line 5: object \"a\": ", 0), 0U) << size;
}

}  // namespace proximity_server::scene::moveit_scene_test
