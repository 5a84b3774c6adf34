// Laws that hold for every pair of shapes in every state.
#include "proximity_server/narrowphase/signed_distance.h"

#include "laws/pair_laws.h"
#include "narrowphase/certificate.h"
#include "narrowphase/scaled.h"
#include "oracle/shape_pairs.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <utility>

namespace proximity_server::narrowphase::signed_distance_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Whole arcs of directions tie where round shapes are concentric; the oracle then says how much it leaves open.
constexpr int kOracleCells = 10000;

struct KnownCase : PairCase {
  Truth truth;
};

/// Returns every pair of every kind in every state, with its true distance.
const std::vector<KnownCase>& cases() {
  static const std::vector<KnownCase> known = [] {
    std::vector<KnownCase> result;
    for (const PairCase& c : pairsInEveryState(allShapes(), repeats(2), /*seed=*/21))
      result.push_back({c, signedDistanceOracle(c.pair(), kOracleCells)});
    return result;
  }();
  return known;
}

SignedDistance distanceOf(const PairCase& c, const Options& options = {}) {
  return signedDistance(c.a, c.b, c.a_T_b, options);
}

Options withTolerance(double tolerance) {
  Options options;
  options.distance_tolerance = tolerance;
  return options;
}

TEST(SignedDistance, CasesOverlapInAThirdToTwoThirds) {
  std::size_t overlaps = 0;
  for (const KnownCase& c : cases()) overlaps += c.truth.distance < 0 ? 1 : 0;
  EXPECT_GT(overlaps, 3 * cases().size() / 10);
  EXPECT_LT(overlaps, 7 * cases().size() / 10);
}

TEST(SignedDistance, PairsOfRoomSizeConverge) {
  for (const KnownCase& c : cases()) EXPECT_EQ(distanceOf(c).status, Status::Converged) << describe(c);
}

TEST(SignedDistance, ConvergedIsWithinTheTolerance) {
  for (double tolerance = 1e-2; tolerance > 1e-13; tolerance /= 10.0)
    for (const KnownCase& c : cases()) {
      const SignedDistance result = distanceOf(c, withTolerance(tolerance));
      if (result.status != Status::Converged) continue;
      EXPECT_LE(errorOf(result, c.truth), tolerance + roundingOf(c.pair())) << tolerance << " " << describe(c);
    }
}

TEST(SignedDistance, BoundsHoldAtEveryIterationLimit) {
  for (int limit = 0; limit <= 6; ++limit)
    for (const KnownCase& c : cases()) {
      Options options;
      options.max_iterations = limit;
      const SignedDistance result = distanceOf(c, options);
      EXPECT_TRUE(carriesItsProof(c.pair(), result, options)) << limit << " " << describe(c);
      EXPECT_TRUE(enclosesTruth(c.pair(), result, c.truth)) << limit << " " << describe(c);
    }
}

TEST(SignedDistance, OfEveryKindInEveryStateKeepsEveryPromise) {
  for (const KnownCase& c : cases()) {
    const Observation seen = observe({c.a, c.b, c.a_T_b, {}, {}});
    EXPECT_FALSE(seen.failure) << seen.failure->sentence << " " << describe(c);
  }
}

TEST(SignedDistance, PowersOfTwoScaleTheDistanceBitForBit) {
  // Scaling by a power of two rounds nothing, so a difference is a constant that lacks a dimension.
  for (const double factor : {std::ldexp(1.0, -20), std::ldexp(1.0, 20)})
    for (const KnownCase& c : cases()) {
      Isometry3d pose = c.a_T_b;
      pose.translation() *= factor;
      const SignedDistance original = distanceOf(c);
      const SignedDistance grown =
          signedDistance(scaled(c.a, factor), scaled(c.b, factor), pose, withTolerance(factor * 1e-9));
      EXPECT_EQ(grown.distance, factor * original.distance) << factor << " " << describe(c);
    }
}

TEST(SignedDistance, MovingBByTheDistanceMakesTheShapesTouch) {
  for (const KnownCase& c : cases()) {
    const SignedDistance before = distanceOf(c);
    PairCase moved = c;
    moved.a_T_b.pretranslate(-before.distance * before.normal);
    EXPECT_NEAR(distanceOf(moved).distance, 0.0, 2e-9) << describe(c);
  }
}

