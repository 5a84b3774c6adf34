#include "laws/pair_laws.h"

#include "narrowphase/certificate.h"
#include "narrowphase/same_bits.h"
#include "narrowphase/scaled.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"
#include "stress/campaign.h"

#include <cmath>
#include <functional>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

SignedDistance ask(const StressPair& p) {
  WarmStart warm_start = p.warm_start;
  return signedDistance(p.a, p.b, p.a_T_b, p.options, warm_start);
}

AssertionResult sameBits(const SignedDistance& x, const SignedDistance& y) {
  if (areSameBits(x, y) && x.iterations == y.iterations) return AssertionSuccess();
  return AssertionFailure() << "same input, other bits: " << x.distance - y.distance;
}

/// Two results enclose one truth, but for `apart` [m].
AssertionResult agree(const SignedDistance& x, const SignedDistance& y, double apart) {
  const double excess = std::max(x.lower_bound - y.upper_bound, y.lower_bound - x.upper_bound) - apart;
  if (excess <= 0.0) return AssertionSuccess();
  return AssertionFailure() << "bounds exclude those of the first query by " << excess << " m";
}

AssertionResult isFinite(const SignedDistance& result) {
  const bool points = result.point_a.allFinite() && result.point_b.allFinite();
  if (!std::isfinite(result.distance)) return AssertionFailure() << "distance is " << result.distance;
  if (!result.normal.allFinite()) return AssertionFailure() << "normal is not finite";
  if (result.has_points && !points) return AssertionFailure() << "has_points, but they are not finite";
  if (!result.has_points && points) return AssertionFailure() << "has points, but says that it has none";
  return AssertionSuccess();
}

/// GJK and EPA may each take max_iterations.
AssertionResult iterationsAreBounded(const SignedDistance& result, const Options& options) {
  if (result.iterations >= 0 && result.iterations <= 2 * options.max_iterations) return AssertionSuccess();
  return AssertionFailure() << result.iterations << " iterations";
}

bool isDecided(const SignedDistance& result, const Options& options) {
  return result.lower_bound > options.stop_above || result.upper_bound <= options.stop_below;
}

/// A search that a threshold may end decides the threshold if the whole search does.
AssertionResult decidesAsTheWholeSearch(const StressPair& p, const SignedDistance& result) {
  StressPair whole = p;
  whole.options.stop_above = std::numeric_limits<double>::infinity();
  whole.options.stop_below = -whole.options.stop_above;
  if (isDecided(result, p.options) || !isDecided(ask(whole), p.options)) return AssertionSuccess();
  return AssertionFailure() << "the whole search decides the threshold, this one does not";
}

/// A warm start does not keep a search from converging.
AssertionResult convergesAsAColdSearch(const StressPair& p, const SignedDistance& result) {
  const bool is_open = result.status == Status::IterationLimit || result.status == Status::Degenerate;
  StressPair cold = p;
  cold.warm_start = {};
  if (!is_open || ask(cold).status != Status::Converged) return AssertionSuccess();
  return AssertionFailure() << "a cold search converges, this one does not";
}

/// `meant`: the same pair, with the pose that the pose of `p` stands for.
AssertionResult keepsItsPromises(const StressPair& p, const StressPair& meant, const SignedDistance& result) {
  AssertionResult check = isFinite(result);
  if (check) check = iterationsAreBounded(result, p.options);
  if (check) check = carriesItsProof(meant.pair(), result, p.options);
  if (check) check = decidesAsTheWholeSearch(p, result);
  if (check) check = convergesAsAColdSearch(p, result);
  return check;
}

AssertionResult keepsItsPromises(const StressPair& p, const SignedDistance& result) {
  return keepsItsPromises(p, p, result);
}

/// A relative of the pair, whose true distance is the pair's within `apart` [m].
struct Relative {
  const char* name;
  StressPair pair;
  double apart;
};

/// How far the linear part is from a rotation, which keeps lengths: its inverse changes them by that part.
double departureFromRotation(const Isometry3d& pose) {
  return (pose.linear().transpose() * pose.linear() - Eigen::Matrix3d::Identity()).norm();
}

Relative swapped(const StressPair& p) {
  const Isometry3d b_T_a = p.a_T_b.inverse(Eigen::Affine);
  // The inverse is rounded: nine products with a translation, six with a rotation, once in each direction.
  return {"swapped",
          {p.b, p.a, b_T_a, p.options, {-p.warm_start.axis}},
          2.0 * roundingOf(p.pair()) + departureFromRotation(p.a_T_b) * p.pair().scale()};
}

/// Both placed in a world by one motion; as far as each entry of the relative pose is rounded on that way.
Relative moved(const StressPair& p, Chance& chance) {
  const double reach = 10.0 * p.pair().scale();
  const Isometry3d world_T_a = randomPose(chance, reach);
  StressPair pair = p;
  pair.a_T_b = world_T_a.inverse() * (world_T_a * p.a_T_b);
  return {"moved with a", pair, roundingOf(p.pair()) + 16.0 * std::numeric_limits<double>::epsilon() * reach};
}

