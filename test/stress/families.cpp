#include "stress/families.h"

#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/motion/motion.h"
#include "stress/random_geometry.h"

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

// Shapes.

Shape nearDuplicates(Chance& chance, double size) {
  Points cloud = boxCorners(randomSizes(chance, size));
  const double offset = size * chance.decades(-17, -6);
  for (std::size_t i = 0; i < 8; ++i) cloud.push_back(cloud[i] + offset * randomDirection(chance));
  return hullOf(chance.below(2) == 0 ? cloud : turned(chance, cloud));
}

/// A lattice on two parallel faces, off their planes by about rounding.
Shape coplanar(Chance& chance, double size) {
  const double noise = chance.below(3) == 0 ? 0.0 : size * chance.decades(-17, -11);
  Points cloud;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (const int z : {-1, 1})
        cloud.push_back(size * Vector3d(0.2 * x, 0.2 * y, 0.4 * z) + noise * randomDirection(chance));
  return hullOf(cloud);
}

Shape anyShape(Chance& chance, double size) {
  switch (chance.below(8)) {
    case 0:
      return flat(chance, size);
    case 1:
      return sliver(chance, size);
    case 2:
      return nearDuplicates(chance, size);
    case 3:
      return coplanar(chance, size);
    default:
      return solid(chance, size);
  }
}

TwoShapes inAnyOrder(Chance& chance, const Shape& a, const Shape& b) {
  return chance.below(2) == 0 ? TwoShapes{a, b} : TwoShapes{b, a};
}

