#include "narrowphase/cso/nearest_features.h"

#include "narrowphase/near.h"
#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/narrowphase/shape/support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace proximity_server::narrowphase::nearest_features_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
constexpr double kTolerance = 1e-9, kHalfTurn = 3.14159265358979323846;

/// A vertex of each shape, in the shape's frame.
struct Vertices {
  Vector3d of_a, of_b;
};

const Vector3d kTip(1, 0, 0);                               ///< of the pyramid, which points along x
const Vector3d kLeft(1, 1, 0), kRight(1, -1, 0);            ///< ends of the edge of the wedge, along y
const Vector3d kTop(0, 2, 0), kP(0, -1, 2), kQ(0, -1, -2);  ///< corners of the face, at x = 0

Shape hullOf(const std::vector<Vector3d>& points) { return Shape(ConvexHull(points)); }
Shape pyramid() { return hullOf({kTip, {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}}); }
Shape wedge() { return hullOf({kLeft, kRight, {0, -1, 1}, {0, 1, 1}, {0, -1, -1}, {0, 1, -1}}); }
Shape face() { return hullOf({kTop, kP, kQ, {-1, 0, 0}}); }

/// b is turned to face a, and moved.
Isometry3d facing(const Vector3d& translation, double angle = kHalfTurn) {
  Isometry3d pose(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
  pose.translation() = translation;
  return pose;
}

int numberOf(const Shape& shape, const Vector3d& vertex) {
  if (shape.kind() != Shape::Kind::Hull) return support::cornerTowards(vertex);
  const std::vector<Vector3d>& all = shape.hull().vertices();
  return static_cast<int>(std::find(all.begin(), all.end(), vertex) - all.begin());
}

std::optional<DistanceOfFeatures> ask(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                      const std::vector<Vertices>& vertices) {
  WarmStart warm_start;
  for (const Vertices& pair : vertices)
    warm_start.simplex[warm_start.simplex_size++] = {numberOf(a, pair.of_a), numberOf(b, pair.of_b)};
  const Cso cso(a, b, a_T_b, csoRounding(a, b, a_T_b), warm_start);
  return distanceOfFeatures(cso, warm_start, kTolerance);
}

void expectDistance(const std::optional<DistanceOfFeatures>& found, double distance, const Vector3d& on_a,
                    const Vector3d& on_b) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->distance, distance, 1e-14);
  EXPECT_LE(found->lower_bound, distance);
  EXPECT_NEAR(found->lower_bound, distance, 1e-13);
  EXPECT_TRUE(isNear(found->normal, (on_b - on_a).normalized(), 1e-14));
  EXPECT_TRUE(isNear(found->points.on_a, on_a, 1e-14));
  EXPECT_TRUE(isNear(found->points.on_b, on_b, 1e-14));
}

TEST(NearestFeatures, TwoVertices) {
  expectDistance(ask(pyramid(), pyramid(), facing({5, 0, 0}), {{kTip, kTip}}), 3.0, {1, 0, 0}, {4, 0, 0});
}

TEST(NearestFeatures, AVertexAndAnEdge) {
  const Isometry3d pose = facing({5, 0.25, 0});
  expectDistance(ask(pyramid(), wedge(), pose, {{kTip, kLeft}, {kTip, kRight}}), 3.0, {1, 0, 0}, {4, 0, 0});
  expectDistance(ask(wedge(), pyramid(), pose, {{kRight, kTip}, {kLeft, kTip}}), 3.0, {1, 0.25, 0}, {4, 0.25, 0});
}

TEST(NearestFeatures, AVertexAndATriangle) {
  const Isometry3d pose = facing({3, 0.25, 0.5});
  expectDistance(ask(face(), pyramid(), pose, {{kQ, kTip}, {kTop, kTip}, {kP, kTip}}), 2.0, {0, 0.25, 0.5},
                 {2, 0.25, 0.5});
  expectDistance(ask(pyramid(), face(), pose, {{kTip, kP}, {kTip, kQ}, {kTip, kTop}}), 2.0, {1, 0, 0}, {3, 0, 0});
}

