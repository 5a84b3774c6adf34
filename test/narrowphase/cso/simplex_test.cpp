#include "narrowphase/cso/simplex.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"
#include "proximity_server/narrowphase/assertion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace proximity_server::narrowphase::simplex_test {

using Eigen::Vector3d;

const std::vector<Vector3d> kSegment{{0, 0, 0}, {4, 0, 0}};
const std::vector<Vector3d> kTriangle{{0, 0, 0}, {6, 0, 0}, {0, 6, 0}};
const std::vector<Vector3d> kObtuse{{0, 0, 0}, {4, 0, 0}, {-2, 2, 0}};  // 135 degrees at the first vertex
const std::vector<Vector3d> kTetrahedron{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}};

/// A simplex seen from `query`: the origin lies there, and the nearest point of the simplex is `nearest`.
struct Region {
  const char* name;
  const std::vector<Vector3d>& vertices;
  Vector3d query, nearest;
  std::vector<int> members;  ///< of the smallest part that has the nearest point
};

// The query lies over the nearest point along a combination, with positive weights, of the outward normals of the faces
// that meet in the part: on paper the nearest point of a convex set.
const Region kRegions[] = {
    {"segment, first end", kSegment, {-1, 2, 0}, {0, 0, 0}, {0}},
    {"segment, across its first end", kSegment, {0, 3, 0}, {0, 0, 0}, {0}},
    {"segment, second end", kSegment, {5, 0, 1}, {4, 0, 0}, {1}},
    {"segment, inside", kSegment, {1, 0, 2}, {1, 0, 0}, {0, 1}},
    {"triangle, corner 0", kTriangle, {-1, -1, 1}, {0, 0, 0}, {0}},
    {"triangle, corner 1", kTriangle, {8, 1, 1}, {6, 0, 0}, {1}},
    {"triangle, corner 2", kTriangle, {1, 8, -1}, {0, 6, 0}, {2}},
    {"triangle, corner 1, beyond one edge only", kTriangle, {7, -2, 1}, {6, 0, 0}, {1}},
    {"triangle, corner 2, beyond one edge only", kTriangle, {-2, 7, 1}, {0, 6, 0}, {2}},
    {"triangle, edge 01", kTriangle, {2, -1, 3}, {2, 0, 0}, {0, 1}},
    {"triangle, edge 12", kTriangle, {3, 5, 2}, {2, 4, 0}, {1, 2}},
    {"triangle, edge 20", kTriangle, {-2, 3, 1}, {0, 3, 0}, {0, 2}},
    {"triangle, over its face", kTriangle, {1, 2, 4}, {1, 2, 0}, {0, 1, 2}},
    {"triangle, under its face", kTriangle, {1, 2, -4}, {1, 2, 0}, {0, 1, 2}},
    {"obtuse triangle, corner 0", kObtuse, {-1, -2, 0}, {0, 0, 0}, {0}},
    {"obtuse triangle, edge 01 beyond two edges", kObtuse, {1, -2, 0}, {1, 0, 0}, {0, 1}},
    {"obtuse triangle, edge 20 beyond two edges", kObtuse, {-2, 0, 0}, {-1, 1, 0}, {0, 2}},
    {"tetrahedron, corner 0", kTetrahedron, {-1, -2, -3}, {0, 0, 0}, {0}},
    {"tetrahedron, corner 1", kTetrahedron, {5, 1, -1}, {3, 0, 0}, {1}},
    {"tetrahedron, corner 2", kTetrahedron, {-1, 5, 1}, {0, 3, 0}, {2}},
    {"tetrahedron, corner 3", kTetrahedron, {1, -1, 5}, {0, 0, 3}, {3}},
    {"tetrahedron, edge 01", kTetrahedron, {1, -1, -2}, {1, 0, 0}, {0, 1}},
    {"tetrahedron, edge 02", kTetrahedron, {-1, 2, -3}, {0, 2, 0}, {0, 2}},
    {"tetrahedron, edge 03", kTetrahedron, {-2, -1, 1}, {0, 0, 1}, {0, 3}},
    {"tetrahedron, edge 12", kTetrahedron, {3, 4, 1}, {1, 2, 0}, {1, 2}},
    {"tetrahedron, edge 23", kTetrahedron, {-1, 3, 4}, {0, 1, 2}, {2, 3}},
    {"tetrahedron, edge 31", kTetrahedron, {3, 0, 2}, {2, 0, 1}, {1, 3}},
    {"tetrahedron, face 012", kTetrahedron, {1, 0.5, -2}, {1, 0.5, 0}, {0, 1, 2}},
    {"tetrahedron, face 013", kTetrahedron, {1, -1, 0.5}, {1, 0, 0.5}, {0, 1, 3}},
    {"tetrahedron, face 023", kTetrahedron, {-3, 1, 0.5}, {0, 1, 0.5}, {0, 2, 3}},
    {"tetrahedron, face 123", kTetrahedron, {3, 3, 3}, {1, 1, 1}, {1, 2, 3}},
};

