#include "proximity_server/scene/object_files/object_file.h"

#include "scene/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace proximity_server::scene::object_file_test {

using narrowphase::Shape;

ObjectFile read(const std::string& yaml) { return objectFileFrom(readYaml(yaml, "cell.yaml"), "cell.yaml"); }
std::string refusal(const std::string& yaml) {
  return errorOf([&] { read(yaml); });
}

const Shape& shapeOf(const ObjectEdit& object, std::size_t index) {
  return std::get<Shape>(object.shapes.at(index).geometry);
}

TEST(ObjectFile, ReadsWhatAnObjectHas) {
  const ObjectFile file = read(R"(
objects:
- id: table
  frame: cell
  pose: {position: {x: 1, z: -0.5}, orientation: {z: 2}}
  padding: 0.01
  primitives: [{type: BOX, dimensions: [1, 2, 0.05]}, {type: 3, dimensions: [0.5, 0.1]}]
  primitive_poses: [{}, {position: [0, 0, 0.25]}]
- id: bar
  link: hand
  touch_links: [finger, thumb]
  mesh_files: [{uri: "package://cell/bar.stl", scale: [1, 1, -1]}]
)");
  ASSERT_EQ(file.objects.size(), 2U);
  const ObjectEdit& table = file.objects[0];
  EXPECT_EQ(table.id, "table");
  EXPECT_EQ(table.place.frame, "cell");
  EXPECT_EQ(table.padding, 0.01);
  EXPECT_EQ(table.place.pose.translation(), Eigen::Vector3d(1.0, 0.0, -0.5));
  EXPECT_TRUE(table.place.pose.linear().isApprox(Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal().toDenseMatrix(), 1e-15))
      << "half a turn about z";
  ASSERT_EQ(table.shapes.size(), 2U);
  EXPECT_EQ(shapeOf(table, 0).kind(), Shape::Kind::Box);
  EXPECT_EQ(shapeOf(table, 0).halfExtents(), Eigen::Vector3d(0.5, 1.0, 0.025));
  EXPECT_EQ(shapeOf(table, 1).kind(), Shape::Kind::Cylinder);
  EXPECT_EQ(shapeOf(table, 1).halfExtents(), Eigen::Vector3d(0.1, 0.1, 0.25)) << "height, then radius";
  EXPECT_EQ(table.shapes[1].object_T_shape.translation().z(), 0.25);

  const ObjectEdit& bar = file.objects[1];
  EXPECT_EQ(bar.place.link, "hand");
  EXPECT_EQ(bar.place.touch_links, (std::vector<std::string>{"finger", "thumb"}));
  EXPECT_TRUE(bar.place.pose.isApprox(Eigen::Isometry3d::Identity(), 0.0));
  EXPECT_EQ(std::get<MeshFile>(bar.shapes.at(0).geometry).scale, Eigen::Vector3d(1.0, 1.0, -1.0));
}

TEST(ObjectFile, AListAloneIsAListOfObjects) {
  EXPECT_EQ(read("[{id: a, primitives: [{type: SPHERE, dimensions: [1]}]}]").objects.size(), 1U);
  EXPECT_TRUE(read("[]").objects.empty());
}

TEST(ObjectFile, RpyTurnsAboutFixedAxesAsInAUrdf) {
  // A quarter turn about x takes y to z; the quarter turn about z that follows leaves it there.
  const ObjectFile file = read(
      "[{id: a, pose: {rpy: [1.5707963267948966, 0, 1.5707963267948966]}, primitives: [{type: SPHERE, dimensions: "
      "[1]}]}]");
  const Eigen::Vector3d y = file.objects.at(0).place.pose.linear() * Eigen::Vector3d::UnitY();
  EXPECT_TRUE(y.isApprox(Eigen::Vector3d::UnitZ(), 1e-15)) << y.transpose();
}

