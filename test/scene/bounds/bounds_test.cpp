#include "scene/bounds/bounds.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace proximity_server::scene::bounds_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

const double kHalfRoot = std::sqrt(0.5);

Bounds ballOf(double radius) {
  Bounds bounds;
  bounds.radius = radius;
  return bounds;
}

Bounds boxOf(const Vector3d& half) {
  Bounds bounds;
  bounds.half = half;
  return bounds;
}

Piece pieceOf(const Shape& shape, const Isometry3d& body_T_piece = Isometry3d::Identity()) {
  return {shape, body_T_piece, 0};
}

Matrix3d turnedBy(double angle, const Vector3d& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

double alignedGap(const Vector3d& between, const Bounds& a, const Bounds& b) {
  return boxGap(between, a, Matrix3d::Identity(), b, Matrix3d::Identity());
}

RelativePose apart(const Vector3d& way) { return {Matrix3d::Identity(), way}; }

// --- spheres

// The centres are 5 apart, the radii 1 and 2.
TEST(SphereGap, IsTheDistanceOfTheCentresLessTheRadii) {
  EXPECT_NEAR(sphereGap(ballOf(1.0), ballOf(2.0), apart({3, 0, -4})), 2.0, 1e-12);
}

TEST(SphereGap, IsNegativeWhereTheSpheresOverlap) {
  EXPECT_NEAR(sphereGap(ballOf(1.0), ballOf(2.0), apart({0, 1, 0})), -2.0, 1e-12);
}

TEST(SphereGap, AllowsForTheRoundingOfAFarPose) {
  const double far = 1e6, gap = sphereGap(ballOf(1.0), ballOf(1.0), apart({far, 0, 0}));
  EXPECT_LE(gap, far - 2.0 - 0.9 * kPoseRounding * far);
  EXPECT_GE(gap, far - 2.0 - 1.1 * kPoseRounding * far);
}

// --- boxes

const Bounds kCube = boxOf({1.0, 1.0, 1.0}), kSmallCube = boxOf({0.5, 0.5, 0.5});

TEST(BoxGap, OfFacesIsTheGapAlongTheirNormal) {
  EXPECT_NEAR(alignedGap({3, 0, 0}, kCube, kSmallCube), 1.5, 1e-12);
  EXPECT_NEAR(alignedGap({0, -3, 0.7}, kCube, kSmallCube), 1.5, 1e-12);
}

// The gaps along two axes are 3 and 4, along all three 1, 2 and 2.
TEST(BoxGap, OfEdgesAndCornersIsTheLengthOfTheGaps) {
  EXPECT_NEAR(alignedGap({4.5, 0, -5.5}, kCube, kSmallCube), 5.0, 1e-12);
  EXPECT_NEAR(alignedGap({2.5, -3.5, 3.5}, kCube, kSmallCube), 3.0, 1e-12);
}

// The small cube sticks 0.5 into the large one along x, and lies deeper along y and z.
TEST(BoxGap, OfAnOverlapIsMinusTheShortestWayOut) {
  EXPECT_NEAR(alignedGap({1.0, 0.5, 0.2}, kCube, kSmallCube), -0.5, 1e-12);
}

// The shortest way out of (1, 2, 3) with (0.5, 0.5, 0.5) is along x; there is no line of the centres.
TEST(BoxGap, OfBoxesAboutOneCentreIsMinusTheSumOfTheirShortestHalves) {
  EXPECT_NEAR(alignedGap(Vector3d::Zero(), boxOf({1, 2, 3}), kSmallCube), -1.5, 1e-12);
}

// A cube of edge 1, turned by 45 degrees, reaches sqrt(1/2) from its centre towards the face of the other one.
TEST(BoxGap, OfAnEdgeBeforeAFaceIsExactInEitherOrder) {
  const Matrix3d straight = Matrix3d::Identity(), slanted = turnedBy(M_PI / 4, Vector3d::UnitZ());
  const double expected = 2.0 - 0.5 - kHalfRoot;
  EXPECT_NEAR(boxGap({2, 0, 0}, kSmallCube, straight, kSmallCube, slanted), expected, 1e-12);
  EXPECT_NEAR(boxGap({2, 0, 0}, kSmallCube, slanted, kSmallCube, straight), expected, 1e-12);
}

// Two edges, one along z and one along y, cross where the line of the centres meets them, sqrt(1/2) from each centre.
TEST(BoxGap, OfCrossingEdgesIsExactAlongTheLineOfTheCentres) {
  const Matrix3d about_z = turnedBy(M_PI / 4, Vector3d::UnitZ()), about_y = turnedBy(M_PI / 4, Vector3d::UnitY());
  EXPECT_NEAR(boxGap({3, 0, 0}, kSmallCube, about_z, kSmallCube, about_y), 3.0 - 2.0 * kHalfRoot, 1e-12);
}

// Half sizes (2, 1, 0.1), turned by a quarter about z: along x it reaches 1.
TEST(BoxGap, TurnsTheHalfSizesOfTheOtherBox) {
  const Matrix3d quarter = turnedBy(M_PI / 2, Vector3d::UnitZ());
  const Bounds plate = boxOf({2, 1, 0.1});
  EXPECT_NEAR(boxGap({4, 0, 0}, plate, Matrix3d::Identity(), plate, quarter), 4.0 - 2.0 - 1.0, 1e-12);
  EXPECT_NEAR(boxGap({0, 4, 0}, plate, Matrix3d::Identity(), plate, quarter), 4.0 - 1.0 - 2.0, 1e-12);
}

TEST(BoxGap, AllowsForTheRoundingOfAFarPose) {
  const double far = 1e6, gap = alignedGap({far, 0, 0}, kCube, kCube);
  EXPECT_LE(gap, far - 2.0 - 0.9 * kPoseRounding * far);
  EXPECT_GE(gap, far - 2.0 - 1.1 * kPoseRounding * far);
}

TEST(BoxGap, OfTurnedBoxesIsNeverAboveTheirDistance) {
  Chance chance(11);
  int apart = 0, overlapping = 0, tight = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d half_a(chance.between(0.1, 1), chance.between(0.1, 1), chance.between(0.1, 1));
    const Vector3d half_b(chance.between(0.1, 1), chance.between(0.1, 1), chance.between(0.1, 1));
    const Isometry3d a = chance.pose(0.1), b = chance.pose(1.5);
    const double distance = signedDistance(Box{2.0 * half_a}, Box{2.0 * half_b}, a.inverse() * b).distance;
    const double gap = boxGap(b.translation() - a.translation(), boxOf(half_a), a.linear(), boxOf(half_b), b.linear());
    EXPECT_LE(gap, distance + 1e-9);
    (distance > 0.0 ? apart : overlapping) += 1;
    tight += distance > 0.0 && gap > 0.9 * distance;
  }
  EXPECT_GT(apart, 400);
  EXPECT_GT(overlapping, 400);
  EXPECT_GT(tight, 50);
}

