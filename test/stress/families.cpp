#include "stress/families.h"

#include <cmath>
#include <limits>

#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/motion/motion.h"
#include "stress/random_geometry.h"

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Random = std::mt19937;

// Shapes.

Shape nearDuplicates(Random& random, double size) {
  Points cloud = boxCorners(randomSizes(random, size));
  const double offset = size * decades(random, -17, -6);
  for (std::size_t i = 0; i < 8; ++i) cloud.push_back(cloud[i] + offset * randomDirection(random));
  return hullOf(below(random, 2) == 0 ? cloud : turned(random, cloud));
}

/// A lattice on two parallel faces, off their planes by about rounding.
Shape coplanar(Random& random, double size) {
  const double noise = below(random, 3) == 0 ? 0.0 : size * decades(random, -17, -11);
  Points cloud;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (const int z : {-1, 1})
        cloud.push_back(size * Vector3d(0.2 * x, 0.2 * y, 0.4 * z) + noise * randomDirection(random));
  return hullOf(cloud);
}

Shape anyShape(Random& random, double size) {
  switch (below(random, 8)) {
    case 0:
      return flat(random, size);
    case 1:
      return sliver(random, size);
    case 2:
      return nearDuplicates(random, size);
    case 3:
      return coplanar(random, size);
    default:
      return solid(random, size);
  }
}