TEST(ObjectFile, RpyMayBeInDegrees) {
  const char kTurned[] = "[{id: a, pose: {rpy: [0, 0, %]}, primitives: [{type: SPHERE, dimensions: [1]}]}]";
  const auto yaw = [&](const std::string& text) {
    std::string yaml = kTurned;
    const ObjectFile file = read(yaml.replace(yaml.find('%'), 1, text));
    return file.objects.at(0).place.pose.linear()(1, 0);
  };
  EXPECT_EQ(yaw("30deg"), yaw("0.5235987755982988"));
  EXPECT_THROW(yaw("30 rad"), std::invalid_argument);
}

TEST(ObjectFile, RpyOfMoreThanATurnIsAWarningByPlaceWithItsNumber) {
  const auto warningsOfYaw = [](const std::string& yaw) {
    return read("- {id: a, pose: {rpy: [0, 0, " + yaw + "]}, primitives: [{type: SPHERE, dimensions: [1]}]}").warnings;
  };
  EXPECT_EQ(
      warningsOfYaw("-90"),
      std::vector<std::string>{"cell.yaml, line 1: [0] \"a\"/pose/rpy[2]: -90 rad is more than a turn; degrees are "
                               "written -90deg"});
  for (const char* text : {"6.28", "-3.2", "450deg"}) EXPECT_TRUE(warningsOfYaw(text).empty()) << text;
}

