#include "proximity_server/narrowphase/shape/shape.h"

#include "chance.h"
#include "oracle/oracle.h"
#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

namespace proximity_server::narrowphase::shape_test {

using Eigen::Vector3d;

const double kNotPositive[] = {0.0, -0.1, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()};

/// The message of the std::invalid_argument that `make` throws; "" where it throws none.
template <typename Make>
std::string refusal(Make make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Shape, NamesTheRadiusThatIsNotPositive) {
  for (const double bad : kNotPositive) {
    EXPECT_NE(refusal([bad] { Shape(Sphere{bad}); }).find("radius"), std::string::npos) << bad;
    EXPECT_NE(refusal([bad] { Shape(Capsule{bad, 1}); }).find("radius"), std::string::npos) << bad;
    EXPECT_NE(refusal([bad] { Shape(Cylinder{bad, 1}); }).find("radius"), std::string::npos) << bad;
    EXPECT_NE(refusal([bad] { Shape(Cone{bad, 1}); }).find("radius"), std::string::npos) << bad;
    EXPECT_NE(refusal([bad] { Shape(Ellipsoid{{1, bad, 1}}); }).find("radius"), std::string::npos) << bad;
  }
}

TEST(Shape, NamesTheLengthThatIsNotPositive) {
  for (const double bad : kNotPositive) {
    EXPECT_NE(refusal([bad] { Shape(Cylinder{1, bad}); }).find("length"), std::string::npos) << bad;
    EXPECT_NE(refusal([bad] { Shape(Cone{1, bad}); }).find("length"), std::string::npos) << bad;
  }
}

TEST(Shape, RefusesABoxWithoutSize) {
  for (const double bad : kNotPositive)
    for (int axis = 0; axis < 3; ++axis) {
      Vector3d size(1, 1, 1);
      size[axis] = bad;
      EXPECT_NE(refusal([size] { Shape(Box{size}); }).find("size"), std::string::npos) << bad;
    }
}

TEST(Shape, RefusesACapsuleOfNegativeLength) {
  EXPECT_NE(refusal([] { Shape(Capsule{1, -1e-9}); }).find("length"), std::string::npos);
}

TEST(Shape, TakesACapsuleWithoutLengthForASphere) {
  const Shape capsule = Capsule{0.5, 0}, sphere = Sphere{0.5};
  EXPECT_EQ(outsideBy(capsule, {3, 4, 0}), outsideBy(sphere, {3, 4, 0}));
}

TEST(Shape, PaddingAddsToTheMargin) { EXPECT_EQ(Shape(Sphere{0.5}).padded(0.25).padded(0.125).margin(), 0.875); }

TEST(Shape, PaddingKeepsTheCore) {
  const Shape box = Box{{1, 2, 3}};
  EXPECT_EQ(box.padded(0.5).halfExtents(), box.halfExtents());
}

TEST(Shape, PaddingMayShrinkAMarginToZero) { EXPECT_EQ(Shape(Box{{1, 1, 1}}).padded(0.5).padded(-0.5).margin(), 0.0); }

TEST(Shape, RefusesPaddingThatMakesTheMarginNegative) {
  EXPECT_THROW(Shape(Sphere{0.5}).padded(-0.75), std::invalid_argument);
  EXPECT_THROW(Shape(Box{{1, 1, 1}}).padded(-1e-9), std::invalid_argument);
}

TEST(Shape, RefusesPaddingThatIsNotFinite) {
  EXPECT_THROW(Shape(Sphere{1}).padded(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(Shape(Sphere{1}).padded(std::numeric_limits<double>::infinity()), std::invalid_argument);
}

TEST(Shape, CoreRadiusIsTheReachOfTheCoreFromItsCentre) {
  EXPECT_EQ(Shape(Sphere{0.5}).coreRadius(), 0.0);
  EXPECT_EQ(Shape(Capsule{0.5, 3}).coreRadius(), 1.5);
  EXPECT_EQ(Shape(Box{{2, 4, 4}}).coreRadius(), 3.0);
  EXPECT_EQ(Shape(Cylinder{3, 8}).coreRadius(), 5.0);
  EXPECT_EQ(Shape(Cone{3, 8}).coreRadius(), 5.0);
  EXPECT_EQ(Shape(Ellipsoid{{1, 3, 2}}).coreRadius(), 3.0);
  EXPECT_NEAR(Shape(ConvexHull({{0, 0, 0}, {6, 0, 0}, {6, 8, 0}, {0, 8, 0}})).coreRadius(), 5.0, 1e-15);
}

TEST(Shape, BallAroundTheCentreHoldsTheCore) {
  Chance random(1);
  for (const NamedShape& named : allShapes())
    for (int i = 0; i < 200; ++i) {
      const Vector3l farthest = coreSupport(named.shape, randomDirection(random).cast<long double>());
      const long double reach = (farthest - named.shape.centre().cast<long double>()).norm();
      EXPECT_LE(reach, named.shape.coreRadius() * (1 + 4e-16L)) << named.name;
    }
}

TEST(Shape, InnerRadiusIsTheLeastDistanceOfTheSurfaceFromTheCentre) {
  EXPECT_EQ(Shape(Sphere{0.5}).innerRadius(), 0.0);
  EXPECT_EQ(Shape(Capsule{0.5, 3}).innerRadius(), 0.0);
  EXPECT_EQ(Shape(Box{{4, 2, 6}}).innerRadius(), 1.0);
  EXPECT_EQ(Shape(Cylinder{3, 8}).innerRadius(), 3.0);
  EXPECT_EQ(Shape(Cylinder{3, 4}).innerRadius(), 2.0);
  EXPECT_EQ(Shape(Cone{3, 4}).innerRadius(), 1.2);  // half of the height of the right triangle with sides 3 and 4
  EXPECT_EQ(Shape(Ellipsoid{{2, 1, 3}}).innerRadius(), 1.0);
  EXPECT_EQ(Shape(Box{{4, 2, 6}}).padded(0.5).innerRadius(), 1.0);
}

TEST(Shape, InnerRadiusOfAHullIsTheLeastDistanceOfAFaceLessItsRounding) {
  std::vector<Vector3d> corners;
  for (const double x : {8.0, 12.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-3.0, 3.0}) corners.emplace_back(x, y, z);
  const double radius = Shape(ConvexHull(corners)).innerRadius();
  EXPECT_LT(radius, 1.0);
  EXPECT_NEAR(radius, 1.0, 1e-13);
}

TEST(Shape, AFlatHullHasNoInnerBall) {
  for (const ConvexHull& flat :
       {ConvexHull({{0, 0, 0}, {6, 0, 0}, {6, 8, 0}, {0, 8, 0}}), ConvexHull({{0, 0, 0}, {6, 0, 0}})}) {
    EXPECT_LE(Shape(flat).innerRadius(), 0.0);
    EXPECT_GE(Shape(flat).innerRadius(), -1e-13);
  }
}

TEST(Shape, ASweepKeepsTheInnerRadius) {
  const Shape sweep = Shape(Box{{4, 2, 6}}).sweptTo(Eigen::Isometry3d(Eigen::Translation3d(8, 0, 0)));
  EXPECT_EQ(sweep.innerRadius(), 1.0);
}

/// Directions in which the core may reach least far: random ones, and across each face of a hull.
std::vector<Vector3d> directionsOf(const Shape& shape, Chance& random) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < 200; ++i) directions.push_back(randomDirection(random));
  if (shape.kind() != Shape::Kind::Hull) return directions;
  const std::vector<Vector3d>& corners = shape.hull().vertices();
  for (const auto& t : shape.hull().triangles()) {
    const auto corner = [&](std::size_t i) { return corners[t[i]]; };
    const Vector3d area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (area.norm() > 0.0) directions.push_back(area.normalized());
  }
  return directions;
}

/// A convex core holds a ball if it reaches at least as far in every direction.
void expectInnerBall(const Shape& shape, Chance& random, const std::string& name) {
  for (const Vector3d& direction : directionsOf(shape, random)) {
    const Vector3l unit = direction.cast<long double>().normalized();
    const long double reach = unit.dot(coreSupport(shape, unit) - shape.centre().cast<long double>());
    EXPECT_GE(reach, shape.innerRadius() * (1 - 4e-16L) - 1e-19L) << name;
  }
}

TEST(Shape, InnerBallLiesInTheCore) {
  Chance random(3);
  for (const NamedShape& named : allShapes()) expectInnerBall(named.shape, random, named.name);
}

// Slivers, far from the origin, and so thin that rounding decides on which side of a face the centre lies.
TEST(Shape, InnerBallLiesInAHullOfAnyThinness) {
  Chance random(4);
  int with_ball = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d size(1.0, std::pow(10.0, -0.05 * (i % 300)), std::pow(10.0, -0.02 * (i % 200)));
    std::vector<Vector3d> cloud;
    const Vector3d away = (i % 3) * 10.0 * randomDirection(random);
    for (int k = 0; k < 4 + i % 30; ++k) cloud.push_back(away + size.cwiseProduct(randomDirection(random)));
    const Shape hull = ConvexHull(cloud);
    with_ball += hull.innerRadius() > 0.0;
    expectInnerBall(hull, random, std::to_string(i));
  }
  EXPECT_GT(with_ball, 150);
  EXPECT_LT(with_ball, 300);
}

TEST(Shape, CentreLiesInTheCore) {
  for (const NamedShape& named : allShapes())
    EXPECT_LE(outsideBy(named.shape, named.shape.centre()), 1e-16L) << named.name;
}

TEST(Shape, HullKeepsItsVertices) {
  const std::vector<Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(Shape(ConvexHull(corners)).hull().size(), 4);
}

}  // namespace proximity_server::narrowphase::shape_test