TwoShapes solids(Chance& chance) { return {solid(chance, 1.0), solid(chance, 1.0)}; }
TwoShapes slivers(Chance& chance) {
  const Shape thin = sliver(chance, 1.0), other = chance.below(2) == 0 ? sliver(chance, 1.0) : solid(chance, 1.0);
  return inAnyOrder(chance, thin, other);
}
TwoShapes sizeRatio(Chance& chance) {
  const Shape large = solid(chance, 1.0), small = solid(chance, chance.decades(-6, -2));
  return inAnyOrder(chance, large, small);
}
TwoShapes identicalShapes(Chance& chance) {
  const Shape shape = anyShape(chance, 1.0);
  return {shape, shape};
}
TwoShapes flatShapes(Chance& chance) {
  return {flat(chance, 1.0), chance.below(2) == 0 ? flat(chance, 1.0) : solid(chance, 1.0)};
}
TwoShapes nearDuplicateShapes(Chance& chance) { return {nearDuplicates(chance, 1.0), nearDuplicates(chance, 1.0)}; }
TwoShapes coplanarShapes(Chance& chance) { return {coplanar(chance, 1.0), coplanar(chance, 1.0)}; }
TwoShapes boxesOfEverySize(Chance& chance) {
  const double size = chance.decades(-2, 3);
  return {boxOrItsHull(chance, randomSizes(chance, size)), boxOrItsHull(chance, randomSizes(chance, size))};
}
TwoShapes equalBoxes(Chance& chance) {
  const Vector3d size = randomSizes(chance, chance.decades(-2, 3));
  return {boxOrItsHull(chance, size), boxOrItsHull(chance, size)};
}
TwoShapes primitives(Chance& chance) {
  return {primitive(chance, randomSizes(chance, 1.0)), primitive(chance, randomSizes(chance, 1.0))};
}
TwoShapes revolvedShapes(Chance& chance) {
  const auto shape = [&]() -> Shape {
    const double radius = chance.between(0.1, 0.5), length = chance.between(0.1, 2.0);
    const Shape shapes[] = {Capsule{radius, length}, Cylinder{radius, length}, Cone{radius, length},
                            Ellipsoid{{radius, radius, length}}};
    return chance.oneOf(shapes);
  };
  const Shape a = shape();
  return {a, shape()};
}
TwoShapes largeHulls(Chance& chance) {
  return {randomHull(chance, 100 + chance.below(400), 0.5 * randomSizes(chance, 1.0)),
          randomHull(chance, 100 + chance.below(400), 0.5 * randomSizes(chance, 1.0))};
}
/// Vertices about a point 1e3 to 1e6 m from the origin of both frames.
TwoShapes farFromTheirOrigin(Chance& chance) {
  const Isometry3d world_T_a = randomPose(chance, chance.decades(3, 6));
  const Isometry3d a_T_b = randomPose(chance, 1.2);
  Points a, b;
  for (const Vector3d& corner : boxCorners(randomSizes(chance, 1.0))) a.push_back(world_T_a * corner);
  for (const Vector3d& corner : boxCorners(randomSizes(chance, 1.0))) b.push_back(world_T_a * (a_T_b * corner));
  return {hullOf(a), hullOf(b)};
}
/// One shape is swept along a translation, or along a screw with its margin; see sweptShape.
TwoShapes sweptShapes(Chance& chance) {
  const double turn = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 0.5);
  const ScrewMotion motion{Isometry3d::Identity(), chance.decades(-3, 0) * randomDirection(chance),
                           turn * randomDirection(chance)};
  const Shape swept = sweptShape(anyShape(chance, 1.0), motion);
  return chance.below(2) == 0 ? TwoShapes{swept, solid(chance, 1.0)} : TwoShapes{solid(chance, 1.0), swept};
}
/// Points about a segment, up to 1e-13 to 1e-6 of its length beside it.
Shape needleCloud(Chance& chance) {
  const double size = chance.decades(-2, 1), thickness = size * chance.decades(-13, -6);
  const Vector3d along = size * randomDirection(chance);
  Points cloud;
  for (int i = 4 + chance.below(17); i > 0; --i)
    cloud.push_back(chance.between(-0.5, 0.5) * along + thickness * randomDirection(chance));
  return hullOf(cloud);
}
TwoShapes needleClouds(Chance& chance) {
  const Shape needle = needleCloud(chance), other = chance.below(2) == 0 ? needleCloud(chance) : solid(chance, 1.0);
  return inAnyOrder(chance, needle, other);
}
/// A capsule of any length from 0 on.
Shape shortCapsule(Chance& chance) {
  return Capsule{chance.between(0.05, 0.5), chance.below(3) == 0 ? 0.0 : chance.decades(-12, -3)};
}
/// A cone, and another solid of revolution.
TwoShapes cones(Chance& chance) {
  const double radius = chance.between(0.02, 0.5), length = chance.between(0.1, 1.5);
  const Shape cone = Cone{chance.between(0.02, 0.5), chance.between(0.1, 1.5)};
  const Shape others[] = {Capsule{radius, length}, Cylinder{radius, length}, Cone{radius, length}};
  const Shape other = chance.oneOf(others);
  return inAnyOrder(chance, cone, other);
}
TwoShapes mantles(Chance& chance) {
  const auto shape = [&]() -> Shape {
    const double radius = chance.between(0.02, 0.5), length = chance.between(0.1, 1.5);
    const int kind = chance.below(3);
    if (kind == 1) return shortCapsule(chance);
    return kind == 0 ? Shape(Capsule{radius, length}) : Shape(Cylinder{radius, length});
  };
  const Shape a = shape();
  return {a, shape()};
}
/// Ellipsoids with two equal radii, or nearly so, beside other round shapes.
TwoShapes spheroids(Chance& chance) {
  const auto spheroid = [&]() -> Shape {
    const double radius = chance.between(0.05, 0.5), part = chance.below(2) == 0 ? 0.0 : chance.decades(-12, -2);
    return Ellipsoid{{radius, radius * (1.0 + part), chance.between(0.05, 0.5)}};
  };
  const Shape a = spheroid();
  switch (chance.below(4)) {
    case 0:
      return {a, shortCapsule(chance)};
    case 1:
      return {a, Cylinder{chance.between(0.05, 0.5), chance.between(0.1, 1.0)}};
    case 2:
      return {a, Cone{chance.between(0.05, 0.5), chance.between(0.1, 1.0)}};
    default:
      return {a, spheroid()};
  }
}
/// Solids of revolution of every kind, one of them an ellipsoid.
TwoShapes roundShapes(Chance& chance) {
  const auto size = [&] { return chance.between(0.05, 0.5); };
  const double radius = size();
  const Shape ellipsoid = Ellipsoid{{radius, radius, size()}};
  const double other = size(), half = size();
  const Shape others[] = {Ellipsoid{{other, other, half}}, Cone{other, 2.0 * half}, Cylinder{other, 2.0 * half},
                          Capsule{other, 2.0 * half}};
  const Shape second = chance.oneOf(others);
  return inAnyOrder(chance, ellipsoid, second);
}
/// A shape of any size down to 1e-318 m.
Shape vanishing(Chance& chance) {
  Vector3d sizes;
  for (int i = 0; i < 3; ++i) sizes[i] = chance.below(3) == 0 ? chance.between(0.2, 1.0) : chance.decades(-318, 0);
  return chance.below(4) == 0 ? hullOf(boxCorners(sizes)) : primitive(chance, sizes);
}
/// One of them has some size of about a metre: all together must not vanish.
TwoShapes vanishingShapes(Chance& chance) {
  Shape large = vanishing(chance);
  while (radiusOf(large) < 0.1) large = vanishing(chance);
  const Shape small = vanishing(chance);
  return inAnyOrder(chance, large, small);
}
TwoShapes anyShapes(Chance& chance) {
  const double size = chance.decades(-2, 3);
  return {anyShape(chance, size), anyShape(chance, size * (chance.below(4) == 0 ? chance.decades(-6, 0) : 1.0))};
}

