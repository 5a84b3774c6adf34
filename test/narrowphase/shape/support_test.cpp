#include "proximity_server/narrowphase/shape/support.h"

#include "narrowphase/near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace proximity_server::narrowphase::support_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Shape kPoint = Sphere{0.5}, kSegment = Capsule{0.5, 2.0}, kBox = Box{{2.0, 4.0, 6.0}};
const Shape kCylinder = Cylinder{1.0, 4.0}, kCone = Cone{1.0, 2.0}, kEllipsoid = Ellipsoid{{1, 2, 3}};
const std::vector<Vector3d> kOctahedron{{1, 0, 0}, {-1, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 3}, {0, 0, -3}};

Shape hullOf(const std::vector<Vector3d>& points) { return ConvexHull(points); }

double radial(const Vector3d& v) { return std::hypot(v.x(), v.y()); }

/// The directions to the points of a lattice: axes, diagonals, and much in between.
std::vector<Vector3d> directions() {
  std::vector<Vector3d> result;
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y)
      for (int z = -4; z <= 4; ++z)
        if (x != 0 || y != 0 || z != 0) result.push_back(Vector3d(x, y, z).normalized());
  return result;
}

/// A core, how far it reaches along a direction, and whether a point lies in it: all on paper.
struct Core {
  const char* name;
  Shape shape;
  std::function<double(const Vector3d&)> reach;
  std::function<double(const Vector3d&)> excess;  ///< of a point: at most 0 inside
};

double mostOf(const std::vector<Vector3d>& points, const Vector3d& d) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vector3d& p : points) most = std::max(most, d.dot(p));
  return most;
}

double beyondHalf(const Vector3d& p, const Vector3d& half) { return (p.cwiseAbs() - half).maxCoeff(); }

std::vector<Core> cores() {
  // From the box at the identity to one a quarter turn about z and 5 m along y.
  const Isometry3d end = Eigen::Translation3d(0, 5, 0) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  const Vector3d half(1, 2, 3), turned(2, 1, 3);
  return {
      {"point", kPoint, [](const Vector3d&) { return 0.0; }, [](const Vector3d& p) { return p.norm(); }},
      {"segment", kSegment, [](const Vector3d& d) { return std::abs(d.z()); },
       [](const Vector3d& p) {
         return beyondHalf(p, {0, 0, 1});
       }},
      {"box", kBox, [half](const Vector3d& d) { return half.dot(d.cwiseAbs()); },
       [half](const Vector3d& p) { return beyondHalf(p, half); }},
      {"cylinder", kCylinder, [](const Vector3d& d) { return radial(d) + 2.0 * std::abs(d.z()); },
       [](const Vector3d& p) { return std::max(radial(p) - 1.0, std::abs(p.z()) - 2.0); }},
      {"cone", kCone, [](const Vector3d& d) { return std::max(d.z(), radial(d) - d.z()); },
       [](const Vector3d& p) { return std::max(-1.0 - p.z(), radial(p) - (1.0 - p.z()) / 2.0); }},
      {"ellipsoid", kEllipsoid, [half](const Vector3d& d) { return half.cwiseProduct(d).norm(); },
       [half](const Vector3d& p) { return p.cwiseQuotient(half).norm() - 1.0; }},
      {"hull", hullOf(kOctahedron), [](const Vector3d& d) { return mostOf(kOctahedron, d); },
       [half](const Vector3d& p) { return p.cwiseQuotient(half).lpNorm<1>() - 1.0; }},
      {"sweep", kBox.sweptTo(end),
       [half, turned](const Vector3d& d) {
         return std::max(half.dot(d.cwiseAbs()), turned.dot(d.cwiseAbs()) + 5.0 * d.y());
       },
       [half, turned](const Vector3d& p) {
         return std::min(beyondHalf(p, half), beyondHalf(p - Vector3d(0, 5, 0), turned));
       }},
  };
}

TEST(SupportPoint, LiesOnTheCoreAndNoPointOfItLiesFarther) {
  for (const Core& core : cores()) {
    SCOPED_TRACE(core.name);
    int vertex = 0;
    for (const Vector3d& direction : directions()) {
      const Vector3d point = supportPoint(core.shape, direction, vertex);
      ASSERT_LE(core.excess(point), 1e-14) << direction.transpose();
      ASSERT_NEAR(direction.dot(point), core.reach(direction), 1e-14) << direction.transpose();
    }
  }
}