// Thresholds around the truth, from far above it to far below, of both signs.
const double kOffsets[] = {-10.0, -0.1, -1e-3, -1e-8, 1e-8, 1e-3, 0.1, 10.0};

TEST(SignedDistance, AboveDecidesAsTheTruthDoes) {
  for (const KnownCase& c : cases())
    for (const double offset : kOffsets) {
      const double threshold = static_cast<double>(c.truth.distance) + offset;
      const SignedDistance result = distanceOf(c, Options::above(threshold));
      if (offset < 0.0) {
        EXPECT_GT(result.lower_bound, threshold) << offset << " " << describe(c);
      } else if (offset > 2e-9 + static_cast<double>(c.truth.error_bound)) {
        EXPECT_LE(result.upper_bound, threshold) << offset << " " << describe(c);
      }
    }
}

struct DeepPair {
  const char* name;
  Shape a, b;
  Isometry3d a_T_b;
  double distance;  // of the inner balls, and of the shapes: the balls touch both surfaces where the depth is least
};

std::vector<DeepPair> pairsAsDeepAsTheirInnerBalls() {
  const Isometry3d along_x(Eigen::Translation3d(0.75, 0, 0));
  Isometry3d crossed = along_x;
  crossed.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Shape cube = Box{{2, 2, 2}},
              corners = ConvexHull(
                  {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}});
  return {{"boxes", cube, cube, along_x, 0.75 - 2.0},
          {"padded boxes", cube.padded(0.25), cube.padded(0.5), along_x, 0.75 - 2.75},
          {"hulls", corners, corners, along_x, 0.75 - 2.0},
          {"hull and padded box", corners, cube.padded(0.5), along_x, 0.75 - 2.5},
          {"crossed cylinders", Cylinder{0.5, 6}, Cylinder{1, 6}, crossed, 0.75 - 1.5},
          {"ellipsoids", Ellipsoid{{1, 2, 3}}, Ellipsoid{{1, 3, 2}}, along_x, 0.75 - 2.0},
          {"sweeps", cube.sweptTo(Isometry3d(Eigen::Translation3d(0, 4, 0))), cube,
           Isometry3d(Eigen::Translation3d(0.75, 2, 0)), 0.75 - 2.0}};
}

TEST(SignedDistance, ABooleanInDeepOverlapDecidesOnBothSidesOfTheDepth) {
  for (const DeepPair& pair : pairsAsDeepAsTheirInnerBalls())
    for (const double beside : {1e-12, 1e-6, 0.01}) {
      const auto isAbove = [&](double threshold) {
        return signedDistance(pair.a, pair.b, pair.a_T_b, Options::above(threshold));
      };
      EXPECT_LE(isAbove(pair.distance + beside).upper_bound, pair.distance + beside) << pair.name;
      EXPECT_GT(isAbove(pair.distance - beside).lower_bound, pair.distance - beside) << pair.name;
    }
}

TEST(SignedDistance, ABooleanInDeepOverlapCarriesItsProof) {
  for (const DeepPair& pair : pairsAsDeepAsTheirInnerBalls())
    for (const double threshold : {pair.distance + 0.01, 0.0, 1.0}) {
      const Options options = Options::above(threshold);
      const SignedDistance result = signedDistance(pair.a, pair.b, pair.a_T_b, options);
      EXPECT_TRUE(carriesItsProof({pair.a, pair.b, pair.a_T_b}, result, options)) << pair.name << " " << threshold;
    }
}

TEST(SignedDistance, ABooleanInDeepOverlapKeepsTheWarmStartOfTheLastSearch) {
  const Shape cube = Box{{2, 2, 2}}, hull = ConvexHull({{-1, -1, -1}, {1, -1, -1}, {0, 1, -1}, {0, 0, 1}});
  WarmStart warm_start;
  signedDistance(cube, hull, Isometry3d(Eigen::Translation3d(2.5, 0.5, 0.25)), {}, warm_start);
  const WarmStart before = warm_start;
  ASSERT_GT(before.simplex_size, 0);
  const Isometry3d deep(Eigen::Translation3d(0.25, 0.125, 0));
  ASSERT_EQ(signedDistance(cube, hull, deep, Options::apart(), warm_start).status, Status::Threshold);
  EXPECT_LE((warm_start.axis - before.axis).norm(), 1e-15);
  ASSERT_EQ(warm_start.simplex_size, before.simplex_size);
  for (std::size_t i = 0; i < static_cast<std::size_t>(before.simplex_size); ++i) {
    EXPECT_EQ(warm_start.simplex[i].a, before.simplex[i].a);
    EXPECT_EQ(warm_start.simplex[i].b, before.simplex[i].b);
  }
}

