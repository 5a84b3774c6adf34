#include "scene/pieces/rooms.h"

#include "proximity_server/scene/pieces/convex_pieces.h"
#include "sanitized.h"
#include "scene/pieces/boxes.h"
#include "scene/pieces/interior.h"
#include "scene/pieces/mesh_deviation.h"
#include "scene/pieces/mesh_parts.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace proximity_server::scene::rooms_test {

using Eigen::Vector3d;
using narrowphase::ConvexHull;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ConvexHull boxHull(const Vector3d& low, const Vector3d& edges) { return ConvexHull(boxMesh(low, edges).vertices); }

const TriangleMesh kOuter = boxMesh(Vector3d::Constant(-1.5), Vector3d::Constant(3.0));
const TriangleMesh kCavity = boxMesh({0.5, -0.5, -0.5}, {-1.0, 1.0, 1.0});

Rooms::Largest largest(const std::vector<TriangleMesh>& parts, const ConvexHull& hull, double known = 0.0,
                       double enough = 0.0) {
  Effort unlimited(kInfinity);
  std::vector<TriangleMesh> components;
  for (const TriangleMesh& part : parts) components.push_back(welded(part));
  return Rooms(components).largestIn(hull, {known, kInfinity, enough, 100000}, unlimited);
}

const ConvexHull kAround = boxHull(Vector3d::Constant(-1.5), Vector3d::Constant(3.0));

TEST(Rooms, HaveTheRadiusOfTheirLargestBall) {
  const Rooms::Largest found = largest({kOuter, kCavity}, kAround);
  EXPECT_NEAR(found.radius, 0.5, 1e-6);
  EXPECT_NEAR(found.at_most, 0.5, 2e-6);
  EXPECT_GE(found.at_most, 0.5);
  EXPECT_EQ(largest({kOuter, kCavity}, boxHull(Vector3d::Constant(0.6), Vector3d::Constant(0.9))).radius, 0.0);
  EXPECT_EQ(largest({}, kAround).radius, 0.0);
}

TEST(Rooms, AreNoneWhereAllPartsFaceTheSameWay) {
  const TriangleMesh inner = boxMesh(Vector3d::Constant(-0.5), Vector3d::Ones());
  const Rooms::Largest found = largest({kOuter, inner}, kAround);
  EXPECT_EQ(found.radius, 0.0);
  EXPECT_LE(found.at_most, kMeshRounding);
}

TEST(Rooms, AreNotLookedForBelowAKnownRadiusOrOneThatIsSmallEnough) {
  EXPECT_EQ(largest({kOuter, kCavity}, kAround, 0.6).radius, 0.6);
  EXPECT_EQ(largest({kOuter, kCavity}, kAround, 0.0, 0.51).at_most, 0.51);
}

TEST(Rooms, EndWhereASolidBeginsInThem) {
  const TriangleMesh core = boxMesh(Vector3d::Constant(-0.4), Vector3d::Constant(0.8));
  // At a corner, as far from the core as from three walls.
  const double radius = 0.1 * std::sqrt(3.0) / (1.0 + std::sqrt(3.0));
  const Rooms::Largest found = largest({kOuter, kCavity, core}, kAround, 0.0, kIsSanitized ? 1.2 * radius : 0.0);
  EXPECT_LE(found.radius, radius + 1e-12);
  EXPECT_GE(found.at_most, radius);
  EXPECT_NEAR(found.radius, radius, kIsSanitized ? radius : 1e-5);
}

TEST(Rooms, AreNoneInTheHullOfWhatIsOpen) {
  TriangleMesh open = kOuter;
  open.triangles.pop_back();
  const Rooms::Largest none = largest({kOuter, kCavity, open}, kAround, 0.0, /*enough=*/0.2);
  EXPECT_EQ(none.radius, 0.0);
  EXPECT_LE(none.at_most, 0.2);
  TriangleMesh sheet{{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}, {{{0, 1, 2}}}};
  EXPECT_NEAR(largest({kOuter, kCavity, sheet}, kAround).radius, 0.5, 1e-6);
}

