// The oracle of points and lines against paper, and against rational numbers.
#include "oracle/point_oracle.h"

#include "oracle/exact_oracle.h"
#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::point_oracle_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr long double kNarrow = 1e-15L;

bool isKnown(const Shape& shape) {
  using Kind = Shape::Kind;
  if (shape.kind() == Kind::Cone || shape.kind() == Kind::Ellipsoid) return false;
  return shape.margin() == 0.0 || shape.kind() == Kind::Point || shape.kind() == Kind::Segment;
}

std::vector<NamedShape> knownShapes() {
  std::vector<NamedShape> known;
  for (const NamedShape& shape : allShapes())
    if (isKnown(shape.shape)) known.push_back(shape);
  std::mt19937 random(3);
  known.push_back({"hull of many", randomHull(random, 200, {0.5, 0.4, 0.02})});
  return known;
}

long double referenceOf(const Shape& shape, const Vector3d& point) {
  const Shape just_the_point = ConvexHull({point});
  const ShapePair pair{shape, just_the_point, Isometry3d::Identity()};
  return hasPolytopeCore(shape) ? exactDistance(pair).withMargins(pair) : signedDistanceOracle(pair).distance;
}

TEST(PointOracle, EnclosesTheDistance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> between(0.0, 1.0);
  int inside = 0, all = 0;
  for (const NamedShape& named : knownShapes()) {
    const PointOracle oracle(named.shape);
    const double size = named.shape.coreRadius() + named.shape.margin();
    for (int i = 0; i < 40; ++i) {
      const Vector3d point = named.shape.centre() + 1.5 * size * between(random) * randomDirection(random);
      const DistanceBounds found = oracle.distance(point.cast<long double>());
      const long double expected = referenceOf(named.shape, point);
      const long double rounding = 1e-17L * (1.0L + size);  // of the other oracle
      EXPECT_LE(found.low, expected + rounding) << named.name;
      EXPECT_GE(found.high, expected - rounding) << named.name;
      EXPECT_LE(found.high - found.low, kNarrow * (1.0L + size)) << named.name;
      inside += expected < 0;
      ++all;
    }
  }
  EXPECT_GT(inside, all / 8);
  EXPECT_LT(inside, all / 2);
}

TEST(PointOracle, KnowsWhereVerticesAre) {
  for (const NamedShape& named : knownShapes()) {
    if (named.shape.kind() != Shape::Kind::Hull) continue;
    const PointOracle oracle(named.shape);
    for (const Vector3d& vertex : named.shape.hull().vertices()) {
      const DistanceBounds found = oracle.distance(vertex.cast<long double>());
      EXPECT_LE(found.low, 0.0L);
      EXPECT_GE(found.high, 0.0L);
      EXPECT_LE(found.high - found.low, kNarrow) << named.name;
    }
  }
}

// A line is on the surface where it enters and leaves, inside between the two, and outside elsewhere.
TEST(PointOracle, CutsLinesAtTheSurface) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> between(0.0, 1.0);
  int hits = 0, all = 0;
  for (const NamedShape& named : knownShapes()) {
    const PointOracle oracle(named.shape);
    const long double size = named.shape.coreRadius() + named.shape.margin();
    const Vector3l centre = named.shape.centre().cast<long double>();
    for (int i = 0; i < 60; ++i) {
      const Vector3l origin = centre + 2 * size * randomDirection(random).cast<long double>();
      const Vector3l to = centre + size * between(random) * randomDirection(random).cast<long double>();
      const Vector3l direction = (to - origin).normalized();
      const PointOracle::Section section = oracle.section(origin, direction);
      const auto at = [&](long double t) { return oracle.distance(origin + t * direction); };
      ++all;
      if (section.isEmpty()) {
        for (int k = 0; k <= 40; ++k) EXPECT_GE(at(0.1L * k * size).high, 0.0L) << named.name;
        continue;
      }
      ++hits;
      for (const long double end : {section.begin, section.end}) {
        EXPECT_LE(at(end).low, kNarrow) << named.name;
        EXPECT_GE(at(end).high, -kNarrow) << named.name;
      }
      EXPECT_LE(at(0.5L * (section.begin + section.end)).low, kNarrow) << named.name;
      EXPECT_GE(at(section.begin - 1e-3L * size).high, 0.0L) << named.name;
      EXPECT_GE(at(section.end + 1e-3L * size).high, 0.0L) << named.name;
      EXPECT_NEAR(static_cast<double>(section.entry_normal.norm()), 1.0, 1e-15) << named.name;
      EXPECT_LE(section.entry_normal.dot(direction), 0.0L) << named.name;
    }
  }
  EXPECT_GT(hits, all / 5);
  EXPECT_LT(hits, 4 * all / 5);
}

TEST(PointOracle, KnowsSectionsOnPaper) {
  const auto along_x = [](const Shape& shape, const Vector3l& origin) {
    return PointOracle(shape).section(origin, Vector3l::UnitX());
  };
  EXPECT_EQ(along_x(Box{{2, 4, 6}}, {-5, 1, 1}).begin, 4.0L);
  EXPECT_EQ(along_x(Sphere{1.25}, {-5, 0.75, 0}).begin, 4.0L);
  EXPECT_EQ(along_x(Cylinder{1.25, 2}, {-5, 0.75, 1}).begin, 4.0L);
  EXPECT_EQ(along_x(Capsule{1.25, 2}, {-5, 0, 1.75}).begin, 4.0L);
  EXPECT_EQ(along_x(Capsule{1.25, 2}, {-5, 0.75, 0.5}).end, 6.0L);
  EXPECT_TRUE(along_x(Capsule{1.25, 2}, {-5, 0, 2.5}).isEmpty());
  EXPECT_TRUE(along_x(Cylinder{1.25, 2}, {-5, 0, 1.0625}).isEmpty());
  const Shape square = ConvexHull({{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}});
  EXPECT_EQ(along_x(square, {-5, 0.5, 0.5}).begin, 5.0L);
  EXPECT_TRUE(along_x(square, {-5, 1.5, 0.5}).isEmpty());
}

TEST(PointOracle, RefusesWhatItDoesNotKnow) {
  EXPECT_THROW(PointOracle(Shape(Cone{1, 1})), std::invalid_argument);
  EXPECT_THROW(PointOracle(Shape(Ellipsoid{{1, 1, 2}})), std::invalid_argument);
  EXPECT_THROW(PointOracle(Shape(Box{{1, 1, 1}}).padded(0.1)), std::invalid_argument);
}

}  // namespace proximity_server::narrowphase::point_oracle_test
