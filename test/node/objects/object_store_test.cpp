// Changes of objects, with a tf of the test.
#include "node/objects/object_store.h"

#include "node/object_messages.h"
#include "node/objects/apply_objects.h"
#include "proximity_server/QueryStatus.h"
#include "robots/urdf.h"
#include "scene/files.h"
#include "scene/posed_scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::node::object_store_test {

using namespace robots;

/// A hand, a sphere of radius 0.1 m, on a slider along x; "finger" has no geometry and is fixed to the hand.
const std::string kSlider = urdfOf(link("rail", ball("0.1")) + link("hand", ball("0.1")) + link("finger") +
                                   slider("slide", "rail", "hand", "1 0 0") + weld("fix", "hand", "finger", "0 0 1"));

geometry_msgs::Pose at(double x, double y, double z) { return poseAt(x, y, z); }

using scene::errorOf;
const shape_msgs::SolidPrimitive kBall = primitive(shape_msgs::SolidPrimitive::SPHERE, {0.1});

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class ObjectsOfASlider : public testing::Test {
 protected:
  std::shared_ptr<const Robot> robot_ = std::make_shared<const Robot>(kSlider, "", Config());
  std::map<std::string, Eigen::Vector3d> tf_ = {
      {"hand", {2.0, 0.0, 0.0}}, {"finger", {2.0, 0.0, 1.0}}, {"camera", {0.0, 5.0, 0.0}}};
  int in_use_ = 0;
  ObjectStore store_{robot_, 7,
                     [this](const Robot&, const std::string& frame) -> Eigen::Isometry3d {
                       if (tf_.count(frame) == 0) throw std::invalid_argument("frame '" + frame + "' has no pose");
                       return Eigen::Isometry3d(Eigen::Translation3d(tf_.at(frame)));
                     },
                     [this](const Robot&) { ++in_use_; }};

  std::uint64_t apply(std::vector<ObjectChange> changes) { return store_.apply(messageOf(std::move(changes))); }

  /// The error of changes, of which none must have an effect.
  std::string refusal(std::vector<ObjectChange> changes) {
    const ObjectList before = store_.list();
    const auto objects = robot_->objects().get();
    const std::string error = errorOf([&] { apply(std::move(changes)); });
    EXPECT_NE(error, "") << "nothing was refused";
    const ObjectList after = store_.list();
    EXPECT_EQ(after.revision, before.revision);
    EXPECT_EQ(after.objects.size(), before.objects.size());
    EXPECT_EQ(robot_->objects().get().all, objects.all);
    return error;
  }

  ObjectInfo info(const std::string& id) {
    for (const ObjectInfo& object : store_.list().objects)
      if (object.id == id) return object;
    ADD_FAILURE() << "no object " << id;
    return {};
  }

  /// The distance of the object to the rail, at the origin, with the hand at x [m].
  double distanceToRail(const std::string& id, double x = 2.0) {
    scene::PosedScene scene(robot_->sharedModel());
    const auto objects = robot_->objects().get().all;
    scene.use(objects);
    scene::FramePoses frames;
    for (const std::string& frame : objects->frames())
      frames.emplace_back(Eigen::Isometry3d(Eigen::Translation3d(tf_.at(frame))));
    scene.update(scene::forwardKinematics(robot_->robotModel(), std::vector<double>{x}), frames);
    return scene.proximity({{robot_->robotModel().findLink("rail")}, scene::ShapeRef::ofObject(objects->find(id))})
        .result.distance;
  }
};

void expectAt(const geometry_msgs::Pose& pose, double x, double y, double z) {
  EXPECT_NEAR(pose.position.x, x, 1e-12);
  EXPECT_NEAR(pose.position.y, y, 1e-12);
  EXPECT_NEAR(pose.position.z, z, 1e-12);
}

TEST_F(ObjectsOfASlider, TellsWhatIsThere) {
  EXPECT_EQ(apply({addBall("b", at(0.0, 0.0, 1.0)), addBall("a")}), 1u);
  const ObjectList list = store_.list();
  EXPECT_EQ(list.node_start, 7u);
  EXPECT_EQ(list.revision, 1u);
  ASSERT_EQ(list.objects.size(), 2u);
  EXPECT_EQ(list.objects[0].id, "a");
  EXPECT_EQ(list.objects[1].frame, "rail");
  expectAt(list.objects[1].pose, 0.0, 0.0, 1.0);
  ASSERT_EQ(list.objects[1].shapes.size(), 1u);
  EXPECT_EQ(list.objects[1].shapes[0].description, "sphere");
  EXPECT_EQ(list.objects[1].shapes[0].pieces, 1u);
  EXPECT_EQ(in_use_, 1);
}

