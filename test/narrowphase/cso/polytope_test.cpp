#include "narrowphase/cso/polytope.h"

#include "narrowphase/cso/two_cores.h"
#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::polytope_test {

using Eigen::Vector3d;
using Face = Polytope::Face;

constexpr double kNoCeiling = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-14;

/// O X Y Z with edges of 3 m along the axes, moved by -(0.5, 0.5, 0.5): the faces are 0.5 m from the origin, and the
/// slant, whose plane is x + y + z = 1.5, is sqrt(3) / 2.
const Vector3d kCorners[] = {{-0.5, -0.5, -0.5}, {2.5, -0.5, -0.5}, {-0.5, 2.5, -0.5}, {-0.5, -0.5, 2.5}};

/// On the heap, as it is large.
std::unique_ptr<Polytope> tetrahedron(const std::array<int, 4>& order = {0, 1, 2, 3}, double rounding = kRounding,
                                      Polytope::Coplanar coplanar = Polytope::Coplanar::Replaced) {
  std::array<CsoVertex, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = vertexAt(kCorners[order[i]]);
  return std::make_unique<Polytope>(corners, rounding, coplanar);
}

/// Expands by a vertex from the face that it lies farthest above, as EPA does from the closest one.
bool expandBy(Polytope& polytope, const Vector3d& w, double ceiling = kNoCeiling) {
  const Face* best = nullptr;
  double highest = 0.0;
  polytope.forEachFace([&](const Face& face) {
    const double height = face.hasNormal() ? face.normal().dot(w) - face.distance() : 0.0;
    if (!(height > highest)) return;
    highest = height;
    best = &face;
  });
  return best != nullptr && polytope.expand(*best, vertexAt(w), ceiling);
}

int facesOf(const Polytope& polytope) {
  int count = 0;
  polytope.forEachFace([&](const Face&) { ++count; });
  return count;
}

/// The distances of the faces as closest() names them, until none is left.
std::vector<double> distancesInOrder(Polytope& polytope) {
  std::vector<double> distances;
  while (const Face* face = polytope.closest()) {
    distances.push_back(face->distance());
    polytope.setAside(*face);
  }
  return distances;
}

TEST(Polytope, BeginsClosedWhateverTheOrderOfTheCorners) {
  std::array<int, 4> order{0, 1, 2, 3};
  do {
    const auto polytope = tetrahedron(order);
    EXPECT_EQ(polytope->checkTopology(), "");
    EXPECT_EQ(facesOf(*polytope), 4);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Polytope, HasOutwardNormalsAndTheDistancesOfThePlanes) {
  std::array<int, 4> order{0, 1, 2, 3};
  do {
    const auto polytope = tetrahedron(order);
    int slants = 0;
    polytope->forEachFace([&](const Face& face) {
      const bool is_slant = face.normal().sum() > 0.0;
      slants += is_slant ? 1 : 0;
      EXPECT_NEAR(face.distance(), is_slant ? std::sqrt(0.75) : 0.5, 1e-15);
      const Vector3d axis = face.normal().cwiseAbs().unaryExpr([](double x) { return x > 0.5 ? 1.0 : 0.0; });
      EXPECT_TRUE(isNear(face.normal(), is_slant ? Vector3d(1, 1, 1).normalized() : Vector3d(-axis), 1e-15));
    });
    EXPECT_EQ(slants, 1);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Polytope, StaysClosedAndConvexUnderEveryExpansion) {
  const auto polytope = tetrahedron();
  for (const Vector3d& w : {Vector3d(2, 2, 2), Vector3d(-2, -1, -1.5), Vector3d(1, -3, 0.5), Vector3d(-1, 3, -2),
                            Vector3d(4, 0.25, 0.5), Vector3d(0.125, 0.25, -5)}) {
    ASSERT_TRUE(expandBy(*polytope, w));
    ASSERT_EQ(polytope->checkTopology(), "");
  }
}

// Above the slant only: three faces instead of one.
TEST(Polytope, ReplacesTheFaceUnderANewVertexByThree) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {1, 1, 1}));
  EXPECT_EQ(facesOf(*polytope), 6);
  EXPECT_EQ(polytope->checkTopology(), "");
}

