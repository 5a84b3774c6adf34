#include "stress/motion_families.h"

#include <algorithm>
#include <cmath>

#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/random_geometry.h"

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Random = std::mt19937;

// Shapes.

TwoShapes solids(Random& random) {
  const Shape a = solid(random, 1.0);
  return {a, solid(random, 1.0)};
}

Shape thinOrFlat(Random& random) { return below(random, 2) == 0 ? sliver(random, 1.0) : flat(random, 1.0); }

TwoShapes thinShapes(Random& random) {
  const Shape a = thinOrFlat(random);
  return {a, thinOrFlat(random)};
}

TwoShapes shapesWithFaces(Random& random) {
  const Shape a = boxOrItsHull(random, randomSizes(random, 1.0));
  if (below(random, 2) == 0) return {a, boxOrItsHull(random, randomSizes(random, 1.0))};
  return {a, primitive(random, randomSizes(random, 1.0))};
}

TwoShapes anyShapes(Random& random) { return below(random, 3) == 0 ? thinShapes(random) : solids(random); }

// Motions.

/// Of the origin `travel` [m] far while it turns by `turn` [rad], from a start within `reach` [m].
ScrewMotion screw(Random& random, double reach, double travel, double turn) {
  const Isometry3d start = randomPose(random, reach);
  const Vector3d linear = travel * randomDirection(random);
  return {start, linear, turn * randomDirection(random)};
}