// Poses. Those of the centres first: a hull may lie far from the origin of its frame.

/// Both placed in the world, 1e3 to 1e6 m from its origin; the relative pose is what double makes of that.
Isometry3d farInTheWorld(const TwoShapes& shapes, Chance& chance) {
  const Isometry3d a_T_b = anywhereWithin(shapes, chance, 1.2);
  Isometry3d world_T_a = randomPose(chance, 0.0);
  world_T_a.translation() = chance.decades(3, 6) * randomDirection(chance);
  const Isometry3d world_T_b = world_T_a * a_T_b;
  return world_T_a.inverse() * world_T_b;
}

Isometry3d concentric(const TwoShapes& shapes, Chance& chance) {
  Matrix3d rotation = Matrix3d::Identity();
  if (chance.below(3) == 0) rotation = quarterTurns(chance);
  if (chance.below(3) == 0) rotation = randomPose(chance, 0.0).linear();
  Vector3d offset = Vector3d::Zero();
  if (chance.below(2) == 0) offset = radiusOf(shapes.a) * chance.decades(-17, -3) * randomDirection(chance);
  return withCentres(shapes, rotation, offset);
}

/// Every entry of the rotation its own neighbour among the doubles; a zero becomes what rounding leaves of one.
Isometry3d offByAnUlp(Isometry3d a_T_b, Chance& chance) {
  for (int i = 0; i < 9; ++i) {
    double& entry = a_T_b.linear()(i / 3, i % 3);
    const double epsilon = std::numeric_limits<double>::epsilon();
    const int direction = chance.below(3) - 1;
    if (direction == 0) continue;
    entry = entry == 0.0 ? 0.5 * direction * epsilon : std::nextafter(entry, 2.0 * direction);
  }
  return a_T_b;
}

/// Axes parallel but for a tilt, the centres on one axis but for an offset.
Isometry3d coaxial(const TwoShapes& shapes, Chance& chance) {
  Isometry3d a_T_b = concentric(shapes, chance);
  const double tilt = chance.below(2) == 0 ? 0.0 : chance.decades(-17, -2);
  a_T_b.linear() = Eigen::AngleAxisd(tilt, randomDirection(chance)).toRotationMatrix();
  if (chance.below(4) == 0) a_T_b.linear() = a_T_b.linear() * Vector3d(1, -1, -1).asDiagonal();
  a_T_b.translation().z() += chance.between(-1.5, 1.5) * radiusOf(shapes.a);
  return a_T_b;
}

/// Centres and axes the same but for an offset and a tilt of every size.
Isometry3d nearlyConcentric(const TwoShapes& shapes, Chance& chance) {
  const double tilt = chance.below(4) == 0 ? 0.0 : chance.decades(-14, -1);
  const double offset = chance.below(4) == 0 ? 0.0 : chance.decades(-16, -1);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, randomDirection(chance)).toRotationMatrix();
  if (chance.below(4) == 0) rotation = rotation * quarterTurns(chance);
  return withCentres(shapes, rotation, offset * radiusOf(shapes.a) * randomDirection(chance));
}

/// Offsets and a tilt of every size.
Isometry3d vanishingOffset(const TwoShapes& shapes, Chance& chance) {
  Vector3d offset;
  for (int i = 0; i < 3; ++i) offset[i] = chance.below(3) == 0 ? 0.0 : chance.eitherSign(chance.decades(-320, 0));
  const double tilt = chance.below(2) == 0 ? 0.0 : chance.decades(-320, 0);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, Vector3d::Unit(chance.below(3))).toRotationMatrix();
  if (chance.below(2) == 0) rotation = rotation * quarterTurns(chance);
  return withCentres(shapes, rotation, offset);
}

/// Axes that are parallel within 1e-3 rad, the centres of overlapping shapes nearly on one of them.
Isometry3d nearOneAxis(const TwoShapes& shapes, Chance& chance) {
  const auto height = [](const Shape& shape) { return shape.halfExtents().z() + shape.margin(); };
  const double tilt = chance.below(2) == 0 ? chance.between(0.0, 1e-3) : chance.decades(-14, -3);
  const double beside = chance.below(4) == 0 ? 0.0 : chance.decades(-14, -2);
  Matrix3d rotation = Eigen::AngleAxisd(tilt, randomDirection(chance)).toRotationMatrix();
  if (chance.below(2) == 0) rotation = rotation * Vector3d(1, -1, -1).asDiagonal();
  Vector3d offset = beside * radiusOf(shapes.a) * randomDirection(chance);
  offset.z() += chance.between(-1.0, 1.0) * (height(shapes.a) + height(shapes.b));
  return withCentres(shapes, rotation, offset);
}