TEST_F(ObjectsOfASlider, HaveTheShapesOfShapeMsgs) {
  ObjectChange some = change(ObjectChange::ADD, "some");
  some.primitives = {primitive(shape_msgs::SolidPrimitive::BOX, {1.0, 1.0, 0.2})};
  some.primitive_poses = {at(0.0, 0.0, 1.0)};
  ObjectChange cylinder = change(ObjectChange::ADD, "cylinder");
  cylinder.primitives = {primitive(shape_msgs::SolidPrimitive::CYLINDER, {0.4, 3.0})};  // height and radius
  cylinder.pose = at(0.0, 0.0, -1.0);
  ObjectChange cone = change(ObjectChange::ADD, "cone");
  cone.primitives = {primitive(shape_msgs::SolidPrimitive::CONE, {2.0, 0.5})};  // its apex is up
  cone.pose = at(0.0, 0.0, -2.0);
  ObjectChange floor = change(ObjectChange::ADD, "floor");
  floor.planes.resize(1);
  floor.planes[0].coef = {0.0, 0.0, 2.0, 1.0};  // z = -0.5
  ObjectChange mesh = change(ObjectChange::ADD, "mesh");
  mesh.meshes.resize(1);
  for (const auto& corner : {at(1, 0, 0), at(1, 1, 0), at(1, 0, 1)}) mesh.meshes[0].vertices.push_back(corner.position);
  mesh.meshes[0].triangles.resize(1);
  mesh.meshes[0].triangles[0].vertex_indices = {0, 1, 2};
  apply({some, cylinder, cone, floor, mesh});
  EXPECT_NEAR(distanceToRail("some"), 0.8, 1e-9);
  EXPECT_NEAR(distanceToRail("cylinder"), 0.7, 1e-9);
  EXPECT_NEAR(distanceToRail("cone"), 0.9, 1e-9);
  EXPECT_NEAR(distanceToRail("floor"), 0.4, 1e-9);
  EXPECT_NEAR(distanceToRail("mesh"), 0.9, 1e-9);
}

TEST_F(ObjectsOfASlider, StandWhereTheFrameOfTheHeaderPutsThem) {
  ObjectChange seen = addBall("seen", at(0.0, 0.0, 1.0));
  seen.header.frame_id = "camera";
  ObjectChange below_finger = addBall("below", at(0.0, 0.0, -3.0));
  below_finger.header.frame_id = "/finger";
  apply({seen, below_finger});
  EXPECT_EQ(info("seen").frame, "rail");
  expectAt(info("seen").pose, 0.0, 5.0, 1.0);
  expectAt(info("below").pose, 2.0, 0.0, -2.0);
}

TEST_F(ObjectsOfASlider, MoveWithTheirFrame) {
  ObjectChange part = addBall("part", at(0.0, 5.0, 1.0));
  part.frame = "camera";
  apply({part});
  EXPECT_EQ(info("part").frame, "camera");
  expectAt(info("part").pose, 0.0, 0.0, 1.0);
  tf_["camera"] = {0.0, 0.0, 2.0};
  EXPECT_NEAR(distanceToRail("part"), 2.8, 1e-9);
}

TEST_F(ObjectsOfASlider, AreHeldWhereTheyAreAndPutDownWhereTheyAre) {
  apply({addBall("bar", at(3.0, 0.0, 0.0)), attach("bar", "hand")});
  EXPECT_EQ(info("bar").link, "hand");
  expectAt(info("bar").pose, 1.0, 0.0, 0.0);
  EXPECT_NEAR(distanceToRail("bar", 5.0), 5.8, 1e-9);
  tf_["hand"] = {4.0, 0.0, 0.0};
  apply({change(ObjectChange::DETACH, "bar")});
  EXPECT_EQ(info("bar").link, "");
  expectAt(info("bar").pose, 5.0, 0.0, 0.0);
}

