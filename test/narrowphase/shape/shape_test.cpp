#include "proximity_server/narrowphase/shape/shape.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "oracle/oracle.h"
#include "oracle/shape_pairs.h"

namespace proximity_server::narrowphase {
namespace {

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
  std::mt19937 random(1);
  for (const NamedShape& named : allShapes())
    for (int i = 0; i < 200; ++i) {
      const Vector3l farthest = coreSupport(named.shape, randomDirection(random).cast<long double>());
      const long double reach = (farthest - named.shape.centre().cast<long double>()).norm();
      EXPECT_LE(reach, named.shape.coreRadius() * (1 + 4e-16L)) << named.name;
    }
}

TEST(Shape, CentreLiesInTheCore) {
  for (const NamedShape& named : allShapes())
    EXPECT_LE(outsideBy(named.shape, named.shape.centre()), 1e-16L) << named.name;
}

TEST(Shape, HullKeepsItsVertices) {
  const std::vector<Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(Shape(ConvexHull(corners)).hull().size(), 4);
}

}  // namespace
}  // namespace proximity_server::narrowphase