/// A box of this edge that stands on z, faces outwards or inwards.
TriangleMesh block(double edge, double z, bool faces_outwards) {
  const double x = faces_outwards ? -0.5 * edge : 0.5 * edge;
  return boxMesh({x, -0.5 * edge, z}, {-2.0 * x, edge, edge});
}

// Regression: boxes along a surface were divided until they were as small as the tolerance, and 100,000 did not suffice
// for the hull of a link of a metre. Each was proven to be too large by the time budget.
TEST(Rooms, AreExcludedInFewBoxesAlongALargeSurface) {
  const ConvexHull around = boxHull({-1.001, -1.001, -0.001}, Vector3d::Constant(2.002));
  Effort effort(0.1);  // seconds, as steps
  const Rooms::Largest found =
      Rooms({welded(block(2.0, 0.0, true))}).largestIn(around, {0.0, 1.0, 0.005, 100000}, effort);
  EXPECT_EQ(found.at_most, 0.005);
}

// The hull of the bracket is open to its notch, where no point is farther from a wall than 0.5. Balls around the boxes are
// larger than the boxes and need more than twice this effort.
TEST(Rooms, AreExcludedByTheCornersOfBoxes) {
  const TriangleMesh notched = welded(bracket());
  Effort effort(2e-4);  // seconds, as steps
  EXPECT_EQ(Rooms({notched}).largestIn(ConvexHull(notched.vertices), {0.0, 1.0, 0.5, 100000}, effort).at_most, 0.5);
}

// All that is near the gap between the two blocks faces upwards, and yet no ball in it can grow: the winding number is 1
// below it and -1 above.
TEST(Rooms, AreFoundBetweenFacesThatFaceTheSameWay) {
  const std::vector<TriangleMesh> blocks{block(2.0, -2.0, true), block(2.0, 0.1, false)};
  const Rooms::Largest found = largest(blocks, boxHull({-0.2, -0.2, -0.5}, {0.4, 0.4, 1.0}));
  EXPECT_GT(found.radius, 0.049);
  EXPECT_GE(found.at_most, 0.05);
}

TEST(Rooms, HaveTheirPlaceInTheHull) { EXPECT_LE(largest({kOuter, kCavity}, kAround).centre.norm(), 1e-3); }

// Regression: the plate had one side, so that all below it counted as solid.
TEST(Rooms, AreFoundBehindAFlatOpenPart) {
  for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
    for (const double place : {-5.0, 5.0}) {
      const Vector3d u = 500.0 * Vector3d(way.y(), way.z(), way.x()), v = way.cross(u), p = place * way;
      const TriangleMesh plate{{p - u - v, p + u - v, p + u + v, p - u + v}, {{{0, 1, 2}}, {{0, 2, 3}}}};
      EXPECT_NEAR(largest({kOuter, kCavity, plate}, kAround).radius, 0.5, 1e-6) << p.transpose();
    }
  }
}

// The ball in the middle has radius 0.5; a coarse bound of it is half of the smallest edge of the hull.
TEST(Rooms, HaveACoarseBoundWhereTheEffortIsSpent) {
  for (double seconds = 1e-8; seconds < 1e-3; seconds *= 3.0) {
    Effort little(seconds);
    const Rooms::Largest found =
        Rooms({welded(kOuter), welded(kCavity)}).largestIn(kAround, {0.1, kInfinity, 0.0, 100000}, little);
    EXPECT_GE(found.at_most, 0.5) << seconds;
    EXPECT_LE(found.at_most, 1.6) << seconds;
  }
}

// --- meshes with rooms