MotionChain chain(Random& random, int screws) {
  MotionChain motion;
  for (int i = 0; i < screws; ++i) {
    const double turn = below(random, 4) == 0 ? 0.0 : uniform(random, 0.0, M_PI);
    const double travel = below(random, 2) == 0 ? 0.0 : uniform(random, 0.0, 1.0);
    motion.push_back(screw(random, 0.7, travel, turn));
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

double someContactDistance(Random& random) {
  switch (below(random, 4)) {
    case 0:
      return decades(random, -4, -0.5);
    case 1:
      return -decades(random, -4, -1);
    default:
      return 0.0;
  }
}

ContactOptions someOptions(Random& random) {
  ContactOptions options;
  options.contact_distance = someContactDistance(random);
  if (below(random, 4) == 0) options.tolerance = decades(random, -12, -2);
  if (below(random, 4) != 0) return options;
  options.begin = uniform(random, 0.0, 0.5);
  options.end = options.begin + uniform(random, 0.0, 1.0 - options.begin);
  return options;
}

double timeWithin(const ContactOptions& options, Random& random) {
  const double times[] = {options.begin, options.end, uniform(random, options.begin, options.end)};
  return times[below(random, 8) < 6 ? 2 : below(random, 2)];
}

StressMotion asked(Random& random, const TwoShapes& shapes, MotionChain a_motion, MotionChain b_motion) {
  return {shapes.a, std::move(a_motion), shapes.b, std::move(b_motion), someOptions(random), {}};
}

/// b within `part` of the sum of the radii from a at some time.
StressMotion meeting(Random& random, StressMotion motion, double part) {
  const Isometry3d a_T_b = anywhereWithin({motion.a, motion.b}, random, part);
  meet(motion, timeWithin(motion.options, random), a_T_b);
  return motion;
}

/// At the contact distance, within touchingGap, at some time.
StressMotion touching(Random& random, StressMotion motion) {
  const TwoShapes shapes{motion.a, motion.b};
  const Isometry3d near = anywhereWithin(shapes, random, 1.2);
  const double gap = motion.options.contact_distance + touchingGap(shapes, random);
  meet(motion, timeWithin(motion.options, random), movedToGap(shapes, near, gap));
  return motion;
}

// Families.

StressMotion translations(Random& random) {
  const MotionChain a_motion = {screw(random, 1.0, decades(random, -1, 1), 0.0)};
  const MotionChain b_motion = {screw(random, 1.0, decades(random, -1, 1), 0.0)};
  return meeting(random, asked(random, solids(random), a_motion, b_motion), 1.3);
}

StressMotion screws(Random& random) {
  const MotionChain a_motion = {screw(random, 1.0, uniform(random, 0.0, 2.0), uniform(random, 0.0, M_PI))};
  const MotionChain b_motion = {screw(random, 1.0, uniform(random, 0.0, 2.0), uniform(random, 0.0, M_PI))};
  return meeting(random, asked(random, solids(random), a_motion, b_motion), 1.5);
}

StressMotion fastRotations(Random& random) {
  const double turns = 2.0 * M_PI * uniform(random, 1.0, 5.0);
  const MotionChain a_motion = {screw(random, 1.0, uniform(random, 0.0, 1.0), uniform(random, 0.0, 1.0))};
  const MotionChain b_motion = {screw(random, 1.0, uniform(random, 0.0, 2.0), turns)};
  return meeting(random, asked(random, solids(random), a_motion, b_motion), 1.5);
}

StressMotion chains(Random& random) {
  const MotionChain a_motion = chain(random, below(random, 5)), b_motion = chain(random, 1 + below(random, 5));
  return meeting(random, asked(random, solids(random), a_motion, b_motion), 1.5);
}

StressMotion thinAndFast(Random& random) {
  const double turn = below(random, 2) == 0 ? 0.0 : uniform(random, 0.0, 2.0 * M_PI);
  const MotionChain a_motion = {screw(random, 1.0, 0.0, below(random, 2) == 0 ? 0.0 : 1.0)};
  const MotionChain b_motion = {screw(random, 1.0, decades(random, 0, 2), turn)};
  return meeting(random, asked(random, thinShapes(random), a_motion, b_motion), 0.5);
}

StressMotion touchingOnTheWay(Random& random) {
  const MotionChain a_motion = {screw(random, 1.0, uniform(random, 0.0, 1.0), uniform(random, 0.0, 1.0))};
  const MotionChain b_motion = {screw(random, 1.0, uniform(random, 0.0, 1.0), uniform(random, 0.0, 1.0))};
  return touching(random, asked(random, anyShapes(random), a_motion, b_motion));
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
double grazingOffset(Random& random) {
  return below(random, 8) == 0 ? 0.0 : eitherSign(random, decades(random, -12, -3));
}

StressMotion grazing(Random& random) {
  StressMotion motion = below(random, 2) == 0 ? screws(random) : chains(random);
  const double time = closestTime(motion);
  motion.suspects.push_back(time);
  motion.options.contact_distance =
      static_cast<double>(fastDistanceAt(motion.pair(), time).high) + grazingOffset(random);
  return motion;
}

/// Two spheres past each other on a straight way: on paper they touch at the suspect time, and only then.
StressMotion grazingSpheres(Random& random) {
  const double radius_a = decades(random, -3, 0), radius_b = decades(random, -3, 0), closest = radius_a + radius_b;
  const Vector3d way = randomDirection(random), across = way.unitOrthogonal();
  StressMotion motion{Sphere{radius_a}, {}, Sphere{radius_b}, {}, {}, {}};
  const double time = uniform(random, 0.1, 0.9), speed = decades(random, -1, 2);
  ScrewMotion past{Isometry3d::Identity(), speed * way, Vector3d::Zero()};
  const double offset = grazingOffset(random);
  past.start.translation() = closest * across - time * speed * way;
  motion.b_motion = {past};
  motion.options.contact_distance = offset;
  motion.suspects = {time};
  return motion;
}

/// Faces at the contact distance, within touchingGap, while one slides along the other and turns about the normal.
StressMotion sliding(Random& random) {
  const TwoShapes shapes = shapesWithFaces(random);
  const Isometry3d a_T_b = parallelFaces(shapes, random);
  const Vector3d normal = signedDistance(shapes.a, shapes.b, a_T_b).normal;
  const Vector3d along = normal.unitOrthogonal();
  StressMotion motion = asked(random, shapes, {}, {{a_T_b, uniform(random, 0.0, 0.5) * along, Vector3d::Zero()}});
  if (below(random, 2) == 0) motion.b_motion.front().angular = uniform(random, -1.0, 1.0) * normal;
  if (below(random, 2) == 0) motion.options.contact_distance = 0.0;
  motion.b_motion.front().start.pretranslate(motion.options.contact_distance * normal);
  return motion;
}

StressMotion touchingAtFirst(Random& random) {
  StressMotion motion = screws(random);
  const TwoShapes shapes{motion.a, motion.b};
  const double gap = motion.options.contact_distance + touchingGap(shapes, random);
  meet(motion, motion.options.begin, movedToGap(shapes, anywhereWithin(shapes, random, 1.2), gap));
  return motion;
}

StressMotion overlapping(Random& random) {
  StressMotion motion = screws(random);
  meet(motion, timeWithin(motion.options, random), anywhereWithin({motion.a, motion.b}, random, 0.3));
  motion.options.contact_distance = -decades(random, -3, 0);
  return motion;
}

/// Both 1e3 to 1e6 m from the origin of their common frame.
StressMotion farAway(Random& random) {
  StressMotion motion = screws(random);
  const Vector3d far = decades(random, 3, 6) * randomDirection(random);
  motion.a_motion.front().start.translation() += far;
  motion.b_motion.front().start.translation() += far;
  return motion;
}

/// One moving frame carries both, so that nothing changes between them. Of no use but to be right: the steps are short.
StressMotion carried(Random& random) {
  StressMotion motion = touching(random, asked(random, anyShapes(random), {{}}, {{}}));
  const MotionChain carrier = chain(random, 1 + below(random, 3));
  motion.options.max_queries = 200;
  for (MotionChain* own : {&motion.a_motion, &motion.b_motion})
    own->insert(own->begin(), carrier.begin(), carrier.end());
  return motion;
}

StressMotion hardlyMoving(Random& random) {
  const auto little = [&] { return below(random, 4) == 0 ? 0.0 : decades(random, -18, -3); };
  const double travel_a = little(), turn_a = little(), travel_b = little(), turn_b = little();
  const MotionChain a_motion = {screw(random, 1.0, travel_a, turn_a)},
                    b_motion = {screw(random, 1.0, travel_b, turn_b)};
  return touching(random, asked(random, anyShapes(random), a_motion, b_motion));
}

/// Where they start and how far they go measured in the size of the shapes, 1 mm to 100 m.
StressMotion ofEverySize(Random& random) {
  const double size = decades(random, -3, 2);
  const Shape a = solid(random, size), b = solid(random, size * (below(random, 2) == 0 ? 1.0 : decades(random, -2, 0)));
  const auto motion = [&]() -> MotionChain {
    return {screw(random, size, size * uniform(random, 0.0, 2.0), uniform(random, 0.0, 2.0 * M_PI))};
  };
  const MotionChain a_motion = motion(), b_motion = motion();
  StressMotion result = meeting(random, asked(random, {a, b}, a_motion, b_motion), 1.3);
  result.options.contact_distance *= size;
  result.options.tolerance *= std::max(1.0, size);
  return result;
}

/// A round shape that spins about its own axis, or nearly so, in a frame that rests or carries it past the other.
StressMotion spinning(Random& random) {
  const double radius = uniform(random, 0.05, 0.5), length = uniform(random, 0.1, 1.0);
  const Shape round[] = {Cylinder{radius, length}, Cone{radius, length}, Capsule{radius, length},
                         Ellipsoid{{radius, radius, length}}};
  const Shape other = solid(random, 1.0), spins = round[below(random, 4)];
  const double tilt = below(random, 2) == 0 ? 0.0 : decades(random, -16, 0);
  const double moves = below(random, 2) == 0 ? 0.0 : uniform(random, 0.0, 2.0);
  const ScrewMotion carrier = screw(random, 1.0, moves, moves);
  const Vector3d axis = Vector3d::UnitZ() + tilt * randomDirection(random);
  const ScrewMotion spin{Isometry3d::Identity(), Vector3d::Zero(), uniform(random, 0.5, 10.0) * axis};
  return meeting(random, asked(random, {other, spins}, {}, {carrier, spin}), 1.5);
}

Shape offCentre(Random& random, double offset) {
  const Isometry3d pose = randomPose(random, 0.0);
  const Vector3d shift = offset * randomDirection(random);
  std::vector<Vector3d> points = boxCorners(randomSizes(random, 1.0));
  for (Vector3d& point : points) point = shift + pose * point;
  return hullOf(points);
}

/// Hulls whose vertices are far from the origin of the frame that moves: a turn carries them about.
StressMotion offCentreHulls(Random& random) {
  const Shape a = offCentre(random, decades(random, -1, 2)), b = offCentre(random, decades(random, -1, 2));
  const MotionChain a_motion = {screw(random, 1.0, uniform(random, 0.0, 2.0), decades(random, -3, 0.5))};
  const MotionChain b_motion = {screw(random, 1.0, uniform(random, 0.0, 2.0), decades(random, -3, 0.5))};
  return meeting(random, asked(random, {a, b}, a_motion, b_motion), 1.3);
}

StressMotion sweptShapes(Random& random) {
  StressMotion motion = screws(random);
  const ScrewMotion first = screw(random, 0.0, uniform(random, 0.0, 1.0), 0.0);
  const ScrewMotion second = screw(random, 0.0, uniform(random, 0.0, 0.5), uniform(random, 0.0, 0.5));
  motion.a = sweptShape(motion.a, first);
  if (below(random, 2) == 0) motion.b = sweptShape(motion.b, second);
  return motion;
}

StressMotion anything(Random& random) {
  StressMotion (*const kinds[])(Random&) = {translations, screws, fastRotations, chains, thinAndFast, touchingOnTheWay};
  StressMotion motion = kinds[below(random, 6)](random);
  const double size = decades(random, -2, 1);
  motion.a = anyShapes(random).a.padded(0.05 * size);
  const int limits[] = {1, 2, 3, 5, 20, 10000};
  motion.options.max_queries = limits[below(random, 6)];
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
  std::seed_seq sequence{static_cast<std::int64_t>(seed), static_cast<std::int64_t>(family), number, number >> 32};
  Random random(sequence);
  return motionFamilies().at(family).motion(random);
}

}  // namespace proximity_server::narrowphase