TEST(ObjectFile, APlaneIsTheHalfSpaceBelowIt) {
  const ObjectFile file = read("[{id: floor, planes: [{coef: [0, 0, 2, 1]}]}]");
  const auto& plane = std::get<HalfSpace>(file.objects.at(0).shapes.at(0).geometry);
  EXPECT_EQ(plane.normal, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(plane.offset, -0.5) << "2 z + 1 <= 0";
}

TEST(ObjectFile, BoxesInBulkHaveOneSizeOrOneEach) {
  const ObjectFile file = read(
      "[{id: map, boxes: [{centres: [[1, 2, 3], {z: 1}], sizes: [[0.2, 0.4, 0.6]]}, "
      "{centres: [[0, 0, 0], [1, 0, 0]], sizes: [[1, 1, 1], [2, 2, 2]]}], "
      "boxes_poses: [{}, {position: [0, 0, 5]}]}]");
  const auto& shapes = file.objects.at(0).shapes;
  ASSERT_EQ(shapes.size(), 2U);
  const auto& same = std::get<Boxes>(shapes[0].geometry).boxes;
  ASSERT_EQ(same.size(), 2U);
  EXPECT_TRUE(same[0].isApprox(Eigen::AlignedBox3d(Eigen::Vector3d(0.9, 1.8, 2.7), Eigen::Vector3d(1.1, 2.2, 3.3))));
  EXPECT_TRUE(same[1].sizes().isApprox(Eigen::Vector3d(0.2, 0.4, 0.6)));
  EXPECT_EQ(std::get<Boxes>(shapes[1].geometry).boxes[1].sizes(), Eigen::Vector3d(2.0, 2.0, 2.0));
  EXPECT_EQ(shapes[1].object_T_shape.translation().z(), 5.0);
  const ObjectFile again = read(yamlOf(file));
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_TRUE(std::get<Boxes>(again.objects.at(0).shapes.at(i).geometry)
                      .boxes.at(k)
                      .isApprox(std::get<Boxes>(shapes[i].geometry).boxes[k], 1e-15));
}

TEST(ObjectFile, BoxesInBulkMayBeNone) {
  for (const char* sizes : {"[]", "[[1, 1, 1]]"}) {
    const ObjectFile file = read(std::string("[{id: map, boxes: [{centres: [], sizes: ") + sizes + "}]}]");
    EXPECT_TRUE(std::get<Boxes>(file.objects.at(0).shapes.at(0).geometry).boxes.empty()) << sizes;
    const ObjectFile again = read(yamlOf(file));
    EXPECT_TRUE(std::get<Boxes>(again.objects.at(0).shapes.at(0).geometry).boxes.empty()) << sizes;
  }
}

TEST(ObjectFile, ReadsRules) {
  const ObjectFile file = read("rules: [{a: table, b: '*', allowed: true}, {a: table, b: hand, allowed: false}]");
  ASSERT_EQ(file.rules.size(), 2U);
  EXPECT_EQ(file.rules[0].b, "*");
  EXPECT_EQ(file.rules[0].rule, AllowedPairs::Rule::Allowed);
  EXPECT_EQ(file.rules[1].rule, AllowedPairs::Rule::Checked);
}

TEST(ObjectFile, ReadsChangesAtRowsAndTimes) {
  const ObjectFile file = read(R"(
changes:
- {at: {row: 3}, operation: ATTACH, id: bar, link: hand, keep_pose: true, touch_links: [finger]}
- {at: {row: 3}, operation: ATTACH, id: nut, link: hand, pose: {position: [0, 0, 1]}}
- {at: {time: 1.5}, operation: DETACH, id: bar}
- {at: {time: 1.5}, operation: MOVE, id: bar, frame: cell, pose: {position: [1, 0, 0]}}
- {at: {time: 2}, operation: REMOVE, id: bar}
- {at: {time: 3}, operation: ADD, id: ball, primitives: [{type: SPHERE, dimensions: [1]}]}
)");
  using Operation = ObjectEdit::Operation;
  ASSERT_EQ(file.changes.size(), 6U);
  EXPECT_EQ(std::get<AtRow>(file.changes[0].at).row, 3);
  EXPECT_EQ(file.changes[0].edit.operation, Operation::Attach);
  EXPECT_EQ(file.changes[0].edit.pose, ObjectEdit::Pose::Kept);
  EXPECT_EQ(file.changes[0].edit.place.touch_links, std::vector<std::string>{"finger"});
  EXPECT_EQ(file.changes[1].edit.pose, ObjectEdit::Pose::Given);
  EXPECT_EQ(file.changes[1].edit.place.pose.translation().z(), 1.0);
  EXPECT_EQ(std::get<AtTime>(file.changes[2].at).time, 1.5);
  EXPECT_EQ(file.changes[3].edit.place.frame, "cell");
  EXPECT_EQ(file.changes[4].edit.operation, Operation::Remove);
  EXPECT_EQ(file.changes[5].edit.shapes.size(), 1U);
}

struct Refusal {
  const char* yaml;
  const char* reason;
};

TEST(ObjectFile, RefusesWithLineFieldAndReason) {
  const std::string ball = "primitives: [{type: SPHERE, dimensions: [1]}]";
  const Refusal refusals[] = {
      {"", "cell.yaml: must be a map of fields"},
      {"object: []", "cell.yaml, line 1: object: there is no such field (did you mean \"objects\"?)"},
      {"objects: 3", "cell.yaml, line 1: objects: must be a list"},
      {"objects:\n- 3", "cell.yaml, line 2: objects[0]: must be a map of fields"},
      {"objects:\n- {}", "cell.yaml, line 2: objects[0]: there is no field \"id\""},
      {"objects:\n- {id: 7}", "cell.yaml, line 2: objects[0]/id: must be a text; a number is one in quotes"},
      {"objects:\n- id: a", "cell.yaml, line 2: objects[0] \"a\": it has no shape"},
      {"- id: a\n  paddings: 1",
       "cell.yaml, line 2: [0] \"a\"/paddings: there is no such field (did you mean \"padding\"?)"},
      {"- id: a\n  padding: -1", "cell.yaml, line 1: [0] \"a\": padding: it is negative, or not finite"},
      {"- id: a\n  padding: .nan", "cell.yaml, line 2: [0] \"a\"/padding: must be a finite number"},
      {"- id: a\n  link: hand\n  frame: cell", "cell.yaml, line 1: [0] \"a\": frame: it goes without link only"},
      {"- id: a\n  pose: {position: [1, 2]}", "cell.yaml, line 2: [0] \"a\"/pose/position: has 2 numbers instead of 3"},
      {"- id: a\n  pose: {position: {u: 1}}", "cell.yaml, line 2: [0] \"a\"/pose/position/u: there is no such field"},
      {"- id: a\n  pose: {rpy: [0, 0, 0], orientation: [0, 0, 0, 1]}",
       "cell.yaml, line 2: [0] \"a\"/pose/rpy: it goes without orientation only"},
      {"- id: a\n  primitives: [{type: BALL, dimensions: [1]}]",
       "cell.yaml, line 2: [0] \"a\"/primitives[0]: type BALL is none of BOX, SPHERE, CYLINDER and CONE"},
      {"- id: a\n  primitives: [{type: BOX, dimensions: [1]}]",
       "cell.yaml, line 2: [0] \"a\"/primitives[0]: dimensions has 1 numbers instead of 3, the edges along x, y and z"},
      {"- id: a\n  primitives: [{type: BOX}]",
       "cell.yaml, line 2: [0] \"a\"/primitives[0]: there is no field \"dimensions\""},
      {"- id: a\n  primitives: [{type: SPHERE, dimensions: [1]}]\n  primitive_poses: [{}, {}]",
       "cell.yaml, line 1: [0] \"a\": primitive_poses: 2 poses for 1 shapes of this kind"},
      {"- id: a\n  planes: [{coef: [0, 0, 0, 1]}]",
       "cell.yaml, line 2: [0] \"a\"/planes[0]: coef: a number is not finite, or a, b and c are zero"},
      {"- id: a\n  boxes: [{centres: [[0, 0, 0]], sizes: []}]",
       "cell.yaml, line 2: [0] \"a\"/boxes[0]: sizes has 0 entries, neither 1 nor the 1 of centres"},
      {"- id: a\n  mesh_files: [{uri: bar.stl}]",
       "cell.yaml, line 2: [0] \"a\"/mesh_files[0]: 'bar.stl' is a relative path, and there is no folder in which "
       "it begins; "
       "an absolute path, package:// or file:// is needed"},
      {"- id: a\n  mesh_files: [{uri: 'http://host/bar.stl'}]",
       "cell.yaml, line 2: [0] \"a\"/mesh_files[0]: http://host/bar.stl: only package://, file:// and plain paths "
       "are "
       "known"},
      {"- id: a\n  mesh_files: [{uri: 'file:///b', scale: [1, 0, 1]}]",
       "cell.yaml, line 2: [0] \"a\"/mesh_files[0]: scale has a number that is zero or not finite"},
      {"- id: a\n  meshes: [{vertices: [[0, 0, 0]], triangles: [{vertex_indices: [0, 0, 1]}]}]",
       "cell.yaml, line 2: [0] \"a\"/meshes[0]: triangles[0] names vertex 1 of 1"},
      {"- id: a\n  meshes: [{vertices: [[0, 0, 0]], triangles: [{vertex_indices: [0, 0, -1]}]}]",
       "cell.yaml, line 2: [0] \"a\"/meshes[0]/triangles[0]/vertex_indices[2]: must be a whole number of at least 0"},
      {"rules: [{a: x, b: '', allowed: true}]", "cell.yaml, line 1: rules[0]/b: is empty"},
      {"rules: [{a: x, b: y}]", "cell.yaml, line 1: rules[0]: there is no field \"allowed\""},
      {"rules: [{a: x, b: y, allowed: 1}]", "cell.yaml, line 1: rules[0]/allowed: must be true or false"},
      {"changes: [{operation: DETACH, id: a}]", "cell.yaml, line 1: changes[0] \"a\": there is no field \"at\""},
      {"changes: [{at: {}, operation: DETACH, id: a}]",
       "cell.yaml, line 1: changes[0] \"a\"/at: must have either row or time"},
      {"changes: [{at: {row: 1.5}, operation: DETACH, id: a}]",
       "cell.yaml, line 1: changes[0] \"a\"/at/row: must be a whole number of at least 0"},
      {"changes: [{at: {row: 1}, operation: APPEND, id: a}]",
       "cell.yaml, line 1: changes[0] \"a\"/operation: is none of ADD, REPLACE, MOVE, ATTACH, DETACH and REMOVE"},
      {"changes: [{at: {row: 1}, operation: DETACH, id: a, link: hand}]",
       "cell.yaml, line 1: changes[0] \"a\"/link: there is no such field"},
      {"changes: [{at: {row: 1}, operation: ATTACH, id: a}]",
       "cell.yaml, line 1: changes[0] \"a\": there is no field \"link\""},
      {"changes: [{at: {row: 1}, operation: ATTACH, id: a, link: b, keep_pose: true, pose: {}}]",
       "cell.yaml, line 1: changes[0] \"a\"/pose: it goes without keep_pose only"},
      {"changes:\n- {at: {row: 2}, operation: DETACH, id: a}\n- {at: {row: 1}, operation: DETACH, id: a}",
       "cell.yaml, line 3: changes[1] \"a\"/at: comes before a change above it: changes are made in their order"},
  };
  for (const Refusal& expected : refusals) EXPECT_EQ(refusal(expected.yaml), expected.reason);
}

TEST(ObjectFile, RefusesASizeThatIsNotPositive) {
  const std::string text = refusal("- id: a\n  primitives:\n  - {type: BOX, dimensions: [1, 0, 1]}");
  EXPECT_EQ(text.rfind("cell.yaml, line 3: [0] \"a\"/primitives[0]: ", 0), 0U) << text;
}

TEST(ObjectFile, ValuesOfNoTextHaveNoLine) {
  const FileValue not_finite{std::numeric_limits<double>::quiet_NaN()};
  const FileValue object{FileValue::Map{{"id", {std::string("a")}}, {"padding", not_finite}}};
  const FileValue list{FileValue::List{object}};
  EXPECT_EQ(errorOf([&] { objectFileFrom(list, "parameter /objects"); }),
            "parameter /objects: [0] \"a\"/padding: must be a finite number");
}

TEST(ObjectFile, TheNameTellsTheFormat) {
  const TemporaryFiles files;
  EXPECT_EQ(
      readObjectFile(files.write("a.yaml", "[{id: a, primitives: [{type: SPHERE, dimensions: [1]}]}]")).objects.size(),
      1U);
  EXPECT_EQ(
      readObjectFile(files.write("a.scene", "cell\n* a\n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n")).objects.size(),
      1U);
}

const char* const kCloud =
    "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
    "POINTS 2\nDATA ascii\n0.05 0.05 0.05\n1.05 0.05 0.05\n";

TEST(ObjectFile, HasTheVoxelsOfACloud) {
  const TemporaryFiles files;
  const std::string cloud = files.write("cell/hall.pcd", kCloud);
  const ObjectFile alone = readObjectFile(cloud);
  EXPECT_EQ(alone.objects.at(0).id, "hall");
  const auto boxes = [](const ObjectFile& file) {
    return std::get<Boxes>(file.objects.at(0).shapes.at(0).geometry).boxes;
  };
  ASSERT_EQ(boxes(alone).size(), 2U);
  EXPECT_TRUE(boxes(alone)[0].sizes().isApprox(Eigen::Vector3d::Constant(0.02)));
  const std::string text = "[{id: scan, frame: camera, boxes: [{cloud: hall.pcd, resolution: 0.1}]}]";
  const ObjectFile named = readObjectFile(files.write("cell/cell.yaml", text));
  EXPECT_EQ(named.objects.at(0).place.frame, "camera");
  ASSERT_EQ(boxes(named).size(), 2U);
  EXPECT_TRUE(boxes(named)[0].sizes().isApprox(Eigen::Vector3d::Constant(0.1)));
  EXPECT_TRUE(boxes(named)[0].contains(Eigen::Vector3d::Constant(0.05)));
}

TEST(ObjectFile, RefusesACloudWithFieldAndFile) {
  const TemporaryFiles files;
  const auto refusal = [&](const std::string& boxes) {
    return errorOf([&] { readObjectFile(files.write("cell.yaml", "[{id: scan, boxes: [" + boxes + "]}]")); });
  };
  const auto expectText = [&](const std::string& boxes, const std::string& text) {
    EXPECT_NE(refusal(boxes).find(text), std::string::npos) << refusal(boxes);
  };
  expectText("{cloud: none.pcd}", "line 1: [0] \"scan\"/boxes[0]: ");
  expectText("{cloud: none.pcd}", "none.pcd");
  files.write("hall.pcd", kCloud);
  expectText("{cloud: hall.pcd, resolution: 0}", "resolution");
  expectText("{cloud: hall.pcd, sizes: []}", "sizes");
  expectText("{cloud: cell.yaml}", "ends with .pcd, .ply, .bt or .ot");
  EXPECT_NE(errorOf([] { read("[{id: scan, boxes: [{cloud: hall.pcd}]}]"); }).find("relative path"), std::string::npos);
}

TEST(ObjectFile, PlainPathsOfMeshesBeginInItsFolder) {
  const TemporaryFiles files;
  const std::string path = files.write("cell/a.yaml",
                                       "objects:\n- id: a\n  mesh_files: [{uri: meshes/bar.stl}, {uri: /abs/bar.stl}, "
                                       "{uri: 'package://cell/bar.stl'}]\n"
                                       "changes:\n- {at: {row: 1}, operation: ADD, id: b, mesh_files: [{uri: b.stl}]}");
  const ObjectFile file = readObjectFile(path);
  const auto uri = [](const ObjectShape& shape) { return std::get<MeshFile>(shape.geometry).uri; };
  const std::vector<ObjectShape>& shapes = file.objects.at(0).shapes;
  EXPECT_EQ(uri(shapes.at(0)), files.path("cell/meshes/bar.stl"));
  EXPECT_EQ(uri(shapes.at(1)), "/abs/bar.stl");
  EXPECT_EQ(uri(shapes.at(2)), "package://cell/bar.stl");
  EXPECT_EQ(uri(file.changes.at(0).edit.shapes.at(0)), files.path("cell/b.stl"));
  // The written file does not depend on the folder.
  const ObjectFile again = objectFileFrom(readYaml(yamlOf({file.objects, {}, {}}), "again"), "again");
  EXPECT_EQ(uri(again.objects.at(0).shapes.at(0)), files.path("cell/meshes/bar.stl"));
}

TEST(ObjectFile, RefusesAFileThatCannotBeRead) {
  EXPECT_EQ(errorOf([] { readObjectFile("/nowhere/a.yaml"); }),
            "/nowhere/a.yaml: cannot be read (No such file or directory)");
  EXPECT_EQ(errorOf([] { readObjectFile("/"); }), "/: cannot be read (Is a directory)");
}

TEST(ObjectFile, ReadsTheExampleOfTheDocument) {
  std::ifstream stream(PROXIMITY_SOURCE_DIR "/config/README.md");
  const std::string document{std::istreambuf_iterator<char>(stream), {}};
  const std::string fence = "```yaml\n";
  const std::size_t begin = document.find(fence) + fence.size();
  const ObjectFile file = read(document.substr(begin, document.find("```", begin) - begin));
  ASSERT_EQ(file.objects.size(), 3U);
  EXPECT_EQ(file.objects[0].shapes.size(), 2U);
  EXPECT_EQ(file.objects[2].shapes.size(), 2U);
  EXPECT_EQ(file.rules.size(), 1U);
}

// --- writing

void expectSame(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  EXPECT_TRUE(a.matrix().isApprox(b.matrix(), 1e-14)) << a.matrix() << "\n" << b.matrix();
}

TEST(ObjectFile, WhatIsWrittenIsReadBack) {
  const std::string yaml = R"(
objects:
- id: "t\u00e4b\n\"le\" #1: "
  frame: cell
  pose: {position: [0.1, 1e-300, -2.5e+17], rpy: [0.1, 0.2, 0.3]}
  padding: 0.012345678901234567
  primitives: [{type: BOX, dimensions: [0.1, 0.2, 0.3]}, {type: SPHERE, dimensions: [0.1]},
               {type: CYLINDER, dimensions: [0.1, 0.2]}, {type: CONE, dimensions: [0.1, 0.2]}]
  primitive_poses: [{position: [1, 2, 3]}, {rpy: [1, 0, 0]}, {}, {}]
  planes: [{coef: [0, 0, 1, 0.1]}]
- id: "7"
  link: "true"
  touch_links: [a, "b, c"]
  meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.1]], triangles: [{vertex_indices: [0, 2, 1]}, {vertex_indices: [0, 1, 3]}]}]
  mesh_files: [{uri: "file:///a b.stl", scale: [0.001, 0.001, 0.001]}]