/// Two shapes with centres on the x axis, along which they are the nearest to each other.
struct PairAlongX {
  const char* name;
  Shape a, b;
  double reach;  // of both along x, with margins
};

std::vector<PairAlongX> pairsAlongX() {
  const Shape ball = Sphere{0.25}, capsule = Capsule{0.125, 2}, box = Box{{1, 2, 3}}, cylinder = Cylinder{0.5, 2},
              plate = Box{{1, 2, 1e-300}};
  return {{"ball, capsule", ball, capsule, 0.375}, {"ball, box", ball, box, 0.75},
          {"capsules", capsule, capsule, 0.25},    {"boxes", box, box, 1.0},
          {"plates", plate, plate, 1.0},           {"padded boxes", box.padded(0.25), box.padded(0.125), 1.375},
          {"box, capsule", box, capsule, 0.625},   {"box, cylinder", box, cylinder, 1.0},
          {"cylinders", cylinder, cylinder, 1.0},  {"padded cylinder, ball", cylinder.padded(0.25), ball, 1.0}};
}

/// b is turned about x, so that the axes are not parallel.
Isometry3d alongX(double x) {
  Isometry3d pose = at(x, 0, 0);
  pose.linear() << 1, 0, 0, 0, 0.8, -0.6, 0, 0.6, 0.8;
  return pose;
}

TEST(SignedDistance, ABooleanDecidesOnBothSidesOfTheGapAlongTheCentres) {
  for (const PairAlongX& pair : pairsAlongX())
    for (const double scale : {1e-8, 1.0, 1e8})
      for (const double distance : {1.0, 0.125, -0.125})
        for (const double beside : {-0.01, -1e-12, 1e-12, 0.01}) {
          const Shape a = scaled(pair.a, scale), b = scaled(pair.b, scale);
          const Isometry3d a_T_b = alongX(scale * (pair.reach + distance));
          const Options options = Options::above(scale * (distance + beside));
          const SignedDistance result = signedDistance(a, b, a_T_b, options);
          EXPECT_TRUE(carriesItsProof({a, b, a_T_b}, result, options)) << pair.name << " " << scale << " " << distance;
          if (beside < 0.0)
            EXPECT_GT(result.lower_bound, options.stop_above) << pair.name << " " << scale << " " << distance;
          else if (distance < 0.0)
            EXPECT_LE(result.upper_bound, options.stop_below) << pair.name << " " << scale << " " << distance;
          else
            EXPECT_LE(result.lower_bound, options.stop_above) << pair.name << " " << scale << " " << distance;
        }
}

TEST(SignedDistance, ABooleanOfTouchingShapesIsNotAbove) {
  for (const PairAlongX& pair : pairsAlongX())
    for (const double scale : {1e-8, 1.0, 1e8}) {
      const Shape a = scaled(pair.a, scale), b = scaled(pair.b, scale);
      const Isometry3d touching = alongX(scale * pair.reach);
      const SignedDistance result = signedDistance(a, b, touching, Options::above(0.0));
      EXPECT_LE(result.lower_bound, 0.0) << pair.name << " " << scale;
      EXPECT_TRUE(carriesItsProof({a, b, touching}, result, Options::above(0.0))) << pair.name << " " << scale;
    }
}