TEST_F(ObjectsOfASlider, PassFromLinkToLink) {
  ObjectChange bar = addBall("bar");
  bar.header.frame_id = bar.link = "hand";
  bar.touch_links = {"rail"};
  apply({bar});
  EXPECT_EQ(info("bar").touch_links, std::vector<std::string>{"rail"});
  apply({attach("bar", "finger")});
  EXPECT_EQ(info("bar").link, "finger");
  EXPECT_TRUE(info("bar").touch_links.empty());
  expectAt(info("bar").pose, 0.0, 0.0, -1.0);
}

TEST_F(ObjectsOfASlider, GetMoreShapesWhereTheAppendedObjectWouldStand) {
  apply({addBall("bar", at(3.0, 0.0, 0.0))});
  ObjectChange more = addBall("bar", at(1.0, 0.0, 0.0));
  more.operation = ObjectChange::APPEND;
  apply({more});
  expectAt(info("bar").pose, 3.0, 0.0, 0.0);
  EXPECT_EQ(info("bar").shapes.size(), 2u);
  EXPECT_NEAR(distanceToRail("bar"), 0.8, 1e-9);
}

TEST_F(ObjectsOfASlider, MoveAsAWholeAndShapeByShape) {
  apply({addBall("bar", at(3.0, 0.0, 0.0))});
  ObjectChange moved = moveTo("bar", at(4.0, 0.0, 0.0));
  apply({moved});
  EXPECT_NEAR(distanceToRail("bar"), 3.8, 1e-9);
  moved.primitive_poses = {at(0.0, 3.0, 0.0)};
  apply({moved});
  EXPECT_NEAR(distanceToRail("bar"), 4.8, 1e-9);
}

TEST_F(ObjectsOfASlider, AreReplacedAndRemoved) {
  apply({addBall("a", at(3.0, 0.0, 0.0)), addBall("b")});
  ObjectChange big = addBall("a", at(3.0, 0.0, 0.0));
  big.operation = ObjectChange::REPLACE;
  big.padding = 0.5;
  EXPECT_EQ(apply({big}), 2u);
  EXPECT_NEAR(distanceToRail("a"), 2.3, 1e-9);
  EXPECT_EQ(apply({change(ObjectChange::REMOVE, "a")}), 3u);
  EXPECT_EQ(apply({change(ObjectChange::REMOVE, "a")}), 3u) << "it was not there: nothing changed";
  EXPECT_EQ(apply({change(ObjectChange::REMOVE, "*")}), 4u);
  EXPECT_TRUE(store_.list().objects.empty());
}

TEST_F(ObjectsOfASlider, MayTouchWhatTheRulesAllow) {
  ObjectChanges message = messageOf({addBall("bar")});
  message.set_rules = true;
  message.rules.resize(2);
  message.rules[0].a = "bar";
  message.rules[0].b = "*";
  message.rules[0].allowed = true;
  message.rules[1].a = "hand";
  message.rules[1].b = "bar";
  store_.apply(message);
  const auto objects = robot_->objects().get().all;
  EXPECT_EQ(objects->reason(robot_->robotModel().findLink("hand"), scene::ShapeRef::ofObject(0)),
            scene::PairReason::Checked);
  EXPECT_EQ(objects->pairCount(), 1);
  EXPECT_EQ(store_.list().rules.size(), 2u);
}

TEST_F(ObjectsOfASlider, ReadMeshFilesBelowAllowedRootsOnly) {
  Config config;
  config.allowed_mesh_roots = {"/usr/share"};
  const auto robot = std::make_shared<const Robot>(kSlider, "", config);
  ObjectStore store(robot, 1, {});
  ObjectChange mesh = change(ObjectChange::ADD, "mesh");
  mesh.mesh_files.resize(1);
  mesh.mesh_files[0].uri = "file:///etc/hostname";
  const std::string error = errorOf([&] { store.apply(messageOf({mesh})); });
  EXPECT_PRED2(holds, error, "/etc/hostname");
  EXPECT_PRED2(holds, error, "\"mesh\"");
}