/// The distance changes by no more than the motion.
Relative shifted(const StressPair& p, Chance& chance) {
  const Vector3d motion = chance.decades(-16, -1) * p.pair().scale() * randomDirection(chance);
  StressPair pair = p;
  pair.a_T_b.pretranslate(motion);
  return {"shifted by a small motion", pair, motion.norm() + roundingOf(p.pair())};
}

Relative cold(const StressPair& p) {
  StressPair pair = p;
  pair.warm_start = {};
  return {"started cold", pair, roundingOf(p.pair())};
}

Relative warm(const StressPair& p) {
  StressPair pair = p;
  signedDistance(p.a, p.b, p.a_T_b, p.options, pair.warm_start);
  return {"started from its own end", pair, roundingOf(p.pair())};
}

Relative askedAbove(const StressPair& p, double threshold) {
  StressPair pair = p;
  pair.options.stop_above = pair.options.stop_below = threshold;
  return {"asked for a threshold", pair, roundingOf(p.pair())};
}

Relative askedApart(const StressPair& p) {
  StressPair pair = p;
  pair.options.stop_below = 0.0;
  return {"asked only for a distance apart", pair, roundingOf(p.pair())};
}

/// The swapped pair has the opposite normal where the shapes are apart. By d the normal is unique: the gap along n is at
/// most d times the cosine of its angle to the true normal, so a gap of d - w allows an angle of sqrt(2 w / d).
std::optional<Failure> failureOfNormal(const Relative& swapped, const SignedDistance& first) {
  const SignedDistance other = ask(swapped.pair);
  if (!(first.distance > 0.0) || !first.has_points || !other.has_points) return std::nullopt;
  const double width =
      std::max(first.upper_bound - first.lower_bound, other.upper_bound - other.lower_bound) + swapped.apart;
  const Isometry3d& b_T_a = swapped.pair.a_T_b;
  const double off = (other.normal + b_T_a.linear() * first.normal).norm();
  if (off <= 2.0 * std::sqrt(2.0 * width / first.distance)) return std::nullopt;
  return Failure{"swapped, the normal is off the opposite one by " + std::to_string(off), swapped.pair};
}

std::optional<Failure> failureOf(const Relative& relative, const SignedDistance& first) {
  const SignedDistance result = ask(relative.pair);
  AssertionResult check = keepsItsPromises(relative.pair, result);
  if (check) check = agree(result, first, relative.apart);
  if (check) return std::nullopt;
  return Failure{std::string(relative.name) + ": " + check.message(), relative.pair};
}

/// A pose of single precision stands for the nearest rotation.
std::optional<Failure> failureOfSinglePrecision(const StressPair& p) {
  StressPair given = p;
  given.a_T_b.matrix() = p.a_T_b.matrix().cast<float>().cast<double>();
  StressPair meant = given;
  meant.a_T_b = rigidPose(given.a_T_b).value();
  const AssertionResult check = keepsItsPromises(given, meant, ask(given));
  if (check) return std::nullopt;
  return Failure{std::string("in single precision: ") + check.message(), given};
}

/// A pair that has moved a little begins with the polytope that its first query has kept.
std::optional<Failure> failureOfRecalled(const StressPair& p, const SignedDistance& first, Chance& chance) {
  WarmPolytope polytope;
  StressPair begun = p;
  begun.warm_start = {};
  begun.warm_start.polytope = &polytope;
  signedDistance(p.a, p.b, p.a_T_b, p.options, begun.warm_start);
  std::optional<Failure> failure = failureOf(shifted(begun, chance), first);
  if (!failure) return std::nullopt;
  failure->pair.warm_start.polytope = nullptr;
  return Failure{"begun with the last polytope, " + failure->sentence, failure->pair};
}

/// A pair that has moved a little, and asks for the bits of a cold search, has them with its first warm start, too.
std::optional<Failure> failureOfRepeated(const StressPair& p, Chance& chance) {
  StressPair begun = p;
  begun.options.repeatability = Repeatability::Always;
  signedDistance(p.a, p.b, p.a_T_b, begun.options, begun.warm_start);
  begun = shifted(begun, chance).pair;
  const SignedDistance found = ask(begun), expected = ask(cold(begun).pair);
  const double threshold = begun.options.stop_above;
  if (found.lower_bound > threshold && expected.lower_bound > threshold) return std::nullopt;  // each has its own proof
  if (areSameBits(found, expected)) return std::nullopt;
  return Failure{"repeatable, but other bits from a warm start: " + std::to_string(found.distance - expected.distance),
                 begun};
}

