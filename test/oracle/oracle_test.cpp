// The oracle against answers that are known on paper, and against a second method where there is one.
#include "oracle/oracle.h"

#include "oracle/shape_pairs.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::narrowphase::oracle_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

long double oracle(const Shape& a, const Shape& b, const Isometry3d& a_T_b) {
  return signedDistanceOracle({a, b, a_T_b}).distance;
}

/// |actual - expected| <= tolerance; EXPECT_NEAR would round to double first.
testing::AssertionResult isNear(long double actual, long double expected, long double tolerance) {
  if (std::abs(actual - expected) <= tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "off by " << static_cast<double>(actual - expected);
}

constexpr long double kExact = 1e-17L;

struct Known {
  const char* what;
  Shape a, b;
  Isometry3d a_T_b;
  long double distance, tolerance;
};

TEST(Oracle, KnowsDistancesOnPaper) {
  const Known cases[] = {
      {"gap of spheres", Sphere{0.25}, Sphere{0.5}, at(3, 4, 0), 4.25L, kExact},
      {"depth of spheres", Sphere{0.25}, Sphere{0.5}, at(0.375, 0.5, 0), -0.125L, kExact},
      {"concentric spheres", Sphere{0.25}, Sphere{0.5}, at(0, 0, 0), -0.75L, kExact},
      {"gap of box corners: 3, 4, 12", Box{{2, 2, 2}}, Box{{2, 2, 2}}, at(5, 6, 14), 13.0L, 4 * kExact},
      {"depth of identical boxes", Box{{2, 3, 4}}, Box{{2, 3, 4}}, at(0, 0, 0), -2.0L, kExact},
      // Radius 3, height 4: slant of length 5. From the middle of the slant 1.25 outwards along (0.8, 0, 0.6).
      {"point beside the slant of a cone", Cone{3, 4}, hullOf({{2.5, 0, 0.75}}), at(0, 0, 0), 1.25L, 4 * kExact},
      {"point in a cylinder", Cylinder{2, 8}, hullOf({{0.5, 0, 0}}), at(0, 0, 0), -1.5L, 4 * kExact},
      {"ellipsoids on an axis", Ellipsoid{{2, 1, 0.5}}, Ellipsoid{{0.5, 3, 1}}, at(4, 0, 0), 1.5L, 4 * kExact},
  };
  for (const Known& c : cases) EXPECT_TRUE(isNear(oracle(c.a, c.b, c.a_T_b), c.distance, c.tolerance)) << c.what;
}

TEST(Oracle, SaysWhatItCannotProveForCoaxialCylinders) {
  const Shape thick = Cylinder{0.5, 4}, thin = Cylinder{0.25, 4};
  const Truth truth = signedDistanceOracle({thick, thin, at(0, 0, 0)}, /*max_cells=*/2000);
  EXPECT_LE(truth.distance, -0.75L + kExact);
  EXPECT_GE(truth.distance + truth.error_bound, -0.75L - kExact);
}

TEST(Oracle, CertifiesEveryPairInGeneralPosition) {
  for (const PairCase& c : pairsInEveryState(solidShapes(), 1, /*seed=*/3)) {
    if (c.name.find("concentric") != std::string::npos || c.name.find("aligned") != std::string::npos) continue;
    EXPECT_LT(signedDistanceOracle(c.pair()).error_bound, 1e-16L) << describe(c);
  }
}

/// Largest gap along the fifteen axes of two boxes: exact where they overlap (Gottschalk, Lin, Manocha 1996).
long double gapByAxes(const Shape& a, const Shape& b, const Isometry3d& a_T_b) {
  const Matrix3l rotation = a_T_b.linear().cast<long double>();
  const Matrix3l face_normals = rotation.inverse().transpose();  // the doubles of a rotation are not quite orthonormal
  std::vector<Vector3l> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(Vector3l::Unit(i));
    axes.push_back(face_normals.col(i));
    for (int j = 0; j < 3; ++j) axes.push_back(Vector3l::Unit(i).cross(rotation.col(j)));
  }
  long double largest = -std::numeric_limits<long double>::infinity();
  for (const Vector3l& axis : axes) {
    if (axis.norm() < 1e-6L) continue;
    for (const long double sign : {-1.0L, 1.0L})
      largest = std::max(largest, ShapePair{a, b, a_T_b}.gapAlong(sign * axis.normalized()));
  }
  return largest;
}