TEST_F(ObjectsOfASlider, FollowAReloadedRobot) {
  apply({addBall("bar"), attach("bar", "hand"), addBall("box")});
  const auto loaded = std::make_shared<const Robot>(kSlider, "", Config());
  bool replaced = false;
  store_.follow(loaded, [&] { replaced = true; });
  EXPECT_TRUE(replaced);
  EXPECT_EQ(loaded->objects().get().all->size(), 2);
  EXPECT_EQ(loaded->objects().get().revision, 1u);
}

TEST_F(ObjectsOfASlider, RefuseARobotWithoutTheirLink) {
  apply({addBall("bar"), attach("bar", "hand")});
  const auto other = std::make_shared<const Robot>(urdfOf(link("rail")), "", Config());
  EXPECT_THROW(store_.follow(other, [] { ADD_FAILURE(); }), std::invalid_argument);
  EXPECT_EQ(apply({addBall("box")}), 2u) << "the robot of before stays";
}

// --- from the start

/// A store with what a file or the parameter says.
class ObjectsFromTheStart : public ObjectsOfASlider {
 protected:
  static scene::ObjectFile file(const std::string& yaml) {
    return scene::objectFileFrom(scene::readYaml(yaml, "cell.yaml"), "cell.yaml");
  }
  static Eigen::Isometry3d noTf(const Robot&, const std::string& frame) {
    throw std::invalid_argument("tf is asked for '" + frame + "'");
  }
  ObjectStore begin(const std::shared_ptr<const Robot>& robot, const std::string& yaml) {
    return ObjectStore(
        robot, 7, noTf, [](const Robot&) {}, {}, file(yaml));
  }
  std::string refusalOf(const std::string& yaml) {
    const std::string error = errorOf([&] { begin(robot_, yaml); });
    EXPECT_NE(error, "") << "nothing was refused";
    EXPECT_TRUE(robot_->objects().get().all->empty());
    return error;
  }
};

const char* const kCell = R"(
objects:
- id: table
  pose: {position: [0, 0, 1]}
  padding: 0.01
  primitives: [{type: SPHERE, dimensions: [0.1]}]
- id: bar
  link: hand
  touch_links: [rail]
  pose: {position: [0, 1, 0]}
  primitives: [{type: SPHERE, dimensions: [0.1]}]
- id: part
  frame: camera
  primitives: [{type: SPHERE, dimensions: [0.1]}]
rules: [{a: table, b: hand, allowed: true}]
)";

TEST_F(ObjectsFromTheStart, AreThereBeforeAnyChangeAndWithoutTf) {
  const ObjectStore store = begin(robot_, kCell);
  const ObjectList list = store.list();
  EXPECT_EQ(list.revision, 0u);
  ASSERT_EQ(list.objects.size(), 3u);
  EXPECT_EQ(list.objects[0].link, "hand");
  EXPECT_EQ(list.objects[0].touch_links, std::vector<std::string>{"rail"});
  expectAt(list.objects[0].pose, 0.0, 1.0, 0.0);
  EXPECT_EQ(list.objects[1].frame, "camera");
  EXPECT_EQ(list.objects[2].frame, "rail");
  EXPECT_EQ(list.objects[2].padding, 0.01);
  ASSERT_EQ(list.rules.size(), 1u);
  const auto objects = robot_->objects().get().all;
  EXPECT_EQ(objects->reason(robot_->robotModel().findLink("hand"), scene::ShapeRef::ofObject(objects->find("table"))),
            scene::PairReason::Allowed);
  EXPECT_EQ(objects->reason(robot_->robotModel().findLink("hand"), scene::ShapeRef::ofObject(objects->find("part"))),
            scene::PairReason::Checked);
}

TEST_F(ObjectsFromTheStart, ChangeAsAllOthersDo) {
  ObjectStore store = begin(robot_, kCell);
  EXPECT_EQ(store.apply(messageOf({change(ObjectChange::REMOVE, "table")})), 1u);
  EXPECT_EQ(store.list().objects.size(), 2u);
  EXPECT_EQ(store.list().rules.size(), 1u);
}

