#include "narrowphase/curved/depth_about_axis.h"

#include "narrowphase/cso/two_cores.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace proximity_server::narrowphase::depth_about_axis_test {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr double kTolerance = 1e-9;  // [m]

double depthAlong(Cso& cso, const Vector3d& normal) { return normal.dot(cso.vertex(normal).point); }

struct Found {
  double bound;     ///< [m]
  Vector3d normal;  ///< the shallowest direction
};

/// The search from the depth along x, without Newton's method.
Found search(TwoCores& cores, double tolerance = kTolerance) {
  Found found{depthAlong(cores.cso, Vector3d::UnitX()), Vector3d::UnitX()};
  double known = found.bound;
  const auto take = [&](const std::array<Vector3d, 2>& directions) {
    const double depth = depthAlong(cores.cso, directions[0]);
    if (depth < known) found.normal = directions[0];
    return known = std::min(known, depth);
  };
  found.bound = depthAboutAxis(cores.cso, known, tolerance, take);
  return found;
}

void expectProves(double depth, TwoCores& cores) {
  const double bound = search(cores).bound;
  EXPECT_LE(bound, depth);
  EXPECT_GE(bound, depth - kTolerance);
}

void expectNoProof(TwoCores& cores, double tolerance = kTolerance) {
  EXPECT_EQ(search(cores, tolerance).bound, -std::numeric_limits<double>::infinity());
}

Isometry3d turnedAbout(const Vector3d& axis, double angle) {
  return Isometry3d(Eigen::AngleAxisd(angle, axis.normalized()));
}

// The shortest way out is across the axis, by the sum of the radii.
TEST(DepthAboutAxis, OfTwoCylindersOnOneAxis) {
  TwoCores cores(Cylinder{1, 4}, Cylinder{0.5, 4}, Vector3d(0, 0, 0.1));
  expectProves(1.5, cores);
}

// The slant of this cone has the normal (0.8, 0, 0.6). From the point on the axis 1 m below the apex it is 0.6 m away.
TEST(DepthAboutAxis, OfAPointOnTheAxisOfACone) {
  TwoCores cores(Cone{1.5, 2.0}, Sphere{0.1}, Vector3d::Zero());
  expectProves(0.6, cores);
}

TEST(DepthAboutAxis, OfAPointOnTheAxisIsTheSameFromTheOtherSide) {
  TwoCores cores(Sphere{0.1}, Cone{1.5, 2.0}, turnedAbout(Vector3d::UnitX(), 1.0));
  expectProves(0.6, cores);
}

// The segment adds nothing to the radius of the spheroid only in the two directions across both axes.
TEST(DepthAboutAxis, OfASegmentInASpheroidAtEveryTilt) {
  for (const double tilt : {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 1e-2}) {
    TwoCores cores(Ellipsoid{{2, 2, 3}}, Capsule{0.1, 1.0}, turnedAbout({1, 2, 0}, tilt));
    expectProves(2.0, cores);
  }
}

TEST(DepthAboutAxis, OfASpheroidUpsideDown) {
  TwoCores cores(Capsule{0.1, 1.0}, Ellipsoid{{2, 2, 3}}, turnedAbout({1, 2, 0}, M_PI - 1e-3));
  expectProves(2.0, cores);
}

TEST(DepthAboutAxis, OfEllipsoidsThatAreNearlyRound) {
  for (const Vector3d& radii : {Vector3d(2.0, 2.02, 3.0), Vector3d(3.0, 2.02, 2.0), Vector3d(2.02, 3.0, 2.0)}) {
    TwoCores cores(Ellipsoid{radii}, Ellipsoid{0.5 * radii}, Vector3d::Zero());
    expectProves(3.0, cores);
  }
}