TEST(Oracle, AgreesWithTheSeparatingAxesOfOverlappingBoxes) {
  std::mt19937 random(4);
  const Shape a = Box{{0.7, 0.4, 0.9}}, b = Box{{0.3, 0.8, 0.5}};
  int overlaps = 0;
  for (int i = 0; i < 300; ++i) {
    const Isometry3d pose = randomPose(random, 1.0);
    const long double expected = gapByAxes(a, b, pose);
    if (expected >= 0) continue;
    ++overlaps;
    EXPECT_TRUE(isNear(oracle(a, b, pose), expected, kExact));
  }
  EXPECT_GT(overlaps, 90);
  EXPECT_LT(overlaps, 270);
}

TEST(Oracle, IsNeverBeatenByARandomDirection) {
  std::mt19937 random(5);
  for (const PairCase& c : pairsInEveryState(allShapes(), 1, /*seed=*/6)) {
    const Truth truth = signedDistanceOracle(c.pair(), /*max_cells=*/20000);
    for (int i = 0; i < repeats(100); ++i)
      EXPECT_LE(c.pair().gapAlong(randomDirection(random).cast<long double>().normalized()),
                truth.distance + truth.error_bound)
          << describe(c);
  }
}

struct Outside {
  const char* what;
  Shape shape;
  Vector3d point;
  double distance;
};

TEST(OutsideBy, MeasuresThePaperDistanceOfAPoint) {
  const Outside cases[] = {
      {"sphere", Sphere{1}, {0, 3, 4}, 4.0},
      {"capsule beside", Capsule{1, 4}, {3, 4, 2}, 4.0},
      {"capsule beyond its cap", Capsule{1, 4}, {0, 3, 6}, 4.0},
      {"box corner", Box{{2, 4, 6}}, {3, 4, 6}, std::sqrt(17.0)},
      {"cylinder rim", Cylinder{1, 2}, {0, 4, 5}, 5.0},
      {"cone under its base", Cone{3, 4}, {1, 1, -5}, 3.0},
      {"cone slant", Cone{3, 4}, {2.5, 0, 0.75}, 1.25},
      {"cone apex", Cone{3, 4}, {0, 0, 4.5}, 2.5},
      {"cone rim", Cone{3, 4}, {4, 0, -2}, 1.0},
      {"ellipsoid", Ellipsoid{{2, 1, 0.5}}, {0, 0, -3}, 2.5},
      {"hull", ConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {-2, 0.25, 0.25}, 2.0},
      {"padded box", Shape(Box{{2, 2, 2}}).padded(0.5), {0, 4, 5}, 4.5},
  };
  for (const Outside& c : cases) EXPECT_TRUE(isNear(outsideBy(c.shape, c.point), c.distance, 1e-15L)) << c.what;
}

TEST(OutsideBy, AgreesWithTheOracleOnPointsBeside) {
  std::mt19937 random(7);
  for (const NamedShape& named : allShapes())
    for (int i = 0; i < 10; ++i) {
      const Vector3d point = (0.8 + 0.1 * i) * randomDirection(random);
      const Shape just_the_point = ConvexHull({point});
      const long double expected = oracle(named.shape, just_the_point, Isometry3d::Identity());
      EXPECT_TRUE(isNear(outsideBy(named.shape, point), expected, 2 * kExact)) << named.name;
    }
}

TEST(OutsideBy, IsNotPositiveForPointsInside) {
  std::mt19937 random(8);
  for (const NamedShape& named : allShapes())
    for (int i = 0; i < 10; ++i) {
      const Vector3l inside = 0.999L * coreSupport(named.shape, randomDirection(random).cast<long double>()) +
                              0.001L * named.shape.centre().cast<long double>();
      EXPECT_LE(outsideBy(named.shape, inside.cast<double>()), 1e-16L) << named.name;
    }
}

}  // namespace proximity_server::narrowphase::oracle_test
