#include "narrowphase/closed_form/points_segments.h"

#include "narrowphase/near.h"
#include "narrowphase/rotation_between.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::points_segments_test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// The cores of a sphere and a capsule are a point and a segment from z = -1 to 1; of the box all faces lie at +-1.
const Shape kPoint = Sphere{0.5}, kSegment = Capsule{0.5, 2.0}, kBox = Box{{2.0, 2.0, 2.0}};

Isometry3d poseOf(const Vector3d& offset, const Matrix3d& rotation = Matrix3d::Identity()) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = offset;
  return pose;
}

/// The rotation that takes z to a coordinate axis or any other direction.
Matrix3d zTo(const Vector3d& direction) { return rotationBetween(Vector3d::UnitZ(), direction); }

SignedDistance expectPoints(const Shape& a, const Shape& b, const Isometry3d& a_T_b, double distance,
                            const Vector3d& normal, const Vector3d& point_a) {
  const SignedDistance result = closedForm(a, b, a_T_b);
  EXPECT_NEAR(result.distance, distance, 1e-14);
  EXPECT_TRUE(isNear(result.normal, normal, 1e-14));
  EXPECT_TRUE(isNear(result.point_a, point_a, 1e-14));
  EXPECT_TRUE(isNear(result.point_b, point_a + distance * normal, 1e-14));
  return result;
}

TEST(PointsAndSegments, MeasureTwoPoints) {
  expectPoints(kPoint, kPoint, poseOf({3, 4, 12}), 13.0, Vector3d(3, 4, 12) / 13.0, {0, 0, 0});
}

TEST(PointsAndSegments, ChooseADirectionForPointsThatCoincide) {
  const SignedDistance result = closedForm(kPoint, kPoint, poseOf({0, 0, 0}));
  EXPECT_EQ(result.distance, 0.0);
  EXPECT_EQ(result.normal.norm(), 1.0);
  EXPECT_FALSE(result.unique);
}

TEST(PointsAndSegments, MeasureAPointBesideASegment) {
  expectPoints(kSegment, kPoint, poseOf({3, 4, 0.25}), 5.0, {0.6, 0.8, 0}, {0, 0, 0.25});
  expectPoints(kPoint, kSegment, poseOf({3, 4, 0.25}), 5.0, {0.6, 0.8, 0}, {0, 0, 0});
}

TEST(PointsAndSegments, MeasureAPointBeyondEitherEndOfASegment) {
  expectPoints(kSegment, kPoint, poseOf({3, 0, 5}), 5.0, {0.6, 0, 0.8}, {0, 0, 1});
  expectPoints(kSegment, kPoint, poseOf({3, 0, -5}), 5.0, {0.6, 0, -0.8}, {0, 0, -1});
}

TEST(PointsAndSegments, MeasureCrossedSegments) {
  const Isometry3d pose = poseOf({3, 0.25, 0.5}, zTo(Vector3d::UnitY()));
  EXPECT_TRUE(expectPoints(kSegment, kSegment, pose, 3.0, {1, 0, 0}, {0, 0, 0.5}).unique);
}

TEST(PointsAndSegments, MeasureSegmentsThatCrossAskew) {
  const Vector3d along = Vector3d(0, 0.6, 0.8);
  const Isometry3d pose = poseOf(Vector3d(3, 0, 0.25) + 0.5 * along, zTo(along));
  expectPoints(kSegment, kSegment, pose, 3.0, {1, 0, 0}, {0, 0, 0.25});
}

TEST(PointsAndSegments, MeasureTheEndOfASegmentBesideAnother) {
  const Isometry3d pose = poseOf({4, 0, 0.5}, zTo(Vector3d::UnitX()));
  expectPoints(kSegment, kSegment, pose, 3.0, {1, 0, 0}, {0, 0, 0.5});
}

TEST(PointsAndSegments, MeasureTheEndsOfTwoSegments) {
  const Isometry3d pose = poseOf({4, 0, 5}, zTo(Vector3d::UnitX()));  // from (3, 0, 5) on
  const SignedDistance result = expectPoints(kSegment, kSegment, pose, 5.0, {0.6, 0, 0.8}, {0, 0, 1});
  EXPECT_NEAR(result.lower_bound, 5.0, 1e-14);
}