TEST(DepthAboutAxis, OfASphereOnTheAxisOfASweptCylinder) {
  const Shape swept = Shape(Cylinder{1, 2}).sweptTo(Isometry3d(Translation3d(0, 0, 4)));
  TwoCores cores(swept, Sphere{0.1}, Vector3d(0, 0, 2));
  expectProves(1.0, cores);
}

// The vertices beside the segment lie 0.1 nm from it, which is less than a quarter of the tolerance.
TEST(DepthAboutAxis, OfACylinderAboutAHullThatIsNearlyASegment) {
  const Shape hull = hullOf({{-1, 3, 2}, {3, 3, 2}, {0, 3 + 1e-10, 2}, {1, 3, 2 - 1e-10}});
  const Isometry3d pose = turnedAbout(Vector3d::UnitY(), M_PI_2);  // (x, y, z) becomes (z, y, -x)
  TwoCores cores(Cylinder{0.5, 1.0}, hull, Isometry3d(Translation3d(-2, -3, 1)) * pose);
  expectProves(0.5, cores);
  TwoCores swapped(cores.b, cores.a, cores.a_T_b.inverse());
  expectProves(0.5, swapped);
}

// Towards -x, where the hull ends in its edge along z.
TEST(DepthAboutAxis, OfANeedleInACylinder) {
  for (const double width : {1e-9, 1e-6, 1e-3}) {
    TwoCores cores(Cylinder{0.5, 1.0}, hullOf({{0, 0, -2}, {0, 0, 2}, {width, 0, 0}}), Vector3d::Zero());
    expectProves(0.5, cores);
    TwoCores swapped(cores.b, cores.a, cores.a_T_b.inverse());
    expectProves(0.5, swapped);
  }
}

// The slant of this cone has the normal (0.8, 0, 0.6), about the axis, and is 0.6 m away. A box adds the least where the
// normal is across its longer edge.
TEST(DepthAboutAxis, OfABoxInACone) {
  for (const double size : {1e-6, 1e-4, 1e-3}) {
    TwoCores cores(Cone{1.5, 2.0}, Box{size * Vector3d(2, 4, 6)}, Vector3d::Zero());
    expectProves(0.6 + size * (0.8 + 1.8), cores);
  }
}

// The depth is nearly the same in all directions.
TEST(DepthAboutAxis, OfABallAndOfABoxInANearlyRoundEllipsoid) {
  for (const double excess : {1e-6, 1e-4, 1e-2})
    for (const Vector3d& radii : {Vector3d(1, 1, 1 - excess), Vector3d(1, 1 + excess, 1 - excess)}) {
      TwoCores of_ball(Ellipsoid{radii}, Sphere{0.1}, Vector3d::Zero());
      expectProves(1.0 - excess, of_ball);
      TwoCores of_box(Box{{2e-6, 2e-6, 2e-6}}, Ellipsoid{radii}, Vector3d::Zero());
      expectProves(1.0 - excess + 1e-6, of_box);
    }
}

TEST(DepthAboutAxis, OfANearlyRoundEllipsoidInACylinderAtEveryTilt) {
  for (const double tilt : {0.0, 0.1, 1.0, M_PI_2}) {
    TwoCores cores(Cylinder{1, 4}, Ellipsoid{{0.5, 0.5, 0.48}}, turnedAbout(Vector3d::UnitX(), tilt));
    expectProves(1.0 + std::hypot(0.5 * std::cos(tilt), 0.48 * std::sin(tilt)), cores);
  }
}

// Across z the swept cylinder reaches 2 m only where its other end is lower than the start: the turned one reaches
// sqrt(1 - c^2) * 2 + 0.5 c along a direction whose cosine with the axis is c, less than 2 m for c > 8 / 17.
TEST(DepthAboutAxis, OfASegmentInAFlatCylinderThatIsTurnedAboutItsDiameter) {
  for (const double angle : {0.0, 0.3, 0.7, 1.1, 1.5}) {
    const Isometry3d turn(Eigen::AngleAxisd(M_PI_2, Vector3d(std::cos(angle), std::sin(angle), 0)));
    TwoCores cores(Shape(Cylinder{2.0, 1.0}).sweptTo(turn), Capsule{0.1, 4.0}, Vector3d::Zero());
    expectProves(2.0, cores);
    TwoCores swapped(cores.b, cores.a, cores.a_T_b.inverse());
    expectProves(2.0, swapped);
  }
}

