#include "stress/motion_families.h"

#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/random_geometry.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Shapes.

TwoShapes solids(Chance& chance) {
  const Shape a = solid(chance, 1.0);
  return {a, solid(chance, 1.0)};
}

Shape thinOrFlat(Chance& chance) { return chance.below(2) == 0 ? sliver(chance, 1.0) : flat(chance, 1.0); }

TwoShapes thinShapes(Chance& chance) {
  const Shape a = thinOrFlat(chance);
  return {a, thinOrFlat(chance)};
}

TwoShapes shapesWithFaces(Chance& chance) {
  const Shape a = boxOrItsHull(chance, randomSizes(chance, 1.0));
  if (chance.below(2) == 0) return {a, boxOrItsHull(chance, randomSizes(chance, 1.0))};
  return {a, primitive(chance, randomSizes(chance, 1.0))};
}

TwoShapes anyShapes(Chance& chance) { return chance.below(3) == 0 ? thinShapes(chance) : solids(chance); }

// Motions.

/// Moves the origin by `travel` [m] and turns by `turn` [rad], from a start within `reach` [m].
ScrewMotion screw(Chance& chance, double reach, double travel, double turn) {
  const Isometry3d start = randomPose(chance, reach);
  const Vector3d linear = travel * randomDirection(chance);
  return {start, linear, turn * randomDirection(chance)};
}

MotionChain chain(Chance& chance, int screws) {
  MotionChain motion;
  for (int i = 0; i < screws; ++i) {
    const double turn = chance.below(4) == 0 ? 0.0 : chance.between(0.0, M_PI);
    const double travel = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 1.0);
    motion.push_back(screw(chance, 0.7, travel, turn));
  }
  return motion;
}

/// The start of b's motion changed so that b stands at a_T_b at that time.
void meet(StressMotion& motion, double time, const Isometry3d& a_T_b) {
  if (motion.b_motion.empty()) motion.b_motion.emplace_back();
  ScrewMotion& first = motion.b_motion.front();
  const LongPose turned = exactPoseAt(ScrewMotion{Isometry3d::Identity(), first.linear, first.angular}, time);
  const MotionChain rest(motion.b_motion.begin() + 1, motion.b_motion.end());
  const LongPose there{a_T_b.linear().cast<long double>(), a_T_b.translation().cast<long double>()};
  const LongPose frame = exactPoseAt(motion.a_motion, time) * there * exactPoseAt(rest, time).inverse();
  // The way of the origin does not depend on how the frame stands.
  first.start.linear() = (turned.rotation.transpose() * frame.rotation).cast<double>();
  first.start.translation() = (frame.translation - turned.translation).cast<double>();
  motion.suspects.push_back(time);
}

// Questions.

double someContactDistance(Chance& chance) {
  switch (chance.below(4)) {
    case 0:
      return chance.decades(-4, -0.5);
    case 1:
      return -chance.decades(-4, -1);
    default:
      return 0.0;
  }
}

ContactOptions someOptions(Chance& chance) {
  ContactOptions options;
  options.contact_distance = someContactDistance(chance);
  if (chance.below(4) == 0) options.tolerance = chance.decades(-12, -2);
  if (chance.below(4) != 0) return options;
  options.begin = chance.between(0.0, 0.5);
  options.end = options.begin + chance.between(0.0, 1.0 - options.begin);
  return options;
}

double timeWithin(const ContactOptions& options, Chance& chance) {
  const double times[] = {options.begin, options.end, chance.between(options.begin, options.end)};
  return times[chance.below(8) < 6 ? 2 : chance.below(2)];
}

StressMotion asked(Chance& chance, const TwoShapes& shapes, MotionChain a_motion, MotionChain b_motion) {
  return {shapes.a, std::move(a_motion), shapes.b, std::move(b_motion), someOptions(chance), {}};
}

/// b within `part` of the sum of the radii from a at some time.
StressMotion meeting(Chance& chance, StressMotion motion, double part) {
  const Isometry3d a_T_b = anywhereWithin({motion.a, motion.b}, chance, part);
  meet(motion, timeWithin(motion.options, chance), a_T_b);
  return motion;
}