TwoShapes solids(Random& random) { return {solid(random, 1.0), solid(random, 1.0)}; }
TwoShapes slivers(Random& random) {
  const Shape thin = sliver(random, 1.0), other = below(random, 2) == 0 ? sliver(random, 1.0) : solid(random, 1.0);
  return below(random, 2) == 0 ? TwoShapes{thin, other} : TwoShapes{other, thin};
}
TwoShapes sizeRatio(Random& random) {
  const Shape large = solid(random, 1.0), small = solid(random, decades(random, -6, -2));
  return below(random, 2) == 0 ? TwoShapes{large, small} : TwoShapes{small, large};
}
TwoShapes identicalShapes(Random& random) {
  const Shape shape = anyShape(random, 1.0);
  return {shape, shape};
}
TwoShapes flatShapes(Random& random) {
  return {flat(random, 1.0), below(random, 2) == 0 ? flat(random, 1.0) : solid(random, 1.0)};
}
TwoShapes nearDuplicateShapes(Random& random) { return {nearDuplicates(random, 1.0), nearDuplicates(random, 1.0)}; }
TwoShapes coplanarShapes(Random& random) { return {coplanar(random, 1.0), coplanar(random, 1.0)}; }
TwoShapes boxesOfEverySize(Random& random) {
  const double size = decades(random, -2, 3);
  return {boxOrItsHull(random, randomSizes(random, size)), boxOrItsHull(random, randomSizes(random, size))};
}
TwoShapes equalBoxes(Random& random) {
  const Vector3d size = randomSizes(random, decades(random, -2, 3));
  return {boxOrItsHull(random, size), boxOrItsHull(random, size)};
}
TwoShapes primitives(Random& random) {
  return {primitive(random, randomSizes(random, 1.0)), primitive(random, randomSizes(random, 1.0))};
}
TwoShapes revolvedShapes(Random& random) {
  const auto shape = [&]() -> Shape {
    const double radius = uniform(random, 0.1, 0.5), length = uniform(random, 0.1, 2.0);
    switch (below(random, 4)) {
      case 0:
        return Capsule{radius, length};
      case 1:
        return Cylinder{radius, length};
      case 2:
        return Cone{radius, length};
      default:
        return Ellipsoid{{radius, radius, length}};
    }
  };
  const Shape a = shape();
  return {a, shape()};
}
TwoShapes largeHulls(Random& random) {
  return {randomHull(random, 100 + below(random, 400), 0.5 * randomSizes(random, 1.0)),
          randomHull(random, 100 + below(random, 400), 0.5 * randomSizes(random, 1.0))};
}
/// Vertices about a point 1e3 to 1e6 m from the origin of both frames.
TwoShapes farFromTheirOrigin(Random& random) {
  const Isometry3d world_T_a = randomPose(random, decades(random, 3, 6));
  const Isometry3d a_T_b = randomPose(random, 1.2);
  Points a, b;
  for (const Vector3d& corner : boxCorners(randomSizes(random, 1.0))) a.push_back(world_T_a * corner);
  for (const Vector3d& corner : boxCorners(randomSizes(random, 1.0))) b.push_back(world_T_a * (a_T_b * corner));
  return {hullOf(a), hullOf(b)};
}
/// Of a translation, or of a screw with its margin; see sweptShape.
TwoShapes sweptShapes(Random& random) {
  const double turn = below(random, 2) == 0 ? 0.0 : uniform(random, 0.0, 0.5);
  const ScrewMotion motion{Isometry3d::Identity(), decades(random, -3, 0) * randomDirection(random),
                           turn * randomDirection(random)};
  const Shape swept = sweptShape(anyShape(random, 1.0), motion);
  return below(random, 2) == 0 ? TwoShapes{swept, solid(random, 1.0)} : TwoShapes{solid(random, 1.0), swept};
}
/// Points about a segment, up to 1e-13 to 1e-6 of its length beside it.
Shape needleCloud(Random& random) {
  const double size = decades(random, -2, 1), thickness = size * decades(random, -13, -6);
  const Vector3d along = size * randomDirection(random);
  Points cloud;
  for (int i = 4 + below(random, 17); i > 0; --i)
    cloud.push_back(uniform(random, -0.5, 0.5) * along + thickness * randomDirection(random));
  return hullOf(cloud);
}
TwoShapes needleClouds(Random& random) {
  const Shape needle = needleCloud(random), other = below(random, 2) == 0 ? needleCloud(random) : solid(random, 1.0);
  return below(random, 2) == 0 ? TwoShapes{needle, other} : TwoShapes{other, needle};
}
/// Of any length from 0 on.
Shape shortCapsule(Random& random) {
  return Capsule{uniform(random, 0.05, 0.5), below(random, 3) == 0 ? 0.0 : decades(random, -12, -3)};
}
/// A cone, and another solid of revolution.
TwoShapes cones(Random& random) {
  const double radius = uniform(random, 0.02, 0.5), length = uniform(random, 0.1, 1.5);
  const Shape cone = Cone{uniform(random, 0.02, 0.5), uniform(random, 0.1, 1.5)};
  const Shape others[] = {Capsule{radius, length}, Cylinder{radius, length}, Cone{radius, length}};
  const Shape other = others[below(random, 3)];
  return below(random, 2) == 0 ? TwoShapes{cone, other} : TwoShapes{other, cone};
}
TwoShapes mantles(Random& random) {
  const auto shape = [&]() -> Shape {
    const double radius = uniform(random, 0.02, 0.5), length = uniform(random, 0.1, 1.5);
    switch (below(random, 3)) {
      case 0:
        return Capsule{radius, length};
      case 1:
        return shortCapsule(random);
      default:
        return Cylinder{radius, length};
    }
  };
  const Shape a = shape();
  return {a, shape()};
}
/// Ellipsoids with two equal radii, or nearly so, beside other round shapes.
TwoShapes spheroids(Random& random) {
  const auto spheroid = [&]() -> Shape {
    const double radius = uniform(random, 0.05, 0.5), part = below(random, 2) == 0 ? 0.0 : decades(random, -12, -2);
    return Ellipsoid{{radius, radius * (1.0 + part), uniform(random, 0.05, 0.5)}};
  };
  const Shape a = spheroid();
  switch (below(random, 4)) {
    case 0:
      return {a, shortCapsule(random)};
    case 1:
      return {a, Cylinder{uniform(random, 0.05, 0.5), uniform(random, 0.1, 1.0)}};
    case 2:
      return {a, Cone{uniform(random, 0.05, 0.5), uniform(random, 0.1, 1.0)}};
    default:
      return {a, spheroid()};
  }
}
/// Solids of revolution of every kind, one of them an ellipsoid.
TwoShapes roundShapes(Random& random) {
  const auto size = [&] { return uniform(random, 0.05, 0.5); };
  const double radius = size();
  const Shape ellipsoid = Ellipsoid{{radius, radius, size()}};
  const double other = size(), half = size();
  const Shape others[] = {Ellipsoid{{other, other, half}}, Cone{other, 2.0 * half}, Cylinder{other, 2.0 * half},
                          Capsule{other, 2.0 * half}};
  const Shape second = others[below(random, 4)];
  return below(random, 2) == 0 ? TwoShapes{ellipsoid, second} : TwoShapes{second, ellipsoid};
}
/// Of every size down to 1e-318 m.
Shape vanishing(Random& random) {
  Vector3d sizes;
  for (double& size : sizes) size = below(random, 3) == 0 ? uniform(random, 0.2, 1.0) : decades(random, -318, 0);
  return below(random, 4) == 0 ? hullOf(boxCorners(sizes)) : primitive(random, sizes);
}
/// One of them has some size of about a metre: all together must not vanish.
TwoShapes vanishingShapes(Random& random) {
  Shape large = vanishing(random);
  while (radiusOf(large) < 0.1) large = vanishing(random);
  const Shape small = vanishing(random);
  return below(random, 2) == 0 ? TwoShapes{large, small} : TwoShapes{small, large};
}
TwoShapes anyShapes(Random& random) {
  const double size = decades(random, -2, 3);
  return {anyShape(random, size), anyShape(random, size * (below(random, 4) == 0 ? decades(random, -6, 0) : 1.0))};
}