// It sees the three faces about the corner -0.5, which goes.
TEST(Polytope, RemovesACornerThatANewVertexHides) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {-1, -1, -1}));
  EXPECT_EQ(facesOf(*polytope), 4);
  EXPECT_EQ(polytope->checkTopology(), "");
  polytope->forEachFace([](const Face& face) {
    for (const int vertex : face.vertices) EXPECT_NE(vertex, 0);
  });
}

TEST(Polytope, StaysClosedUnderAVertexInThePlaneOfAFace) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {2, 2, -0.5}));  // in the plane z = -0.5, beyond the slant
  EXPECT_EQ(polytope->checkTopology(), "");
  EXPECT_EQ(facesOf(*polytope), 6);  // V = 5, so E = 9 and F = 6
}

TEST(Polytope, StaysClosedUnderAVertexInThePlanesOfTwoFaces) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {4, -0.5, -0.5}));  // on the line of an edge, whose end goes
  EXPECT_EQ(polytope->checkTopology(), "");
  EXPECT_EQ(facesOf(*polytope), 4);
}

// The two faces in the plane of the vertex stay, and each is joined by one of the cone; so is the third at the edge.
TEST(Polytope, KeepsTheFacesInThePlaneOfANewVertexOfACurvedCore) {
  const auto polytope = tetrahedron({0, 1, 2, 3}, kRounding, Polytope::Coplanar::Kept);
  ASSERT_TRUE(expandBy(*polytope, {4, -0.5, -0.5}));
  EXPECT_EQ(polytope->checkTopology(), "");
  EXPECT_EQ(facesOf(*polytope), 6);
}

// The base is z = -0.5, and each vertex lies in its plane. After the first few it sees one edge of the base, and adds
// one triangle there.
TEST(Polytope, GrowsAFlatBaseByOneTriangleForEachVertex) {
  const auto polytope = tetrahedron({0, 1, 2, 3}, kRounding, Polytope::Coplanar::Kept);
  const auto baseFaces = [&] {
    std::vector<std::array<int, 3>> faces;
    polytope->forEachFace([&](const Face& face) {
      if (face.normal().z() < -0.999) faces.push_back(face.vertices);
    });
    return faces;
  };
  for (int i = 1; i <= 40; ++i) {
    const std::vector<std::array<int, 3>> before = baseFaces();
    const double angle = 2.4 * i;  // the golden angle, nearly: each vertex falls between older ones
    ASSERT_TRUE(expandBy(*polytope, {8.0 * std::cos(angle), 8.0 * std::sin(angle), -0.5}));
    ASSERT_EQ(polytope->checkTopology(), "");
    const std::vector<std::array<int, 3>> after = baseFaces();
    const auto is_new = [&](const auto& face) { return std::find(before.begin(), before.end(), face) == before.end(); };
    if (i > 8) {
      EXPECT_EQ(std::count_if(after.begin(), after.end(), is_new), 1) << i;
    }
  }
}

std::vector<Vector3d> randomDirections(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i)
    directions.push_back(Vector3d(normal(random), normal(random), normal(random)).normalized());
  return directions;
}

// The vertex beyond the sphere hides most of the faces, so that more are removed than made.
TEST(Polytope, NeverNamesARemovedFace) {
  const auto polytope = tetrahedron();
  for (const Vector3d& direction : randomDirections(40, 1)) expandBy(*polytope, 8.0 * direction);
  const int before = facesOf(*polytope);
  ASSERT_TRUE(expandBy(*polytope, {300, 200, 100}));
  ASSERT_LT(facesOf(*polytope), before);
  std::vector<double> distances;
  polytope->forEachFace([&](const Face& face) { distances.push_back(face.distance()); });
  std::sort(distances.begin(), distances.end());
  EXPECT_EQ(distancesInOrder(*polytope), distances);
}

// So that rounding of the area cannot make the lower bound of the depth too great.
TEST(Polytope, TakesTheLowestCornerForTheHeightOfAFace) {
  const auto polytope = tetrahedron();
  int uneven = 0;
  for (const Vector3d& direction : randomDirections(60, 2)) {
    expandBy(*polytope, 8.0 * direction);
    polytope->forEachFace([&](const Face& face) {
      for (const int v : face.vertices) {
        const double height = face.area.dot(polytope->vertex(v).point);
        ASSERT_LE(face.height, height);
        uneven += face.height < height ? 1 : 0;
      }
    });
  }
  EXPECT_GT(uneven, 100);
}