// The start alone has a depth of 0.5 m along -x, where the sweep is 1.5 m deep.
TEST(DepthAboutAxis, IsNotProvenWhereASweepReachesFartherThanItsStart) {
  TwoCores cores(Shape(Cylinder{1, 4}).sweptTo(Isometry3d(Translation3d(-1, 0, 0))), Sphere{0.1}, Vector3d(-0.5, 0, 0));
  expectNoProof(cores);
}

TEST(DepthAboutAxis, IsNotProvenForACoreThatIsNotRound) {
  TwoCores of_box(Cylinder{1, 4}, Box{{1, 1, 1}}, Vector3d::Zero());
  expectNoProof(of_box);
  TwoCores of_ellipsoid(Ellipsoid{{1, 2, 3}}, Box{{1e-3, 1e-3, 1}}, Vector3d::Zero());
  expectNoProof(of_ellipsoid);
}

TEST(DepthAboutAxis, IsNotProvenForASweepAcrossTheAxis) {
  TwoCores cores(Shape(Cylinder{1, 2}).sweptTo(Isometry3d(Translation3d(1e-6, 0, 4))), Sphere{0.1}, Vector3d(0, 0, 2));
  expectNoProof(cores);
}

TEST(DepthAboutAxis, IsNotProvenForAxesThatAreFarFromParallel) {
  TwoCores cores(Cylinder{1, 4}, Cylinder{0.5, 4}, turnedAbout(Vector3d::UnitX(), 0.1));
  expectNoProof(cores);
}

TEST(DepthAboutAxis, IsNotProvenToLessThanRounding) {
  TwoCores cores(Cylinder{1, 4}, Cylinder{0.5, 4}, Vector3d::Zero());
  expectNoProof(cores, 1e-15);
}

Shape anyRoundCore(std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.05, 1.0), excess(-0.04, 0.04);
  const double radius = size(random), length = size(random);
  switch (random() % 6) {
    case 0:
      return Capsule{0.1, length};
    case 1:
      return Cylinder{radius, length};
    case 2:
      return Cone{radius, length};
    case 3:
      return Ellipsoid{{radius, radius, length}};
    case 4:
      return Ellipsoid{{radius, radius * (1.0 + excess(random)), length}};
    default:
      return Shape(Cone{radius, length}).sweptTo(Isometry3d(Translation3d(0, 0, size(random) - 0.5)));
  }
}

Isometry3d nearOneAxis(std::mt19937& random) {
  std::uniform_real_distribution<double> part(-1.0, 1.0), exponent(-12.0, -1.7);
  const Vector3d axis(part(random), part(random), part(random));
  Isometry3d pose = turnedAbout(axis, std::pow(10.0, exponent(random)));
  if (random() % 2 == 0) pose = pose * turnedAbout(Vector3d::UnitX(), M_PI);
  pose = pose * turnedAbout(Vector3d::UnitZ(), 4.0 * part(random));
  const double beside = std::pow(10.0, exponent(random));
  pose.translation() = Vector3d(beside * part(random), beside * part(random), 0.5 * part(random));
  return pose;
}

/// The least depth over directions everywhere, and in the ring about z through the given one.
double sampledDepth(Cso& cso, const Vector3d& normal, std::mt19937& random) {
  std::normal_distribution<double> entry;
  std::uniform_real_distribution<double> angle(0.0, 2.0 * M_PI), exponent(-8.0, 0.0);
  double least = depthAlong(cso, normal);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d noise = std::pow(10.0, exponent(random)) * Vector3d(entry(random), entry(random), entry(random));
    const Vector3d in_ring = Eigen::AngleAxisd(i % 2 == 0 ? angle(random) : 0.0, Vector3d::UnitZ()) * normal;
    least = std::min(least, depthAlong(cso, (in_ring + noise).normalized()));
  }
  return least;
}