/// A sheet in the plane z, from a square hole to a square around it, with half edges; seen from above it faces up, or
/// down.
void addFrame(double hole, double around, double z, bool faces_up, TriangleMesh& mesh) {
  const auto corner = [&](double half, int i) {
    return Vector3d(i == 0 || i == 3 ? -half : half, i < 2 ? -half : half, z);
  };
  for (int i = 0; i < 4; ++i) {
    const int first = static_cast<int>(mesh.vertices.size()), next = (i + 1) % 4;
    for (const Vector3d& p : {corner(around, i), corner(around, next), corner(hole, next), corner(hole, i)})
      mesh.vertices.push_back(p);
    mesh.triangles.push_back({first, first + (faces_up ? 1 : 2), first + (faces_up ? 2 : 1)});
    mesh.triangles.push_back({first, first + (faces_up ? 2 : 3), first + (faces_up ? 3 : 2)});
  }
}

/// A box that faces inwards or outwards, without its side in the plane of the largest z.
TriangleMesh withoutLid(double half, bool faces_inwards) {
  TriangleMesh box = faces_inwards ? boxMesh({half, -half, -half}, {-2 * half, 2 * half, 2 * half})
                                   : boxMesh(Vector3d::Constant(-half), Vector3d::Constant(2 * half));
  const auto isLid = [&](const std::array<int, 3>& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](int v) { return box.vertices[v].z() > 0.0; });
  };
  box.triangles.erase(std::remove_if(box.triangles.begin(), box.triangles.end(), isLid), box.triangles.end());
  return box;
}

/// A room in a box of edge 1, with walls of 0.1 and a square hole of 6 mm in one of them.
TriangleMesh roomWithAHole() {
  TriangleMesh mesh = together({withoutLid(0.5, false), withoutLid(0.4, true)});
  addFrame(0.003, 0.5, 0.5, true, mesh);
  addFrame(0.003, 0.4, 0.4, false, mesh);
  TriangleMesh tunnel = boxMesh({0.003, -0.003, 0.4}, {-0.006, 0.006, 0.1});
  const auto isEnd = [&](const std::array<int, 3>& triangle) {
    const auto z = [&](int corner) { return tunnel.vertices[triangle[corner]].z(); };
    return z(0) == z(1) && z(1) == z(2);
  };
  tunnel.triangles.erase(std::remove_if(tunnel.triangles.begin(), tunnel.triangles.end(), isEnd),
                         tunnel.triangles.end());
  return together({mesh, tunnel});
}

/// The cavity of kOuter and kCavity with one corner moved to that of the outer box: one component.
TriangleMesh roomAtAVertex() {
  TriangleMesh cavity = kCavity;
  for (Vector3d& vertex : cavity.vertices)
    if (vertex == Vector3d::Constant(0.5)) vertex = Vector3d::Constant(1.5);
  return together({kOuter, cavity});
}

/// A cubic room of half edge 0.07 in a box of half edge 0.1; pyramids of 14 mm x 14 mm, 8 mm high, line all its walls.
TriangleMesh roomOfPyramids() {
  constexpr int kCells = 10;
  TriangleMesh mesh = boxMesh(Vector3d::Constant(-0.1), Vector3d::Constant(0.2));
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j) {
          const auto place = [&](double u, double v, double height) {
            Vector3d p;
            p[axis] = side * (0.07 - height);
            p[(axis + 1) % 3] = std::round(2 * u) * 0.007 - 0.07;
            p[(axis + 2) % 3] = std::round(2 * v) * 0.007 - 0.07;
            return p;
          };
          const int first = static_cast<int>(mesh.vertices.size());
          for (const auto& [u, v] : {std::pair(i, j), {i + 1, j}, {i + 1, j + 1}, {i, j + 1}})
            mesh.vertices.push_back(place(u, v, 0.0));
          mesh.vertices.push_back(place(i + 0.5, j + 0.5, 0.008));
          for (int k = 0; k < 4; ++k) {
            const int a = first + k, b = first + (k + 1) % 4;
            mesh.triangles.push_back({side > 0 ? b : a, side > 0 ? a : b, first + 4});
          }
        }
  return mesh;
}

/// Solid between half edges of 0.1 and 0.09, and of 0.06 and 0.04.
TriangleMesh shells() {
  const auto box = [](double half, double sign) {
    return boxMesh({-sign * half, -half, -half}, {sign * 2 * half, 2 * half, 2 * half});
  };
  return together({box(0.1, 1), box(0.09, -1), box(0.06, 1), box(0.04, -1)});
}