// One edge of the tetrahedron is 1e-6 m long, and where it is on the horizon, its triangle is narrow at the apex. The
// cross product of the long edges would tilt the normal by about 1e-10.
TEST(Polytope, HasAccurateNormalsOfTrianglesThatAreNarrowAtTheApex) {
  const Vector3d p(0.4, 0.5, -0.3), q = p + 1e-6 * Vector3d(1, 0.3, 0.7);
  const std::array<CsoVertex, 4> corners{vertexAt(p), vertexAt(q), vertexAt({-0.6, 0.4, -0.35}),
                                         vertexAt({-0.1, -0.9, -0.5})};
  int narrow = 0;
  for (const Vector3d& direction : randomDirections(100, 3)) {
    const auto polytope = std::make_unique<Polytope>(corners, kRounding);
    if (!expandBy(*polytope, 2.0 * direction)) continue;
    polytope->forEachFace([&](const Face& face) {
      using Exact = Eigen::Matrix<long double, 3, 1>;
      const auto corner = [&](int i) { return Exact(polytope->vertex(face.vertices[i]).point.cast<long double>()); };
      const Exact area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
      EXPECT_TRUE(isNear(face.normal(), area.normalized().cast<double>(), 1e-14));
      narrow += area.norm() < 1e-5L ? 1 : 0;
    });
  }
  EXPECT_GT(narrow, 50);
}

// The vertex lies within rounding above two faces, on the line of their edge: one is replaced, the other is kept, and
// the triangle between them is narrower than rounding. The next vertex removes it.
TEST(Polytope, ReplacesAFaceWithoutANormalWhateverIsKept) {
  const auto polytope = tetrahedron({0, 1, 2, 3}, 1e-3, Polytope::Coplanar::Kept);
  ASSERT_TRUE(expandBy(*polytope, {1.0, -0.5001, -0.5001}));
  const auto withoutNormal = [&] {
    int count = 0;
    polytope->forEachFace([&](const Face& face) { count += face.hasNormal() ? 0 : 1; });
    return count;
  };
  ASSERT_GT(withoutNormal(), 0);
  ASSERT_TRUE(expandBy(*polytope, {1.0, -2.0, -2.0}));
  EXPECT_EQ(withoutNormal(), 0);
}

// A long prism whose three sides lie within rounding of the axis. From a point of the axis they count as visible, and
// the two ends do not, so that the horizon is the rim of either end.
TEST(Polytope, DoesNotGrowWhereTheHorizonIsTwoLoops) {
  const auto corner = [](int i, double z) {
    const double angle = 2.0 * M_PI / 3.0 * i;
    return Vector3d(1.8e-3 * std::cos(angle), 1.8e-3 * std::sin(angle), z);
  };
  const std::array<CsoVertex, 4> corners{vertexAt(corner(0, -1)), vertexAt(corner(1, -1)), vertexAt(corner(2, -1)),
                                         vertexAt(corner(0, 1))};
  const auto polytope = std::make_unique<Polytope>(corners, 1e-3);
  ASSERT_TRUE(expandBy(*polytope, corner(1, 1)));
  ASSERT_TRUE(expandBy(*polytope, corner(2, 1)));
  ASSERT_EQ(facesOf(*polytope), 8);
  const Face* side = nullptr;
  polytope->forEachFace([&](const Face& face) { side = std::abs(face.normal().z()) < 0.5 ? &face : side; });
  WarmPolytope kept;
  polytope->keep(kept);
  EXPECT_EQ(kept.faceCount(), 8);
  EXPECT_FALSE(polytope->expand(*side, vertexAt({0, 0, 0.1}), kNoCeiling));
  polytope->keep(kept);
  EXPECT_EQ(kept.faceCount(), 0);  // it is not closed any more
}

