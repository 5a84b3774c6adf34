#include "narrowphase/closed_form/boxes.h"

#include "narrowphase/edge_to_edge.h"
#include "narrowphase/near.h"
#include "narrowphase/rotation_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace proximity_server::narrowphase::boxes_test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kHalf(1, 1, 1), kSmall(0.1, 0.1, 0.1);
constexpr double kTolerance = 1e-9, kRounding = 1e-14;

Isometry3d poseOf(const Vector3d& offset, const Matrix3d& rotation = Matrix3d::Identity()) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = offset;
  return pose;
}

/// Turns the diagonal of a box into `direction`.
Matrix3d diagonalAlong(const Vector3d& direction) { return rotationBetween(Vector3d(1, 1, 1), direction); }

void expectOverlap(const Vector3d& half_b, const Isometry3d& a_T_b, double depth, const Vector3d& normal,
                   const Vector3d& point_a) {
  const BoxPair boxes(kHalf, half_b, a_T_b);
  EXPECT_NEAR(boxes.separation(), -depth, 1e-14);
  EXPECT_TRUE(isNear(boxes.normal(), normal, 1e-14));
  const std::optional<SignedDistance> result = boxes.distanceAlongNormal(kTolerance, kRounding);
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->distance, -depth, 1e-14);
  EXPECT_TRUE(isNear(result->normal, normal, 1e-14));
  EXPECT_TRUE(isNear(result->point_a, point_a, 1e-14));
  EXPECT_TRUE(isNear(result->point_b, point_a - depth * normal, 1e-14));
  EXPECT_TRUE(result->unique);
}

TEST(BoxPair, SeparatesFacesAlongEachAxis) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) {
      Vector3d offset(0.5, 0.25, -0.5);
      offset[axis] = 4.0 * side;
      const Isometry3d pose = poseOf(offset);
      const BoxPair boxes(kHalf, kHalf, pose);
      EXPECT_EQ(boxes.separation(), 2.0);
      EXPECT_EQ(boxes.normal(), side * Vector3d::Unit(axis));
    }
}

// The axes of b are the y, z and x axis of a, which is 1, 2 and 3 m to its faces.
TEST(BoxPair, SeparatesUnequalBoxesWhoseAxesAreExchanged) {
  Matrix3d cycle;
  cycle << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const Vector3d half_a(1, 2, 3), half_b(0.25, 0.5, 0.75);  // b is 0.75, 0.25 and 0.5 m along x, y and z
  const Vector3d touching(1.75, 2.25, 3.5);
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d offset = touching - Vector3d(0.5, 0.5, 0.5);
    offset[axis] = touching[axis] + 0.125;
    const Isometry3d pose = poseOf(offset, cycle), back = pose.inverse();
    EXPECT_EQ(BoxPair(half_a, half_b, pose).separation(), 0.125);
    EXPECT_EQ(BoxPair(half_b, half_a, back).separation(), 0.125);
    EXPECT_EQ(BoxPair(half_a, half_b, pose).normal(), Vector3d(Vector3d::Unit(axis)));
  }
}

// The gaps along x, y and z are 3, 4 and 6; the corners are sqrt(61) apart.
TEST(BoxPair, GivesALowerBoundWhereCornersAreNearest) {
  const Isometry3d pose = poseOf({5, 6, 8});
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_EQ(boxes.separation(), 6.0);
  EXPECT_EQ(boxes.normal(), Vector3d(0, 0, 1));
}

TEST(BoxPair, SeparatesTheFaceOfTheOtherBoxFromACorner) {
  const Vector3d diagonal = Vector3d(1, 1, 1).normalized();
  const Matrix3d rotation = rotationBetween(Vector3d::UnitZ(), diagonal);
  const Isometry3d pose = poseOf((std::sqrt(3.0) + 1.0 + 0.25) * diagonal, rotation);
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_NEAR(boxes.separation(), 0.25, 1e-14);
  EXPECT_TRUE(isNear(boxes.normal(), diagonal, 1e-14));
}

TEST(BoxPair, SeparatesCrossingEdges) {
  const Isometry3d pose = edgeToEdge(0.25);
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_NEAR(boxes.separation(), 0.25, 1e-14);
  EXPECT_TRUE(isNear(boxes.normal(), Vector3d(1, 1, 0).normalized(), 1e-14));
}