MeshOptions within(double tolerance) {
  MeshOptions options;
  options.tolerance = tolerance;
  return options;
}

bool isInAHull(const MeshPieces& pieces, const Vector3d& p) {
  return std::any_of(pieces.hulls.begin(), pieces.hulls.end(), [&](const ConvexHull& hull) {
    return std::all_of(hull.triangles().begin(), hull.triangles().end(), [&](const auto& triangle) {
      const Vector3d &a = hull.vertices()[triangle[0]], &b = hull.vertices()[triangle[1]],
                     &c = hull.vertices()[triangle[2]];
      return hull.dimension() == 3 && (b - a).cross(c - a).dot(p - a) <= 0.0;
    });
  });
}

// Regression: one hull stood for each of these, and some were called exact.
TEST(Rooms, StayOutsideOfThePiecesOfAMesh) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    double radius;     // [m] of the largest ball in the room
    double tolerance;  // [m] smaller than that
  };
  const Case cases[] = {{"with a hole", roomWithAHole(), 0.4, 0.005},
                        {"at a vertex", roomAtAVertex(), 0.5, 0.005},
                        {"of pyramids", roomOfPyramids(), 0.062, 0.005},
                        {"shells", shells(), 0.04, 0.03}};
  for (const Case& room : cases) {
    if (kIsSanitized && room.tolerance < 0.03) continue;  // the finer ones take minutes
    SCOPED_TRACE(room.name);
    const MeshPieces pieces = convexPieces(room.mesh, within(room.tolerance));
    EXPECT_FALSE(isInAHull(pieces, Vector3d::Zero()));
    EXPECT_LE(pieces.deviation, room.tolerance);
    EXPECT_EQ(pieces.openness, "");
    EXPECT_EQ(pieces.shortfall, "");
    const MeshPieces filled = convexPieces(room.mesh, within(1.5 * room.radius));
    EXPECT_EQ(filled.hulls.size(), 1u);
    EXPECT_GE(filled.deviation, room.radius - 1e-6);
    EXPECT_LE(filled.deviation, 1.5 * room.radius);
    EXPECT_EQ(filled.representation, Representation::ConvexHull);
  }
}

/// A box with up to eight rooms, some of which hold a box, or share a corner with the outer one.
struct RandomRooms {
  explicit RandomRooms(std::mt19937& random) {
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const auto is = [&](double share) { return uniform(0.0, 1.0) < share; };
    const double half = std::pow(10.0, uniform(-1.5, 0.5));
    const int cells = is(0.5) ? 1 : 2;
    std::vector<TriangleMesh> parts{boxMesh(Vector3d::Constant(-half), Vector3d::Constant(2.0 * half))};
    for (int i = 0; i < cells * cells * cells; ++i) {
      if (is(0.3)) continue;
      const double edge = 2.0 * half / cells, wall = edge * uniform(0.02, 0.4);
      const Vector3d cell(i % cells, i / cells % cells, i / cells / cells);
      const Vector3d low = (cell * edge).array() - half + wall, size = Vector3d::Constant(edge - 2.0 * wall);
      TriangleMesh room = boxMesh(low + Vector3d(size.x(), 0, 0), {-size.x(), size.y(), size.z()});
      if (i == 0 && is(0.5))
        for (Vector3d& vertex : room.vertices)
          if (vertex.x() == low.x() && vertex.y() == low.y() && vertex.z() == low.z())
            vertex = Vector3d::Constant(-half);
      parts.push_back(room);
      const double gap = uniform(0.05, 0.45);
      if (is(0.3)) parts.push_back(boxMesh(low + gap * size, (1.0 - 2.0 * gap) * size));
      places.push_back(low + 0.5 * size);
      places.push_back(low + 0.02 * size);
    }
    mesh = together(parts);
    const Eigen::Quaterniond turn = Eigen::Quaterniond(Eigen::AngleAxisd(
        is(0.5) ? 0.0 : uniform(0.0, 3.0), Vector3d(uniform(-1, 1), uniform(-1, 1), 1.5).normalized()));
    for (std::vector<Vector3d>* points : {&mesh.vertices, &places})
      for (Vector3d& point : *points) point = turn * point;
  }