// Scaling by a power of two rounds nothing, so that the truth is scaled, too.
TEST(SignedDistance, ABooleanEnclosesTheTruthAtAnyScale) {
  int without_points = 0;
  for (const KnownCase& c : cases())
    for (const double factor : {std::ldexp(1.0, -27), 1.0, std::ldexp(1.0, 27)})
      for (const double offset : kOffsets) {
        PairCase grown{c.name, scaled(c.a, factor), scaled(c.b, factor), c.a_T_b};
        grown.a_T_b.translation() *= factor;
        Options options = Options::above(factor * (static_cast<double>(c.truth.distance) + offset));
        options.distance_tolerance *= factor;
        const SignedDistance result = distanceOf(grown, options);
        EXPECT_TRUE(carriesItsProof(grown.pair(), result, options)) << factor << " " << offset << " " << describe(c);
        const Truth truth{factor * c.truth.distance, factor * c.truth.error_bound};
        EXPECT_TRUE(enclosesTruth(grown.pair(), result, truth)) << factor << " " << offset << " " << describe(c);
        without_points += result.has_points ? 0 : 1;
      }
  EXPECT_GT(without_points, 1000);
}

// The axis of the last query is taken for the first direction, whatever its length is. Along z the shapes seem to
// overlap.
TEST(SignedDistance, ABooleanTakesAWarmAxisOfAnyLength) {
  for (const PairAlongX& pair : pairsAlongX())
    for (const double length : {1e-320, 1e-101, 1e-99, 1e-3, 1e99, 1e101, 1e300})
      for (const Vector3d& axis : {Vector3d(length, 0, 0), Vector3d(-length, 0, 0), Vector3d(0, 0, length)}) {
        const Isometry3d a_T_b = alongX(pair.reach + 0.5);
        WarmStart warm_start;
        warm_start.axis = axis;
        const SignedDistance above = signedDistance(pair.a, pair.b, a_T_b, Options::above(0.25), warm_start);
        EXPECT_GT(above.lower_bound, 0.25) << pair.name << " " << length;
        EXPECT_TRUE(carriesItsProof({pair.a, pair.b, a_T_b}, above, Options::above(0.25)))
            << pair.name << " " << length;
        warm_start.axis = axis;
        const SignedDistance below = signedDistance(pair.a, pair.b, a_T_b, Options::above(0.75), warm_start);
        EXPECT_LE(below.upper_bound, 0.75) << pair.name << " " << length;
      }
}

TEST(SignedDistance, ABooleanOfSharedCentresIsNotAbove) {
  for (const PairAlongX& pair : pairsAlongX())
    for (const double offset : {0.0, 1e-308, 1e-165, 1e-155, 1e-149, 1e-99}) {
      const Isometry3d a_T_b = alongX(offset);
      const SignedDistance result = signedDistance(pair.a, pair.b, a_T_b, Options::above(0.0));
      EXPECT_LE(result.upper_bound, 0.0) << pair.name << " " << offset;
      EXPECT_TRUE(carriesItsProof({pair.a, pair.b, a_T_b}, result, Options::above(0.0))) << pair.name << " " << offset;
    }
}

TEST(SignedDistance, ABooleanOfACentreInsideOfABoxHasNoPoints) {
  const Shape ball = Sphere{0.25}, box = Box{{1, 2, 3}};
  const Isometry3d inside = at(0.25, 0.5, 0.75);
  EXPECT_EQ(signedDistance(ball, box, inside, Options::above(0.0)).status, Status::Converged);
  const Isometry3d near_the_centre = at(0.25, 0.125, 0.25);
  const SignedDistance result = signedDistance(ball, box, near_the_centre, Options::above(0.0));
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_FALSE(result.has_points);
  EXPECT_EQ(result.iterations, 0);
}

TEST(SignedDistance, AThresholdLeavesParallelCylindersInOverlapTheirPoints) {
  const SignedDistance result =
      signedDistance(Cylinder{0.5, 4}, Cylinder{0.25, 4}, at(0.125, 0, 0), Options::above(0.0));
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.distance, -0.625, 1e-14);
}

// The first direction, from centre to centre, does not separate the plates; their faces do, by 0.05.
TEST(SignedDistance, AFaceOfABoxDecidesAThreshold) {
  const Shape plate = Box{{4, 4, 0.2}};
  const Isometry3d stacked(Eigen::Translation3d(1.5, 0.5, 0.25));
  const SignedDistance above = signedDistance(plate, plate, stacked, Options::above(0.04));
  EXPECT_EQ(above.status, Status::Threshold);
  EXPECT_NEAR(above.lower_bound, 0.05, 2e-14);
  EXPECT_EQ(above.normal, Vector3d::UnitZ());
  EXPECT_LE(signedDistance(plate, plate, stacked, Options::above(0.06)).upper_bound, 0.06);
}