TEST(NearestFeatures, TwoEdgesByAnyOfTheVerticesThatTheySpan) {
  Isometry3d crossing = facing({5, 0.25, -0.5});
  crossing.linear() = Eigen::AngleAxisd(0.5 * kHalfTurn, Vector3d::UnitX()) * crossing.linear();
  const std::vector<std::vector<Vertices>> simplices{{{kLeft, kLeft}, {kLeft, kRight}, {kRight, kLeft}},
                                                     {{kRight, kRight}, {kLeft, kRight}, {kRight, kLeft}},
                                                     {{kLeft, kLeft}, {kRight, kRight}}};
  for (const std::vector<Vertices>& simplex : simplices)
    expectDistance(ask(wedge(), wedge(), crossing, simplex), 3.0, {1, 0.25, 0}, {4, 0.25, 0});
}

TEST(NearestFeatures, ACornerOfABoxAndTheAxisOfACapsule) {
  const Shape box = Box{{2, 2, 2}}, capsule = Capsule{0.1, 4.0};
  const Vector3d corner(1, 1, 1), up(0, 0, 1), down(0, 0, -1);
  Isometry3d pose(Eigen::Quaterniond::FromTwoVectors(up, Vector3d(1, -1, 0)));
  pose.translation() = Vector3d(2, 2, 2);
  expectDistance(ask(box, capsule, pose, {{corner, up}, {corner, down}}), std::sqrt(3.0), {1, 1, 1}, {2, 2, 2});
  // the axis has no width: its end has four numbers
  const Vector3d also_up(-1, -1, 1), also_down(-1, 1, -1);
  expectDistance(ask(box, capsule, pose, {{corner, also_up}, {corner, also_down}}), std::sqrt(3.0), {1, 1, 1},
                 {2, 2, 2});
}

TEST(NearestFeatures, OtherFeaturesAreNotTaken) {
  const Isometry3d pose = facing({5, 0, 0});
  const Vector3d behind(0, 1, 1), also_behind(0, -1, 1);
  EXPECT_FALSE(ask(pyramid(), pyramid(), pose, {})) << "nothing is recalled";
  EXPECT_FALSE(ask(pyramid(), pyramid(), pose, {{behind, kTip}})) << "a farther vertex";
  EXPECT_FALSE(ask(pyramid(), pyramid(), pose, {{kTip, kTip}, {kTip, behind}})) << "an edge whose end is the nearest";
  EXPECT_FALSE(ask(pyramid(), pyramid(), pose, {{kTip, kTip}, {behind, behind}, {kTip, also_behind}}))
      << "more vertices than features have that meet in a point";
  EXPECT_FALSE(ask(pyramid(), pyramid(), facing({1.5, 0, 0}), {{kTip, kTip}})) << "an overlap";
}

TEST(NearestFeatures, ANumberOutOfRangeIsThatOfSomeVertex) {
  WarmStart warm_start;
  warm_start.simplex = {{{99, -1}, {-7, 5}, {1 << 30, 5}}};
  warm_start.simplex_size = 99;
  const Shape a = pyramid(), b = Box{{1, 1, 1}};
  const Isometry3d pose = facing({5, 0, 0});
  const Cso cso(a, b, pose, csoRounding(a, b, pose), warm_start);
  EXPECT_FALSE(distanceOfFeatures(cso, warm_start, kTolerance));
}

TEST(NearestFeatures, FeaturesNearlyAsNearAreNotTaken) {
  // the faces of two cubes
  const Shape cube = Box{{2, 2, 2}};
  EXPECT_FALSE(ask(cube, cube, facing({5, 0, 0}), {{{1, 1, 1}, {1, 1, 1}}, {{1, -1, 1}, {1, -1, 1}}}));
  // a vertex over a face of four vertices, of which three are recalled
  EXPECT_FALSE(
      ask(pyramid(), cube, facing({5, 0.1, 0.2}), {{kTip, {1, 1, 1}}, {kTip, {1, -1, -1}}, {kTip, {1, 1, -1}}}));
  // a vertex over an edge, beside its end
  const std::vector<Vertices> on_edge{{kTip, kLeft}, {kTip, kRight}};
  EXPECT_FALSE(ask(pyramid(), wedge(), facing({5, 1.0 - 1e-10, 0}), on_edge));
  EXPECT_TRUE(ask(pyramid(), wedge(), facing({5, 1.0 - 1e-5, 0}), on_edge));
  // beyond the end, where the vertex of the end is the nearest
  EXPECT_FALSE(ask(pyramid(), wedge(), facing({5, 1.0 + 1e-10, 0}), {{kTip, kLeft}}));
  EXPECT_TRUE(ask(pyramid(), wedge(), facing({5, 1.0 + 1e-5, 0}), {{kTip, kLeft}}));
}

}  // namespace proximity_server::narrowphase::nearest_features_test