  TriangleMesh mesh;
  std::vector<Vector3d> places;  // where rooms are
};

TEST(Rooms, OfRandomMeshesAreFilledNoFartherThanTheDeviationSays) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int filled = 0, empty = 0;
  for (int i = repeats(60); i > 0; --i) {
    const RandomRooms rooms(random);
    const double tolerance = i % 8 == 0 ? 0.0 : std::pow(10.0, 3.0 * unit(random) - 3.0);
    SCOPED_TRACE("round " + std::to_string(i) + ", tolerance " + std::to_string(tolerance));
    const MeshPieces pieces = convexPieces(rooms.mesh, within(tolerance));
    ASSERT_LE(pieces.deviation, std::max(tolerance, kMeshRounding));
    Effort unlimited(kInfinity);
    const std::vector<Triangle> triangles = trianglesOf(rooms.mesh.vertices, rooms.mesh.triangles);
    const MeshSolid solid(triangles, triangles, unlimited);
    const auto check = [&](const Vector3d& p) {
      ASSERT_LE(solid.distance(p), pieces.deviation + 2.0 * kMeshRounding) << p.transpose();
    };
    for (const Vector3d& place : rooms.places) {
      (isInAHull(pieces, place) ? filled : empty) += solid.distance(place) > 2.0 * kMeshRounding;
      if (isInAHull(pieces, place)) check(place);
    }
    for (const ConvexHull& hull : pieces.hulls)
      for (int k = 0; k < 20; ++k) {
        Vector3d sum = Vector3d::Zero();
        double weights = 0.0;
        for (const Vector3d& vertex : hull.vertices()) {
          const double weight = std::pow(unit(random), 4);
          weights += weight;
          sum += weight * vertex;
        }
        check(sum / weights);
      }
  }
  EXPECT_GT(filled, repeats(60) / 2);
  EXPECT_GT(empty, repeats(60) / 2);
}

// Regression: the hull of the outer part stood for both, "exactly".
TEST(Rooms, OfAPartOfItsOwnStayOutsideOfThePieces) {
  for (const double tolerance : {0.0, 0.005, 0.3}) {
    const MeshPieces pieces = convexPieces(thickShell(), within(tolerance));
    for (const double x : {-0.15, 0.0, 0.15}) EXPECT_FALSE(isInAHull(pieces, {x, 0.1, -0.1})) << tolerance;
    EXPECT_LE(pieces.deviation, std::max(tolerance, 1e-6));
    EXPECT_EQ(pieces.openness, "");
  }
  EXPECT_EQ(convexPieces(thickShell(), within(0.6)).hulls.size(), 1u);
}

// --- what belongs to the pieces beside the hulls

TEST(MeshPieces, HaveAnInteriorOnlyWhereHullsMayLeaveSomeEmpty) {
  EXPECT_EQ(convexPieces(kOuter, within(0.0)).interior, nullptr);
  EXPECT_EQ(convexPieces(together({kOuter, boxMesh({2, 0, 0}, {1, 1, 1})}), within(0.0)).interior, nullptr);
  EXPECT_NE(convexPieces(bracket(), within(0.0)).interior, nullptr);
  EXPECT_NE(convexPieces(dentedBall(), within(kIsSanitized ? 0.03 : 0.005)).interior, nullptr);
}

TEST(MeshPieces, HaveARepresentativeForEachPart) {
  TriangleMesh other = bracket();
  for (Vector3d& vertex : other.vertices) vertex.x() += 5.0;
  const MeshPieces pieces = convexPieces(together({bracket(), other}), within(0.0));
  ASSERT_EQ(pieces.is_representative.size(), pieces.hulls.size());
  int left = 0, right = 0;
  for (std::size_t i = 0; i < pieces.hulls.size(); ++i)
    if (pieces.is_representative[i]) (pieces.hulls[i].vertices().front().x() < 3.0 ? left : right) += 1;
  EXPECT_EQ(left, 1);
  EXPECT_EQ(right, 1);
}