// All but four of its faces come in pairs within one plane, so most new vertices lie in the plane of a face.
TEST(Polytope, GrowsToACubeWithTwelveFaces) {
  std::array<CsoVertex, 4> corners{vertexAt({1, 1, 1}), vertexAt({-1, -1, 1}), vertexAt({1, -1, -1}),
                                   vertexAt({-1, 1, -1})};
  const auto polytope = std::make_unique<Polytope>(corners, kRounding);
  for (const Vector3d& w : {Vector3d(-1, -1, -1), Vector3d(1, 1, -1), Vector3d(1, -1, 1), Vector3d(-1, 1, 1)}) {
    ASSERT_TRUE(expandBy(*polytope, w));
    ASSERT_EQ(polytope->checkTopology(), "");
  }
  EXPECT_EQ(facesOf(*polytope), 12);
  for (const double distance : distancesInOrder(*polytope)) EXPECT_NEAR(distance, 1.0, 1e-15);
}

/// Points all over the unit sphere, no two of them near each other: a spiral by the golden angle.
Vector3d onSphere(int i, int count) {
  const double z = 1.0 - (2.0 * i + 1.0) / count, angle = 2.399963229728653 * i;
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

TEST(Polytope, TakesAsManyVerticesAsItsStorageHas) {
  std::array<CsoVertex, 4> corners{vertexAt(Vector3d(1, 1, 1) / 2), vertexAt(Vector3d(-1, -1, 1) / 2),
                                   vertexAt(Vector3d(1, -1, -1) / 2), vertexAt(Vector3d(-1, 1, -1) / 2)};
  const auto polytope = std::make_unique<Polytope>(corners, kRounding);
  constexpr int kAdded = Polytope::kMaxVertices - 4;
  for (int i = 0; i < kAdded; ++i) {
    ASSERT_FALSE(polytope->full());
    ASSERT_TRUE(expandBy(*polytope, onSphere((7 * i) % kAdded, kAdded))) << i;
    if (i % 50 != 0) continue;
    ASSERT_EQ(polytope->checkTopology(), "") << i;
  }
  EXPECT_TRUE(polytope->full());
  EXPECT_EQ(polytope->checkTopology(), "");
}

TEST(Polytope, NamesTheClosestFaceAfterEveryExpansion) {
  const auto polytope = tetrahedron();
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(expandBy(*polytope, 5.0 * onSphere((7 * i) % 200, 200)));
    double least = std::numeric_limits<double>::infinity();
    polytope->forEachFace([&](const Face& face) { least = std::min(least, face.distance()); });
    ASSERT_NEAR(polytope->closest()->distance(), least, 1e-15);
  }
}

TEST(Polytope, NamesTheFacesInTheOrderOfTheirDistances) {
  const auto polytope = tetrahedron();
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(expandBy(*polytope, 5.0 * onSphere((7 * i) % 100, 100)));
  const int faces = facesOf(*polytope);
  const std::vector<double> distances = distancesInOrder(*polytope);
  EXPECT_EQ(distances.size(), static_cast<std::size_t>(faces));
  for (std::size_t i = 1; i < distances.size(); ++i)  // they are compared by their squares, whose rounding differs
    EXPECT_GE(distances[i], distances[i - 1] * (1.0 - 1e-15));
}

TEST(Polytope, DoesNotNameAgainWhatWasSetAside) {
  const auto polytope = tetrahedron();
  const Face* first = polytope->closest();
  EXPECT_NEAR(first->distance(), 0.5, 1e-15);
  polytope->setAside(*first);
  EXPECT_NE(polytope->closest(), first);
  polytope->setAside(*polytope->closest());
  polytope->setAside(*polytope->closest());
  EXPECT_NEAR(polytope->closest()->distance(), std::sqrt(0.75), 1e-15);  // the slant comes last
  polytope->setAside(*polytope->closest());
  EXPECT_EQ(polytope->closest(), nullptr);
  EXPECT_EQ(polytope->checkTopology(), "");  // it is still there
}

// The new faces lie at least as far as the slant, the ceiling.
TEST(Polytope, NeverNamesANewFaceThatReachesTheCeiling) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {2, 2, 2}, 0.75));
  EXPECT_EQ(facesOf(*polytope), 6);
  const std::vector<double> distances = distancesInOrder(*polytope);
  ASSERT_EQ(distances.size(), 3u);
  for (const double distance : distances) EXPECT_NEAR(distance, 0.5, 1e-15);
}

