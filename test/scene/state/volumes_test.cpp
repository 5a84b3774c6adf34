#include "scene/state/volumes.h"

#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace proximity_server::scene::volumes_test {

using namespace narrowphase;

using Eigen::Vector3d;
using Leaves = std::vector<int>;  // indices of pieces, sorted

/// The pieces of the leaves below a volume, each as often as it is found.
Leaves leavesOf(const Volumes& volumes, int volume) {
  const Volume& top = volumes[volume];
  if (top.isLeaf()) return {top.piece};
  Leaves leaves;
  if (top.isEmpty()) return leaves;
  for (const int part : top.parts) {
    const Leaves of_part = leavesOf(volumes, part);
    leaves.insert(leaves.end(), of_part.begin(), of_part.end());
  }
  std::sort(leaves.begin(), leaves.end());
  return leaves;
}

int depthOf(const Volumes& volumes, int volume) {
  const Volume& top = volumes[volume];
  if (top.isLeaf() || top.isEmpty()) return 0;
  return 1 + std::max(depthOf(volumes, top.parts[0]), depthOf(volumes, top.parts[1]));
}

Leaves sorted(Leaves pieces) {
  std::sort(pieces.begin(), pieces.end());
  return pieces;
}

/// Balls of radius 0.1 at these places on the x axis.
std::string ballsAt(const std::vector<int>& places) {
  std::string balls;
  for (const int place : places) balls += ball("0.1", std::to_string(place) + " 0 0");
  return balls;
}

std::string mixture(int count) {
  std::string collisions;
  for (int i = 0; i < count; ++i) {
    const std::string place =
        std::to_string(0.7 * (i % 3)) + " " + std::to_string(0.5 * (i % 5)) + " " + std::to_string(0.3 * i);
    if (i % 3 == 0) collisions += box("0.2 0.4 0.1", place, "0.3 0.2 " + std::to_string(i));
    if (i % 3 == 1) collisions += cylinder("0.1", "0.6", place, "0.5 " + std::to_string(i) + " 0");
    if (i % 3 == 2) collisions += ball("0.15", place);
  }
  return collisions;
}

TEST(Volumes, HaveEachPieceOfALinkOnceAsALeaf) {
  for (const int count : {1, 2, 3, 7, 20}) {
    const RobotModel robot = floatingLinks({mixture(count), mixture(2)});
    const Volumes volumes(robot);
    EXPECT_EQ(leavesOf(volumes, robot.findLink("0")), sorted(robot.bodies[bodyOf(robot, "0")].pieces));
    EXPECT_EQ(leavesOf(volumes, robot.findLink("1")), sorted(robot.bodies[bodyOf(robot, "1")].pieces));
  }
}

/// The boxes and spheres of a whole hold the corners of the boxes of primitives below.
void expectHolds(const Volumes& volumes, const Volume& whole, int part) {
  if (!volumes[part].isLeaf()) {
    for (const int below : volumes[part].parts) expectHolds(volumes, whole, below);
    return;
  }
  const Bounds &outer = whole.bounds, &inner = volumes[part].bounds;
  const double slack = 1e-12;
  EXPECT_LE((inner.centre - outer.centre).norm(), outer.radius + slack);
  EXPECT_GE(outer.reach + slack, inner.centre.norm());
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d signs(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vector3d point = inner.centre + inner.axes * signs.cwiseProduct(inner.half);
    const Vector3d from_centre = outer.axes.transpose() * (point - outer.centre);
    EXPECT_LE((point - outer.centre).norm(), outer.radius + slack);
    EXPECT_TRUE((from_centre.cwiseAbs().array() <= outer.half.array() + slack).all());
  }
}

TEST(Volumes, OfAWholeHoldTheBoundsOfItsParts) {
  std::string boxes;  // whose own bounds are exact, so that the corners of these are points of the robot
  for (int i = 0; i < 20; ++i)
    boxes += box("0.2 0.4 0.1", std::to_string(0.7 * (i % 3)) + " " + std::to_string(0.5 * (i % 5)) + " 0.3",
                 "0.3 0.2 " + std::to_string(i));
  const RobotModel robot = floatingLinks({boxes});
  const Volumes volumes(robot);
  std::vector<int> pending{robot.findLink("0")};
  int wholes = 0;
  while (!pending.empty()) {
    const Volume& whole = volumes[pending.back()];
    pending.pop_back();
    if (whole.isLeaf()) continue;
    ++wholes;
    for (const int part : whole.parts) {
      expectHolds(volumes, whole, part);
      pending.push_back(part);
    }
  }
  EXPECT_EQ(wholes, 19);
}

TEST(Volumes, HalveTheirPiecesAlongTheLongestEdge) {
  const RobotModel robot = floatingLinks({ballsAt({3, 0, 2, 1})});
  const Volumes volumes(robot);
  const std::vector<int>& pieces = robot.bodies[bodyOf(robot, "0")].pieces;
  const Volume& whole = volumes[robot.findLink("0")];
  const std::set<Leaves> halves{leavesOf(volumes, whole.parts[0]), leavesOf(volumes, whole.parts[1])};
  EXPECT_EQ(halves, (std::set<Leaves>{sorted({pieces[1], pieces[3]}), sorted({pieces[0], pieces[2]})}));
}