TEST(SupportPoint, DoesNotDependOnTheLengthOfTheDirection) {
  for (const Core& core : cores())
    for (const double length : {1e-100, 1e-9, 1e9, 1e100}) {
      SCOPED_TRACE(core.name);
      int vertex = 0;
      const Vector3d unit = Vector3d(0.6, -0.64, 0.48);
      const Vector3d expected = supportPoint(core.shape, unit, vertex);
      EXPECT_TRUE(isNear(supportPoint(core.shape, length * unit, vertex), expected, 1e-14)) << length;
    }
}

TEST(SupportPoint, OfARimIsTheCentreWhereTheDirectionIsTheAxis) {
  int vertex = 0;
  EXPECT_EQ(supportPoint(kCylinder, {0, 0, -1}, vertex), Vector3d(0, 0, -2));
  EXPECT_EQ(supportPoint(kCone, {0, 0, -1}, vertex), Vector3d(0, 0, -1));
  EXPECT_EQ(supportPoint(kCylinder, {1e-200, 0, 1}, vertex), Vector3d(0, 0, 2));
}

TEST(SupportPoint, OfAPolytopeHasTheNumberOfItsVertex) {
  for (const Core& core : cores()) {
    if (!core.shape.isPolytope()) continue;
    SCOPED_TRACE(core.name);
    int vertex = 0;
    for (const Vector3d& direction : directions()) {
      const Vector3d point = supportPoint(core.shape, direction, vertex);
      ASSERT_TRUE(isNear(vertexOf(core.shape, vertex), point, 1e-15));
    }
  }
}

TEST(VertexOf, GivesAVertexForAnyNumber) {
  for (const Core& core : cores()) {
    if (!core.shape.isPolytope()) continue;
    for (const int number : {-7, 8, 1000}) {
      const auto is_farthest = [&](const Vector3d& direction) {
        int vertex = 0;
        return supportPoint(core.shape, direction, vertex) == vertexOf(core.shape, number);
      };
      const std::vector<Vector3d> all = directions();
      EXPECT_TRUE(std::any_of(all.begin(), all.end(), is_farthest)) << core.name << " " << number;
    }
  }
}

TEST(VertexOf, NumbersTheCornersOfABoxByTheirSigns) {
  EXPECT_EQ(vertexOf(kBox, 0), Vector3d(1, 2, 3));
  EXPECT_EQ(vertexOf(kBox, 1), Vector3d(-1, 2, 3));
  EXPECT_EQ(vertexOf(kBox, 2), Vector3d(1, -2, 3));
  EXPECT_EQ(vertexOf(kBox, 4), Vector3d(1, 2, -3));
}

constexpr double kTolerance = 1e-9;

SupportFeature featureOf(const Shape& shape, const Vector3d& direction) {
  int vertex = 0;
  supportPoint(shape, direction, vertex);
  return supportFeature(shape, direction.normalized(), kTolerance, vertex);
}

/// An edge along `along`, in either direction; of a dimension other than 1 there is none.
void expectFeature(const Shape& shape, const Vector3d& direction, int dimension,
                   const Vector3d& along = Vector3d::Zero()) {
  const SupportFeature feature = featureOf(shape, direction);
  ASSERT_EQ(feature.dimension, dimension) << direction.transpose();
  if (dimension != 1) return;
  EXPECT_TRUE(isNear(feature.along, feature.along.dot(along) < 0.0 ? Vector3d(-along) : along, 1e-14));
}

TEST(SupportFeature, OfABoxIsAFaceAnEdgeOrACorner) {
  expectFeature(kBox, {0, 0, -1}, 2);
  expectFeature(kBox, {1, 0, 0}, 2);
  expectFeature(kBox, {0, 1, -1}, 1, {2, 0, 0});
  expectFeature(kBox, {1, 0, 1}, 1, {0, 4, 0});
  expectFeature(kBox, {-1, 2, 0}, 1, {0, 0, 6});
  expectFeature(kBox, {1, 1, 1}, 0);
}