/// Returns every way to put `count` vertices into the four places: the place of each vertex.
std::vector<std::vector<int>> placings(std::size_t count) {
  std::vector<std::vector<int>> result;
  std::vector<int> places{0, 1, 2, 3};
  do {
    const std::vector<int> some(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count));
    if (std::find(result.begin(), result.end(), some) == result.end()) result.push_back(some);
  } while (std::next_permutation(places.begin(), places.end()));
  return result;
}

unsigned bitsOf(const std::vector<int>& members, const std::vector<int>& placing) {
  unsigned bits = 0;
  for (const int member : members) bits |= 1u << placing[member];
  return bits;
}

/// The vertices in their places as seen from `query`, all but the newest as members.
Simplex placed(const std::vector<Vector3d>& vertices, const Vector3d& query, const std::vector<int>& placing,
               int newest) {
  Simplex simplex;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    simplex[placing[i]] = vertexAt(vertices[i] - query);
    if (placing[i] != newest) simplex.members |= 1u << placing[i];
  }
  return simplex;
}

// The newest vertex belongs to the nearest part, as in GJK, so every member is tried as the newest.
TEST(NearestToOrigin, FindsTheVoronoiRegionForAllOrdersOfTheVertices) {
  for (const Region& region : kRegions)
    for (const std::vector<int>& placing : placings(region.vertices.size()))
      for (const int member : region.members) {
        SCOPED_TRACE(region.name + (", newest " + std::to_string(member)));
        const int newest = placing[member];
        const Nearest nearest = nearestToOrigin(placed(region.vertices, region.query, placing, newest), newest);
        const double distance = (region.query - region.nearest).norm();
        ASSERT_FALSE(nearest.encloses_origin);
        ASSERT_EQ(nearest.members, bitsOf(region.members, placing));
        ASSERT_NEAR(nearest.distance, distance, 1e-15 * 8.0);
        ASSERT_TRUE(isNear(nearest.normal(), (region.query - region.nearest) / distance, 1e-15));
      }
}

// It has an edge with the newest vertex, so it is among the parts that are tried.
TEST(NearestToOrigin, KeepsAnOldCornerThatStaysTheNearest) {
  for (const Region& region : kRegions) {
    if (region.members.size() != 1 || region.vertices.size() > 3) continue;
    for (const std::vector<int>& placing : placings(region.vertices.size()))
      for (const int newest : placing) {
        const Nearest nearest = nearestToOrigin(placed(region.vertices, region.query, placing, newest), newest);
        ASSERT_EQ(nearest.members, bitsOf(region.members, placing)) << region.name;
        ASSERT_NEAR(nearest.distance, (region.query - region.nearest).norm(), 1e-14) << region.name;
      }
  }
}

TEST(NearestToOrigin, EnclosesAnOriginInsideOfATetrahedronForAllOrders) {
  for (const std::vector<int>& placing : placings(4))
    for (int newest = 0; newest < 4; ++newest)
      EXPECT_TRUE(nearestToOrigin(placed(kTetrahedron, {0.5, 0.5, 0.5}, placing, newest), newest).encloses_origin);
}

TEST(NearestToOrigin, EnclosesAnOriginThatIsNearOneFaceOnly) {
  for (const Vector3d& query :
       {Vector3d(1, 1, 1e-9), Vector3d(1, 1e-9, 1), Vector3d(1e-9, 1, 1), Vector3d(1 - 1e-9, 1 - 1e-9, 1 - 1e-9)})
    for (const std::vector<int>& placing : placings(4))
      EXPECT_TRUE(nearestToOrigin(placed(kTetrahedron, query, placing, placing[3]), placing[3]).encloses_origin);
}

// The face opposite of the newest vertex is none that the origin can lie beyond: it was reduced to it before.
TEST(NearestToOrigin, DoesNotEncloseAnOriginOnAFace) {
  const struct {
    Vector3d query;
    std::vector<int> face;
  } cases[] = {{{1, 1, 0}, {0, 1, 2}}, {{1, 0, 1}, {0, 1, 3}}, {{0, 1, 1}, {0, 2, 3}}, {{1, 1, 1}, {1, 2, 3}}};
  for (const auto& [query, face] : cases)
    for (const std::vector<int>& placing : placings(4))
      for (const int member : face) {
        const int newest = placing[member];
        const Nearest nearest = nearestToOrigin(placed(kTetrahedron, query, placing, newest), newest);
        ASSERT_FALSE(nearest.encloses_origin);
        ASSERT_EQ(nearest.distance, 0.0);
        ASSERT_EQ(nearest.members, bitsOf(face, placing));
      }
}