rules: [{a: "*", b: "7", allowed: true}, {a: "x", b: "y", allowed: false}]
)";
  const ObjectFile before = read(yaml), after = read(yamlOf(before));
  ASSERT_EQ(after.objects.size(), 2U);
  EXPECT_EQ(after.objects[0].id,
            "t\xc3\xa4"
            "b\n\"le\" #1: ");
  EXPECT_EQ(after.objects[0].padding, 0.012345678901234567);
  EXPECT_EQ(after.objects[0].place.frame, "cell");
  expectSame(after.objects[0].place.pose, before.objects[0].place.pose);
  ASSERT_EQ(after.objects[0].shapes.size(), 5U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(shapeOf(after.objects[0], i).kind(), shapeOf(before.objects[0], i).kind());
    EXPECT_EQ(shapeOf(after.objects[0], i).halfExtents(), shapeOf(before.objects[0], i).halfExtents());
    EXPECT_EQ(shapeOf(after.objects[0], i).margin(), shapeOf(before.objects[0], i).margin());
    expectSame(after.objects[0].shapes[i].object_T_shape, before.objects[0].shapes[i].object_T_shape);
  }
  EXPECT_NEAR(std::get<HalfSpace>(after.objects[0].shapes[4].geometry).offset, -0.1, 1e-16);
  EXPECT_EQ(after.objects[1].place.link, "true");
  EXPECT_EQ(after.objects[1].place.touch_links, (std::vector<std::string>{"a", "b, c"}));
  const auto& mesh = std::get<TriangleMesh>(after.objects[1].shapes.at(0).geometry);
  EXPECT_EQ(mesh.vertices, std::get<TriangleMesh>(before.objects[1].shapes.at(0).geometry).vertices);
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<int, 3>>{{0, 2, 1}, {0, 1, 3}}));
  EXPECT_EQ(std::get<MeshFile>(after.objects[1].shapes.at(1).geometry).uri, "file:///a b.stl");
  EXPECT_EQ(after.rules.size(), 2U);
}