TEST_F(ObjectsFromTheStart, AreThoseOfTheSnapshotOfAnotherStart) {
  const ObjectStore first = begin(robot_, kCell);
  const auto again = std::make_shared<const Robot>(kSlider, "", Config());
  const ObjectStore second = begin(again, scene::yamlOf(first.snapshot().file));
  const auto listed = [](const ObjectStore& store) {
    ObjectList list = store.list();
    for (ObjectInfo& object : list.objects)
      for (ShapeInfo& shape : object.shapes)
        shape.volume_ratio = 0.0;  // NaN of a primitive, which is not equal to itself
    return list;
  };
  const ObjectList before = listed(first), after = listed(second);
  ASSERT_EQ(after.objects.size(), 3u);
  for (std::size_t i = 0; i < before.objects.size(); ++i) EXPECT_EQ(after.objects[i], before.objects[i]);
  EXPECT_EQ(after.rules, before.rules);
}

// The reference frame may be another one at the next start.
TEST_F(ObjectsFromTheStart, OfASnapshotStandInAFrameWithAName) {
  const ObjectStore first = begin(robot_, kCell);
  Config config;
  config.reference_frame = "hand";
  const auto from_the_hand = std::make_shared<const Robot>(kSlider, "", config);
  const ObjectStore second = begin(from_the_hand, scene::yamlOf(first.snapshot().file));
  EXPECT_EQ(second.list().objects[2].id, "table");
  EXPECT_EQ(second.list().objects[2].frame, "rail");
}

TEST_F(ObjectsFromTheStart, AreRefusedWithTheirPlaceIdFieldAndReason) {
  const std::string ball = "primitives: [{type: SPHERE, dimensions: [0.1]}]";
  EXPECT_EQ(refusalOf("- {id: a, " + ball + "}\n- {id: a, " + ball + "}"),
            "cell.yaml, line 2: [1] \"a\": object \"a\": id: there is an object with this id already");
  EXPECT_EQ(refusalOf("- {id: hand, " + ball + "}"),
            "cell.yaml, line 1: [0] \"hand\": object \"hand\": id: a link has this name");
  EXPECT_EQ(refusalOf("- {id: a, link: hund, " + ball + "}"),
            "cell.yaml, line 1: [0] \"a\": object \"a\": link: there is no link \"hund\" (did you mean \"hand\"?)");
  EXPECT_EQ(
      refusalOf("- {id: a, link: hand, touch_links: [ral], " + ball + "}"),
      "cell.yaml, line 1: [0] \"a\": object \"a\": touch_links: there is no link \"ral\" (did you mean \"rail\"?)");
  EXPECT_EQ(refusalOf("- {id: a, link: hand, planes: [{coef: [0, 0, 1, 0]}]}"),
            "cell.yaml, line 1: [0] \"a\": object \"a\": link: an object with a plane cannot be attached");
  EXPECT_EQ(refusalOf("- {id: a, pose: {position: [2e6, 0, 0]}, " + ball + "}"),
            "cell.yaml, line 1: [0] \"a\": object \"a\": pose: it is farther than 1e6 m from its frame, or not finite");
  const std::string no_file = refusalOf("- {id: a, mesh_files: [{uri: 'file:///nowhere/a.stl'}]}");
  EXPECT_NE(no_file.find("cell.yaml, line 1: [0] \"a\": object \"a\": "), std::string::npos) << no_file;
  EXPECT_NE(no_file.find("/nowhere/a.stl"), std::string::npos) << no_file;
}

TEST_F(ObjectsFromTheStart, DoNotChangeAtARowOrTime) {
  EXPECT_EQ(refusalOf("changes: [{at: {row: 1}, operation: REMOVE, id: a}]"),
            "cell.yaml, line 1: changes[0] \"a\": only the tool clearance makes changes at a row or time");
}

TEST_F(ObjectsFromTheStart, LieWithinTheMeshRoots) {
  Config config;
  config.allowed_mesh_roots = {"/usr"};
  robot_ = std::make_shared<const Robot>(kSlider, "", config);
  const std::string reason = refusalOf("- {id: a, mesh_files: [{uri: 'file:///etc/hostname'}]}");
  EXPECT_NE(reason.find("cell.yaml, line 1: [0] \"a\": object \"a\": "), std::string::npos) << reason;
  EXPECT_NE(reason.find("/etc/hostname"), std::string::npos) << reason;
}

TEST_F(ObjectsOfASlider, AnIdIsATextInUtf8) {
  EXPECT_NE(refusal({addBall("\xff")}).find("id: it is no text in UTF-8"), std::string::npos);
  tf_["\xff"] = {0.0, 0.0, 0.0};
  EXPECT_NE(refusal({addBallInFrame("a", "\xff")}).find("frame: it is no text in UTF-8"), std::string::npos);
  EXPECT_NE(refusal({change(ObjectChange::REMOVE, "\xff")}).find("id: it is no text in UTF-8"), std::string::npos);
}