// Poses. Those of the centres first: a hull may lie far from the origin of its frame.

/// Both placed in the world, 1e3 to 1e6 m from its origin; the relative pose is what double makes of that.
Isometry3d farInTheWorld(const TwoShapes& shapes, Random& random) {
  const Isometry3d a_T_b = anywhereWithin(shapes, random, 1.2);
  Isometry3d world_T_a = randomPose(random, 0.0);
  world_T_a.translation() = decades(random, 3, 6) * randomDirection(random);
  const Isometry3d world_T_b = world_T_a * a_T_b;
  return world_T_a.inverse() * world_T_b;
}

Isometry3d concentric(const TwoShapes& shapes, Random& random) {
  Matrix3d rotation = Matrix3d::Identity();
  if (below(random, 3) == 0) rotation = quarterTurns(random);
  if (below(random, 3) == 0) rotation = randomPose(random, 0.0).linear();
  Vector3d offset = Vector3d::Zero();
  if (below(random, 2) == 0) offset = radiusOf(shapes.a) * decades(random, -17, -3) * randomDirection(random);
  return withCentres(shapes, rotation, offset);
}

/// Every entry of the rotation its own neighbour among the doubles; a zero becomes what rounding leaves of one.
Isometry3d offByAnUlp(Isometry3d a_T_b, Random& random) {
  for (int i = 0; i < 9; ++i) {
    double& entry = a_T_b.linear()(i / 3, i % 3);
    const double epsilon = std::numeric_limits<double>::epsilon();
    const int direction = below(random, 3) - 1;
    if (direction == 0) continue;
    entry = entry == 0.0 ? 0.5 * direction * epsilon : std::nextafter(entry, 2.0 * direction);
  }
  return a_T_b;
}