// Compares every edge of a with every edge of b, whose axes are relabelled; a mirrored box would not be a rotation.
TEST(BoxPair, SeparatesEachOfTheNinePairsOfEdges) {
  const Isometry3d pose = edgeToEdge(0.25);
  Matrix3d cycle;
  cycle << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Matrix3d of_a = Matrix3d::Identity();
  for (int i = 0; i < 3; ++i, of_a = cycle * of_a) {
    Matrix3d of_b = Matrix3d::Identity();
    for (int j = 0; j < 3; ++j, of_b = cycle * of_b) {
      const Isometry3d turned = poseOf(of_a * pose.translation(), of_a * pose.linear() * of_b);
      const BoxPair boxes(kHalf, kHalf, turned);
      EXPECT_NEAR(boxes.separation(), 0.25, 1e-14);
      EXPECT_TRUE(isNear(boxes.normal(), of_a * Vector3d(1, 1, 0).normalized(), 1e-14));
    }
  }
}

TEST(BoxPair, LeadsACornerOutOfAFaceOfTheFirstBox) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) {
      const Vector3d normal = side * Vector3d::Unit(axis);
      Vector3d offset = Vector3d(0.1, 0.2, 0.3);
      offset[axis] = 0.0;
      const Isometry3d pose = poseOf(offset + (1.0 + std::sqrt(3.0) - 0.125) * normal, diagonalAlong(-normal));
      expectOverlap(kHalf, pose, 0.125, normal, offset + normal);
    }
}

TEST(BoxPair, LeadsACornerOutOfAFaceOfTheSecondBox) {
  const Vector3d corner(1, -1, 1), normal = corner.normalized();
  const Matrix3d rotation = rotationBetween(-Vector3d::UnitY(), normal);
  expectOverlap({3, 2, 3}, poseOf(corner + (2.0 - 0.125) * normal, rotation), 0.125, normal, corner);
}

TEST(BoxPair, LeadsCrossingEdgesOutAlongTheirCommonPerpendicular) {
  expectOverlap(kHalf, edgeToEdge(-0.125), 0.125, Vector3d(1, 1, 0).normalized(), {1, 1, 0.3});
}

TEST(BoxPair, LeadsCrossingEdgesOutOnTheOppositeSide) {
  Isometry3d pose = edgeToEdge(-0.125);
  pose.translation() *= -1.0;  // boxes are symmetric about their centres
  expectOverlap(kHalf, pose, 0.125, Vector3d(-1, -1, 0).normalized(), {-1, -1, -0.3});
}

TEST(BoxPair, HasNoPointsOfItsOwnWhereFacesAreParallel) {
  const Isometry3d pose = poseOf({1.5, 0.25, 0.5});
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_EQ(boxes.separation(), -0.5);
  EXPECT_EQ(boxes.normal(), Vector3d(1, 0, 0));
  EXPECT_FALSE(boxes.distanceAlongNormal(kTolerance, kRounding).has_value());
}

TEST(BoxPair, HasNoPointsOfItsOwnWhereAnEdgeLiesInAFace) {
  const Isometry3d pose = poseOf({2, 0, 0.25}, Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()).toRotationMatrix());
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_NEAR(boxes.separation(), 1.0 - std::sqrt(2.0), 1e-14);
  EXPECT_FALSE(boxes.distanceAlongNormal(kTolerance, kRounding).has_value());
}

// The corner of b is half a metre from the plane x = 1, but 0.2 m beside the face of a: no axis has points on both.
TEST(BoxPair, HasNoPointsWhereTheBoxesAreApart) {
  const Isometry3d pose = poseOf({1.0 + std::sqrt(3.0) + 0.5, 1.2, 0.25}, diagonalAlong(-Vector3d::UnitX()));
  const BoxPair boxes(kHalf, kHalf, pose);
  EXPECT_GE(boxes.separation(), 0.5 - 1e-14);
  EXPECT_LE(boxes.separation(), std::hypot(0.5, 0.2));
  EXPECT_FALSE(boxes.distanceAlongNormal(kTolerance, kRounding).has_value());
}

TEST(BoxPair, SaysThatConcentricBoxesHaveSeveralWaysOut) {
  const Isometry3d pose = poseOf({0, 0, 0}, diagonalAlong({0.3, 0.5, 0.9}));
  const Vector3d half_a(1, 2, 3);
  const BoxPair boxes(half_a, kSmall, pose);
  const std::optional<SignedDistance> result = boxes.distanceAlongNormal(kTolerance, kRounding);
  ASSERT_TRUE(result.has_value());
  EXPECT_FALSE(result->unique);  // along -x it is as deep
}