TEST(NearestToOrigin, GivesADistanceOfZeroAtAVertexAndOnAnEdge) {
  const Nearest at_vertex = nearestToOrigin(placed(kTetrahedron, {0, 3, 0}, {0, 1, 2, 3}, 2), 2);
  EXPECT_EQ(at_vertex.distance, 0.0);
  EXPECT_EQ(at_vertex.members, 0b0100u);
  EXPECT_NEAR(at_vertex.normal().norm(), 1.0, 1e-15);
  const Nearest on_edge = nearestToOrigin(placed(kTetrahedron, {2, 0, 0}, {0, 1, 2, 3}, 1), 1);
  EXPECT_EQ(on_edge.distance, 0.0);
  EXPECT_EQ(on_edge.members, 0b0011u);
}

TEST(NearestToOrigin, ProjectsOntoAFlatTetrahedron) {
  const std::vector<Vector3d> flat{{-1, -2, 2}, {3, -1, 2}, {2, 3, 2}, {-2, 2, 2}};
  for (const std::vector<int>& placing : placings(4)) {
    const Nearest nearest = nearestToOrigin(placed(flat, Vector3d::Zero(), placing, placing[3]), placing[3]);
    EXPECT_FALSE(nearest.encloses_origin);
    EXPECT_EQ(nearest.distance, 2.0);
    EXPECT_TRUE(isNear(nearest.normal(), -Vector3d::UnitZ(), 1e-15));
  }
}

// Products of vertices would be of the size of the squared distance, and the area would drown in their rounding.
TEST(NearestToOrigin, KnowsTheFaceOfASmallTriangleFarAway) {
  const double s = std::ldexp(1.0, -12);  // exact in sums with 1024
  const std::vector<Vector3d> far{{-s, -s, 1024}, {s, -s, 1024}, {0, s, 1024}};
  const Nearest nearest = nearestToOrigin(placed(far, Vector3d::Zero(), {0, 1, 2}, 1), 1);
  EXPECT_EQ(nearest.members, 0b0111u);
  EXPECT_EQ(nearest.distance, 1024.0);
  EXPECT_EQ(nearest.normal(), Vector3d(0, 0, -1));
}

/// The smallest height over a face of kTetrahedron, whose fourth plane is x + y + z = 3.
double leastHeight(const Vector3d& query) {
  return std::min({query.x(), query.y(), query.z(), (3.0 - query.sum()) / std::sqrt(3.0)});
}

TEST(EnclosedRadius, IsTheHeightOverTheNearestFaceForAllOrdersOfTheVertices) {
  const Vector3d queries[] = {{0.5, 0.5, 0.5}, {0.8, 0.8, 0.8}, {0.2, 0.5, 0.6}, {0.5, 0.2, 0.6}, {0.6, 0.5, 0.2}};
  for (const Vector3d& query : queries)
    for (const std::vector<int>& placing : placings(4)) {
      Simplex simplex = placed(kTetrahedron, query, placing, -1);
      const double radius = enclosedRadius(simplex);
      EXPECT_LE(radius, leastHeight(query));
      EXPECT_NEAR(radius, leastHeight(query), 1e-13);
    }
}

TEST(EnclosedRadius, IsNotPositiveForAFlatTetrahedron) {
  const std::vector<Vector3d> flat{{-1, -2, 0}, {3, -1, 0}, {2, 3, 0}, {-2, 2, 0}};
  EXPECT_FALSE(enclosedRadius(placed(flat, Vector3d::Zero(), {0, 1, 2, 3}, -1)) > 0.0);
}

TEST(EnclosedRadius, IsNegativeForAnOriginOutside) {
  EXPECT_NEAR(enclosedRadius(placed(kTetrahedron, {1, 1, -0.25}, {0, 1, 2, 3}, -1)), -0.25, 1e-13);
}