TEST(MeshPieces, TellWhatIsOpen) {
  TriangleMesh open = bracket();
  open.triangles.pop_back();
  EXPECT_EQ(convexPieces(open, within(0.0)).openness,
            "it is not a closed surface; what lies inside and touches none of its convex pieces counts as apart");
  EXPECT_EQ(convexPieces(open, within(0.0)).interior, nullptr);
  TriangleMesh lid = kOuter;
  lid.triangles.pop_back();
  EXPECT_EQ(convexPieces(lid, within(3.0)).openness,
            "it is not a closed surface; a convex hull stands for each such part, and is solid");
  TriangleMesh far = open;
  for (Vector3d& vertex : far.vertices) vertex.x() += 5.0;
  EXPECT_EQ(convexPieces(together({open, far}), within(0.0)).openness.find("it is not closed in any of its 2 parts"),
            0u);
  TriangleMesh turned = bracket();  // one triangle faces the other way
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_EQ(convexPieces(turned, within(0.0)).openness.find("it is not a closed surface"), 0u);
  TriangleMesh sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 1}}}};  // closed, but of no volume
  EXPECT_EQ(convexPieces(sheet, within(0.0)).openness.find("it is not a closed surface"), 0u);
}

// The wall of a room is a closed part that faces inwards; without a closed wall around it, nothing tells it from a solid
// that is inside out.
TEST(MeshPieces, OfAHollowWithAHoleInItsOuterWallFillTheRoomAndSaySo) {
  TriangleMesh outer = kOuter;
  outer.triangles.pop_back();
  const MeshPieces pieces = convexPieces(together({outer, kCavity}), within(0.0));
  ASSERT_TRUE(pieces.interior);
  EXPECT_NEAR(pieces.interior->placeOf(Vector3d::Zero()).upper_bound, -0.5, 1e-12) << "in the room";
  EXPECT_GT(pieces.interior->placeOf({1.0, 0.0, 0.0}).upper_bound, 0.0) << "in the outer wall";
  EXPECT_FALSE(isInAHull(pieces, {1.0, 0.0, 0.0}));
  EXPECT_EQ(pieces.openness,
            "1 of its 2 parts are not closed; what lies inside and touches none of its convex pieces counts as apart, "
            "but a room is solid if the wall around it is not closed");
  const MeshPieces whole = convexPieces(together({kOuter, kCavity}), within(0.0));
  EXPECT_FALSE(isInAHull(whole, Vector3d::Zero()));
  ASSERT_TRUE(whole.interior);
  EXPECT_GT(whole.interior->placeOf(Vector3d::Zero()).upper_bound, 0.0);
  const MeshPieces two_solids = convexPieces(together({outer, boxMesh({-0.5, -0.5, -0.5}, {1, 1, 1})}), within(0.0));
  EXPECT_EQ(two_solids.openness.find("room"), std::string::npos) << two_solids.openness;
}

TEST(MeshPieces, OfASolidThatIsInsideOutHaveTheSameInterior) {
  TriangleMesh inside_out = bracket();
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  const MeshPieces pieces = convexPieces(inside_out, within(0.0));
  ASSERT_NE(pieces.interior, nullptr);
  EXPECT_NEAR(pieces.interior->placeOf({0.5, 0.5, 0.4}).upper_bound, -0.4, 1e-12);
  EXPECT_EQ(pieces.openness, "");
}

TEST(MeshPieces, FromTheCacheAreSolidToo) {
  TemporaryFiles files;
  MeshOptions options;
  options.tolerance = 0.0;
  options.cache = files.path("cache");
  const MeshPieces first = convexPieces(bracket(), options), again = convexPieces(bracket(), options);
  ASSERT_NE(again.interior, nullptr);
  EXPECT_EQ(again.is_representative, first.is_representative);
}

}  // namespace proximity_server::scene::rooms_test