// A turn about x + y leaves x and y equal, so the box reaches as far along either.
// The face axes of both boxes are as shallow, and within the angle that counts as one direction.
TEST(BoxPair, SaysThatConcentricBoxesThatAreHardlyTurnedHaveSeveralWaysOut) {
  const Vector3d half(1, 2, 2);
  const Isometry3d a_T_b = poseOf({0, 0, 0}, Eigen::AngleAxisd(0.004, Vector3d(0, 1, 2).normalized()).matrix());
  const std::optional<SignedDistance> result = BoxPair(half, half, a_T_b).distanceAlongNormal(kTolerance, kRounding);
  ASSERT_TRUE(result.has_value());
  EXPECT_FALSE(result->unique);
}

TEST(BoxPair, SaysThatTwoFacesAreAsNear) {
  const Matrix3d rotation = Eigen::AngleAxisd(0.7, Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  for (const double y : {0.5, 0.375}) {
    const Isometry3d pose = poseOf({0.5, y, 0}, rotation);
    const BoxPair boxes(kHalf, kSmall, pose);
    const std::optional<SignedDistance> result = boxes.distanceAlongNormal(kTolerance, kRounding);
    ASSERT_TRUE(result.has_value());
    EXPECT_EQ(result->unique, y != 0.5);
  }
}

TEST(BoxPair, HasTheDistanceOfACornerInFrontOfAFace) {
  const Isometry3d pose = poseOf({1.0 + std::sqrt(3.0) + 0.5, 0.2, 0.25}, diagonalAlong(-Vector3d::UnitX()));
  expectOverlap(kHalf, pose, -0.5, Vector3d::UnitX(), {1, 0.2, 0.25});
}

void expectNearest(const Isometry3d& a_T_b, const Vector3d& on_a, const Vector3d& on_b) {
  const std::optional<NearestOfBoxes> nearest = nearestOfBoxes(kHalf, kHalf, a_T_b, kRounding);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_TRUE(isNear(nearest->on_a, on_a, 1e-14));
  EXPECT_TRUE(isNear(nearest->on_b, on_b, 1e-14));
  EXPECT_NEAR(nearest->distance, (on_b - on_a).norm(), 1e-14);
  EXPECT_NEAR(nearest->gap, nearest->distance, kRounding);
}

// The edges cross at a right angle, so that their product has the length 1.
TEST(OverlapByAxes, IsTheDepthOfEdgesThatCrossAtARightAngle) {
  const double bound = overlapByAxes(kHalf, kHalf, edgeToEdge(-0.125), kRounding);
  EXPECT_GE(bound, -0.125);
  EXPECT_NEAR(bound, -0.125, 70.0 * kRounding);
}

TEST(OverlapByAxes, IsNeverLessThanTheGreatestSeparation) {
  int overlaps = 0;
  for (int i = 1; i < 1000; ++i) {
    const Vector3d axis(std::sin(i), std::cos(2.3 * i), std::sin(1.7 * i)), half(1.0, 0.3, 2.0);
    const Matrix3d rotation = Eigen::AngleAxisd(0.37 * i + 0.5, axis.normalized()).toRotationMatrix();
    const Isometry3d pose = poseOf({1.5 * std::cos(0.9 * i), std::sin(3.1 * i), std::cos(5.3 * i)}, rotation);
    const double bound = overlapByAxes(kHalf, half, pose, kRounding),
                 separation = BoxPair(kHalf, half, pose).separation();
    EXPECT_GE(bound, separation) << i;
    overlaps += static_cast<int>(bound < 0.0);
    EXPECT_TRUE(bound < 0.0 || separation > -0.1) << i;  // products of nearly parallel edges are short
  }
  EXPECT_GT(overlaps, 500);
}

TEST(OverlapByAxes, IsThatOfTheFacesOfNearlyParallelBoxes) {
  int overlaps = 0;
  for (int i = 1; i < 2000; ++i) {
    const Vector3d axis(std::sin(i), std::cos(2.3 * i), std::sin(1.7 * i));
    const double angle = i % 5 == 0 ? 0.0 : std::pow(10.0, -3.2 - 0.006 * i);
    Matrix3d turned = Matrix3d::Zero();  // quarter turns
    for (int k = 0; k < 3; ++k) turned((k + i) % 3, k) = k == i % 2 ? -1.0 : 1.0;
    if (turned.determinant() < 0.0) turned = -turned;
    const Matrix3d rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix() * turned;
    const Vector3d half(1.0, i % 7 == 0 ? 1e-6 : 0.3, 2.0);
    const Isometry3d pose = poseOf({1.5 * std::cos(0.9 * i), std::sin(3.1 * i), std::cos(5.3 * i)}, rotation);
    const double bound = overlapByAxes(kHalf, half, pose, kRounding),
                 separation = BoxPair(kHalf, half, pose).separation();
    EXPECT_GE(bound, separation) << i;
    overlaps += static_cast<int>(bound < 0.0);
    EXPECT_TRUE(bound < 0.0 || separation > -1e-2) << i << ": " << separation;
  }
  EXPECT_GT(overlaps, 1000);
}

TEST(OverlapByAxes, IsOpenWhereTheBoxesAreApart) {
  EXPECT_TRUE(std::isinf(overlapByAxes(kHalf, kHalf, edgeToEdge(0.125), kRounding)));
  EXPECT_TRUE(std::isinf(overlapByAxes(kHalf, kHalf, poseOf({2.5, 0.25, 0}), kRounding)));
}

/// The box whose corner towards -x lies in `corner`.
Isometry3d withCornerAt(const Vector3d& corner) {
  return poseOf(corner + std::sqrt(3.0) * Vector3d::UnitX(), diagonalAlong(-Vector3d::UnitX()));
}

TEST(NearestOfBoxes, LieOnTheFaceTheEdgeOrTheCornerBeforeACorner) {
  for (const double side : {1.0, -1.0}) {
    expectNearest(withCornerAt({1.5, 0.2, 0.25}), {1, 0.2, 0.25}, {1.5, 0.2, 0.25});
    expectNearest(withCornerAt({1.5, side * 1.2, 0.25}), {1, side, 0.25}, {1.5, side * 1.2, 0.25});
    expectNearest(withCornerAt({1.5, side * 1.2, 1.3}), {1, side, 1}, {1.5, side * 1.2, 1.3});
  }
}

TEST(NearestOfBoxes, LieInTheFaceOfTheSecondBoxBeforeACornerOfTheFirst) {
  const Isometry3d b_T_a = withCornerAt({1.5, 0.2, 0.25}), a_T_b = b_T_a.inverse();
  expectNearest(a_T_b, a_T_b * Vector3d(1.5, 0.2, 0.25), a_T_b * Vector3d(1, 0.2, 0.25));
}

TEST(NearestOfBoxes, LieOnCrossingEdges) {
  const double part = 0.125 / std::sqrt(2.0);
  expectNearest(edgeToEdge(0.125), {1, 1, 0.3}, {1 + part, 1 + part, 0.3});
}

TEST(NearestOfBoxes, AreNotToldOfBoxesThatOverlapOrWhereTheyAreNotAsNearAsAsked) {
  EXPECT_FALSE(nearestOfBoxes(kHalf, kHalf, edgeToEdge(-0.125), kRounding).has_value());
  EXPECT_FALSE(nearestOfBoxes(kHalf, kHalf, withCornerAt({0.9, 0.2, 0.25}), kRounding).has_value());
  EXPECT_FALSE(nearestOfBoxes(kHalf, kHalf, poseOf({0, 0, 0}), kRounding).has_value());
  EXPECT_FALSE(nearestOfBoxes(kHalf, kHalf, edgeToEdge(0.125), -1.0).has_value());
}

TEST(BoxesMeetInOnePoint, UnlessTheirFeaturesHaveADirectionInCommon) {
  const Vector3d n = Vector3d(1, 1, 0).normalized(), x = Vector3d::UnitX();
  const Matrix3d eighth = Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()).toRotationMatrix();
  const auto meet = [](const Isometry3d& pose, const Vector3d& normal) {
    return boxesMeetInOnePoint(kHalf, kHalf, pose, normal, kTolerance);
  };
  EXPECT_TRUE(meet(withCornerAt({1.5, 0.2, 0.25}), x));  // a corner and a face
  EXPECT_TRUE(meet(edgeToEdge(0.125), n));               // crossing edges
  EXPECT_FALSE(meet(poseOf({3, 0, 0}), x));              // parallel faces
  EXPECT_FALSE(meet(poseOf({3, 3, 0}), n));              // parallel edges
  EXPECT_FALSE(meet(poseOf({3, 0, 0}, eighth), x));      // an edge and a face
}

}  // namespace proximity_server::narrowphase::boxes_test
