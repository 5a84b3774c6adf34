#include "scene/pieces/cavities.h"

#include <gtest/gtest.h>

#include <limits>

#include "proximity_server/scene/pieces/convex_pieces.h"
#include "scene/pieces/boxes.h"
#include "scene/pieces/interior.h"
#include "scene/solids.h"

namespace proximity_server::scene::cavities_test {

using Eigen::Vector3d;
using narrowphase::ConvexHull;

ConvexHull boxHull(const Vector3d& low, const Vector3d& edges) { return ConvexHull(boxMesh(low, edges).vertices); }

const TriangleMesh kOuter = boxMesh(Vector3d::Constant(-1.5), Vector3d::Constant(3.0));
const TriangleMesh kCavity = boxMesh({0.5, -0.5, -0.5}, {-1.0, 1.0, 1.0});

bool areFilled(const Cavities& cavities, const ConvexHull& hull) {
  Effort unlimited(std::numeric_limits<double>::infinity());
  return cavities.areFilledBy(hull, unlimited);
}

TEST(Cavities, AreFilledByAHullAroundThem) {
  const Cavities cavities({kOuter, kCavity}, 0.1);
  EXPECT_TRUE(areFilled(cavities, boxHull(Vector3d::Constant(-1.5), Vector3d::Constant(3.0))));
  EXPECT_FALSE(areFilled(cavities, boxHull(Vector3d::Constant(0.6), Vector3d::Constant(0.9))));
}

TEST(Cavities, AreNoneWhereAllPartsFaceTheSameWay) {
  const TriangleMesh inner = boxMesh(Vector3d::Constant(-0.5), Vector3d::Ones());
  EXPECT_FALSE(areFilled(Cavities({kOuter, inner}, 0.1), boxHull(Vector3d::Constant(-1.5), Vector3d::Constant(3.0))));
}

TEST(Cavities, AreNoneWhereTheyAreShallowerThanTheTolerance) {
  EXPECT_FALSE(
      areFilled(Cavities({kOuter, kCavity}, 0.51), boxHull(Vector3d::Constant(-1.5), Vector3d::Constant(3.0))));
}

TEST(Cavities, EndWhereASolidBeginsInThem) {
  const TriangleMesh core = boxMesh(Vector3d::Constant(-0.49), Vector3d::Constant(0.98));
  const Cavities cavities({kOuter, kCavity, core}, 0.1);
  EXPECT_FALSE(areFilled(cavities, boxHull(Vector3d::Constant(-1.5), Vector3d::Constant(3.0))));
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

// Regression: the hull of the outer part stood for both, "exactly".
TEST(Cavities, StayOutsideOfThePiecesOfAMesh) {
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
  EXPECT_NE(convexPieces(dentedBall(), within(0.005)).interior, nullptr);
}

TEST(MeshPieces, HaveAnAnchorForEachPart) {
  TriangleMesh other = bracket();
  for (Vector3d& vertex : other.vertices) vertex.x() += 5.0;
  const MeshPieces pieces = convexPieces(together({bracket(), other}), within(0.0));
  ASSERT_EQ(pieces.is_anchor.size(), pieces.hulls.size());
  int left = 0, right = 0;
  for (std::size_t i = 0; i < pieces.hulls.size(); ++i)
    if (pieces.is_anchor[i]) (pieces.hulls[i].vertices().front().x() < 3.0 ? left : right) += 1;
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
  EXPECT_EQ(again.is_anchor, first.is_anchor);
}

}  // namespace proximity_server::scene::cavities_test