Isometry3d nearby(const TwoShapes& shapes, Chance& chance) { return anywhereWithin(shapes, chance, 1.2); }
Isometry3d deep(const TwoShapes& shapes, Chance& chance) { return anywhereWithin(shapes, chance, 0.2); }
Isometry3d touching(const TwoShapes& shapes, Chance& chance) {
  return movedToGap(shapes, anywhereWithin(shapes, chance, 1.2), touchingGap(shapes, chance));
}

Isometry3d anyPose(const TwoShapes& shapes, Chance& chance) {
  switch (chance.below(8)) {
    case 0:
      return deep(shapes, chance);
    case 1:
      return concentric(shapes, chance);
    case 2:
      return parallelFaces(shapes, chance);
    case 3:
      return farInTheWorld(shapes, chance);
    case 4:
      return offByAnUlp(concentric(shapes, chance), chance);
    case 5:
      return coaxial(shapes, chance);
    case 6:
      return touching(shapes, chance);
    default:
      return nearby(shapes, chance);
  }
}

// Queries.

/// The default tolerance for shapes up to a metre; beyond, the same part of the size.
Query asked(const TwoShapes& shapes, const Isometry3d& a_T_b) {
  Query query{a_T_b, {}, {}};
  query.options.distance_tolerance *= std::max(1.0, scaleOf(shapes, a_T_b));
  return query;
}

/// A query that only says where the shapes lie.
template <Isometry3d (*pose)(const TwoShapes&, Chance&)>
Query posed(const TwoShapes& shapes, Chance& chance) {
  return asked(shapes, pose(shapes, chance));
}

Isometry3d nearbyOrTouching(const TwoShapes& shapes, Chance& chance) {
  return chance.below(2) == 0 ? nearby(shapes, chance) : touching(shapes, chance);
}
Isometry3d farApart(const TwoShapes& shapes, Chance& chance) {
  const Isometry3d pose = randomPose(chance, 0.0);
  return withCentres(shapes, pose.linear(), chance.decades(3, 6) * randomDirection(chance));
}
Isometry3d vanishingOffsets(const TwoShapes& shapes, Chance& chance) {
  return chance.below(2) == 0 ? anyPose(shapes, chance) : vanishingOffset(shapes, chance);
}
Isometry3d withAnUlp(const TwoShapes& shapes, Chance& chance) {
  Isometry3d a_T_b = anywhereWithin(shapes, chance, 1.0);
  if (chance.below(3) != 0) a_T_b = withCentres(shapes, quarterTurns(chance), a_T_b.translation());
  return offByAnUlp(a_T_b, chance);
}
/// The vertices say where they are; b moves a little from there, or not at all.
Isometry3d nearlyAsTheyAre(const TwoShapes& /*shapes*/, Chance& chance) {
  Isometry3d a_T_b = Isometry3d::Identity();
  if (chance.below(8) != 0) a_T_b.translation() = chance.decades(-10, 0) * randomDirection(chance);
  return a_T_b;
}

/// Whether the distance is above a threshold that is the distance, or next to it.
Query aboveTheTruth(const TwoShapes& shapes, Chance& chance) {
  Query query = posed<nearbyOrTouching>(shapes, chance);
  const double distance = signedDistance(shapes.a, shapes.b, query.a_T_b, query.options).distance;
  const double offset = chance.below(4) == 0 ? 0.0 : chance.eitherSign(chance.decades(-17, -9));
  query.options.stop_above = query.options.stop_below = distance + offset;
  return query;
}
Query withOptions(const TwoShapes& shapes, Chance& chance) {
  Query query = asked(shapes, anyPose(shapes, chance));
  query.options.distance_tolerance = chance.decades(-14, -2);
  const int caps[] = {1, 2, 3, 5, 10, 500};
  query.options.max_iterations = chance.oneOf(caps);
  return query;
}

/// After a query of the same shapes somewhere else.
Query afterAJump(const TwoShapes& shapes, Chance& chance) {
  Query query = asked(shapes, anyPose(shapes, chance));
  signedDistance(shapes.a, shapes.b, anyPose(shapes, chance), query.options, query.warm_start);
  return query;
}