// --- the bounds of a piece

// The centre is (1, 2, 2), 3 from the origin; the half diagonal of 2 x 4 x 4 is 3.
TEST(BoundsOfAPiece, OfABoxAreTheBoxAndTheSphereThroughItsCorners) {
  const Isometry3d pose = turned(0.7, {1, 2, -1}, {1, 2, 2});
  const Bounds bounds = boundsOf(pieceOf(Box{{2, 4, 4}}, pose));
  EXPECT_LE((bounds.centre - Vector3d(1, 2, 2)).norm(), 1e-12);
  EXPECT_LE((bounds.half - Vector3d(1, 2, 2)).norm(), 1e-12);
  EXPECT_LE((bounds.axes - pose.linear()).norm(), 1e-12);
  EXPECT_NEAR(bounds.radius, 3.0, 1e-12);
  EXPECT_NEAR(bounds.reach, 6.0, 1e-12);
}

// The sides of a cone of radius 1 and length 2: the box is that of the cylinder about it.
TEST(BoundsOfAPiece, OfAConeAreTheBoxOfItsCylinder) {
  EXPECT_LE((boundsOf(pieceOf(Cone{1.0, 2.0})).half - Vector3d(1, 1, 1)).norm(), 1e-12);
}

TEST(BoundsOfAPiece, HoldItsMargin) {
  const Bounds bounds = boundsOf(pieceOf(Shape(Box{{2, 4, 4}}).padded(0.5)));
  EXPECT_LE((bounds.half - Vector3d(1.5, 2.5, 2.5)).norm(), 1e-12);
  EXPECT_NEAR(bounds.radius, 3.5, 1e-12);
}