// A corner that is 0.05 deep in a face, far from the inner balls.
TEST(SignedDistance, TheDepthOfBoxesDecidesAThreshold) {
  const Shape plate = Box{{4, 4, 0.2}};
  const Isometry3d pressed(Eigen::Translation3d(3.5, 3.5, 0.15));
  EXPECT_LE(signedDistance(plate, plate, pressed, Options::above(-0.04)).upper_bound, -0.04);
  EXPECT_GT(signedDistance(plate, plate, pressed, Options::above(-0.06)).lower_bound, -0.06);
}

// A ball above a face of a cube, which is 2 from its centre: the points that prove the threshold do so by the radius of
// the ball.
TEST(SignedDistance, AMarginCountsWhereAThresholdIsDecidedFromBelow) {
  const Shape cube =
      ConvexHull({{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}});
  Options options;
  options.stop_below = 1.9;
  const Isometry3d above(Eigen::Translation3d(0.3, 0.2, 3));
  const SignedDistance result = signedDistance(cube, Sphere{0.5}, above, options);
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_LE(result.upper_bound, 1.9);
  EXPECT_LE(result.lower_bound, 1.5);
}

TEST(SignedDistance, ApartReportsAnOverlapAsSuch) {
  int overlaps = 0;
  for (const KnownCase& c : cases()) {
    if (!(c.truth.distance < -1e-6L)) continue;
    ++overlaps;
    EXPECT_LE(distanceOf(c, Options::apart()).upper_bound, 0.0) << describe(c);
  }
  EXPECT_GT(overlaps, 100);
}

TEST(SignedDistance, ApartIsExactWhereTheShapesAreApart) {
  for (const KnownCase& c : cases()) {
    if (!(c.truth.distance > 1e-6L)) continue;
    const SignedDistance result = distanceOf(c, Options::apart());
    EXPECT_EQ(result.status, Status::Converged) << describe(c);
    EXPECT_LE(errorOf(result, c.truth), 1e-9) << describe(c);
  }
}

// Regression: squares of such lengths overflow, and the lower bound was infinite.
TEST(SignedDistance, ShapesTooFarToComputeWithAreUnknown) {
  const std::vector<Shape> shapes{Sphere{1}, Box{{1, 2, 3}}, Cylinder{1, 2}, Ellipsoid{{1, 2, 3}},
                                  ConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})};
  for (const Shape& a : shapes)
    for (const Shape& b : shapes) {
      Isometry3d a_T_b = Isometry3d::Identity();
      for (const double far : {1e31, 1e155, 1e308}) {
        a_T_b.translation() = Vector3d(far, far, 0);
        EXPECT_EQ(signedDistance(a, b, a_T_b).status, Status::Unknown) << far;
      }
      a_T_b.translation() = Vector3d(3e29, 4e29, 0);
      const SignedDistance near = signedDistance(a, b, a_T_b);
      EXPECT_NEAR(near.distance, 5e29, 1e15);
      EXPECT_LE(near.lower_bound, 5e29);
      EXPECT_GE(near.upper_bound, 5e29 - 1e15);
    }
  EXPECT_EQ(signedDistance(Sphere{1e31}, Sphere{1}, Isometry3d::Identity()).status, Status::Unknown);
}