/// Axes parallel but for a tilt, the centres on one axis but for an offset.
Isometry3d coaxial(const TwoShapes& shapes, Random& random) {
  Isometry3d a_T_b = concentric(shapes, random);
  const double tilt = below(random, 2) == 0 ? 0.0 : decades(random, -17, -2);
  a_T_b.linear() = Eigen::AngleAxisd(tilt, randomDirection(random)).toRotationMatrix();
  if (below(random, 4) == 0) a_T_b.linear() = a_T_b.linear() * Vector3d(1, -1, -1).asDiagonal();
  a_T_b.translation().z() += uniform(random, -1.5, 1.5) * radiusOf(shapes.a);
  return a_T_b;
}

/// Centres and axes the same but for an offset and a tilt of every size.
Isometry3d nearlyConcentric(const TwoShapes& shapes, Random& random) {
  const double tilt = below(random, 4) == 0 ? 0.0 : decades(random, -14, -1);
  const double offset = below(random, 4) == 0 ? 0.0 : decades(random, -16, -1);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, randomDirection(random)).toRotationMatrix();
  if (below(random, 4) == 0) rotation = rotation * quarterTurns(random);
  return withCentres(shapes, rotation, offset * radiusOf(shapes.a) * randomDirection(random));
}

/// Offsets and a tilt of every size.
Isometry3d vanishingOffset(const TwoShapes& shapes, Random& random) {
  Vector3d offset;
  for (double& entry : offset) entry = below(random, 3) == 0 ? 0.0 : eitherSign(random, decades(random, -320, 0));
  const double tilt = below(random, 2) == 0 ? 0.0 : decades(random, -320, 0);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, Vector3d::Unit(below(random, 3))).toRotationMatrix();
  if (below(random, 2) == 0) rotation = rotation * quarterTurns(random);
  return withCentres(shapes, rotation, offset);
}

/// Axes that are parallel within 1e-3 rad, the centres of overlapping shapes nearly on one of them.
Isometry3d nearOneAxis(const TwoShapes& shapes, Random& random) {
  const auto height = [](const Shape& shape) { return shape.halfExtents().z() + shape.margin(); };
  const double tilt = below(random, 2) == 0 ? uniform(random, 0.0, 1e-3) : decades(random, -14, -3);
  const double beside = below(random, 4) == 0 ? 0.0 : decades(random, -14, -2);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, randomDirection(random)).toRotationMatrix();
  if (below(random, 2) == 0) rotation = rotation * Vector3d(1, -1, -1).asDiagonal();
  Vector3d offset = beside * radiusOf(shapes.a) * randomDirection(random);
  offset.z() += uniform(random, -1.0, 1.0) * (height(shapes.a) + height(shapes.b));
  return withCentres(shapes, rotation, offset);
}

Isometry3d anyPose(const TwoShapes& shapes, Random& random) {
  switch (below(random, 8)) {
    case 0:
      return anywhereWithin(shapes, random, 0.2);
    case 1:
      return concentric(shapes, random);
    case 2:
      return parallelFaces(shapes, random);
    case 3:
      return farInTheWorld(shapes, random);
    case 4:
      return offByAnUlp(concentric(shapes, random), random);
    case 5:
      return coaxial(shapes, random);
    case 6:
      return movedToGap(shapes, anywhereWithin(shapes, random, 1.2), touchingGap(shapes, random));
    default:
      return anywhereWithin(shapes, random, 1.2);
  }
}

// Queries.

/// The default tolerance for shapes up to a metre; beyond, the same part of the size.
Query asked(const TwoShapes& shapes, const Isometry3d& a_T_b) {
  Query query{a_T_b, {}, {}};
  query.options.distance_tolerance *= std::max(1.0, scaleOf(shapes, a_T_b));
  return query;
}