TEST(ObjectFile, NothingIsWrittenAndReadBack) { EXPECT_TRUE(read(yamlOf({})).objects.empty()); }

TEST(ObjectFile, AllTextsInUtf8AreReadBack) {
  // The control characters and others that YAML forbids are written as escapes.
  const std::string all[] = {
      std::string("\0\x01\x1f\x7f", 4), "\xc2\x80", "\xef\xbf\xbe", "\xf4\x8f\xbf\xbf", "\xf0\x9f\xa4\x96", "\\u0041"};
  for (const std::string& id : all) {
    ObjectFile file;
    file.objects.push_back({id, {}, 0.0, {{Shape(narrowphase::Sphere{1.0})}}, ""});
    EXPECT_EQ(read(yamlOf(file)).objects.at(0).id, id);
  }
}

TEST(ObjectFile, ATextThatIsNotInUtf8CannotBeWritten) {
  for (const char* id : {"\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "a\x80"}) {
    EXPECT_THROW(requireUtf8(id), std::invalid_argument) << id;
    ObjectFile file;
    file.objects.push_back({id, {}, 0.0, {{Shape(narrowphase::Sphere{1.0})}}, ""});
    EXPECT_THROW(yamlOf(file), std::invalid_argument);
  }
  requireUtf8(
      "t\xc3\xa4"
      "ble");
}

TEST(ObjectFile, RefusesToWriteShapesThatTheFormatLacks) {
  ObjectFile file;
  file.objects.push_back({"a", {}, 0.0, {{Shape(narrowphase::Capsule{1.0, 1.0})}}, ""});
  EXPECT_NE(errorOf([&] { yamlOf(file); }).find("object \"a\": "), std::string::npos);
}

}  // namespace proximity_server::scene::object_file_test
