// A shape that lies wholly inside a closed mesh is in collision: on paper, against a winding number, and with skipping.
#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "sanitized.h"
#include "scene/query/cell.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace proximity_server::scene::solid_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

void expectIdentity(const SignedDistance& result) {
  EXPECT_TRUE(result.has_points);
  EXPECT_NEAR(result.normal.norm(), 1.0, 1e-12);
  EXPECT_TRUE(result.point_b.isApprox(result.point_a + result.distance * result.normal, 1e-12));
  EXPECT_LE(result.lower_bound, result.distance);
  EXPECT_GE(result.upper_bound, result.distance);
}

// --- on paper

TEST(Solid, HoldsABallByItsDepthAndTheWayOut) {
  Meshes meshes;
  Cell cell({meshes.of(bracket()), ball("0.1")});
  cell.put({at(5, 0, 0), at(5.5, 0.5, 0.4)});
  const PairProximity pair = cell.between(cell.link("0"), cell.link("1"));
  EXPECT_EQ(pair.representation, Representation::Triangles);
  EXPECT_EQ(pair.result.status, Status::Converged);
  EXPECT_NEAR(pair.result.distance, -0.5, 1e-12);
  EXPECT_TRUE(pair.result.normal.isApprox(-Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(pair.result.point_a.isApprox(Vector3d(5.5, 0.5, 0.0), 1e-12));
  EXPECT_TRUE(pair.depth_is_lower_bound);
  EXPECT_EQ(pair.collision_a, 1);
  EXPECT_EQ(pair.collision_b, 1);
  expectIdentity(pair.result);
  const PairProximity other = cell.between(cell.link("1"), cell.link("0"));
  EXPECT_EQ(other.result.distance, pair.result.distance);
  EXPECT_TRUE(other.result.normal.isApprox(Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(other.result.point_b.isApprox(Vector3d(5.5, 0.5, 0.0), 1e-12));
  expectIdentity(other.result);
}

TEST(Solid, HoldsWhatIsTheFirstOfThePair) {
  Meshes meshes;
  Cell cell({ball("0.1"), meshes.of(bracket())});
  cell.put({turned(0.3, {1, 2, 3}, {5.5, 0.5, 0.4}), at(5, 0, 0)});
  const PairProximity pair = cell.between(cell.link("0"), cell.link("1"));
  EXPECT_NEAR(pair.result.distance, -0.5, 1e-12);
  EXPECT_TRUE(pair.result.normal.isApprox(Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(pair.result.point_b.isApprox(Vector3d(5.5, 0.5, 0.0), 1e-12));
  expectIdentity(pair.result);
}

TEST(Solid, AddsTheInnerRadiusOfABoxAndThePaddings) {
  Meshes meshes;
  ModelOptions options;
  options.link_padding = {{"0", 0.02}, {"1", 0.03}};
  Cell cell({meshes.of(bracket()), box("0.4 0.2 0.3")}, 0.0, options);
  cell.put({at(0, 0, 0), at(0.5, 0.5, 0.4)});
  // The ball in the box has a radius of 0.1; the paddings move both surfaces outwards.
  const PairProximity pair = cell.between(cell.link("0"), cell.link("1"));
  EXPECT_NEAR(pair.result.distance, -(0.4 + 0.1 + 0.05), 1e-12);
  EXPECT_TRUE(pair.result.point_a.isApprox(Vector3d(0.5, 0.5, -0.02), 1e-12));
  expectIdentity(pair.result);
}

TEST(Solid, IsNotInItsCavity) {
  Meshes meshes;
  Cell cell({meshes.of(thickShell()), ball("0.1")});
  cell.put({at(0, 0, 0), at(0.1, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, 0.3, 1e-12);
  cell.put({at(0, 0, 0), at(1.1, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, -0.5, 1e-12);
  cell.put({at(0, 0, 0), at(1.8, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, 0.2, 1e-12);
}

TEST(Solid, BeginsAgainWithinACavity) {
  Meshes meshes;
  const TriangleMesh core = boxMesh(Vector3d::Constant(-0.25), Vector3d::Constant(0.5));
  const TriangleMesh hole = boxMesh({0.125, -0.125, -0.125}, {-0.25, 0.25, 0.25});
  Cell cell({meshes.of(together({thickShell(), core, hole})), ball("0.01")});
  const std::map<double, double> distance_at = {
      {0.0, 0.115}, {0.1875, -0.0725}, {0.375, 0.115}, {1.0, -0.51}, {1.6, 0.09}};
  for (const auto& [x, distance] : distance_at) {
    cell.put({at(0, 0, 0), at(x, 0, 0)});
    EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, distance, 1e-12) << x;
  }
}

TEST(Solid, IsNoneWhereTheMeshIsOpen) {
  TriangleMesh open = bracket();
  open.triangles.pop_back();
  Meshes meshes;
  Cell cell({meshes.of(open), ball("0.1")});
  cell.put({at(0, 0, 0), at(0.5, 0.5, 0.4)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, 0.3, 1e-12);
  ASSERT_EQ(cell.robot().warnings.size(), 1u);
  const std::string& warning = cell.robot().warnings.front();
  EXPECT_NE(warning.find("link \"0\", <collision> 1: mesh file://"), std::string::npos) << warning;
  EXPECT_NE(warning.find(": it is not a closed surface; what lies inside and touches none of its convex pieces counts "
                         "as apart."),
            std::string::npos)
      << warning;
}

TEST(Solid, IsEachClosedPartOfAMeshWithOpenOnes) {
  TriangleMesh open = bracket();
  open.triangles.pop_back();
  for (Vector3d& vertex : open.vertices) vertex.x() += 10.0;
  Meshes meshes;
  Cell cell({meshes.of(together({bracket(), open})), ball("0.1")});
  cell.put({at(0, 0, 0), at(0.5, 0.5, 0.4)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, -0.5, 1e-12);
  cell.put({at(0, 0, 0), at(10.5, 0.5, 0.4)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.link("1")).result.distance, 0.3, 1e-12);
  ASSERT_EQ(cell.robot().warnings.size(), 1u);
  EXPECT_NE(cell.robot().warnings.front().find("1 of its 2 parts are not closed"), std::string::npos);
}

TEST(Solid, HoldsAMeshAndOneOfSeveralParts) {
  Meshes meshes;
  const TriangleMesh small = scaled(bracket(), 0.1);
  TriangleMesh far = small;
  for (Vector3d& vertex : far.vertices) vertex.x() += 7.0;
  Cell cell({meshes.of(bracket()), meshes.of(together({far, small}))});
  cell.put({at(0, 0, 0), at(0.4, 0.4, 0.5)});
  // The first triangle of the small part lies at z = 0.5, between 0.4 and 0.6 along x and y.
  const PairProximity pair = cell.between(cell.link("0"), cell.link("1"));
  EXPECT_LE(pair.result.distance, -0.4);
  EXPECT_GE(pair.result.distance, -0.5);
}

TEST(Solid, CountsWithoutDepthToo) {
  Meshes meshes;
  Cell cell({meshes.of(bracket()), ball("0.1")});
  cell.put({at(0, 0, 0), at(0.5, 0.5, 0.4)});
  Question question;
  question.depth = Question::Depth::NotWanted;
  const PairProximity* closest = cell.scene().minimum(cell.scene().candidates(), question);
  ASSERT_NE(closest, nullptr);
  EXPECT_LE(closest->result.upper_bound, 0.0);
  question.threshold = 0.1;
  EXPECT_NE(cell.scene().first(cell.scene().candidates(), question), nullptr);
  EXPECT_EQ(cell.scene().closestBelow(cell.scene().candidates(), 5, question).count, 1);
}

TEST(Solid, DoesNotConvergeWhereWhatItLeavesOutMayBeDeeper) {
  Meshes meshes;
  Cell cell({meshes.of(dentedBall()), meshes.of(scaled(dentedBall(), 0.125))});
  cell.put({at(0, 0, 0), at(0, 0, 0)});
  Question question;
  question.depth = Question::Depth::NotWanted;
  const SignedDistance found = cell.between(cell.link("0"), cell.link("1"), question).result;
  EXPECT_LT(found.upper_bound, 0.0);
  EXPECT_GT(found.upper_bound - found.lower_bound, question.tolerance) << "or nothing was left out";
  EXPECT_EQ(found.status, Status::Threshold);
}

TEST(Solid, IsFoundByItsCollisionElementAsByItsLink) {
  Meshes meshes;
  Cell cell({box("0.1 0.1 0.1", "0 0 9") + meshes.of(bracket(), "0 0 1"), ball("0.1")});
  cell.put({at(0, 0, 0), at(0.5, 0.5, 1.4)});
  EXPECT_NEAR(cell.between({cell.link("0").link(), 2}, cell.link("1")).result.distance, -0.5, 1e-12);
  EXPECT_EQ(cell.between(cell.link("0"), cell.link("1")).collision_a, 2);
  EXPECT_GT(cell.between({cell.link("0").link(), 1}, cell.link("1")).result.distance, 7.0);
}

// --- objects

TEST(SolidObject, HoldsALinkAndALinkHoldsAnObject) {
  Meshes meshes;
  Cell cell({ball("0.1"), meshes.of(bracket())});
  cell.change({add("bracket", {{bracket()}}, Fixed{at(0, 0, 0)}),
               add("ball", {{Shape(Sphere{0.1})}}, Moving{"cart", at(0.5, 0.5, 0.3)})});
  cell.put({at(0.5, 0.5, 0.4), at(20, 0, 0)}, {at(20, 0, 0)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("bracket")).result.distance, -0.5, 1e-12);
  EXPECT_NEAR(cell.between(cell.object("bracket"), cell.link("0")).result.distance, -0.5, 1e-12);
  EXPECT_NEAR(cell.between(cell.link("1"), cell.object("ball")).result.distance, -0.4, 1e-12);
  EXPECT_EQ(cell.scene()
                .below(cell.scene().candidates(),
                       [] {
                         Question question;
                         question.threshold = 0.0;
                         return question;
                       }())
                .size(),
            2u);
}

TEST(SolidObject, HoldsSomeOfManyBoxes) {
  Meshes meshes;
  Cell cell({meshes.of(bracket())});
  Boxes boxes;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) boxes.boxes.emplace_back(Vector3d(i, j, 0.4), Vector3d(i + 0.1, j + 0.1, 0.5));
  cell.change({add("boxes", {{boxes}}, Fixed{at(-9.55, -9.55, 0)})});
  cell.put({at(0, 0, 0)});
  // Boxes stand about (0.5, 0.5), (1.5, 0.5), (0.5, 1.5) with their centres at z = 0.45.
  const PairProximity pair = cell.between(cell.link("0"), cell.object("boxes"));
  EXPECT_NEAR(pair.result.distance, -0.5, 1e-12);
  cell.put({at(0, 0, 2)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("boxes")).result.distance, 1.5, 1e-12);
}

TEST(SolidObject, MeetsAHalfSpaceAsItsSurfaceDoes) {
  Meshes meshes;
  Cell cell({meshes.of(bracket())});
  cell.change({add("floor", {{HalfSpace{{0, 0, 1}, 0.0}}, {Shape(Sphere{0.1}), at(0.5, 0.5, 20.5)}}, Fixed{})});
  cell.put({at(0, 0, 0.25)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("floor")).result.distance, 0.25, 1e-12);
  cell.put({at(0, 0, -3)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("floor")).result.distance, -3.0, 1e-12);
  cell.put({at(0, 0, 20)});
  EXPECT_NEAR(cell.between(cell.link("0"), cell.object("floor")).result.distance, -0.6, 1e-12);
}

TEST(SolidObject, WarnsOfAMeshThatIsOpen) {
  TriangleMesh open = bracket();
  open.triangles.pop_back();
  const AddObject opened = add("cover", {{open}, {open, at(2, 0, 0)}}, Fixed{}),
                  closed = add("bracket", {{bracket()}}, Fixed{});
  EXPECT_EQ(warningsOf(closed.object).size(), 0u);
  ASSERT_EQ(warningsOf(opened.object).size(), 1u) << "once for both shapes";
  EXPECT_EQ(
      warningsOf(opened.object).front().find("object \"cover\": mesh of 19 triangles: it is not a closed surface"), 0u);
}

// --- against the oracle

#ifdef PROXIMITY_SANITIZED
constexpr int kPoses = 100;
#else
constexpr int kPoses = 1500;
#endif

struct Body {
  const char* name;
  TriangleMesh mesh;
  double tolerance;
};

class SolidOfMesh : public testing::TestWithParam<Body> {};

/// A ball has the distance of its centre from the solid, less its radius; hulls may lie outside by the tolerance.
TEST_P(SolidOfMesh, HasTheDistanceOfTheOracleFromBalls) {
  const Body& body = GetParam();
  Meshes meshes;
  Cell cell({ball("0.02"), meshes.of(body.mesh)}, body.tolerance);
  const Eigen::AlignedBox3d box = boxAround(body.mesh);
  Chance chance(17);
  int wholly_inside = 0, in_contact = 0, apart = 0;
  for (int i = 0; i < kPoses; ++i) {
    const Isometry3d solid = chance.pose(1.0);
    const Vector3d p = box.center() + box.sizes().cwiseProduct(chance.pose(0.7).translation());
    cell.put({at(0, 0, 0) * Eigen::Translation3d(solid * p), solid});
    const double expected = distanceFromSolid(body.mesh, p) - 0.02;
    const PairProximity pair = cell.between(cell.link("0"), cell.link("1"));
    EXPECT_LE(pair.result.distance, expected + 1e-9) << p.transpose();
    EXPECT_GE(pair.result.distance, expected - body.tolerance - 1e-9) << p.transpose();
    EXPECT_LE(pair.result.lower_bound, expected + 1e-12);
    expectIdentity(pair.result);
    (expected < -0.04 ? wholly_inside : expected < 0.0 ? in_contact : apart) += 1;
  }
  EXPECT_GT(wholly_inside, kPoses / 20);
  EXPECT_GT(apart, kPoses / 10);
}

/// Two solids of which a point of one lies in the other are in collision, whichever holds which.
TEST_P(SolidOfMesh, IsInCollisionWithASolidThatSharesAPoint) {
  const Body& body = GetParam();
  if (kIsSanitized && body.tolerance > 0.0)
    GTEST_SKIP() << "a sanitized run decomposes the mesh once, in the test above";
  Meshes meshes;
  const double size = boxAround(body.mesh).diagonal().norm();
  const TriangleMesh small = scaled(dentedBall(), 0.25 * size);
  Cell cell({meshes.of(small), meshes.of(body.mesh)}, body.tolerance);
  Chance chance(23);
  int found = 0;
  for (int i = 0; i < kPoses; ++i) {
    const Isometry3d solid = chance.pose(1.0), other = solid * chance.pose(0.3 * size);
    const Vector3d shared = other * (0.1 * boxAround(small).diagonal().norm() * chance.direction());
    if (distanceFromSolid(body.mesh, solid.inverse() * shared) > -1e-6) continue;
    if (distanceFromSolid(small, other.inverse() * shared) > -1e-6) continue;
    ++found;
    cell.put({other, solid});
    EXPECT_LT(cell.between(cell.link("0"), cell.link("1")).result.distance, 0.0);
  }
  EXPECT_GT(found, kPoses / 20);
}

INSTANTIATE_TEST_SUITE_P(Meshes, SolidOfMesh,
                         testing::Values(Body{"BracketAsTriangles", bracket(), 0.0},
                                         Body{"ShellAsTriangles", thickShell(), 0.0},
                                         Body{"DentedBallAsTriangles", dentedBall(), 0.0},
                                         Body{"DentedBallDecomposed", dentedBall(), 0.005}),
                         [](const auto& test) { return test.param.name; });

TEST(SolidOfHulls, IsNotInThePiecesOfTheDentedBall) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitized run decomposes the mesh once, in a test above";
  // Otherwise the tests above would prove nothing about decompositions.
  MeshOptions within_5_mm;
  within_5_mm.tolerance = 0.005;
  const MeshPieces pieces = convexPieces(dentedBall(), within_5_mm);
  EXPECT_EQ(pieces.representation, Representation::Decomposed);
  const Shape speck = Sphere{1e-3};
  for (const ConvexHull& hull : pieces.hulls)
    EXPECT_GT(signedDistance(speck, hull, Isometry3d::Identity()).distance, 0.01);
  EXPECT_NE(pieces.interior, nullptr);
}

}  // namespace proximity_server::scene::solid_test