// Regression: such a rule was taken, and then no change could be written into objects_file any more.
TEST_F(ObjectsOfASlider, ANameInARuleIsATextInUtf8) {
  ObjectChanges changes;
  changes.set_rules = true;
  changes.rules.resize(1);
  changes.rules[0].a = "table";
  changes.rules[0].b = "\xff";
  EXPECT_EQ(errorOf([&] { store_.apply(changes); }), "rules[0]: it is no text in UTF-8");
}

// Two objects that no link holds are checked if one of them moves, and if that is asked for.
TEST_F(ObjectsOfASlider, FreeObjectsAreCheckedIfTheConfigurationAsksForIt) {
  const auto reasonWith = [](scene::ObjectRules::FreeObjects free_objects) {
    Config config;
    config.free_objects = free_objects;
    const auto robot = std::make_shared<const Robot>(kSlider, "", config);
    ObjectStore store(robot, 7, [](const Robot&, const std::string&) { return Eigen::Isometry3d::Identity(); });
    ObjectChanges changes = messageOf({addBall("table"), addBallInFrame("cart", "camera")});
    changes.set_rules = true;  // must not forget what the configuration asks for
    store.apply(changes);
    const auto objects = robot->objects().get().all;
    return objects->reason(scene::ShapeRef::ofObject(objects->find("table")),
                           scene::ShapeRef::ofObject(objects->find("cart")));
  };
  EXPECT_EQ(reasonWith(scene::ObjectRules::FreeObjects::NotChecked), scene::PairReason::FreeObjects);
  EXPECT_EQ(reasonWith(scene::ObjectRules::FreeObjects::Checked), scene::PairReason::Checked);
}

// --- many boxes

ObjectChange addBoxes(const std::string& id, const std::vector<double>& x, const std::vector<double>& edges) {
  ObjectChange result = change(ObjectChange::ADD, id);
  result.boxes.resize(1);
  for (const double each : x) result.boxes[0].centres.emplace_back().x = each;
  for (const double edge : edges) {
    geometry_msgs::Vector3& size = result.boxes[0].sizes.emplace_back();
    size.x = size.y = size.z = edge;
  }
  return result;
}

TEST_F(ObjectsOfASlider, ManyBoxesAreOneShape) {
  apply({addBoxes("map", {1.0, 2.0, 3.0}, {0.2})});
  EXPECT_NEAR(distanceToRail("map"), 0.8, 1e-9);
  ASSERT_EQ(info("map").shapes.size(), 1u);
  EXPECT_EQ(info("map").shapes[0].pieces, 3u);
}

TEST_F(ObjectsOfASlider, BoxesMayHaveASizeEach) {
  apply({addBoxes("map", {1.0, 3.0}, {0.2, 4.0})});
  EXPECT_NEAR(distanceToRail("map"), 0.8, 1e-9);
  apply({addBoxes("larger", {1.0, 3.0}, {0.2, 4.4})});
  EXPECT_NEAR(distanceToRail("larger"), 0.7, 1e-9);
}

TEST_F(ObjectsOfASlider, BoxesMoveWithTheirPoses) {
  ObjectChange boxes = addBoxes("map", {1.0}, {0.2});
  boxes.boxes_poses = {at(1.0, 0.0, 0.0)};
  apply({boxes});
  EXPECT_NEAR(distanceToRail("map"), 1.8, 1e-9);
  ObjectChange farther = change(ObjectChange::MOVE, "map");
  farther.boxes_poses = {at(2.0, 0.0, 0.0)};
  apply({farther});
  EXPECT_NEAR(distanceToRail("map"), 2.8, 1e-9);
}

// --- bounds

TEST_F(ObjectsOfASlider, NamesAreOfBoundedLengthAndTheirErrorsToo) {
  const std::string id(50000000, 'x');
  ApplyObjectsRequest request = requestOf({addBall(id)});
  const std::string error = answer(store_, request).status.message;
  EXPECT_PRED2(holds, error, "id: it has 50000000 characters, more than 1024");
  EXPECT_LT(error.size(), 700u);
  ObjectChange framed = addBall("part");
  framed.frame = id;
  EXPECT_PRED2(holds, refusal({framed}), "frame: it has 50000000 characters");
}

