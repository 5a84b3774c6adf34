// Distances of objects: on paper, and against the same geometry elsewhere.
#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/files.h"
#include "scene/posed_scene.h"
#include "scene/query/cell.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace proximity_server::scene::object_scene_test {

using namespace narrowphase;

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

const HalfSpace kFloor{{0, 0, 2}, 0.0};  // all below z = 0

// --- placement

TEST(FixedObject, StandsInTheWorld) {
  Cell cell({ball("1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(5, 0, 0)})});
  cell.put({at(1, 0, 0)});
  const PairProximity pair = cell.between(cell.link("0"), cell.object("box"));
  EXPECT_NEAR(pair.result.distance, 2.0, 1e-12);
  EXPECT_TRUE(pair.result.point_a.isApprox(Vector3d(2, 0, 0), 1e-12));
  EXPECT_TRUE(pair.result.point_b.isApprox(Vector3d(4, 0, 0), 1e-12));
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 2.0, 1e-12);
}

TEST(FixedObject, IsFoundInEitherOrder) {
  Cell cell({ball("1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(5, 0, 0)})});
  cell.put({at(1, 0, 0)});
  const PairProximity pair = cell.between(cell.object("box"), cell.link("0"));
  EXPECT_NEAR(pair.result.distance, 2.0, 1e-12);
  EXPECT_TRUE(pair.result.normal.isApprox(Vector3d(-1, 0, 0), 1e-12));
  EXPECT_TRUE(pair.result.point_a.isApprox(Vector3d(4, 0, 0), 1e-12));
}

TEST(FixedObject, IsWhereItWasMovedToAtOnce) {
  Cell cell({ball("1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(5, 0, 0)})});
  cell.put({at(1, 0, 0)});
  cell.move("box", Fixed{at(8, 0, 0)});
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 5.0, 1e-12);
}

TEST(MovingObject, MovesWithItsFrame) {
  Cell cell({ball("1")});
  cell.change({add("cart", {{Shape(Box{{2, 2, 2}})}}, Moving{"cart_frame", at(0, 0, 3)})});
  cell.put({at(0, 0, 0)}, {turned(M_PI / 2, Vector3d::UnitY(), {2, 0, 0})});  // the cart is at (5, 0, 0)
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("cart")).result.distance, 3.0, 1e-12);
}

TEST(MovingObject, IsUnknownWithoutItsFrame) {
  Cell cell({ball("1"), ball("1")});
  cell.change({add("cart", {{Shape(Sphere{1})}}, Moving{"cart_frame"})});
  cell.put({at(0, 0, 0), at(9, 0, 0)}, {std::nullopt});
  EXPECT_EQ(cell.between(cell.link("0"), cell.object("cart")).result.status, Status::Unknown);
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 7.0, 1e-12);
  EXPECT_EQ(cell.scene().counts().total, 3);
  EXPECT_EQ(cell.scene().counts().unknown, 2);
  long unknown = 0;
  for (const PairProximity& pair : cell.scene().all(cell.scene().candidates()))
    unknown += pair.result.status == Status::Unknown;
  EXPECT_EQ(unknown, 2);
  cell.scene().update(posesOf(cell.robot(), {at(0, 0, 0), at(9, 0, 0)}));  // without frames
  EXPECT_EQ(cell.between(cell.link("0"), cell.object("cart")).result.status, Status::Unknown);
  EXPECT_EQ(errorOf([&] { cell.put({at(0, 0, 0), at(9, 0, 0)}); }), "the objects have 1 frames, but there are 0 poses");
}

TEST(MovingObject, HasNoPoseInAnotherFrameUntilTheNextUpdate) {
  Cell cell({ball("1")});
  cell.change({add("cart", {{Shape(Sphere{1})}}, Moving{"first"})});
  cell.put({at(0, 0, 0)}, {at(5, 0, 0)});
  cell.move("cart", Moving{"first", at(1, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("cart")).result.distance, 4.0, 1e-12);
  cell.move("cart", Moving{"second"});
  EXPECT_EQ(cell.between(cell.link("0"), cell.object("cart")).result.status, Status::Unknown);
  cell.put({at(0, 0, 0)}, {at(7, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("cart")).result.distance, 5.0, 1e-12);
}

TEST(AttachedObject, MovesWithItsLinkAndIsNotComparedWithIt) {
  Cell cell({ball("0.1"), ball("1")});
  cell.change({add("bar", {{Shape(Box{{6, 0.2, 0.2}})}}, Attached{"0"})});
  cell.put({at(0, 0, 0), at(0, 5, 0)});
  const PairProximity* pair = cell.scene().minimum(Pairs(cell.scene().candidates(), PairKind::WithObject));
  EXPECT_NEAR(pair->result.distance, 3.9, 1e-12);
  EXPECT_EQ(cell.scene().counts().total, 1);
  cell.put({turned(M_PI / 2, Vector3d::UnitZ()), at(0, 5, 0)});
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 1.0, 1e-12);
}

TEST(AttachedObject, MayHangOnALinkWithoutGeometry) {
  Cell cell({"", ball("1")});
  cell.change({add("bar", {{Shape(Sphere{1})}}, Attached{"0"})});
  cell.put({at(5, 0, 0), at(0, 0, 0)});
  EXPECT_NEAR(cell.between(cell.object("bar"), cell.link("1")).result.distance, 3.0, 1e-12);
}

TEST(AttachedObject, IsComparedWithAFixedOneAndWithThatOfAnotherLink) {
  Cell cell({ball("0.1"), ball("0.1")});
  cell.change({add("left", {{Shape(Sphere{0.5})}}, Attached{"0", {"1"}, at(0, 0, 1)}),
               add("right", {{Shape(Sphere{0.5})}}, Attached{"1", {"0"}, at(0, 0, 1)}),
               add("table", {{Shape(Box{{100, 100, 2}})}}, Fixed{at(0, 0, -2)})});
  cell.put({at(0, 0, 3), at(7, 0, 8)});
  EXPECT_NEAR(cell.between(cell.object("left"), cell.object("table")).result.distance, 4.5, 1e-12);
  EXPECT_NEAR(cell.between(cell.object("left"), cell.object("right")).result.distance, std::sqrt(74.0) - 1.0, 1e-12);
  cell.scene().all(Pairs(cell.scene().candidates(), PairKind::WithObject));
  EXPECT_EQ(cell.scene().counts().total, 5);  // links and table, objects and table, objects
}

// An attached object answers as a link of the same geometry does, far from the origin of the poses too.
TEST(AttachedObject, AnswersAsALinkOfTheSameGeometry) {
  const std::string boxes = box("0.1 0.2 0.3", "0.1 0 0") + cylinder("0.1", "0.4", "0 0.3 0");
  const std::vector<std::string> links{ball("0.1"), box("0.3 0.2 0.1") + ball("0.1", "0.2 0 0")};
  const auto welded = modelOf(urdfOf(link("frame") + link("0", links[0]) + link("1", links[1]) + link("tool", boxes) +
                                     joint("a", "floating", "frame", "0") + joint("b", "floating", "frame", "1") +
                                     joint("hold", "fixed", "0", "tool", origin("0.2 -0.1 0.4", "0.3 0.2 0.1"))));
  PosedScene expected(welded);
  Cell cell(links);
  const Link& tool = welded->robot.links[welded->robot.findLink("tool")];
  cell.change({add("tool", {{Shape(Box{{0.1, 0.2, 0.3}}), at(0.1, 0, 0)}, {Shape(Cylinder{0.1, 0.4}), at(0, 0.3, 0)}},
                   Attached{"0", {}, tool.body_T_link})});
  Chance chance(4);
  long overlaps = 0;
  for (int state = 0; state < 2000; ++state) {
    const Isometry3d base = at(state % 2 ? 0.0 : 1e5, 0, 0);
    const std::vector<Isometry3d> poses{base * chance.pose(0.5), base * chance.pose(0.5)};
    expected.update(posesOf(welded->robot, poses));
    cell.put(poses);
    const PairProximity here = cell.between(cell.object("tool"), cell.link("1"));
    const PairProximity there = expected.proximity({{welded->robot.findLink("tool")}, {welded->robot.findLink("1")}});
    ASSERT_NEAR(here.result.distance, there.result.distance, 1e-12);
    ASSERT_EQ(here.collision_a, there.collision_a);
    ASSERT_EQ(here.collision_b, there.collision_b);
    ASSERT_NEAR(here.result.lower_bound, there.result.lower_bound, 1e-12);
    ASSERT_EQ(here.depth_is_lower_bound, there.depth_is_lower_bound);
    overlaps += here.result.distance < 0.0;
  }
  EXPECT_GT(overlaps, 100);
  EXPECT_LT(overlaps, 1900);
}

// --- shapes

TEST(AnObjectOfSeveralShapes, TellsWhichIsClosest) {
  Cell cell({ball("1")});
  const Eigen::AlignedBox3d near{Vector3d(3, -1, -1), Vector3d(4, 1, 1)}, far{Vector3d(9, -1, -1), Vector3d(9.5, 1, 1)};
  cell.change(
      {add("things", {{Shape(Sphere{1}), at(-9, 0, 0)}, {Boxes{{far, near}}}, {kFloor, at(0, 0, -5)}}, Fixed{})});
  cell.put({at(0, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("things")).result.distance, 2.0, 1e-12);
  EXPECT_EQ(cell.between(cell.link("0"), cell.object("things")).collision_b, 2);
  cell.put({at(-6, 0, 0)});
  EXPECT_NEAR(cell.between(cell.object("things"), cell.link("0")).result.distance, 1.0, 1e-12);
  EXPECT_EQ(cell.between(cell.object("things"), cell.link("0")).collision_a, 1);
  cell.put({at(-3, 0, -3.5)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("things")).result.distance, 0.5, 1e-12);
  EXPECT_EQ(cell.between(cell.link("0"), cell.object("things")).collision_b, 3);
}

TEST(PaddingOfAnObject, IsTakenOffTheDistance) {
  Cell cell({ball("1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(5, 0, 0)}, 0.25),
               add("floor", {{kFloor}}, Fixed{at(0, 0, -7)}, 0.5)});
  cell.put({at(0, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("box")).result.distance, 2.75, 1e-12);
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("floor")).result.distance, 5.5, 1e-12);
}

TEST(AMesh, BecomesPiecesAsThatOfALinkDoes) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  Cell cell({ball("1")});
  cell.change({add("tetrahedron", {{mesh}}, Fixed{at(3, 0, 0)})});
  cell.put({at(0, 0, 0)});
  const PairProximity pair = cell.between(cell.link("0"), cell.object("tetrahedron"));
  EXPECT_NEAR(pair.result.distance, 2.0, 1e-12);
  EXPECT_EQ(pair.representation, Representation::Exact);
}

TEST(AMeshFile, IsReadThroughTheResolver) {
  const TemporaryFiles files;
  const std::string path = files.write("plate.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ObjectOptions options;
  options.resolve = packageResolver({});
  Cell cell({ball("1")});
  cell.change({AddObject{makeObject("plate", {{MeshFile{path, {2, 2, 2}}}}, Fixed{at(-1, -1, 4)}, options)}});
  cell.put({at(-1, -1, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("plate")).result.distance, 3.0, 1e-12);
  EXPECT_NE(errorOf([&] {
              makeObject("plate", {{MeshFile{files.path("none.stl")}}}, Fixed{}, options);
            }).find("object \"plate\": shape 1: "),
            std::string::npos);
}

// --- half-spaces

TEST(AHalfSpace, IsAsFarAsTheLowestPoint) {
  Cell cell({ball("0.5"), box("2 2 2"), cylinder("1", "4")});
  cell.change({add("floor", {{kFloor}}, Fixed{at(7, 8, 1)})});
  cell.put(
      {at(0, 0, 5), turned(M_PI / 4, Vector3d::UnitX(), {3, 3, 4}), turned(M_PI / 6, Vector3d::UnitX(), {0, 0, 6})});
  const PairProximity of_ball = cell.between(cell.link("0"), cell.object("floor"));
  EXPECT_NEAR(of_ball.result.distance, 3.5, 1e-12);
  EXPECT_TRUE(of_ball.result.normal.isApprox(Vector3d(0, 0, -1), 1e-12));
  EXPECT_TRUE(of_ball.result.point_a.isApprox(Vector3d(0, 0, 4.5), 1e-12));
  EXPECT_TRUE(of_ball.result.point_b.isApprox(Vector3d(0, 0, 1), 1e-12));
  EXPECT_EQ(of_ball.result.status, Status::Converged);
  EXPECT_TRUE(of_ball.result.unique);
  EXPECT_EQ(of_ball.collision_b, 1);
  const PairProximity of_box = cell.between(cell.link("1"), cell.object("floor"));
  EXPECT_NEAR(of_box.result.distance, 3.0 - std::sqrt(2.0), 1e-12);
  EXPECT_FALSE(of_box.result.unique);  // an edge
  EXPECT_NEAR(cell.between(cell.link("2"), cell.object("floor")).result.distance,
              5.0 - (2.0 * std::cos(M_PI / 6) + std::sin(M_PI / 6)), 1e-12);
}

TEST(AHalfSpace, IsAsDeepAsTheLowestPoint) {
  Cell cell({ball("0.5") + box("1 1 1", "0 0 -3")});
  cell.change({add("floor", {{kFloor}}, Fixed{})});
  cell.put({at(0, 0, 0)});
  const PairProximity pair = cell.between(cell.object("floor"), cell.link("0"));
  EXPECT_NEAR(pair.result.distance, -3.5, 1e-12);
  EXPECT_TRUE(pair.result.normal.isApprox(Vector3d(0, 0, 1), 1e-12));
  EXPECT_EQ(pair.collision_b, 2);
  EXPECT_FALSE(pair.depth_is_lower_bound);  // the way out of a plane is the same for all pieces
}

TEST(AHalfSpace, MovesWithItsFrame) {
  Cell cell({ball("1")});
  cell.change({add("wall", {{HalfSpace{{1, 0, 0}, 2.0}}}, Moving{"wall"})});
  cell.put({at(0, 9, 0)}, {turned(M_PI / 2, Vector3d::UnitZ(), {50, 3, 0})});  // all with y <= 5
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 3.0, 1e-12);
}

TEST(AHalfSpace, HasBoundsThatHoldTheTruthAndStatusOfTheTolerance) {
  Cell cell({box("0.3 0.2 0.1") + cylinder("0.1", "0.5", "0.3 0.1 0", "0.4 0.5 0.6")});
  Chance chance(6);
  const Vector3d normal = chance.direction();
  cell.change({add("wall", {{HalfSpace{normal, 0.3}}}, Fixed{})});
  for (int state = 0; state < 2000; ++state) {
    const Isometry3d pose = at(0, state % 3 ? 0.0 : 1e3, 0) * chance.pose(1.0);
    cell.put({pose});
    const SignedDistance result = cell.between(cell.link("0"), cell.object("wall")).result;
    long double truth = std::numeric_limits<long double>::infinity();
    for (const int index : cell.robot().bodies[bodyOf(cell.robot(), "0")].pieces) {
      const Piece& piece = cell.robot().pieces[index];
      const Isometry3d world = pose * piece.body_T_piece;
      long double height = static_cast<long double>(normal.dot(world.translation())) - 0.3L;
      const Vector3d along = world.linear().transpose() * normal;
      const Vector3d half = piece.shape.halfExtents();
      if (piece.shape.kind() == Shape::Kind::Box)
        height -= along.cwiseAbs().dot(half);
      else
        height -= half.z() * std::abs(along.z()) + half.x() * along.head<2>().norm();
      truth = std::min(truth, height);
    }
    ASSERT_NEAR(result.distance, static_cast<double>(truth), 1e-12 * (state % 3 ? 1.0 : 1e3));
    ASSERT_LE(result.lower_bound, static_cast<double>(truth) + 1e-15);
    ASSERT_GE(result.upper_bound, static_cast<double>(truth) - 1e-15);
    ASSERT_EQ(result.status, Status::Converged);
  }
}

// --- against all pieces, one by one

// Regression: it said Converged, as its depth in the first half-space was, with the lower bound of the other.
TEST(AHalfSpace, WithoutDepthSaysThatAnotherMayBeDeeper) {
  Cell cell({ball("1")});
  cell.change({add("corner", {{kFloor}, {HalfSpace{{1, 0, 0}, 0.0}}}, Fixed{})});
  cell.put({at(-3, 0, 0.5)});  // 0.5 deep in the floor, 4 deep in the wall
  Question question;
  question.depth = Question::Depth::NotWanted;
  const PairProximity pair = cell.between(cell.link("0"), cell.object("corner"), question);
  EXPECT_NEAR(pair.result.lower_bound, -4.0, 1e-9);
  EXPECT_NEAR(pair.result.upper_bound, -0.5, 1e-9);
  EXPECT_EQ(pair.result.status, Status::Threshold);
}

TEST(ObjectsInRandomScenes, HaveTheDistanceOfTheirClosestPieces) {
  Chance chance(8);
  long overlaps = 0, apart = 0;
  for (int scene = 0; scene < 300; ++scene) {
    Cell cell({ball("0.2") + box("0.3 0.2 0.1", "0.2 0 0"), cylinder("0.1", "0.5")});
    const std::vector<Isometry3d> links{chance.pose(0.6), chance.pose(0.6)};
    const Isometry3d frame = chance.pose(0.6);
    struct Known {
      std::string id;
      std::vector<std::pair<Shape, Isometry3d>> pieces;  // in the world
      int attached_to;
    };
    std::vector<Known> known;
    std::vector<ObjectChange> changes;
    for (int i = 0; i < 6; ++i) {
      const int kind = i < 2 ? i : chance.below(3);
      const Isometry3d place = chance.pose(0.5);
      Known object{"object " + std::to_string(i), {}, kind == 2 ? i % 2 : -1};
      const Isometry3d world = kind == 0 ? place : (kind == 1 ? frame : links[i % 2]) * place;
      std::vector<ObjectShape> shapes;
      for (int shape = 1 + chance.below(3); shape-- > 0;) {
        const Shape some = shape == 0   ? Shape(Box{{0.2, 0.1, 0.3}})
                           : shape == 1 ? Shape(Sphere{0.15})
                                        : Shape(Cone{0.1, 0.2});
        const Isometry3d pose = chance.pose(0.2);
        shapes.push_back({some, pose});
        object.pieces.emplace_back(some, world * pose);
      }
      Placement placement = Fixed{place};
      if (kind == 1) placement = Moving{"frame", place};
      if (kind == 2) placement = Attached{std::to_string(i % 2), {}, place};
      changes.emplace_back(add(object.id, shapes, placement));
      known.push_back(object);
    }
    cell.change(changes);
    cell.put(links, {frame});
    for (const Known& object : known) {
      for (int link = 0; link < 2; ++link) {
        if (object.attached_to == link) continue;
        double closest = std::numeric_limits<double>::infinity();
        const RobotModel& robot = cell.robot();
        for (const int index : robot.bodies[bodyOf(robot, std::to_string(link))].pieces) {
          const Piece& piece = robot.pieces[index];
          for (const auto& [shape, pose] : object.pieces) {
            const Isometry3d world = links[link] * piece.body_T_piece;
            const SignedDistance truth = signedDistance(piece.shape, shape, world.inverse(Eigen::Isometry) * pose);
            closest = std::min(closest, truth.distance);
          }
        }
        const SignedDistance found =
            cell.between(cell.link(std::to_string(link).c_str()), cell.object(object.id.c_str())).result;
        ASSERT_NEAR(found.distance, closest, 1e-8);
        ASSERT_LE(found.lower_bound, closest + 2e-9);
        ASSERT_GE(found.upper_bound, closest - 2e-9);
        ++(closest < 0.0 ? overlaps : apart);
      }
    }
  }
  EXPECT_GT(overlaps, 150);
  EXPECT_GT(apart, 300);
}

// --- questions

// --- far poses that cancel each other

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

/// The rotation that is nearest to that of a pose.
Matrix3l rotationOf(const Isometry3d& pose) {
  Matrix3l rotation = pose.linear().cast<long double>();
  for (int i = 0; i < 4; ++i)
    rotation = 0.5L * rotation * (3.0L * Matrix3l::Identity() - rotation.transpose() * rotation);
  return rotation;
}
Vector3l inParent(const Isometry3d& pose, const Vector3l& p) {
  return rotationOf(pose) * p + pose.translation().cast<long double>();
}

TEST(FarPosesThatCancel, LeaveBoundsThatHold) {
  Chance chance(5);
  for (int i = 0; i < 200; ++i) {
    const Vector3d far = std::pow(10.0, chance.between(0.0, 5.5)) * chance.direction();
    const Isometry3d object_T_shape = Eigen::Translation3d(far) * chance.pose(0.5);
    const Isometry3d link_T_object = chance.pose(0.5) * object_T_shape.inverse();
    const Isometry3d link = chance.pose(0.3);
    Cell cell({ball("0.125"), ball("0.125")});
    const HalfSpace plane{{0, 0, 1}, -0.5};
    cell.change({add("ball", {{Shape(Sphere{0.125}), object_T_shape}}, Attached{"0", {}, link_T_object}),
                 add("floor", {{plane, object_T_shape}}, Moving{"cart", link_T_object})});
    cell.put({at(0, 0, 0), link}, {at(0, 0, 0)});
    const auto check = [&](const SignedDistance& found, long double distance) {
      EXPECT_LE(found.lower_bound, distance) << i << " at " << far.norm();
      EXPECT_GE(found.upper_bound, distance) << i << " at " << far.norm();
      EXPECT_NEAR(found.upper_bound, found.lower_bound, 1e-12 + 1e-12 * far.norm());
    };
    const Vector3l centre = link.translation().cast<long double>(),
                   of_object = inParent(link_T_object, inParent(object_T_shape, Vector3l::Zero()));
    check(cell.between(cell.link("1"), cell.object("ball")).result, (centre - of_object).norm() - 0.25L);
    const Vector3l up = rotationOf(link_T_object) * rotationOf(object_T_shape) * Vector3l::UnitZ();
    check(cell.between(cell.link("1"), cell.object("floor")).result, up.dot(centre - of_object) + 0.5L - 0.125L);
  }
}

TEST(ASceneWithObjects, RefusesWhatIsNotThere) {
  Cell cell({ball("1")});
  cell.change({add("floor", {{kFloor}}, Fixed{}), add("wall", {{kFloor}}, Fixed{})});
  cell.put({at(0, 0, 5)});
  EXPECT_EQ(errorOf([&] { cell.between(cell.link("0"), ShapeRef::ofObject(7)); }), "there is no object 7");
  EXPECT_EQ(errorOf([&] { cell.between(cell.link("0"), ShapeRef::ofObject(-1)); }), "there is no object -1");
  EXPECT_EQ(errorOf([&] { cell.between(cell.link("0"), cell.object("floor").part(1)); }),
            "a part of an object cannot be asked about");
  EXPECT_EQ(errorOf([&] { cell.between(cell.object("floor"), cell.object("wall")); }),
            "the distance of two half-spaces is not defined");
  const ShapeRef removed = cell.object("wall");
  cell.change({RemoveObject{"wall"}});
  EXPECT_EQ(errorOf([&] { cell.between(cell.link("0"), removed); }), "there is no object 1");
  const auto other = modelOf(floatingLinks({ball("1")}));
  EXPECT_EQ(errorOf([&] { cell.scene().use(std::make_shared<const Objects>(other)); }),
            "the objects are those of another model");
}

TEST(ASceneWithObjects, GivesItsObjectsToThatOfAnotherThread) {
  Cell cell({ball("1")});
  cell.change({add("floor", {{kFloor}}, Fixed{})});
  PosedScene other = cell.scene().forAnotherThread();
  EXPECT_EQ(other.objects(), cell.objects().get());
  other.update(posesOf(cell.robot(), {at(0, 0, 5)}), {});
  EXPECT_NEAR(other.minimum(other.candidates())->result.distance, 4.0, 1e-12);
}

// The objects of one state have numbers that the other does not know.
TEST(ASceneWithObjects, AnswersAboutStatesInTurn) {
  const auto model = modelOf(floatingLinks({ball("1"), ball("1")}));
  std::vector<ObjectChange> boxes;
  for (int i = 0; i < 5; ++i)
    boxes.push_back(add("box" + std::to_string(i), {{Shape(Box{{2, 2, 2}})}}, Fixed{at(0, 3.5 + i, 0)}));
  State few(model), many(model);
  few.set(posesOf(model->robot, {at(0, 0, 0), at(4, 0, 0)}));
  many.set(std::make_shared<const Objects>(Objects(model).changed(boxes)));
  many.set(posesOf(model->robot, {at(0, 0, 0), at(5, 0, 0)}));
  Scene scene(model);
  for (int round = 0; round < 3; ++round)
    for (const State* state : {&many, &few}) {
      Scene fresh(model);
      const auto expected = fresh.closest(*state, fresh.candidates(), 3);
      const auto& found = scene.closest(*state, scene.candidates(), 3);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_TRUE(found[i].asked.isSameAs(expected[i].asked));
        EXPECT_NEAR(found[i].result.distance, expected[i].result.distance, 1e-12);
      }
      EXPECT_EQ(scene.counts().total, fresh.counts().total);
    }
}

TEST(ASceneWithObjects, AnswersAboutEachKindOfPair) {
  Cell cell({ball("1"), ball("1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(0, 9, 0)})});
  cell.put({at(0, 0, 0), at(4, 0, 0)});
  const Candidates& candidates = cell.scene().candidates();
  EXPECT_NEAR(cell.scene().minimum(Pairs(candidates, PairKind::OfLinks))->result.distance, 2.0, 1e-12);
  EXPECT_EQ(cell.scene().counts().total, 1);
  EXPECT_NEAR(cell.scene().minimum(Pairs(candidates, PairKind::WithObject))->result.distance, 7.0, 1e-12);
  EXPECT_EQ(cell.scene().counts().total, 2);
  EXPECT_NEAR(cell.scene().minimum(candidates)->result.distance, 2.0, 1e-12);
  EXPECT_EQ(cell.scene().counts().total, 3);
}

TEST(ASceneWithObjects, IsAsBeforeAfterAnUpdateThatThrows) {
  Cell cell({ball("1")});
  cell.change({add("cart", {{Shape(Sphere{1})}}, Moving{"cart"})});
  cell.put({at(0, 0, 0)}, {at(5, 0, 0)});
  EXPECT_THROW(cell.put({at(9, 0, 0)}, {}), std::invalid_argument);
  EXPECT_THROW(cell.scene().update(BodyPoses(7), {at(7, 0, 0)}), std::invalid_argument);
  EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 3.0, 1e-12);
}

// Under the thread sanitizer this finds what a change shares with the questions that are being answered.
TEST(ASceneWithObjects, IsNotDisturbedByChangesInAnotherThread) {
  Cell cell({ball("1")});
  std::vector<ObjectChange> some;
  for (int i = 0; i < 40; ++i)
    some.emplace_back(add("box " + std::to_string(i), {{Shape(Box{{1, 1, 1}})}}, Fixed{at(5 + i, 0, 0)}));
  cell.change(some);
  cell.put({at(0, 0, 0)});
  const std::shared_ptr<const Objects> shared = cell.objects();
  std::thread changing([&] {
    Objects now = *shared;
    for (int i = 0; i < 200; ++i) {
      const Fixed place{at(2, 0, 0.01 * i)};
      const Object& box = *now.object(now.find("box 0"));
      now = now.changed({add("near " + std::to_string(i), {{Shape(Sphere{1})}}, place),
                         ReplaceObject{{box.id, box.geometry, place}}});
    }
    EXPECT_EQ(now.size(), 240);
  });
  for (int i = 0; i < 200; ++i) {
    cell.put({at(0, 0, 0.01 * (i % 2))});
    EXPECT_NEAR(cell.scene().minimum(cell.scene().candidates())->result.distance, 3.5, 1e-12);
  }
  changing.join();
}

TEST(ASceneWithObjects, ForgetsTheAnswersAboutWhatIsReplacedInItsPlace) {
  Cell cell({ball("1")});
  cell.change({add("thing", {{Shape(Box{{2, 2, 2}})}}, Fixed{at(5, 0, 0)})});
  cell.put({at(0, 0, 0)});
  const auto distance = [&] { return cell.scene().all(cell.scene().candidates()).front().result.distance; };
  EXPECT_NEAR(distance(), 3.0, 1e-12);
  cell.change({ReplaceObject{add("thing", {{Shape(Sphere{0.5})}}, Fixed{at(5, 0, 0)}).object}});
  EXPECT_NEAR(distance(), 3.5, 1e-12);
  cell.change({RemoveObject{"thing"}, add("other", {{Shape(Sphere{2})}}, Fixed{at(5, 0, 0)})});  // in its number
  EXPECT_NEAR(distance(), 2.0, 1e-12);
}

TEST(ASceneWithObjects, KeepsTheAnswersAboutWhatStays) {
  Cell cell({ball("1"), box("1 1 1")});
  cell.change({add("box", {{Shape(Box{{2, 2, 2}})}}, Fixed{turned(0.3, {1, 2, 3}, {5, 3, 1})})});
  cell.put({at(0, 0, 0), at(4, 0, 0)});
  cell.scene().all(cell.scene().candidates());
  cell.change({add("ball", {{Shape(Cone{1, 2})}}, Fixed{at(9, 9, 0)})});
  cell.scene().all(cell.scene().candidates());
  EXPECT_EQ(cell.scene().counts().at_rest, 3);
  EXPECT_EQ(cell.scene().counts().computed, 2);
  cell.change({ReplaceObject{add("box", {{Shape(Cone{1, 2})}}, Fixed{at(5, 3, 1)}).object}});
  cell.scene().all(cell.scene().candidates());
  EXPECT_EQ(cell.scene().counts().at_rest, 3);
  EXPECT_EQ(cell.scene().counts().computed, 2);
}

}  // namespace proximity_server::scene::object_scene_test