Query nearby(const TwoShapes& shapes, Random& random) { return asked(shapes, anywhereWithin(shapes, random, 1.2)); }
Query deep(const TwoShapes& shapes, Random& random) { return asked(shapes, anywhereWithin(shapes, random, 0.2)); }
Query touching(const TwoShapes& shapes, Random& random) {
  return asked(shapes, movedToGap(shapes, anywhereWithin(shapes, random, 1.2), touchingGap(shapes, random)));
}
Query nearbyOrTouching(const TwoShapes& shapes, Random& random) {
  return below(random, 2) == 0 ? nearby(shapes, random) : touching(shapes, random);
}
Query facing(const TwoShapes& shapes, Random& random) { return asked(shapes, parallelFaces(shapes, random)); }
Query farAway(const TwoShapes& shapes, Random& random) { return asked(shapes, farInTheWorld(shapes, random)); }
Query farApart(const TwoShapes& shapes, Random& random) {
  const Isometry3d pose = randomPose(random, 0.0);
  return asked(shapes, withCentres(shapes, pose.linear(), decades(random, 3, 6) * randomDirection(random)));
}
Query centred(const TwoShapes& shapes, Random& random) { return asked(shapes, concentric(shapes, random)); }
Query onOneAxis(const TwoShapes& shapes, Random& random) { return asked(shapes, coaxial(shapes, random)); }
Query nearlyInOnePlace(const TwoShapes& shapes, Random& random) {
  return asked(shapes, nearlyConcentric(shapes, random));
}
Query vanishingOffsets(const TwoShapes& shapes, Random& random) {
  return asked(shapes, below(random, 2) == 0 ? anyPose(shapes, random) : vanishingOffset(shapes, random));
}
Query nearlyOnOneAxis(const TwoShapes& shapes, Random& random) { return asked(shapes, nearOneAxis(shapes, random)); }
/// Whether the distance is above a threshold that is the distance, or next to it.
Query aboveTheTruth(const TwoShapes& shapes, Random& random) {
  Query query = nearbyOrTouching(shapes, random);
  const double distance = signedDistance(shapes.a, shapes.b, query.a_T_b, query.options).distance;
  const double offset = below(random, 4) == 0 ? 0.0 : eitherSign(random, decades(random, -17, -9));
  query.options.stop_above = query.options.stop_below = distance + offset;
  return query;
}
Query withAnUlp(const TwoShapes& shapes, Random& random) {
  Isometry3d a_T_b = anywhereWithin(shapes, random, 1.0);
  if (below(random, 3) != 0) a_T_b = withCentres(shapes, quarterTurns(random), a_T_b.translation());
  return asked(shapes, offByAnUlp(a_T_b, random));
}
/// The vertices say where they are; b moves a little from there, or not at all.
Query nearlyAsTheyAre(const TwoShapes& shapes, Random& random) {
  Isometry3d a_T_b = Isometry3d::Identity();
  if (below(random, 8) != 0) a_T_b.translation() = decades(random, -10, 0) * randomDirection(random);
  return asked(shapes, a_T_b);
}

Query withOptions(const TwoShapes& shapes, Random& random) {
  Query query = asked(shapes, anyPose(shapes, random));
  query.options.distance_tolerance = decades(random, -14, -2);
  const int caps[] = {1, 2, 3, 5, 10, 500};
  query.options.max_iterations = caps[below(random, 6)];
  return query;
}

/// After a query of the same shapes somewhere else.
Query afterAJump(const TwoShapes& shapes, Random& random) {
  Query query = asked(shapes, anyPose(shapes, random));
  signedDistance(shapes.a, shapes.b, anyPose(shapes, random), query.options, query.warm_start);
  return query;
}