TEST(SupportFeature, DoesNotDependOnTheVertexThatIsGiven) {
  const Shape octahedron = hullOf(kOctahedron),
              swept = octahedron.sweptTo(Eigen::Isometry3d(Eigen::Translation3d(0, 5, 0)));
  for (const Shape& shape : {octahedron, swept})
    for (const Vector3d& direction : directions()) {
      const SupportFeature expected = featureOf(shape, direction);
      for (const int vertex : {-1, 0, 1, 2, 3, 4, 5, 6, 1000}) {
        const SupportFeature feature = supportFeature(shape, direction.normalized(), kTolerance, vertex);
        ASSERT_EQ(feature.dimension, expected.dimension) << direction.transpose() << ", vertex " << vertex;
        if (feature.dimension == 1) {
          ASSERT_TRUE(isNear(feature.along.cross(expected.along), Vector3d::Zero(), 1e-14));
        }
      }
    }
}

// Over 6 m a face falls by the tolerance at 1e-9 / 6 rad.
TEST(SupportFeature, CountsWhatFallsByNoMoreThanTheTolerance) {
  expectFeature(kBox, {1, 0, 1.6e-10}, 2);
  expectFeature(kBox, {1, 0, 1.7e-10}, 1, {0, 4, 0});
}

TEST(SupportFeature, OfAPointAndAnEllipsoidIsAPoint) {
  expectFeature(kPoint, {1, 0, 0}, 0);
  expectFeature(kEllipsoid, {1, 0, 0}, 0);
}

TEST(SupportFeature, OfASegmentIsAllOfItOrAnEnd) {
  expectFeature(kSegment, {1, 1, 0}, 1, {0, 0, 2});
  expectFeature(kSegment, {1, 1, 0.01}, 0);
  expectFeature(Capsule{0.5, 0.0}, {1, 1, 0}, 0);  // a sphere
}

TEST(SupportFeature, OfACylinderIsAnEndALineOrAPoint) {
  expectFeature(kCylinder, {0, 0, 1}, 2);
  expectFeature(kCylinder, {0, 0, -1}, 2);
  expectFeature(kCylinder, {3, 4, 0}, 1, {0, 0, 4});
  expectFeature(kCylinder, {3, 4, 1}, 0);
}

TEST(SupportFeature, OfAConeIsItsBaseALineOrAPoint) {
  expectFeature(kCone, {0, 0, -1}, 2);
  expectFeature(kCone, {0, 0, 1}, 0);
  expectFeature(kCone, {2, 0, 1}, 1, {-1, 0, 2});  // from the rim to the apex
  expectFeature(kCone, {2, 0, 0.9}, 0);
}

TEST(SupportFeature, OfAHullIsAFaceAnEdgeOrAVertex) {
  const Shape octahedron = hullOf(kOctahedron);
  expectFeature(octahedron, {6, 3, 2}, 2);
  expectFeature(octahedron, {6, 3, 1}, 1, {-1, 2, 0});
  expectFeature(octahedron, {1, 0, 0}, 0);
  expectFeature(hullOf({{0, 0, 0}, {1, 2, 3}}), {3, 0, -1}, 1, {1, 2, 3});
}

TEST(SupportFeature, OfASweptPointIsTheWay) {
  const Shape way = hullOf({{0, 0, 0}}).sweptTo(Isometry3d(Eigen::Translation3d(0, 3, 0)));
  expectFeature(way, {1, 0, 1}, 1, {0, 3, 0});
  expectFeature(way, {0, 1, 0}, 0);
  expectFeature(way, {0, -1, 0}, 0);
}

TEST(SupportFeature, OfASweptSegmentIsAParallelogramOrOneOfItsSides) {
  const Shape swept = kSegment.sweptTo(Isometry3d(Eigen::Translation3d(0, 3, 1)));
  expectFeature(swept, {1, 0, 0}, 2);
  expectFeature(swept, {0, 1, 0}, 1, {0, 0, 2});
  expectFeature(swept, {0, -1, 0}, 1, {0, 0, 2});
  expectFeature(swept, {0, -1, 3}, 1, {0, 3, 1});
  expectFeature(swept, {0, 0, 1}, 0);
}

// Regression: the square of what the direction leaves of the radii lost digits, and the point lay a fifth of the radius
// outside.
TEST(SupportPoint, LiesInAnEllipsoidThatIsHardlyThick) {
  const Vector3d radii(3e-38, 8e-225, 0.12);
  for (const double tilt : {1e-160, 2.2e-161, 2e-161, 1e-220}) {
    int vertex = 0;
    const Vector3d point = supportPoint(Ellipsoid{radii}, {0, 1, tilt}, vertex);
    EXPECT_LE(point.cwiseQuotient(radii).norm(), 1.0 + 1e-15) << tilt;
  }
}

}  // namespace proximity_server::narrowphase::support_test