TEST(BoundsOfAPiece, AreEnlargedByTheRoundingOfTheirReach) {
  const Bounds bounds = boundsOf(pieceOf(Box{{2, 2, 2}}));
  const double rounding = kPoseRounding * std::sqrt(3.0);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(bounds.half[k] - 1.0, rounding, 0.1 * rounding);
  EXPECT_NEAR(bounds.radius - std::sqrt(3.0), rounding, 0.1 * rounding);
}

// A rectangle of 4 x 2 in the plane z = 0 whose edges lie along the diagonals of x and y.
TEST(BoundsOfAPiece, OfAHullFollowItsPrincipalAxes) {
  const Vector3d u = 2.0 * Vector3d(kHalfRoot, kHalfRoot, 0), v = Vector3d(-kHalfRoot, kHalfRoot, 0);
  const Bounds bounds = boundsOf(pieceOf(ConvexHull({u + v, u - v, -u + v, -u - v})));
  EXPECT_NEAR(bounds.half.minCoeff(), 0.0, 1e-12);
  EXPECT_NEAR(bounds.half.maxCoeff(), 2.0, 1e-12);
  EXPECT_NEAR(bounds.half.sum(), 3.0, 1e-12);
}

// --- the bounds of a box

TEST(BoundsOfABox, HoldItsCorners) {
  Chance chance(3);
  for (int i = 0; i < 1000; ++i) {
    Eigen::AlignedBox3d box(Vector3d(1e3 * chance.direction()));
    box.extend(1e3 * chance.direction());
    const Bounds bounds = boundsOf(box);
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d point = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
      EXPECT_LE((point - bounds.centre).norm(), bounds.radius);
      EXPECT_TRUE(((point - bounds.centre).cwiseAbs().array() <= bounds.half.array()).all());
      EXPECT_LE(point.norm(), bounds.reach * (1.0 + 1e-15));
    }
  }
}

// --- the bounds of several pieces

struct Group {
  explicit Group(std::vector<Piece> of) : pieces(std::move(of)) {
    for (const Piece& piece : pieces) each.push_back(boundsOf(piece));
  }
  Bounds bounds() const {
    std::vector<const Piece*> all;
    std::vector<const Bounds*> all_bounds;
    for (const Piece& piece : pieces) all.push_back(&piece);
    for (const Bounds& one : each) all_bounds.push_back(&one);
    return boundsOf(all, all_bounds);
  }
  std::vector<Piece> pieces;
  std::vector<Bounds> each;
};

// Balls of radius 1 about the origin and (6, 0, 0), one of radius 2 about (0, 3, 0): x from -2 to 7, y from -1 to 5.
TEST(BoundsOfPieces, AreTheSmallestBoxAlongTheFrame) {
  const Bounds bounds =
      Group({pieceOf(Sphere{1}), pieceOf(Sphere{1}, at(6, 0, 0)), pieceOf(Sphere{2}, at(0, 3, 0))}).bounds();
  EXPECT_LE((bounds.centre - Vector3d(2.5, 2, 0)).norm(), 1e-12);
  EXPECT_LE((bounds.half - Vector3d(4.5, 3, 2)).norm(), 1e-12);
  EXPECT_NEAR(bounds.radius, std::hypot(3.5, 2.0) + 1.0, 1e-12);  // to the ball about (6, 0, 0)
  EXPECT_NEAR(bounds.reach, 7.0, 1e-12);
}