/// Places the vertices, with points on a of their own, and checks the witnesses of weights that are known on paper.
void expectWitnesses(const std::vector<Vector3d>& vertices, const std::vector<double>& weights, double height) {
  const Vector3d on_a[] = {{1, 2, 3}, {-4, 0, 2}, {0, 5, -7}};
  const Vector3d side(0, 0, height);
  Vector3d query = side, expected_a(0, 0, 0);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    query += weights[i] * vertices[i];
    expected_a += weights[i] * on_a[i];
  }
  for (const std::vector<int>& placing : placings(vertices.size())) {
    Simplex simplex;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      simplex[placing[i]] = {vertices[i] - query, on_a[i], {0, 0}};
      simplex.members |= 1u << placing[i];
    }
    const WitnessPoints points = witnessPoints(simplex);
    EXPECT_TRUE(isNear(points.on_a, expected_a, 1e-14));
    EXPECT_TRUE(isNear(points.on_b, expected_a + side, 1e-14));
  }
}

TEST(WitnessPoints, OfAVertexAreThePointsThatMadeIt) { expectWitnesses({kTriangle[1]}, {1.0}, 2.0); }

TEST(WitnessPoints, OfAnEdgeDivideItLikeTheNearestPoint) {
  expectWitnesses({kTriangle[1], kTriangle[2]}, {0.75, 0.25}, 2.0);
  expectWitnesses(kSegment, {0.125, 0.875}, 0.0);
}

TEST(WitnessPoints, OfATriangleHaveTheWeightsOfTheNearestPoint) {
  expectWitnesses(kTriangle, {0.5, 0.375, 0.125}, 2.0);
  expectWitnesses(kObtuse, {0.25, 0.25, 0.5}, -1.0);
}

TEST(WitnessPoints, StayOnATriangleWhoseWeightRoundingMadeNegative) {
  const double weights[] = {0.6, 0.5, -0.1};
  Vector3d query(0, 0, 0);
  for (std::size_t i = 0; i < 3; ++i) query += weights[i] * kTriangle[i];
  Simplex simplex;
  for (int i = 0; i < 3; ++i) simplex[i] = vertexAt(kTriangle[i] - query);
  simplex.members = 0b0111;
  const Vector3d expected = (0.6 * kTriangle[0] + 0.5 * kTriangle[1]) / 1.1 - query;
  EXPECT_TRUE(isNear(witnessPoints(simplex).on_a, expected, 1e-14));
}

/// The distance between the witness points of a triangle of height 1e-13 m about its edge through the origin.
double missedByNeedle(const std::vector<int>& order) {
  const Vector3d along = Vector3d(1, 2, 3).normalized(), across = along.unitOrthogonal();
  const Vector3d corners[] = {-0.31 * along, 0.52 * along, 0.11 * along + 1e-13 * across};
  Simplex needle;
  for (int i = 0; i < 3; ++i) needle[i] = {corners[order[i]], corners[order[i]], {0, 0}};
  needle.members = 0b111;
  const WitnessPoints points = witnessPoints(needle);
  return (points.on_a - points.on_b).norm();
}

// Regression: the signed areas of a needle are rounding, and as weights they gave a point 1e-3 of its length away.
TEST(WitnessPoints, OfANeedleThroughTheOriginCoincideForAllOrdersOfTheVertices) {
  std::vector<int> order{0, 1, 2};
  do EXPECT_LT(missedByNeedle(order), 1e-15);
  while (std::next_permutation(order.begin(), order.end()));
}

TEST(Simplex, NamesTheFirstFreePlace) {
  Simplex simplex;
  for (unsigned members = 0; members < 16; ++members) {
    simplex.members = members;
    const int place = simplex.freePlace();
    EXPECT_FALSE(simplex.has(place));  // of place 4 there is no bit
    for (int before = 0; before < place; ++before) EXPECT_TRUE(simplex.has(before));
  }
}

// --- preconditions

TEST(Assertion, EndsTheProgramWithTheConditionAndAdvice) {
#ifdef NDEBUG
  GTEST_SKIP() << "assertions are compiled in the sanitized builds only";
#else
  Simplex point;
  point.members = 0b1;
  EXPECT_DEATH(nearestToOrigin(point, 0),
               "simplex.cpp:.*: assertion failed: !simplex.has\\(newest\\)\nThe newest place");
  EXPECT_DEATH(witnessPoints(Simplex()), "reduce it by nearestToOrigin\\(\\) first");
#endif
}

TEST(Assertion, KnowsUnitVectorsAndPlaces) {
  EXPECT_TRUE(isUnit(Vector3d(1, 2, 3).normalized()));
  EXPECT_FALSE(isUnit(Vector3d(1, 0, 1e-4)));
  EXPECT_FALSE(isUnit(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(isPlace(0, 1u));
  EXPECT_FALSE(isPlace(-1, 4u));
  EXPECT_FALSE(isPlace(4, 4u));
}

}  // namespace proximity_server::narrowphase::simplex_test