WarmStart garbage(Chance& chance) {
  const double values[] = {0.0,   -0.0,   1.0,    -1.0,
                           1e300, -1e300, 1e-300, std::numeric_limits<double>::denorm_min(),
                           1e-17, 1e154,  1e-160, std::numeric_limits<double>::infinity(),
                           0.5,   3.0,    -0.1,   std::numeric_limits<double>::quiet_NaN()};
  const int vertices[] = {-1, 0, 1, 7, 1000, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
  const auto value = [&] { return chance.oneOf(values); };
  const auto vertex = [&] { return chance.oneOf(vertices); };
  WarmStart result{Vector3d(value(), value(), value())};
  for (WarmStart::Pair& pair : result.simplex) pair = {vertex(), vertex()};
  result.simplex_size = vertex();
  return result;
}

Query afterGarbage(const TwoShapes& shapes, Chance& chance) {
  Query query = asked(shapes, anyPose(shapes, chance));
  query.warm_start = garbage(chance);
  return query;
}

Query anyQuery(const TwoShapes& shapes, Chance& chance) {
  switch (chance.below(4)) {
    case 0:
      return withOptions(shapes, chance);
    case 1:
      return afterAJump(shapes, chance);
    case 2:
      return afterGarbage(shapes, chance);
    default:
      return asked(shapes, anyPose(shapes, chance));
  }
}

}  // namespace

const std::vector<Family>& stressFamilies() {
  static const std::vector<Family> families = {
      {"all shape pairs", solids, posed<nearby>},
      {"touching", solids, posed<touching>},
      {"boxes of every size", boxesOfEverySize, posed<nearbyOrTouching>},
      {"parallel faces", boxesOfEverySize, posed<parallelFaces>},
      {"equal boxes, face to face", equalBoxes, posed<parallelFaces>},
      {"parallel faces and edges, curved", primitives, posed<parallelFaces>},
      {"slivers", slivers, posed<nearbyOrTouching>},
      {"size ratio", sizeRatio, posed<nearbyOrTouching>},
      {"far in the world", solids, posed<farInTheWorld>},
      {"far apart", solids, posed<farApart>},
      {"vertices far from the origin", farFromTheirOrigin, posed<nearlyAsTheyAre>},
      {"identical", identicalShapes, posed<concentric>},
      {"flat hulls", flatShapes, posed<nearbyOrTouching>},
      {"flat hulls in one plane", flatShapes, posed<parallelFaces>},
      {"near-duplicate vertices", nearDuplicateShapes, posed<nearbyOrTouching>},
      {"coplanar vertices", coplanarShapes, posed<nearbyOrTouching>, 32},
      {"coplanar faces in contact", coplanarShapes, posed<parallelFaces>, 8},
      {"concentric", solids, posed<concentric>},
      {"coaxial", revolvedShapes, posed<coaxial>, 8},
      {"deep", solids, posed<deep>},
      {"rotations off by an ulp", solids, posed<withAnUlp>},
      {"boxes off by an ulp", equalBoxes, posed<withAnUlp>},
      {"large hulls", largeHulls, posed<nearbyOrTouching>, 8},
      {"tolerances and iteration limits", solids, withOptions},
      {"warm start from elsewhere", solids, afterAJump},
      {"warm start from garbage", solids, afterGarbage},
      {"random mix", anyShapes, anyQuery, 8},
      {"swept shapes", sweptShapes, posed<nearbyOrTouching>, 32},
      {"needle clouds", needleClouds, posed<nearbyOrTouching>, 64},
      {"nearly coaxial mantles", mantles, posed<nearlyConcentric>, 8},
      {"nearly coaxial cones", cones, posed<nearlyConcentric>, 8},
      {"rings of equal depth", spheroids, posed<nearlyConcentric>, 8},
      {"sizes down to nothing", vanishingShapes, posed<vanishingOffsets>, 8},
      {"round shapes near one axis", roundShapes, posed<nearOneAxis>, 64},
      {"thresholds at the truth", solids, aboveTheTruth, 2},
      {"thresholds at the truth, needles", needleClouds, aboveTheTruth, 64},
  };
  return families;
}

std::vector<StressPair> stressBlock(std::size_t family, unsigned seed, std::int64_t block) {
  Chance chance(seed, family, block);
  const Family& kind = stressFamilies().at(family);
  const TwoShapes shapes = kind.shapes(chance);
  std::vector<StressPair> pairs;
  for (std::int64_t i = 0; i < kPairsPerBlock; ++i) {
    const Query query = kind.query(shapes, chance);
    pairs.push_back({shapes.a, shapes.b, query.a_T_b, query.options, query.warm_start});
  }
  return pairs;
}

}  // namespace proximity_server::narrowphase