/// At the contact distance, within touchingGap, at some time.
StressMotion touching(Chance& chance, StressMotion motion) {
  const TwoShapes shapes{motion.a, motion.b};
  const Isometry3d near = anywhereWithin(shapes, chance, 1.2);
  const double gap = motion.options.contact_distance + touchingGap(shapes, chance);
  meet(motion, timeWithin(motion.options, chance), movedToGap(shapes, near, gap));
  return motion;
}

// Families.

StressMotion translations(Chance& chance) {
  const MotionChain a_motion = {screw(chance, 1.0, chance.decades(-1, 1), 0.0)};
  const MotionChain b_motion = {screw(chance, 1.0, chance.decades(-1, 1), 0.0)};
  return meeting(chance, asked(chance, solids(chance), a_motion, b_motion), 1.3);
}

StressMotion screws(Chance& chance) {
  const MotionChain a_motion = {screw(chance, 1.0, chance.between(0.0, 2.0), chance.between(0.0, M_PI))};
  const MotionChain b_motion = {screw(chance, 1.0, chance.between(0.0, 2.0), chance.between(0.0, M_PI))};
  return meeting(chance, asked(chance, solids(chance), a_motion, b_motion), 1.5);
}

StressMotion fastRotations(Chance& chance) {
  const double turns = 2.0 * M_PI * chance.between(1.0, 5.0);
  const MotionChain a_motion = {screw(chance, 1.0, chance.between(0.0, 1.0), chance.between(0.0, 1.0))};
  const MotionChain b_motion = {screw(chance, 1.0, chance.between(0.0, 2.0), turns)};
  return meeting(chance, asked(chance, solids(chance), a_motion, b_motion), 1.5);
}

StressMotion chains(Chance& chance) {
  const MotionChain a_motion = chain(chance, chance.below(5)), b_motion = chain(chance, 1 + chance.below(5));
  return meeting(chance, asked(chance, solids(chance), a_motion, b_motion), 1.5);
}

StressMotion thinAndFast(Chance& chance) {
  const double turn = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 2.0 * M_PI);
  const MotionChain a_motion = {screw(chance, 1.0, 0.0, chance.below(2) == 0 ? 0.0 : 1.0)};
  const MotionChain b_motion = {screw(chance, 1.0, chance.decades(0, 2), turn)};
  return meeting(chance, asked(chance, thinShapes(chance), a_motion, b_motion), 0.5);
}

StressMotion touchingOnTheWay(Chance& chance) {
  const MotionChain a_motion = {screw(chance, 1.0, chance.between(0.0, 1.0), chance.between(0.0, 1.0))};
  const MotionChain b_motion = {screw(chance, 1.0, chance.between(0.0, 1.0), chance.between(0.0, 1.0))};
  return touching(chance, asked(chance, anyShapes(chance), a_motion, b_motion));
}

/// The closest approach by dense sampling and golden sections.
double closestTime(const StressMotion& motion) {
  constexpr int kSamples = 100;
  const MovingPair pair = motion.pair();
  const DistanceOverTime distance{[&](long double time) { return fastDistanceAt(pair, time); }, pair.speedLimit()};
  const ContactOptions& o = motion.options;
  const auto time = [&](int i) { return o.begin + (o.end - o.begin) * std::clamp(i, 0, kSamples) / kSamples; };
  int closest = 0;
  for (int i = 1; i <= kSamples; ++i)
    if (distance.at(time(i)).high < distance.at(time(closest)).high) closest = i;
  return static_cast<double>(timeOfLocalMinimum(distance, {time(closest - 1), time(closest + 1)}));
}

/// 0 or +-1e-12 to +-1e-3 beside the closest approach.
double grazingOffset(Chance& chance) { return chance.below(8) == 0 ? 0.0 : chance.eitherSign(chance.decades(-12, -3)); }

StressMotion grazing(Chance& chance) {
  StressMotion motion = chance.below(2) == 0 ? screws(chance) : chains(chance);
  const double time = closestTime(motion);
  motion.suspects.push_back(time);
  motion.options.contact_distance =
      static_cast<double>(fastDistanceAt(motion.pair(), time).high) + grazingOffset(chance);
  return motion;
}

