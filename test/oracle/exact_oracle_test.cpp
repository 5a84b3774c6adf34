// The exact oracle against paper and against the long double oracle; and the library against it.
#include "oracle/exact_oracle.h"

#include "narrowphase/certificate.h"
#include "oracle/shape_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>

namespace proximity_server::narrowphase::exact_oracle_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Known {
  const char* what;
  Shape a, b;
  Isometry3d a_T_b;
  bool overlap;
  mpq_class squared;
};

TEST(ExactOracle, KnowsDistancesOnPaper) {
  const double ulp = std::ldexp(1.0, -52);
  // The slanted face is x + y + z = 0; the point stands 1/4 / sqrt(3) below it and 7/8 or more above the others.
  const Shape corner = ConvexHull({{-1, -1, -1}, {2, -1, -1}, {-1, 2, -1}, {-1, -1, 2}}), point = hullOf({{0, 0, 0}});
  const Shape square = ConvexHull({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
  const Shape one = Box{{1, 1, 1}}, two = Box{{2, 2, 2}};
  Isometry3d sheared = at(3, 0, 0);
  sheared.linear()(0, 0) = 1 + ulp;  // b reaches that much farther towards a
  const mpq_class gap = mpq_class(1) - mpq_class(ulp);
  const Known cases[] = {
      {"gap of box corners: 3, 4, 12", two, two, at(5, 6, 14), false, 169},
      {"gap of the last bit of a double", one, one, at(1 + ulp, 0, 0), false, mpq_class(ulp * ulp)},
      {"touching is an overlap of depth 0", one, one, at(1, 0.25, 0.5), true, 0},
      {"depth of identical boxes", Box{{2, 3, 4}}, Box{{2, 3, 4}}, at(0, 0, 0), true, 4},
      {"depth that is no double", corner, point, at(-0.125, -0.125, 0), true, mpq_class(1, 48)},
      {"flat overlap", square, square, at(0.5, 0.25, 0), true, 0},
      {"the rotation as it is", two, two, sheared, false, gap * gap},
  };
  for (const Known& c : cases) {
    const ExactDistance d = exactDistance({c.a, c.b, c.a_T_b});
    EXPECT_EQ(d.overlap, c.overlap) << c.what;
    EXPECT_EQ(d.squared, c.squared) << c.what;
  }
}

TEST(ExactOracle, RoundsOnlyTheResult) {
  const ExactDistance d{false, 2};
  const Shape point = Sphere{0.25};
  const Isometry3d anywhere = Isometry3d::Identity();
  EXPECT_EQ(d.withMargins({point, point, anywhere}), std::sqrt(2.0L) - 0.5L);
}

std::vector<NamedShape> polytopes() {
  std::vector<NamedShape> result;
  for (const NamedShape& s : allShapes())
    if (hasPolytopeCore(s.shape)) result.push_back(s);
  return result;
}

TEST(ExactOracle, AgreesWithTheLongDoubleOracleOnEveryPolytopePair) {
  int apart = 0, overlapping = 0;
  for (const PairCase& c : pairsInEveryState(polytopes(), 1, /*seed=*/71)) {
    const Truth truth = signedDistanceOracle(c.pair());
    const long double exact = exactDistance(c.pair()).withMargins(c.pair());
    // gapAlong() rounds by as much, see signedDistanceOracle().
    const long double rounding = 16 * std::numeric_limits<long double>::epsilon() * c.pair().scale();
    EXPECT_GE(exact, truth.distance - rounding) << describe(c);
    EXPECT_LE(exact, truth.distance + truth.error_bound + rounding) << describe(c);
    (exact > 0 ? apart : overlapping) += 1;
  }
  EXPECT_GT(apart, 50);
  EXPECT_GT(overlapping, 50);
}

// ---- the library against it

/// One step of the last bit up or down, or none, in each of the nine entries.
void jitter(Isometry3d& pose, std::mt19937& random) {
  for (int i = 0; i < 9; ++i) {
    double& entry = pose.linear()(i / 3, i % 3);
    entry = std::nextafter(entry, entry + (static_cast<int>(random() % 3) - 1));
  }
}

/// The shapes whose answers must be exact, in sizes about `size`.
std::vector<NamedShape> polytopesOfSize(double size, std::mt19937& random) {
  const auto hull = [&](int points) { return randomHull(random, points, size * Vector3d(0.45, 0.38, 0.33)); };
  const auto scaled = [&](std::vector<Vector3d> points) {
    for (Vector3d& p : points) p *= size;
    return Shape(ConvexHull(points));
  };
  return {{"box", Box{size * Vector3d(0.61, 0.83, 0.47)}},
          {"hull of 8", hull(8)},
          {"hull of 16", hull(16)},
          {"hull of 32", hull(32)},
          {"polygon", scaled({{0.4, 0.0, 0.0}, {0.1, 0.35, 0.0}, {-0.3, 0.2, 0.0}, {-0.2, -0.4, 0.0}})},
          {"segment", scaled({{-0.2, 0.1, 0.3}, {0.25, -0.3, -0.1}})},
          {"point", scaled({{0.05, -0.02, 0.03}})}};
}

struct Tally {
  int apart = 0;
  int overlapping = 0;
  long double worst = 0;  ///< error over scale
};

/// The error of the distance is at most 1e-14 times the size: ShapePair::scale, the radius of the ball around the
/// origin of a's frame that holds both shapes.
void expectExact(const PairCase& c, Tally& tally) {
  const SignedDistance result = signedDistance(c.a, c.b, c.a_T_b);
  const long double exact = exactDistance(c.pair()).withMargins(c.pair());
  const long double error = std::abs(result.distance - exact) / c.pair().scale();
  EXPECT_LE(error, 1e-14L) << describe(c) << "distance " << result.distance << " instead of "
                           << static_cast<double>(exact);
  EXPECT_LE(result.lower_bound, exact) << describe(c);
  EXPECT_GE(result.upper_bound, exact) << describe(c);
  tally.worst = std::max(tally.worst, error);
  (exact > 0 ? tally.apart : tally.overlapping) += 1;
}

void report(const Tally& tally) {
  testing::Test::RecordProperty("worst_error_over_scale", std::to_string(static_cast<double>(tally.worst)));
  std::cout << tally.apart << " apart, " << tally.overlapping << " overlapping, worst error "
            << static_cast<double>(tally.worst) << " of the scale\n";
}

using Visit = std::function<void(const PairCase&)>;

/// Random poses of all pairs of shapes of one size, half of them with jittered rotations.
void visitRandomPoses(double size, int poses, const Visit& visit) {
  std::mt19937 random(72);
  const std::vector<NamedShape> shapes = polytopesOfSize(size, random);
  for (const NamedShape& a : shapes)
    for (const NamedShape& b : shapes)
      for (int i = 0; i < poses; ++i) {
        PairCase c{a.name + "-" + b.name, a.shape, b.shape, randomPose(random, 0.9 * size)};
        if (i % 2 == 1) jitter(c.a_T_b, random);
        visit(c);
      }
}

/// Moves b along the library's own normal, so that the gap is about `gap`.
PairCase slidTo(double gap, PairCase c) {
  const SignedDistance now = signedDistance(c.a, c.b, c.a_T_b);
  c.a_T_b.pretranslate((gap - now.distance) * now.normal);
  return c;
}

TEST(ExactPolytopes, AtRandomPosesOfEverySize) {
  Tally tally;
  for (const double size : {0.01, 1.0, 1000.0})
    visitRandomPoses(size, 50, [&](const PairCase& c) { expectExact(c, tally); });
  report(tally);
  EXPECT_GT(tally.apart, 2000);
  EXPECT_GT(tally.overlapping, 2000);
}

TEST(ExactPolytopes, NearlyTouching) {
  Tally tally;
  int i = 0;
  const double gaps[] = {0.0, 1e-16, -1e-16, 1e-14, -1e-14, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3};
  visitRandomPoses(1.0, 130, [&](const PairCase& c) { expectExact(slidTo(gaps[i++ % 13], c), tally); });
  report(tally);
  EXPECT_GT(tally.apart, 2000);
  EXPECT_GT(tally.overlapping, 2000);
}

TEST(ExactPolytopes, FarFromEachOther) {
  Tally tally;
  for (const double distance : {1e3, 1e6})
    visitRandomPoses(1.0, 20, [&](PairCase c) {
      c.a_T_b.translation() *= distance;
      expectExact(c, tally);
    });
  report(tally);
  EXPECT_GT(tally.apart, 1500);
}

TEST(ExactPolytopes, FacesEdgesAndCornersInLine) {
  Tally tally;
  const Shape box = Box{{1, 1, 1}}, other = Box{{0.8, 0.6, 0.5}};
  for (const Shape& b : {box, other})
    for (const double x : {0.0, 0.3, 0.5, 0.9, 1.0, 1.5})
      for (const double y : {0.0, 0.1, 0.8, 1.2})
        for (const double gap : {-1e-3, -1e-15, 0.0, 1e-15, 1e-3})
          expectExact({"in line", box, b, at(x, y, 0.5 + b.halfExtents().z() + gap)}, tally);
  report(tally);
  EXPECT_GT(tally.apart, 50);
  EXPECT_GT(tally.overlapping, 50);
}

}  // namespace proximity_server::narrowphase::exact_oracle_test