TEST(PointsAndSegments, MeasureParallelSegments) {
  const SignedDistance result = closedForm(kSegment, kSegment, poseOf({3, 4, 0.5}));
  EXPECT_NEAR(result.distance, 5.0, 1e-15);
  EXPECT_TRUE(isNear(result.normal, {0.6, 0.8, 0}, 1e-15));
  EXPECT_LE(std::abs(result.point_a.z()), 1.0);
  EXPECT_LE(std::abs(result.point_b.z() - 0.5), 1.0);
}

TEST(PointsAndSegments, MeasureSegmentsInOneLine) {
  expectPoints(kSegment, kSegment, poseOf({0, 0, -5}), 3.0, {0, 0, -1}, {0, 0, -1});
}

TEST(PointsAndSegments, GiveCrossingSegmentsTheirCommonPerpendicular) {
  const SignedDistance result = closedForm(kSegment, kSegment, poseOf({0, 0.25, 0.5}, zTo(Vector3d::UnitY())));
  EXPECT_NEAR(result.distance, 0.0, 1e-15);
  EXPECT_NEAR(std::abs(result.normal.x()), 1.0, 1e-15);
  EXPECT_NEAR(result.lower_bound, 0.0, 1e-15);
  EXPECT_FALSE(result.unique);
}

TEST(PointsAndSegments, GiveSegmentsThatOverlapInOneLineADirectionAcross) {
  const SignedDistance result = closedForm(kSegment, kSegment, poseOf({0, 0, 0.5}));
  EXPECT_EQ(result.distance, 0.0);
  EXPECT_NEAR(result.normal.z(), 0.0, 1e-15);
  EXPECT_NEAR(result.normal.norm(), 1.0, 1e-15);
  EXPECT_FALSE(result.unique);
}

// The difference of points that are 1e-13 apart is rounding, and would tilt the normal by 1e-3.
TEST(PointsAndSegments, KeepTheNormalOfSegmentsThatNearlyTouchAcrossBoth) {
  const Vector3d along = Vector3d(0, 0.6, 0.8);
  const Isometry3d pose = poseOf(Vector3d(1e-13, 0, 0.3) + 0.7 * along, zTo(along));
  const SignedDistance result = closedForm(kSegment, kSegment, pose);
  EXPECT_NEAR(result.distance, 1e-13, 1e-15);
  EXPECT_TRUE(isNear(result.normal, {1, 0, 0}, 1e-14));
  EXPECT_NEAR(result.lower_bound, 1e-13, 1e-15);
}

// An end of one segment is next to the middle of the other: the normal is perpendicular to the other only.
TEST(PointsAndSegments, KeepTheNormalOfAnEndThatNearlyTouchesASegmentAcrossThat) {
  const Vector3d along(0, 0.6, 0.8), normal(0, -0.8, 0.6), end_of_a(0, 0, 1);
  const Isometry3d pose = poseOf(end_of_a + 1e-13 * normal + 0.3 * along, zTo(along));
  const SignedDistance on_b = closedForm(kSegment, kSegment, pose),
                       on_a = closedForm(kSegment, kSegment, pose.inverse());
  EXPECT_TRUE(isNear(on_b.normal, normal, 1e-14));
  EXPECT_TRUE(isNear(on_a.normal, pose.linear().transpose() * -normal, 1e-14));
  for (const SignedDistance& result : {on_b, on_a}) {
    EXPECT_NEAR(result.distance, 1e-13, 1e-15);
    EXPECT_NEAR(result.lower_bound, 1e-13, 1e-15);
  }
}