// Regression: from 1e38 m on, the square of a direction overflowed, and a lower bound was above the upper one; from
// 1e-40 m on it underflowed, and the lower bound was NaN.
TEST(SignedDistance, BoundsOfAnyComputableSizeAreThoseOfTheSameShapesInMetres) {
  const Vector3d radii(1.8, 0.6, 1.4), sizes(1.2, 0.8, 1.0);
  const auto distanceAt = [&](double scale) {
    Isometry3d a_T_b(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    a_T_b.translation() = scale * Vector3d(2.0, 1.5, 1.0);
    Options options;
    options.distance_tolerance = 1e-9 * scale;
    return signedDistance(Ellipsoid{scale * radii}, Box{scale * sizes}, a_T_b, options);
  };
  const SignedDistance in_metres = distanceAt(1.0);
  for (const int exponent : {-164, -150, -130, -98, 90, 120, 130, 150}) {
    const double scale = std::ldexp(1.0, exponent);
    const SignedDistance scaled = distanceAt(scale);
    if (scaled.status == Status::Unknown) continue;
    EXPECT_EQ(scaled.status, in_metres.status) << exponent;
    EXPECT_LE(scaled.lower_bound / scale, in_metres.upper_bound) << exponent;
    EXPECT_GE(scaled.upper_bound / scale, in_metres.lower_bound) << exponent;
  }
}

// Regression: the square of the offset has lost digits, and the normal that proves the lower bound had the length 0.7.
TEST(SignedDistance, AnOffsetOfHardlyAnyLengthGivesAUnitNormal) {
  const std::vector<Shape> shapes{Sphere{1}, Box{{1, 2, 3}}, Ellipsoid{{1, 2, 3}}, Cylinder{1, 2}};
  for (const Shape& shape : shapes) {
    Isometry3d a_T_b(Eigen::AngleAxisd(shape.kind() == Shape::Kind::Cylinder ? 0.3 : 0.0, Vector3d::UnitX()));
    for (const double offset : {1e-150, 1e-158, 1.6e-162, 1e-308}) {
      a_T_b.translation() = Vector3d(offset, 0, 0);
      const SignedDistance result = signedDistance(shape, shape, a_T_b, Options::apart());
      EXPECT_NEAR(result.normal.norm(), 1.0, 1e-15) << offset;
      EXPECT_LE(result.lower_bound, result.upper_bound) << offset;
    }
  }
}

// Regression: the square of the radii underflowed, and the upper bound was far below the distance.
TEST(SignedDistance, AnEllipsoidOfHardlyAnySizeIsItsCentre) {
  Isometry3d a_T_b = Isometry3d::Identity();
  a_T_b.translation() = Vector3d(3, 2, 1);
  for (const double size : {1e-155, 1e-170, 1e-300}) {
    const SignedDistance result = signedDistance(Ellipsoid{size * Vector3d(1, 2, 3)}, Box{{1, 1, 1}}, a_T_b);
    EXPECT_EQ(result.status, Status::Converged) << size;
    EXPECT_NEAR(result.distance, std::sqrt(2.5 * 2.5 + 1.5 * 1.5 + 0.5 * 0.5), 1e-9) << size;
  }
}

// Regression: the squares of the sizes underflowed, the normal of the slant was no unit vector, and the depth was 0.
TEST(SignedDistance, AConeOfHardlyAnySizeIsItsCentre) {
  const Isometry3d offsets[] = {Isometry3d::Identity(), at(0.1, 0, 0.2), at(0.3, 0, 2)};
  const std::pair<Shape, std::array<double, 3>> others[] = {
      {Cylinder{1, 1}, {-0.5, -0.3, 1.5}}, {Sphere{1}, {-1, std::sqrt(0.05) - 1, std::sqrt(4.09) - 1}}};
  for (const double size : {1e-155, 1e-162, 1e-164, 1e-300, 1e-318})
    for (const auto& [other, distances] : others)
      for (std::size_t i = 0; i < 3; ++i) {
        const Shape cone = Cone{size, size};
        const SignedDistance result = signedDistance(other, cone, offsets[i]);
        EXPECT_NEAR(result.distance, distances[i], 1e-14) << size;
        EXPECT_NEAR(signedDistance(cone, other, offsets[i].inverse()).distance, distances[i], 1e-14) << size;
        EXPECT_TRUE(carriesItsProof({other, cone, offsets[i]}, result)) << size;
      }
}

// Regression: the square of the length of capsules that cross lost digits, and the normal was no unit vector.
TEST(SignedDistance, ACapsuleOfHardlyAnyLengthIsASphere) {
  const Isometry3d a_T_b(Eigen::AngleAxisd(1.2, Vector3d::UnitX()));
  for (const double length : {1e-150, 1e-160, 3e-162, 1e-200})
    EXPECT_TRUE(carriesItsProof({Capsule{1, 1}, Capsule{1, length}, a_T_b},
                                signedDistance(Capsule{1, 1}, Capsule{1, length}, a_T_b)))
        << length;
}

// Regression: squares of such lengths underflow, and the bounds of an overlap were minus infinity.
TEST(SignedDistance, ShapesTooSmallToComputeWithAreUnknown) {
  for (const double size : {1e-31, 1e-100, 1e-155}) {
    const Shape ellipsoid = Ellipsoid{size * Vector3d(1, 2, 3)}, cone = Cone{size, size};
    EXPECT_EQ(signedDistance(ellipsoid, cone, Isometry3d::Identity()).status, Status::Unknown) << size;
  }
  const Shape point = ConvexHull({{0, 0, 0}});
  EXPECT_EQ(signedDistance(point, point, Isometry3d::Identity()).distance, 0.0);
}

TEST(SignedDistance, IsProportionalToTheSizeFromTheSmallestToTheLargest) {
  const auto distanceOf = [](double size, bool overlap) {
    const Shape cone = Cone{size, 2.0 * size},
                hull = ConvexHull(std::vector<Vector3d>{size * Vector3d(0, 0, 0), size * Vector3d(1, 0, 0),
                                                        size * Vector3d(0, 1, 0), size * Vector3d(0.25, 0.5, 1)});
    Isometry3d a_T_b(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()));
    a_T_b.translation() = size * (overlap ? Vector3d(0.25, 0.125, 0.5) : Vector3d(4, 2, 1));
    Options options;
    options.distance_tolerance = 1e-9 * size;
    const SignedDistance result = signedDistance(cone, hull, a_T_b, options);
    EXPECT_EQ(result.status, Status::Converged) << size;
    return result.distance / size;
  };
  for (const bool overlap : {false, true})
    for (const double size : {1e-28, 1e-20, 1e-6, 1e6, 1e20, 1e28})
      EXPECT_NEAR(distanceOf(size, overlap), distanceOf(1.0, overlap), 1e-9) << size;
}