std::string refusalOf(ObjectStore& store, const ObjectChanges& changes) {
  return errorOf([&] { store.apply(changes); });
}

TEST_F(ObjectsOfASlider, AllObjectsTogetherAreBounded) {
  ObjectLimits limits;
  limits.objects = 3;
  limits.pieces = 10;
  ObjectStore store(
      robot_, 7, nullptr, [](const Robot&) {}, limits);
  store.apply(messageOf({addBall("a"), addBall("b")}));
  EXPECT_PRED2(holds, refusalOf(store, messageOf({addBall("c"), addBall("d")})),
               "there would be 4 ids of all objects together");
  EXPECT_PRED2(holds, refusalOf(store, messageOf({addBoxes("map", {1, 2, 3, 4, 5, 6, 7, 8, 9}, {0.2})})),
               "there would be 11 convex pieces");
  EXPECT_EQ(store.list().objects.size(), 2u);
  store.apply(messageOf({change(ObjectChange::REMOVE, "a"), addBall("c"), addBall("d")}));
  EXPECT_EQ(store.list().objects.size(), 3u);
}

TEST_F(ObjectsOfASlider, FramesOfAllObjectsTogetherAreBounded) {
  ObjectLimits limits;
  limits.frames = 2;
  ObjectStore store(
      robot_, 7, nullptr, [](const Robot&) {}, limits);
  store.apply(messageOf({addBallInFrame("a", "camera"), addBallInFrame("b", "camera"), addBallInFrame("c", "belt")}));
  EXPECT_PRED2(holds, refusalOf(store, messageOf({addBallInFrame("d", "cart")})),
               "there would be 3 tf frames of all objects together, more than 2");
  EXPECT_EQ(store.list().objects.size(), 3u);
  store.apply(messageOf({change(ObjectChange::REMOVE, "c"), addBallInFrame("d", "cart")}));
  EXPECT_EQ(store.list().objects.size(), 3u);
}

ObjectChange tetrahedron(const std::string& id) {
  ObjectChange add = change(ObjectChange::ADD, id);
  add.meshes.resize(1);
  for (const auto& corner : {at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)})
    add.meshes[0].vertices.push_back(corner.position);
  add.meshes[0].triangles.resize(4);
  for (std::uint32_t i = 0; i < 4; ++i)
    for (std::uint32_t k = 0; k < 3; ++k) add.meshes[0].triangles[i].vertex_indices[k] = (i + k) % 4;
  return add;
}

// Before, all changes waited while the mesh of one was decomposed.
TEST_F(ObjectsOfASlider, MeshesAreMadeBeforeItIsTheTurnOfTheirChange) {
  ObjectChange placed = tetrahedron("mesh");
  placed.pose = at(3.0, 0.0, 0.0);
  const ObjectChanges message = messageOf({addBall("ball"), placed});
  ReadChanges read = readChanges(*robot_, message);
  ASSERT_EQ(read.edits.size(), 2u);
  EXPECT_FALSE(read.edits[0].geometry) << "only that of the mesh";
  const auto made = read.edits[1].geometry;
  ASSERT_TRUE(made);
  const scene::Objects none(robot_->sharedModel());
  ChangeFrames frames(*robot_);
  const scene::ObjectOptions options;
  scene::ObjectEditor objects(none, frames, options);
  node::apply(read, objects);
  const scene::Object& object = *objects.find("mesh");
  EXPECT_EQ(object.id, "mesh");
  EXPECT_EQ(object.geometry, made);
  EXPECT_EQ(std::get<scene::Fixed>(object.placement).world_T_object.translation().x(), 3.0);
}

TEST_F(ObjectsOfASlider, AMeshThatCannotBeMadeIsRefusedAtItsTurn) {
  ObjectChange broken = tetrahedron("mesh");
  broken.meshes[0].triangles[2].vertex_indices[0] = 9;
  EXPECT_PRED2(holds, refusal({addBall("ball"), broken}),
               "changes[1]: object \"mesh\": meshes[0]: triangles[2] names vertex 9");
}