// The second segment crosses in front of the first, at an angle at which its part across the first is mostly rounding
// if it is found as a difference.
TEST(PointsAndSegments, KeepTheNormalOfNearlyParallelSegments) {
  for (const double angle : {1e-3, 1e-8, 1e-13, 1e-18}) {
    Isometry3d pose = poseOf({3, 0, 0.5});
    pose.linear().col(1) = Vector3d(0, 1, -angle);
    pose.linear().col(2) = Vector3d(0, angle, 1);
    const SignedDistance result = closedForm(kSegment, kSegment, pose);
    EXPECT_NEAR(result.distance, 3.0, 1e-15) << angle;
    EXPECT_TRUE(isNear(result.normal, {1, 0, 0}, 1e-15)) << angle;
    EXPECT_NEAR(result.lower_bound, 3.0, 1e-15) << angle;
  }
}

TEST(PointsAndSegments, MeetInOnePointUnlessTheyAreParallel) {
  const auto meet = [](const Matrix3d& rotation, const Vector3d& normal) {
    return meetInOnePoint(kSegment, kSegment, poseOf({3, 0, 0}, rotation), normal, 1e-9);
  };
  const auto tiltedBy = [](double angle) {
    Matrix3d tilted = Matrix3d::Identity();
    tilted(1, 2) = angle;
    tilted(2, 1) = -angle;
    return tilted;
  };
  EXPECT_FALSE(meet(Matrix3d::Identity(), Vector3d::UnitX()));
  EXPECT_FALSE(meet(tiltedBy(1e-10), Vector3d::UnitX()));
  EXPECT_TRUE(meet(tiltedBy(1e-8), Vector3d::UnitX()));
  EXPECT_TRUE(meet(zTo(Vector3d::UnitY()), Vector3d::UnitX()));
  EXPECT_TRUE(meet(zTo(Vector3d::UnitX()), Vector3d::UnitX()));  // an end of b
  EXPECT_TRUE(meet(zTo(Vector3d::UnitX()), Vector3d::UnitZ()));  // an end of a
}

TEST(PointsAndSegments, MeasureAPointOverAFaceAnEdgeAndACornerOfABox) {
  expectPoints(kBox, kPoint, poseOf({0.25, -3, 0.5}), 2.0, {0, -1, 0}, {0.25, -1, 0.5});
  expectPoints(kBox, kPoint, poseOf({4, 0.5, 5}), 5.0, {0.6, 0, 0.8}, {1, 0.5, 1});
  expectPoints(kBox, kPoint, poseOf({-4, -5, 13}), 13.0, Vector3d(-3, -4, 12) / 13.0, {-1, -1, 1});
}

TEST(PointsAndSegments, LeadAPointOutOfTheNearestFaceOfABox) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) {
      Vector3d point(0.25, -0.5, 0.125);
      point[axis] = 0.75 * side;
      Vector3d surface = point;
      surface[axis] = side;
      EXPECT_TRUE(expectPoints(kBox, kPoint, poseOf(point), -0.25, side * Vector3d::Unit(axis), surface).unique);
    }
}

TEST(PointsAndSegments, SayThatSeveralFacesAreAsNear) {
  EXPECT_FALSE(closedForm(kBox, kPoint, poseOf({0, 0, 0})).unique);
  EXPECT_FALSE(closedForm(kBox, kPoint, poseOf({0.5, 0.5, 0})).unique);
  EXPECT_EQ(closedForm(kBox, kPoint, poseOf({0.5, 0.5, 0})).distance, -0.5);
}

// The box is turned by 45 degrees about z: its edge points to the point.
TEST(PointsAndSegments, MeasureATurnedBoxFromAPoint) {
  const Matrix3d turn = Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()).toRotationMatrix();
  expectPoints(kPoint, kBox, poseOf({4, 0, 0.5}, turn), 4.0 - std::sqrt(2.0), {1, 0, 0}, {0, 0, 0});
  const Vector3d normal = Vector3d(1, 1, 0).normalized();  // of a face
  expectPoints(kPoint, kBox, poseOf(3.0 * normal, turn), 2.0, normal, {0, 0, 0});
  expectPoints(kPoint, kBox, poseOf(0.75 * normal, turn), -0.25, normal, {0, 0, 0});
}

}  // namespace proximity_server::narrowphase::points_segments_test