/// Two spheres past each other on a straight way: on paper they touch at the suspect time, and only then.
StressMotion grazingSpheres(Chance& chance) {
  const double radius_a = chance.decades(-3, 0), radius_b = chance.decades(-3, 0), closest = radius_a + radius_b;
  const Vector3d way = randomDirection(chance), across = way.unitOrthogonal();
  StressMotion motion{Sphere{radius_a}, {}, Sphere{radius_b}, {}, {}, {}};
  const double time = chance.between(0.1, 0.9), speed = chance.decades(-1, 2);
  ScrewMotion past{Isometry3d::Identity(), speed * way, Vector3d::Zero()};
  const double offset = grazingOffset(chance);
  past.start.translation() = closest * across - time * speed * way;
  motion.b_motion = {past};
  motion.options.contact_distance = offset;
  motion.suspects = {time};
  return motion;
}

/// Faces at the contact distance, within touchingGap, while one slides along the other and turns about the normal.
StressMotion sliding(Chance& chance) {
  const TwoShapes shapes = shapesWithFaces(chance);
  const Isometry3d a_T_b = parallelFaces(shapes, chance);
  const Vector3d normal = signedDistance(shapes.a, shapes.b, a_T_b).normal;
  const Vector3d along = normal.unitOrthogonal();
  StressMotion motion = asked(chance, shapes, {}, {{a_T_b, chance.between(0.0, 0.5) * along, Vector3d::Zero()}});
  if (chance.below(2) == 0) motion.b_motion.front().angular = chance.between(-1.0, 1.0) * normal;
  if (chance.below(2) == 0) motion.options.contact_distance = 0.0;
  motion.b_motion.front().start.pretranslate(motion.options.contact_distance * normal);
  return motion;
}

StressMotion touchingAtFirst(Chance& chance) {
  StressMotion motion = screws(chance);
  const TwoShapes shapes{motion.a, motion.b};
  const double gap = motion.options.contact_distance + touchingGap(shapes, chance);
  meet(motion, motion.options.begin, movedToGap(shapes, anywhereWithin(shapes, chance, 1.2), gap));
  return motion;
}

StressMotion overlapping(Chance& chance) {
  StressMotion motion = screws(chance);
  meet(motion, timeWithin(motion.options, chance), anywhereWithin({motion.a, motion.b}, chance, 0.3));
  motion.options.contact_distance = -chance.decades(-3, 0);
  return motion;
}

/// Both 1e3 to 1e6 m from the origin of their common frame.
StressMotion farAway(Chance& chance) {
  StressMotion motion = screws(chance);
  const Vector3d far = chance.decades(3, 6) * randomDirection(chance);
  motion.a_motion.front().start.translation() += far;
  motion.b_motion.front().start.translation() += far;
  return motion;
}

/// One moving frame carries both, so that nothing changes between them. It tests that this is right, though the steps
/// are short.
StressMotion carried(Chance& chance) {
  StressMotion motion = touching(chance, asked(chance, anyShapes(chance), {{}}, {{}}));
  const MotionChain carrier = chain(chance, 1 + chance.below(3));
  motion.options.max_queries = 200;
  for (MotionChain* own : {&motion.a_motion, &motion.b_motion})
    own->insert(own->begin(), carrier.begin(), carrier.end());
  return motion;
}

StressMotion hardlyMoving(Chance& chance) {
  const auto little = [&] { return chance.below(4) == 0 ? 0.0 : chance.decades(-18, -3); };
  const double travel_a = little(), turn_a = little(), travel_b = little(), turn_b = little();
  const MotionChain a_motion = {screw(chance, 1.0, travel_a, turn_a)},
                    b_motion = {screw(chance, 1.0, travel_b, turn_b)};
  return touching(chance, asked(chance, anyShapes(chance), a_motion, b_motion));
}

/// Shapes of 1 mm to 100 m; starts and ways are measured in their size.
StressMotion ofEverySize(Chance& chance) {
  const double size = chance.decades(-3, 2);
  const Shape a = solid(chance, size), b = solid(chance, size * (chance.below(2) == 0 ? 1.0 : chance.decades(-2, 0)));
  const auto motion = [&]() -> MotionChain {
    return {screw(chance, size, size * chance.between(0.0, 2.0), chance.between(0.0, 2.0 * M_PI))};
  };
  const MotionChain a_motion = motion(), b_motion = motion();
  StressMotion result = meeting(chance, asked(chance, {a, b}, a_motion, b_motion), 1.3);
  result.options.contact_distance *= size;
  result.options.tolerance *= std::max(1.0, size);
  return result;
}