TEST_F(ObjectsOfASlider, TheTrianglesOfAllMeshesAreBoundedUntilTheyAreRemoved) {
  ObjectLimits limits;
  limits.triangles = 5;
  ObjectStore store(
      robot_, 7, nullptr, [](const Robot&) {}, limits);
  for (int round = 0; round < 3; ++round) {
    store.apply(messageOf({tetrahedron("a")}));
    EXPECT_PRED2(holds, refusalOf(store, messageOf({tetrahedron("b")})),
                 "there would be 8 triangles of all objects together");
    store.apply(messageOf({change(ObjectChange::REMOVE, "a")}));
  }
}

// --- several messages in one change

class MessagesTogether : public ObjectsOfASlider {
 protected:
  /// The reasons of those that are refused.
  std::vector<std::string> applyTogether(const std::vector<ObjectChanges>& messages) {
    std::vector<const ObjectChanges*> pointers;
    for (const ObjectChanges& message : messages) pointers.push_back(&message);
    std::vector<std::string> reasons;
    store_.applyTogether(pointers, [&](const std::exception& error) { reasons.emplace_back(error.what()); });
    return reasons;
  }
};

TEST_F(MessagesTogether, AreOneChangeInTheirOrder) {
  const ObjectChange moved = moveTo("part", at(0.0, 1.0, 0.0));
  EXPECT_EQ(applyTogether({messageOf({addBall("part")}), messageOf({moved}), messageOf({addBall("other")})}),
            std::vector<std::string>());
  EXPECT_EQ(in_use_, 1);
  EXPECT_NEAR(distanceToRail("part"), 0.8, 1e-9);
}

TEST_F(MessagesTogether, AreEachAppliedWholeOrLeftOut) {
  apply({addBall("kept", at(0.0, 1.0, 0.0)), addBall("gone")});
  const ObjectChange moved = moveTo("kept", at(0.0, 2.0, 0.0));
  const auto reasons = applyTogether({
      messageOf({addBall("first"), change(ObjectChange::REMOVE, "gone")}),
      messageOf({moved, change(ObjectChange::REMOVE, "*"), addBall("second"), change(ObjectChange::MOVE, "missing")}),
      messageOf({addBall("third")}),
      messageOf({addBall("third")}),
  });
  ASSERT_EQ(reasons.size(), 2u);
  EXPECT_PRED2(holds, reasons[0], "changes[3]: object \"missing\"");
  EXPECT_PRED2(holds, reasons[1], "\"third\": id: there is an object with this id already");
  std::vector<std::string> ids;
  for (const ObjectInfo& object : store_.list().objects) ids.push_back(object.id);
  EXPECT_EQ(ids, (std::vector<std::string>{"first", "kept", "third"}));
  EXPECT_NEAR(distanceToRail("kept"), 0.8, 1e-9) << "the MOVE was in the message that is left out";
}

TEST_F(MessagesTogether, AreTriedOneByOneIfTheirObjectsCannotBeTogether) {
  ObjectChange far = change(ObjectChange::ADD, "far");  // beyond 1e6 m from its frame, as only the scene finds
  far.primitives = {primitive(shape_msgs::SolidPrimitive::SPHERE, {10.0})};
  far.frame = far.header.frame_id = "camera";
  far.pose = at(999999.0, 0.0, 0.0);
  const auto reasons = applyTogether({messageOf({addBall("part")}), messageOf({far}), messageOf({addBall("other")})});
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_PRED2(holds, reasons[0], "\"far\"");
  EXPECT_EQ(store_.list().objects.size(), 2u);
}

TEST_F(MessagesTogether, WaitOnceForAFrameThatHasNoPose) {
  int asked = 0;
  ObjectStore store(robot_, 7, [&](const Robot&, const std::string& frame) -> Eigen::Isometry3d {
    ++asked;
    throw ChangeError(proximity_server::QueryStatus::TF_UNAVAILABLE, "frame '" + frame + "' has no pose");
  });
  ObjectChange unplaced = addBall("part");
  unplaced.header.frame_id = "missing";
  const ObjectChanges message = messageOf({unplaced});
  int refused = 0;
  store.applyTogether({&message, &message, &message}, [&](const std::exception&) { ++refused; });
  EXPECT_EQ(refused, 3);
  EXPECT_EQ(asked, 1);
}

}  // namespace proximity_server::node::object_store_test