/// A threshold near the distance is the hard one.
double thresholdNear(const SignedDistance& first, double size, Chance& chance) {
  const double offset = chance.decades(-17, 0) * size;
  return first.distance + (chance() % 2 == 0 ? offset : -offset);
}

/// Any seed will do, but a recorded pair must meet the same relatives again.
unsigned seedOf(const StressPair& p) {
  const std::hash<double> hash;
  std::size_t seed = 0;
  for (int i = 0; i < 16; ++i) seed = 31 * seed + hash(p.a_T_b.matrix().data()[i]);
  return static_cast<unsigned>(seed ^ (seed >> 32));
}

std::optional<Failure> failureOfRelatives(const StressPair& p, const SignedDistance& first) {
  Chance chance(seedOf(p));
  const double threshold = thresholdNear(first, p.pair().scale(), chance);
  for (const Relative& relative :
       {swapped(p), moved(p, chance), shifted(p, chance), warm(p), cold(p), askedAbove(p, threshold), askedApart(p)})
    if (std::optional<Failure> failure = failureOf(relative, first)) return failure;
  if (std::optional<Failure> failure = failureOfNormal(swapped(p), first)) return failure;
  if (std::optional<Failure> failure = failureOfSinglePrecision(p)) return failure;
  if (std::optional<Failure> failure = failureOfRepeated(p, chance)) return failure;
  return failureOfRecalled(p, first, chance);
}

double errorLimit(const Shape& shape) { return shape.isPolytope() ? kPolytopeErrorLimit : kCurvedErrorLimit; }

/// Asked as exactly as the limits, the answer encloses the truth and lies within them where it says Converged.
AssertionResult isAsExactAsItsLimit(const StressPair& p, const Truth& truth) {
  StressPair exact = p;
  exact.options.distance_tolerance = std::max(errorLimit(p.a), errorLimit(p.b)) * p.pair().scale();
  const SignedDistance result = ask(exact);
  const AssertionResult encloses = enclosesTruth(p.pair(), result, truth);
  if (!encloses) return encloses;
  const double excess = errorOf(result, truth) - exact.options.distance_tolerance;
  if (result.status != Status::Converged || excess <= roundingOf(p.pair())) return AssertionSuccess();
  return AssertionFailure() << "converged, but off by " << excess << " m more than the limit";
}

/// A hull of the vertices of a hull may leave out some of them, see ConvexHull; then it is another shape.
bool hasTheVerticesOf(const Shape& scaled, const Shape& shape) {
  if (shape.kind() == Shape::Kind::Sweep) return hasTheVerticesOf(scaled.sweep().shape, shape.sweep().shape);
  return shape.kind() != Shape::Kind::Hull || scaled.hull().size() == shape.hull().size();
}

/// A power of two loses no bit: everything, tolerance and all, scales with the shapes.
AssertionResult scalesWithItsShapes(const StressPair& p, const SignedDistance& first) {
  const double factor = 0.25;
  StressPair small{scaled(p.a, factor), scaled(p.b, factor), p.a_T_b, p.options, {}};
  if (!hasTheVerticesOf(small.a, p.a) || !hasTheVerticesOf(small.b, p.b)) return AssertionSuccess();
  small.a_T_b.translation() *= factor;
  small.options.distance_tolerance *= factor;
  SignedDistance result = ask(small);
  const AssertionResult check = keepsItsPromises(small, result);
  if (!check) return AssertionFailure() << "a quarter of the size: " << check.message();
  result.lower_bound /= factor;
  result.upper_bound /= factor;
  const AssertionResult same = agree(result, first, roundingOf(p.pair()));
  return same ? same : AssertionFailure() << "a quarter of the size: " << same.message();
}

}  // namespace

Observation observe(const StressPair& p) {
  Observation seen;
  seen.size = p.pair().scale();
  const stress::Stopwatch first;
  seen.result = ask(p);
  const double microseconds = 1e6 * first.seconds();
  const stress::Stopwatch second;
  const SignedDistance repeated = ask(p);
  seen.microseconds = std::min(microseconds, 1e6 * second.seconds());

  AssertionResult check = sameBits(seen.result, repeated);
  if (check) check = keepsItsPromises(p, seen.result);
  if (!check)
    seen.failure = Failure{check.message(), p};
  else
    seen.failure = failureOfRelatives(p, seen.result);
  return seen;
}

Observation observeWithOracle(const StressPair& p) {
  Observation seen = observe(p);
  const Truth truth = signedDistanceOracle(p.pair(), /*max_cells=*/4000);
  seen.error = errorOf(seen.result, truth);
  AssertionResult check = enclosesTruth(p.pair(), seen.result, truth);
  if (check) check = isAsExactAsItsLimit(p, truth);
  if (check) check = scalesWithItsShapes(p, seen.result);
  if (!check && !seen.failure) seen.failure = Failure{check.message(), p};
  return seen;
}

}  // namespace proximity_server::narrowphase