WarmStart garbage(Random& random) {
  const double values[] = {0.0,   -0.0,   1.0,    -1.0,
                           1e300, -1e300, 1e-300, std::numeric_limits<double>::denorm_min(),
                           1e-17, 1e154,  1e-160, std::numeric_limits<double>::infinity(),
                           0.5,   3.0,    -0.1,   std::numeric_limits<double>::quiet_NaN()};
  const int vertices[] = {-1, 0, 1, 7, 1000, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
  const auto value = [&] { return values[below(random, 16)]; };
  const auto vertex = [&] { return vertices[below(random, 7)]; };
  WarmStart result{Vector3d(value(), value(), value())};
  for (WarmStart::Pair& pair : result.simplex) pair = {vertex(), vertex()};
  result.simplex_size = vertex();
  return result;
}

Query afterGarbage(const TwoShapes& shapes, Random& random) {
  Query query = asked(shapes, anyPose(shapes, random));
  query.warm_start = garbage(random);
  return query;
}

Query anyQuery(const TwoShapes& shapes, Random& random) {
  switch (below(random, 4)) {
    case 0:
      return withOptions(shapes, random);
    case 1:
      return afterAJump(shapes, random);
    case 2:
      return afterGarbage(shapes, random);
    default:
      return asked(shapes, anyPose(shapes, random));
  }
}

}  // namespace

const std::vector<Family>& stressFamilies() {
  static const std::vector<Family> families = {
      {"all shape pairs", solids, nearby},
      {"touching", solids, touching},
      {"boxes of every size", boxesOfEverySize, nearbyOrTouching},
      {"parallel faces", boxesOfEverySize, facing},
      {"equal boxes, face to face", equalBoxes, facing},
      {"parallel faces and edges, curved", primitives, facing},
      {"slivers", slivers, nearbyOrTouching},
      {"size ratio", sizeRatio, nearbyOrTouching},
      {"far in the world", solids, farAway},
      {"far apart", solids, farApart},
      {"vertices far from the origin", farFromTheirOrigin, nearlyAsTheyAre},
      {"identical", identicalShapes, centred},
      {"flat hulls", flatShapes, nearbyOrTouching},
      {"flat hulls in one plane", flatShapes, facing},
      {"near-duplicate vertices", nearDuplicateShapes, nearbyOrTouching},
      {"coplanar vertices", coplanarShapes, nearbyOrTouching, 32},
      {"coplanar faces in contact", coplanarShapes, facing, 8},
      {"concentric", solids, centred},
      {"coaxial", revolvedShapes, onOneAxis, 8},
      {"deep", solids, deep},
      {"rotations off by an ulp", solids, withAnUlp},
      {"boxes off by an ulp", equalBoxes, withAnUlp},
      {"large hulls", largeHulls, nearbyOrTouching, 8},
      {"tolerances and iteration limits", solids, withOptions},
      {"warm start from elsewhere", solids, afterAJump},
      {"warm start from garbage", solids, afterGarbage},
      {"random mix", anyShapes, anyQuery, 8},
      {"swept shapes", sweptShapes, nearbyOrTouching, 32},
      {"needle clouds", needleClouds, nearbyOrTouching, 64},
      {"nearly coaxial mantles", mantles, nearlyInOnePlace, 8},
      {"nearly coaxial cones", cones, nearlyInOnePlace, 8},
      {"rings of equal depth", spheroids, nearlyInOnePlace, 8},
      {"sizes down to nothing", vanishingShapes, vanishingOffsets, 8},
      {"round shapes near one axis", roundShapes, nearlyOnOneAxis, 64},
      {"thresholds at the truth", solids, aboveTheTruth, 2},
      {"thresholds at the truth, needles", needleClouds, aboveTheTruth, 64},
  };
  return families;
}

std::vector<StressPair> stressBlock(std::size_t family, unsigned seed, std::int64_t block) {
  std::seed_seq sequence{static_cast<std::int64_t>(seed), static_cast<std::int64_t>(family), block, block >> 32};
  Random random(sequence);
  const Family& kind = stressFamilies().at(family);
  const TwoShapes shapes = kind.shapes(random);
  std::vector<StressPair> pairs;
  for (std::int64_t i = 0; i < kPairsPerBlock; ++i) {
    const Query query = kind.query(shapes, random);
    pairs.push_back({shapes.a, shapes.b, query.a_T_b, query.options, query.warm_start});
  }
  return pairs;
}

}  // namespace proximity_server::narrowphase