TEST(SignedDistance, PoseThatIsNotFiniteIsUnknown) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        for (const NamedShape& a : allShapes()) {
          Isometry3d pose = Isometry3d::Identity();
          pose.matrix()(row, column) = bad;
          EXPECT_EQ(signedDistance(a.shape, Box{{1, 1, 1}}, pose).status, Status::Unknown) << a.name;
        }
}

// Regression: such axes were used as they are, and the answer converged.
TEST(SignedDistance, PoseThatIsNoRotationIsUnknown) {
  const Eigen::Matrix3d matrices[] = {Eigen::Matrix3d::Zero(),
                                      2.0 * Eigen::Matrix3d::Identity(),
                                      -Eigen::Matrix3d::Identity(),
                                      Vector3d(1, 1, -1).asDiagonal().toDenseMatrix(),
                                      Vector3d(0.5, 1, 2).asDiagonal().toDenseMatrix(),
                                      Vector3d(1, 1, 1.0 + 1e-5).asDiagonal().toDenseMatrix()};
  for (const Eigen::Matrix3d& matrix : matrices) {
    Isometry3d pose = at(3, 2, 1);
    pose.linear() = matrix;
    for (const NamedShape& a : allShapes())
      for (const NamedShape& b : allShapes())
        EXPECT_EQ(signedDistance(a.shape, b.shape, pose).status, Status::Unknown) << a.name << "-" << b.name;
  }
}

TEST(SignedDistance, ToleranceThatIsNotANumberCountsAsZero) {
  for (const KnownCase& c : cases()) {
    const SignedDistance result = distanceOf(c, withTolerance(std::numeric_limits<double>::quiet_NaN()));
    const SignedDistance of_zero = distanceOf(c, withTolerance(0.0));
    EXPECT_EQ(result.status, of_zero.status) << describe(c);
    EXPECT_EQ(result.distance, of_zero.distance) << describe(c);
    EXPECT_EQ(result.unique, of_zero.unique) << describe(c);
  }
}

TEST(SignedDistance, UnknownHoldsNoNumber) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const SignedDistance result = signedDistance(Sphere{1}, Sphere{1}, pose);
  EXPECT_TRUE(std::isnan(result.distance) && !result.has_points && result.point_a.hasNaN() && result.normal.hasNaN());
}