/// A round shape that spins about its own axis, or nearly so, in a frame that rests or carries it past the other.
StressMotion spinning(Chance& chance) {
  const double radius = chance.between(0.05, 0.5), length = chance.between(0.1, 1.0);
  const Shape round[] = {Cylinder{radius, length}, Cone{radius, length}, Capsule{radius, length},
                         Ellipsoid{{radius, radius, length}}};
  const Shape other = solid(chance, 1.0), spins = chance.oneOf(round);
  const double tilt = chance.below(2) == 0 ? 0.0 : chance.decades(-16, 0);
  const double moves = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 2.0);
  const ScrewMotion carrier = screw(chance, 1.0, moves, moves);
  const Vector3d axis = Vector3d::UnitZ() + tilt * randomDirection(chance);
  const ScrewMotion spin{Isometry3d::Identity(), Vector3d::Zero(), chance.between(0.5, 10.0) * axis};
  return meeting(chance, asked(chance, {other, spins}, {}, {carrier, spin}), 1.5);
}

Shape offCentre(Chance& chance, double offset) {
  const Isometry3d pose = randomPose(chance, 0.0);
  const Vector3d shift = offset * randomDirection(chance);
  std::vector<Vector3d> points = boxCorners(randomSizes(chance, 1.0));
  for (Vector3d& point : points) point = shift + pose * point;
  return hullOf(points);
}

/// Hulls whose vertices are far from the origin of the frame that moves: a turn carries them about.
StressMotion offCentreHulls(Chance& chance) {
  const Shape a = offCentre(chance, chance.decades(-1, 2)), b = offCentre(chance, chance.decades(-1, 2));
  const MotionChain a_motion = {screw(chance, 1.0, chance.between(0.0, 2.0), chance.decades(-3, 0.5))};
  const MotionChain b_motion = {screw(chance, 1.0, chance.between(0.0, 2.0), chance.decades(-3, 0.5))};
  return meeting(chance, asked(chance, {a, b}, a_motion, b_motion), 1.3);
}

StressMotion sweptShapes(Chance& chance) {
  StressMotion motion = screws(chance);
  const ScrewMotion first = screw(chance, 0.0, chance.between(0.0, 1.0), 0.0);
  const ScrewMotion second = screw(chance, 0.0, chance.between(0.0, 0.5), chance.between(0.0, 0.5));
  motion.a = sweptShape(motion.a, first);
  if (chance.below(2) == 0) motion.b = sweptShape(motion.b, second);
  return motion;
}

StressMotion anything(Chance& chance) {
  StressMotion (*const kinds[])(Chance&) = {translations, screws, fastRotations, chains, thinAndFast, touchingOnTheWay};
  StressMotion motion = chance.oneOf(kinds)(chance);
  const double size = chance.decades(-2, 1);
  motion.a = anyShapes(chance).a.padded(0.05 * size);
  const int limits[] = {1, 2, 3, 5, 20, 10000};
  motion.options.max_queries = chance.oneOf(limits);
  return motion;
}

}  // namespace

const std::vector<MotionFamily>& motionFamilies() {
  static const std::vector<MotionFamily> families = {
      {"translations", translations},
      {"screws", screws},
      {"fast rotations", fastRotations},
      {"chains", chains},
      {"thin and fast", thinAndFast},
      {"touching on the way", touchingOnTheWay},
      {"grazing", grazing},
      {"grazing spheres", grazingSpheres},
      {"sliding", sliding},
      {"touching at first", touchingAtFirst},
      {"overlapping", overlapping},
      {"far from the origin", farAway},
      {"carried by one frame", carried, 4},
      {"hardly moving", hardlyMoving},
      {"every size", ofEverySize},
      {"off-centre hulls", offCentreHulls},
      {"spinning", spinning},
      {"swept shapes", sweptShapes, 16},
      {"anything, few queries", anything},
  };
  return families;
}

StressMotion stressMotion(std::size_t family, unsigned seed, std::int64_t number) {
  Chance chance(seed, family, number);
  return motionFamilies().at(family).motion(chance);
}

}  // namespace proximity_server::narrowphase