TEST(Volumes, AreAsDeepAsABalancedTreeAlsoWhereAllCentresAreEqual) {
  for (const std::vector<int>& places : {std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7}, std::vector<int>(8, 0)}) {
    const RobotModel robot = floatingLinks({ballsAt(places)});
    EXPECT_EQ(depthOf(Volumes(robot), robot.findLink("0")), 3);
  }
}

TEST(Volumes, PartsBelongToTheBodyOfTheirLink) {
  const RobotModel robot = floatingLinks({ballsAt({0, 1, 2}), ballsAt({0})});
  const Volumes volumes(robot);
  for (const char* name : {"0", "1"}) {
    const ShapeRef link(robot.findLink(name));
    for (const ShapeRef& ref : {link, link.part(1)})
      EXPECT_EQ(volumes.part(ref, nullptr).body, bodyOf(robot, name)) << name << ", <collision> " << ref.collision();
  }
}

TEST(Volumes, OfLinksOfOneBodyAreApart) {
  const RobotModel robot =
      robotOf(urdfOf(link("a", ballsAt({0, 1})) + link("b", ballsAt({5})) + weld("weld", "a", "b")));
  const Volumes volumes(robot);
  EXPECT_EQ(leavesOf(volumes, robot.findLink("a")).size(), 2u);
  EXPECT_EQ(leavesOf(volumes, robot.findLink("b")).size(), 1u);
  EXPECT_EQ(volumes.part(robot.findLink("b")).body, bodyOf(robot, "a"));
}

TEST(Volumes, OfALinkWithoutGeometryAreEmptyAndNoLeaf) {
  const RobotModel robot = floatingLinks({ballsAt({0, 1})});
  const Volumes volumes(robot);
  const Volume& empty = volumes[robot.findLink("frame")];
  EXPECT_TRUE(empty.isEmpty());
  EXPECT_FALSE(empty.isLeaf());
  EXPECT_FALSE(volumes[robot.findLink("0")].isEmpty());
}

TEST(Volumes, HaveAClosedFormForASingleSphereOrCapsule) {
  const std::string capsule = cylinder("0.5", "2") + ball("0.5", "0 0 1") + ball("0.5", "0 0 -1");
  const RobotModel robot =
      floatingLinks({ball("1"), capsule, box("1 1 1"), cylinder("1", "1"), ball("1") + ball("1", "3 0 0")});
  const Volumes volumes(robot);
  const auto has_closed_form = [&](const char* link) { return volumes[robot.findLink(link)].has_closed_form; };
  EXPECT_TRUE(has_closed_form("0"));
  EXPECT_TRUE(has_closed_form("1"));
  EXPECT_FALSE(has_closed_form("2"));
  EXPECT_FALSE(has_closed_form("3"));
  EXPECT_FALSE(has_closed_form("4"));
}

TEST(Volumes, AreAsExactAsTheLeastExactOfTheirPieces) {
  RobotModel robot = floatingLinks({ballsAt({0, 1, 8, 9})});
  robot.collisions[1].representation = Representation::Decomposed;
  robot.collisions[0].representation = Representation::ConvexHull;
  const Volumes volumes(robot);
  const Volume& whole = volumes[robot.findLink("0")];
  EXPECT_EQ(whole.representation, Representation::Decomposed);
  std::set<Representation> of_parts;
  for (const int part : whole.parts) of_parts.insert(volumes[part].representation);
  EXPECT_EQ(of_parts, (std::set<Representation>{Representation::Decomposed, Representation::Exact}));
}

// --- roots

TEST(VolumesOf, AShapeRefAreTheWholeLinkOrItsNthCollision) {
  const RobotModel robot = floatingLinks({ballsAt({0, 1}), ballsAt({0, 1, 2})});
  const Volumes volumes(robot);
  const int link = robot.findLink("1");
  EXPECT_EQ(leavesOf(volumes, volumes.of({link, 0})).size(), 3u);
  for (int number = 1; number <= 3; ++number) {
    const Collision& collision = robot.collisions[robot.links[link].collisions[number - 1]];
    ASSERT_EQ(collision.number, number);
    EXPECT_EQ(leavesOf(volumes, volumes.of({link, number})), collision.pieces);
  }
}

TEST(VolumesOf, AllShapeRefsAreTheFirst) {
  const RobotModel robot = floatingLinks({ballsAt({0, 1}), ballsAt({0, 1, 2})});
  const Volumes volumes(robot);
  std::set<int> found;
  for (int link = 0; link < 3; ++link)
    for (int number = 0; number <= static_cast<int>(robot.links[link].collisions.size()); ++number)
      found.insert(volumes.of({link, number}));
  EXPECT_EQ(volumes.rootCount(), 8);  // three links, five <collision> elements
  EXPECT_EQ(found, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(VolumesOf, WhatDoesNotExistThrowNamingIt) {
  const RobotModel robot = floatingLinks({ballsAt({0, 1})});
  const Volumes volumes(robot);
  const int link = robot.findLink("0");
  EXPECT_EQ(errorOf([&] { volumes.of({-1}); }), "there is no link -1");
  EXPECT_EQ(errorOf([&] { volumes.of({2}); }), "there is no link 2");
  EXPECT_EQ(errorOf([&] { volumes.of({link, 3}); }), "link \"0\" has no <collision> 3");
  EXPECT_EQ(errorOf([&] { volumes.of({link, -1}); }), "link \"0\" has no <collision> -1");
  EXPECT_EQ(errorOf([&] { volumes.of({link, 2}); }), "");
}

}  // namespace proximity_server::scene::volumes_test