TEST(BoundsOfPieces, OfASinglePieceAreItsOwn) {
  const Group group({pieceOf(Box{{1, 2, 3}}, turned(0.4, {1, 1, 0}, {1, 0, 0}))});
  EXPECT_EQ(group.bounds().half, group.each[0].half);
  EXPECT_EQ(group.bounds().axes, group.each[0].axes);
}

// Two cubes of edge 1 in a row, 3 apart along an edge that is slanted: their box is 4 x 1 x 1.
TEST(BoundsOfPieces, FollowTheAxesOfAPieceWhereThatIsSmaller) {
  const Isometry3d slanted = turned(M_PI / 6, Vector3d::UnitZ());
  const Bounds bounds =
      Group({pieceOf(Box{{1, 1, 1}}, slanted), pieceOf(Box{{1, 1, 1}}, slanted * at(3, 0, 0))}).bounds();
  EXPECT_LE((bounds.half - Vector3d(2.0, 0.5, 0.5)).norm(), 1e-12);
}

// Nine balls of radius 0.1 on a slanted line, which is 8 long.
TEST(BoundsOfPieces, OfManyFollowTheLineOfTheirCentres) {
  std::vector<Piece> balls;
  for (int i = 0; i < 9; ++i) balls.push_back(pieceOf(Sphere{0.1}, at(i * kHalfRoot, i * kHalfRoot, 0)));
  const Bounds bounds = Group(balls).bounds();
  EXPECT_NEAR(bounds.half.maxCoeff(), 4.1, 1e-12);
  EXPECT_NEAR(bounds.half.sum(), 4.3, 1e-12);
}

/// The point of a piece that is farthest along a unit direction, in the body's frame.
Vector3d farthestPoint(const Piece& piece, const Vector3d& direction) {
  int vertex = 0;
  const Vector3d in_piece = piece.body_T_piece.linear().transpose() * direction;
  return piece.body_T_piece * supportPoint(piece.shape, in_piece, vertex) + piece.shape.margin() * direction;
}

TEST(BoundsOfPieces, HoldEveryPointOfThem) {
  const std::vector<Shape> shapes{Sphere{0.5},
                                  Capsule{0.2, 1.0},
                                  Box{{0.3, 0.6, 1.2}},
                                  Cylinder{0.4, 0.9},
                                  Cone{0.5, 1.1},
                                  Ellipsoid{{0.2, 0.5, 0.8}},
                                  ConvexHull({{0, 0, 0}, {1, 0, 0}, {0.2, 0.9, 0}, {0.3, 0.3, 0.7}})};
  Chance chance(5);
  for (const int count : {1, 2, 7, 8, 9, 20}) {
    std::vector<Piece> pieces;
    for (int i = 0; i < count; ++i)
      pieces.push_back(pieceOf(shapes[chance.below(static_cast<int>(shapes.size()))].padded(0.01), chance.pose(2.0)));
    const Group group(pieces);
    const Bounds bounds = group.bounds();
    for (const Piece& piece : pieces) {
      for (int i = 0; i < 200; ++i) {
        const Vector3d point = farthestPoint(piece, chance.direction());
        EXPECT_LE((point - bounds.centre).norm(), bounds.radius);
        EXPECT_LE(point.norm(), bounds.reach);
        EXPECT_TRUE(
            ((bounds.axes.transpose() * (point - bounds.centre)).cwiseAbs().array() <= bounds.half.array()).all());
      }
    }
  }
}

}  // namespace proximity_server::scene::bounds_test