TEST(Polytope, NamesANewFaceBelowTheCeiling) {
  const auto polytope = tetrahedron();
  ASSERT_TRUE(expandBy(*polytope, {2, 2, 2}, 10.0));
  EXPECT_EQ(distancesInOrder(*polytope).size(), 6u);
}

TEST(Polytope, HasNoFaceForEpaWhereAllIsRounding) {
  const auto polytope = tetrahedron({0, 1, 2, 3}, 10.0);
  EXPECT_EQ(polytope->closest(), nullptr);
  polytope->forEachFace([](const Face& face) {
    EXPECT_FALSE(face.hasNormal());
    EXPECT_FALSE(face.isCloserThan(100.0));
  });
  const Face* any = nullptr;
  polytope->forEachFace([&](const Face& face) { any = &face; });
  EXPECT_FALSE(polytope->expand(*any, vertexAt({20, 20, 20}), kNoCeiling));
}

// A vertex on the line of an edge makes a face without area beside it; it is never the closest.
TEST(Polytope, NeverNamesAFaceWithoutArea) {
  std::array<CsoVertex, 4> corners{vertexAt({1, 0, 0}), vertexAt({-1, 0, 0}), vertexAt({3, 0, 0}), vertexAt({0, 1, 0})};
  Polytope flat(corners, kRounding);
  flat.forEachFace([](const Face& face) { EXPECT_EQ(face.hasNormal(), face.area2 > 0.0); });
  for (const double distance : distancesInOrder(flat)) EXPECT_TRUE(std::isfinite(distance));
}

TEST(PolytopeFace, ComparesDistancesOfEitherSignWithALimit) {
  Face face{};
  face.area = Vector3d(0, 0, 4);
  face.area2 = 16.0;
  face.height = 4.0 * 0.5;
  EXPECT_TRUE(face.isCloserThan(0.51));
  EXPECT_FALSE(face.isCloserThan(0.5));
  EXPECT_FALSE(face.isCloserThan(-0.51));
  face.height = -4.0 * 0.5;  // the origin lies 0.5 m outside
  EXPECT_TRUE(face.isCloserThan(-0.49));
  EXPECT_FALSE(face.isCloserThan(-0.5));
  EXPECT_TRUE(face.isCloserThan(0.1));
}

TEST(Polytope, WeighsTheCornersWhereARayMeetsTheFace) {
  const auto polytope = tetrahedron();
  const Vector3d ray = Vector3d(0.25 * kCorners[1] + 0.25 * kCorners[2] + 0.5 * kCorners[3]).normalized();
  const Vector3d beyond = 0.75 * kCorners[1] + 0.75 * kCorners[2] - 0.5 * kCorners[3];
  const double expected[] = {0.0, 0.25, 0.25, 0.5}, expected_beyond[] = {0.0, 0.75, 0.75, -0.5};
  polytope->forEachFace([&](const Face& face) {
    if (face.normal().sum() < 0.0) return;  // the slant is meant
    const std::array<double, 3> weights = polytope->rayWeights(face, ray);
    const std::array<double, 3> weights_beyond = polytope->rayWeights(face, beyond.normalized());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(weights[i], expected[face.vertices[i]], 1e-15);
      EXPECT_NEAR(weights_beyond[i], expected_beyond[face.vertices[i]], 1e-14);
    }
  });
}

TEST(Polytope, KnowsTheCornersOfAFace) {
  const auto polytope = tetrahedron();
  polytope->forEachFace([&](const Face& face) {
    int corners = 0;
    for (const Vector3d& corner : kCorners) corners += polytope->hasCorner(face, vertexAt(corner)) ? 1 : 0;
    EXPECT_EQ(corners, 3);
    EXPECT_FALSE(polytope->hasCorner(face, vertexAt({1, 1, 1})));
  });
}

TEST(Polytope, KnowsTheNeighbourBeyondEachEdge) {
  const auto polytope = tetrahedron();
  polytope->forEachFace([&](const Face& face) {
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const Face& next = polytope->neighbour(face, edge);
      EXPECT_NE(&next, &face);
      EXPECT_TRUE(polytope->hasCorner(next, polytope->vertex(face.vertices[edge])));
      EXPECT_TRUE(polytope->hasCorner(next, polytope->vertex(face.vertices[(edge + 1) % 3])));
    }
  });
}

}  // namespace proximity_server::narrowphase::polytope_test