/// Searches random pairs. The bound of each must not be more than the sampled depth. Returns the share of the overlaps
/// that are proven.
template <class RandomPair>
double shareOfProofs(unsigned seed, const RandomPair& pair) {
  std::mt19937 random(seed);
  int overlaps = 0, proofs = 0;
  const int pairs = repeats(3000);
  for (int i = 0; i < pairs; ++i) {
    TwoCores cores = pair(random);
    const Found found = search(cores);
    const double sampled = sampledDepth(cores.cso, found.normal, random);
    EXPECT_LE(found.bound, sampled) << i;
    overlaps += sampled > 1e-6 ? 1 : 0;
    proofs += found.bound > sampled - kTolerance ? 1 : 0;
  }
  EXPECT_GT(overlaps, pairs / 2);
  return static_cast<double>(proofs) / overlaps;
}

TEST(DepthAboutAxis, IsNeverMoreThanTheDepthAndNearlyAlwaysProven) {
  const auto pair = [](std::mt19937& random) {
    const Shape a = anyRoundCore(random), b = anyRoundCore(random);
    return TwoCores(a, b, nearOneAxis(random));
  };
  EXPECT_GT(shareOfProofs(30, pair), 0.97);  // without Newton's method
}

TEST(DepthAboutAxis, IsNeverMoreThanTheDepthOfANeedleInARoundCore) {
  std::uniform_real_distribution<double> part(-1.0, 1.0), exponent(-9.0, -3.5);
  const auto pair = [&](std::mt19937& random) {
    std::vector<Vector3d> points;
    const Vector3d size(std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)), part(random));
    for (int i = 0; i < 9; ++i) points.push_back(size.cwiseProduct(Vector3d(part(random), part(random), part(random))));
    const Shape polytope = hullOf(points), round = anyRoundCore(random);
    const bool is_first = random() % 2 == 0;
    Isometry3d pose = nearOneAxis(random);
    if (random() % 2 == 0) pose = pose * turnedAbout({part(random), part(random), part(random)}, 4.0);
    return TwoCores(is_first ? polytope : round, is_first ? round : polytope, pose);
  };
  EXPECT_GT(shareOfProofs(32, pair), 0.8);  // without Newton's method, which finds most depths at once
}

/// A core that is not round, with a round one inside of it.
Shape anyCoreAroundARoundOne(std::mt19937& random) {
  std::uniform_real_distribution<double> part(-1.0, 1.0), exponent(-9.0, 0.5);
  if (random() % 2 == 0) {
    std::vector<Vector3d> points;
    for (int i = 0; i < 5; ++i) points.emplace_back(1e-10 * part(random), 1e-10 * part(random), part(random));
    return hullOf(points);
  }
  Isometry3d end = turnedAbout({part(random), part(random), part(random)}, std::pow(10.0, exponent(random)));
  if (random() % 2 == 0) end.translation() = 0.1 * Vector3d(part(random), part(random), part(random));
  return anyRoundCore(random).sweptTo(end);
}

TEST(DepthAboutAxis, IsNeverMoreThanTheDepthOfCoresAroundRoundOnes) {
  const auto pair = [](std::mt19937& random) {
    const Shape around = anyCoreAroundARoundOne(random), round = anyRoundCore(random);
    const bool is_first = random() % 2 == 0;
    return TwoCores(is_first ? around : round, is_first ? round : around, nearOneAxis(random));
  };
  EXPECT_GT(shareOfProofs(31, pair), 0.5);  // the depth of many sweeps is more than that of their start
}

}  // namespace proximity_server::narrowphase::depth_about_axis_test