TEST(SignedDistance, IsUniqueWhereACornerFacesAFace) {
  Isometry3d pose = at(0, 0, 3);
  pose.linear() = Eigen::Quaterniond(0.9, 0.3, 0.2, 0.1).normalized().toRotationMatrix();
  EXPECT_TRUE(signedDistance(Box{{2, 2, 2}}, Box{{1, 1, 1}}, pose).unique);
}

TEST(SignedDistance, IsNotUniqueBetweenParallelFaces) {
  EXPECT_FALSE(signedDistance(Box{{2, 2, 2}}, Box{{1, 1, 1}}, at(0, 0, 3)).unique);
}

TEST(SignedDistance, IsNotUniqueBetweenParallelFacesOfHulls) {
  const Shape below = hullOf(boxCorners({2, 2, 2})), above = hullOf(boxCorners({1, 1, 1}));
  EXPECT_FALSE(signedDistance(below, above, at(0.1, 0.2, 3)).unique);
  EXPECT_FALSE(signedDistance(below.padded(0.1), above, at(0.1, 0.2, 3)).unique);
}

TEST(SignedDistance, IsNotUniqueForConcentricSpheres) {
  EXPECT_FALSE(signedDistance(Sphere{1}, Sphere{2}, at(0, 0, 0)).unique);
}

TEST(SignedDistance, IsNotUniqueForTheCentreOfACube) {
  EXPECT_FALSE(signedDistance(Box{{2, 2, 2}}, Sphere{0.5}, at(0, 0, 0)).unique);
}

TEST(SignedDistance, IsNotUniqueForParallelCapsules) {
  EXPECT_FALSE(signedDistance(Capsule{0.1, 1}, Capsule{0.2, 1}, at(2, 0, 0.25)).unique);
}

TEST(SignedDistance, IsNotUniqueForCoaxialCylinders) {
  EXPECT_FALSE(signedDistance(Cylinder{0.5, 4}, Cylinder{0.25, 4}, at(0, 0, 0)).unique);
}

// Regression: the search stopped at the iteration limit after up to 9 ms. The depth is nearly the same in a ring of
// directions, and least across both axes: the sum of the radii.
TEST(SignedDistance, CapsuleInATiltedCylinderConvergesInAFewIterations) {
  for (const double tilt : {1e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
    const Isometry3d a_T_b(Eigen::AngleAxisd(tilt, Vector3d(0.6, 0.8, 0.0)));
    const SignedDistance result = signedDistance(Cylinder{0.25, 0.8}, Capsule{0.1, 1.0}, a_T_b);
    EXPECT_EQ(result.status, Status::Converged) << tilt;
    EXPECT_LE(result.iterations, 64) << tilt;
    EXPECT_NEAR(result.distance, -0.35, 1e-12) << tilt;
  }
}

TEST(SignedDistance, ConcentricEllipsoidsWithARingOfEqualDepthConvergeInAFewIterations) {
  for (const double offset : {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3}) {
    const Isometry3d a_T_b(Eigen::Translation3d(offset, 0.0, 0.0));
    const SignedDistance result = signedDistance(Ellipsoid{{0.3, 0.3, 0.5}}, Ellipsoid{{0.1, 0.1, 0.2}}, a_T_b);
    EXPECT_EQ(result.status, Status::Converged) << offset;
    EXPECT_LE(result.iterations, 64) << offset;
    EXPECT_NEAR(result.distance, offset - 0.4, 1e-12) << offset;
    EXPECT_EQ(result.unique, offset > 1e-4) << offset;
  }
}

TEST(SignedDistance, CapsuleOfLengthZeroIsASphere) {
  const Isometry3d a_T_b(Eigen::Translation3d(0.1, 0.2, 0.3));
  const SignedDistance of_capsule = signedDistance(Capsule{0.2, 0.0}, Cylinder{0.5, 1.0}, a_T_b);
  const SignedDistance of_sphere = signedDistance(Sphere{0.2}, Cylinder{0.5, 1.0}, a_T_b);
  EXPECT_EQ(of_capsule.distance, of_sphere.distance);
  EXPECT_EQ(of_capsule.iterations, 0);
}

}  // namespace proximity_server::narrowphase::signed_distance_test
