#include "proximity_server/narrowphase/signed_distance.h"

#include "narrowphase/closed_form/boxes.h"
#include "narrowphase/closed_form/parallel_axes.h"
#include "narrowphase/closed_form/points_segments.h"
#include "narrowphase/cso/observer.h"
#include "narrowphase/gjk_epa/epa.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "narrowphase/shape/near_origin.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// True if products of the lengths neither overflow nor underflow: an ellipsoid squares a direction that GJK computes
/// from the third power of lengths, one of which may be as small as rounding. `rounding` [m] is csoRounding(), of
/// lengths from 1e-30 to 1e30 m; it is 0 if two points coincide.
bool isComputable(double rounding) {
  constexpr double kOfOneMetre = 8.0 * std::numeric_limits<double>::epsilon();
  return rounding < 1e30 * kOfOneMetre && !(rounding > 0.0 && rounding < 1e-30 * kOfOneMetre);
}

/// [m] The error of a closed form that uses the transpose of the axes as their inverse: the two differ by twice the
/// distance from a rotation. The rounding allows for axes whose entries have been rounded.
double transposeError(const Shape& b, const Isometry3d& a_T_b, double departure2) {
  constexpr double kRoundedEntries = 4.0 * std::numeric_limits<double>::epsilon();
  if (departure2 <= kRoundedEntries * kRoundedEntries) return 0.0;
  return 6.0 * std::sqrt(departure2) * (b.coreReach() + a_T_b.translation().lpNorm<1>());
}

/// True if, within the tolerance, only one pair of points of the cores has this distance: the features of the cores
/// along the normal of the result (vertex, edge or face) have no direction in common. `numbers`: those of the vertices
/// that are the farthest along the normal, if they are known.
bool meetInOnePoint(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const SignedDistance& result,
                    double tolerance, const WarmStart::Pair& numbers) {
  const Vector3d& normal = result.normal;
  const SupportFeature on_a = supportFeature(a, normal, tolerance, numbers.a);
  if (on_a.dimension == 0) return true;
  const Vector3d towards_a = -(a_T_b.linear().transpose() * normal);
  const SupportFeature on_b = supportFeature(b, towards_a, tolerance, numbers.b);
  if (on_b.dimension == 0) return true;
  if (on_a.dimension + on_b.dimension > 2) return false;
  const Vector3d along_b = a_T_b.linear() * on_b.along;
  const double longer = std::max(on_a.along.norm(), along_b.norm());
  const double gap = result.upper_bound - result.lower_bound;
  const double sideways = tolerance + sidewaysError(a, normal, gap) + sidewaysError(b, towards_a, gap);
  return on_a.along.cross(along_b).norm() > sideways * longer;
}

/// Sets the points of the result. withMargins() will derive b's point from a's along the normal; the distance between
/// this point and `point_b` widens the upper bound: for shapes apart the points prove it, and in overlap the points lie
/// on the shapes within the gap of the bounds.
inline void setPoints(SignedDistance& result, const Vector3d& point_a, const Vector3d& point_b, double rounding) {
  result.has_points = true;
  result.point_a = point_a;
  result.point_b = point_b;
  const double missed = (point_a + result.distance * result.normal - point_b).norm();
  const double proven = result.distance > 0.0 ? result.distance + missed + rounding : result.lower_bound + missed;
  result.upper_bound = std::max(result.upper_bound, proven);
}

[[gnu::always_inline]] inline SignedDistance fromGjk(const Cso& cso, const GjkResult& gjk) {
  SignedDistance result;
  result.status = gjk.status;
  result.lower_bound = gjk.lower_bound;
  result.normal = gjk.normal;
  result.iterations = gjk.iterations;
  if (gjk.outcome == GjkResult::Outcome::Threshold) {
    result.distance = gjk.lower_bound;
    return result;
  }
  result.distance = gjk.distance;
  result.upper_bound = gjk.distance + cso.rounding();
  setPoints(result, gjk.points.on_a, gjk.points.on_b, cso.rounding());
  return result;
}

SignedDistance fromEpa(const Cso& cso, const GjkResult& gjk, const EpaResult& epa) {
  SignedDistance result;
  result.status = epa.status;
  result.upper_bound = -epa.lower_bound;
  // If the polytope does not contain the origin, only points on both cores bound the distance from above.
  if (result.upper_bound > 0.0) {
    const double by_epa = epa.has_normal && epa.has_points ? (epa.point_b - epa.point_a).norm() : gjk.distance;
    result.upper_bound = std::max(result.upper_bound, std::min(by_epa, gjk.distance) + cso.rounding());
  }
  result.iterations = gjk.iterations + epa.iterations;
  if (!epa.has_normal) {  // EPA stopped before it had a direction
    result.lower_bound = gjk.lower_bound;
    result.normal = gjk.normal;
    result.distance = result.upper_bound;
    return result;
  }
  result.distance = 0.0 - epa.depth;  // written so that a depth of 0 does not give minus zero
  result.lower_bound = -epa.depth - cso.rounding();
  result.normal = epa.normal;
  result.unique = epa.unique;
  if (epa.has_points) setPoints(result, epa.point_a, epa.point_b, cso.rounding());
  return result;
}

/// Completes the answer of a closed form: its bounds differ by rounding only. If the closed form has set a lower bound,
/// because rounding has tilted its normal, that bound is kept.
inline SignedDistance certified(SignedDistance exact, double rounding) {
  const bool has_bound = std::isfinite(exact.lower_bound);
  exact.lower_bound = (has_bound ? std::min(exact.lower_bound, exact.distance) : exact.distance) - rounding;
  exact.upper_bound = exact.distance + rounding;
  exact.status = Status::Converged;
  exact.has_points = true;
  return exact;
}

/// The data that a query remembers of its search by GJK and EPA; unchanged if there was no search.
struct SearchState {
  /// The warm start with which it began, if a threshold may end it: the copy takes a twentieth of a query without GJK.
  std::optional<WarmStart> begun_with;
  WarmStart::Pair newest{0, 0};  ///< numbers of the vertex of the CSO that was found last
  bool is_by_features = false;   ///< GjkResult::by_features
};

template <typename Observer>
SignedDistance iterative(Cso& cso, const Vector3d& normal_guess, const CsoVertex& first, const Options& options,
                         SearchState& search, Observer observer) {
  if (cso.warmStart().polytope != nullptr)
    if (const auto recalled = epaRecalled(cso, normal_guess, first, options, observer))
      return fromEpa(cso, GjkResult(), *recalled);
  observer.reaches(Algorithm::Gjk);
  const GjkResult gjk_result = gjk(cso, normal_guess, first, options, observer);
  search.is_by_features = gjk_result.by_features;
  if (gjk_result.outcome != GjkResult::Outcome::Overlap) return fromGjk(cso, gjk_result);
  return fromEpa(cso, gjk_result, epa(cso, gjk_result.simplex, options, observer));
}

/// A vector where it stands: a copy would pass through memory, and be read there in other pieces than it was written in,
/// which the processor must wait for.
using VectorInPlace = Eigen::Map<const Vector3d>;

/// False if the square of the length might underflow or overflow.
bool hasDirection(const Vector3d& axis) {
  const double length2 = axis.squaredNorm();
  return length2 > 1e-200 && length2 < 1e200;
}

/// First direction of the search, roughly from a to b. It is not normalised, so that the first support point need not
/// wait for a root and a division.
Vector3d firstDirection(const WarmStart& warm_start, const Cso& cso) {
  if (hasDirection(warm_start.axis)) return warm_start.axis;
  const Vector3d centres = cso.centreDifference();
  return centres.squaredNorm() > 1e-200 ? centres : Vector3d(Vector3d::UnitX());
}

/// The coordinates of the first direction of cores whose centres are the origins of their frames.
const double* firstDirection(const WarmStart& warm_start, const Isometry3d& a_T_b) {
  static constexpr std::array<double, 3> kUnitX{1.0, 0.0, 0.0};
  if (hasDirection(warm_start.axis)) return warm_start.axis.data();
  const VectorInPlace centres(a_T_b.translation().data());
  return centres.squaredNorm() > 1e-200 ? centres.data() : kUnitX.data();
}

/// The answer of shapes whose lower bound, which the normal proves, decides the threshold.
SignedDistance separatedAlong(const Vector3d& normal, double lower_bound, int iterations = 1) {
  SignedDistance result;
  result.status = Status::Threshold;
  result.lower_bound = result.distance = lower_bound;
  result.normal = normal;
  result.iterations = iterations;
  return result;
}

/// The answer of shapes whose upper bound decides the threshold. The normal proves the lower bound.
SignedDistance overlapAlong(const Vector3d& normal, double lower_bound, double upper_bound, int iterations = 1) {
  SignedDistance result = separatedAlong(normal, lower_bound, iterations);
  result.distance = result.upper_bound = upper_bound;
  return result;
}

/// [m] Upper bound of the distance of two cores, by the ball inside of each of them.
///
/// A translation that parts the cores parts the balls. So the signed distance of the cores is at most that of the
/// balls: the distance of the centres less both radii. The rounding of the CSO covers the distance of the centres, too:
/// it is computed as the norm of a CSO vertex is, from points of the cores, and the radii have the error of a support
/// point.
template <typename Vector>
double distanceOfInnerBalls(const Shape& a, const Shape& b, const Vector& centres, double rounding) {
  return centres.norm() - (a.innerRadius() + b.innerRadius()) + rounding;
}

bool areBoxes(const Shape& a, const Shape& b) { return a.kind() == Shape::Kind::Box && b.kind() == Shape::Kind::Box; }

bool asksThreshold(const Options& options) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  return options.stop_above < kNone || options.stop_below > -kNone;
}

/// True for a core whose support planes have formulas without support points. Its centre is the origin of its frame.
bool hasFormula(const Shape& shape) {
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
    case Shape::Kind::Cylinder:
      return true;
    case Shape::Kind::Cone:
    case Shape::Kind::Ellipsoid:
    case Shape::Kind::Hull:
    case Shape::Kind::Sweep:
      break;
  }
  return false;
}

/// True if a threshold is asked about two cores with formulas.
bool hasFirstBounds(const Shape& a, const Shape& b, const Options& options) {
  const bool is_asked = options.stop_above < std::numeric_limits<double>::infinity() ||
                        (areBoxes(a, b) && options.stop_below > -std::numeric_limits<double>::infinity());
  return is_asked && hasFormula(a) && hasFormula(b);
}

/// [m] Height of the support plane of such a core along `direction`, times the length of the direction.
template <typename Vector>
double heightAlong(const Shape& shape, const Vector& direction) {
  const Vector3d& half = shape.halfExtents();
  if (shape.kind() == Shape::Kind::Cylinder)
    return half.x() * support::radialPart(Vector3d(direction)) + half.z() * std::abs(direction.z());
  return half.dot(direction.cwiseAbs());
}

/// [m] Gap between the support planes of two such cores along `direction`, times the length of the direction.
[[gnu::always_inline]] inline double gapAlong(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                              const VectorInPlace& direction) {
  const double of_b = heightAlong(b, Vector3d(a_T_b.linear().transpose() * direction));
  return direction.dot(a_T_b.translation()) - heightAlong(a, direction) - of_b;
}

/// [m] Lower bound of the distance of two shapes by the gap between the support planes of their cores along a direction
/// of this length; `gap` is multiplied by it.
///
/// The rounding of the CSO covers that of heights, too. To first order in eps, a height has an error of 2 eps of the
/// reach, and the turned direction adds 2.6 eps of it to that of b. The last sum adds eps / 2, the norm and the quotient
/// 1.75 eps, rounding and margins 1 eps: together 7.85 eps of b's reach, and less of a's reach and of the offset.
double boundByPlanes(const Shape& a, const Shape& b, double gap, double length, double rounding) {
  return gap / length - rounding - (a.margin() + b.margin());
}

/// The answer that the fifteen axes of two boxes give: the signed distance of boxes that overlap, or that a threshold
/// is decided. Returns nullopt if the distance is not along one of the axes, or if the points are not unique.
std::optional<SignedDistance> byBoxAxes(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                                        double rounding) {
  const BoxPair boxes(a.halfExtents(), b.halfExtents(), a_T_b);
  const double separation = boxes.separation();
  if (separation - rounding > options.stop_above) return separatedAlong(boxes.normal(), separation - rounding);
  if (separation < -rounding && separation + rounding <= options.stop_below)
    return overlapAlong(boxes.normal(), separation - rounding, separation + rounding);
  const std::optional<SignedDistance> exact = boxes.distanceAlongNormal(options.distance_tolerance, rounding);
  if (!exact) return std::nullopt;
  return certified(*exact, rounding + transposeError(b, a_T_b, departure2FromRotation(a_T_b)));
}

/// The answer of two boxes that are apart by their nearest points. Returns nullopt if these are not found.
std::optional<SignedDistance> byNearestPoints(const Shape& a, const Shape& b, const Isometry3d& a_T_b, double tolerance,
                                              double rounding) {
  const auto nearest =
      nearestOfBoxes(a.halfExtents(), b.halfExtents(), a_T_b, finalGap(tolerance, rounding) - 2.0 * rounding);
  if (!nearest) return std::nullopt;
  const Vector3d normal = (nearest->on_b - nearest->on_a) / nearest->distance;
  SignedDistance result = separatedAlong(normal, nearest->gap - rounding, 0);
  result.distance = nearest->distance;
  result.upper_bound = nearest->distance + rounding;
  setPoints(result, nearest->on_a, nearest->on_b, rounding);
  return result;
}

/// [m] An upper bound of how far the tilt of the axes of two solids of revolution moves a point of b. Returns nullopt
/// if that is more than a small part of the tolerance, because the axes then do not count as parallel.
std::optional<double> turnedByTilt(const Shape& a, const Shape& b, const Isometry3d& a_T_b, double tolerance) {
  if (!isSolidOfRevolution(a.kind()) || !isSolidOfRevolution(b.kind())) return std::nullopt;
  const double turned = axesTilt(a, b, a_T_b) * b.coreReach();
  return turned <= tolerance / 16.0 ? std::optional<double>(turned) : std::nullopt;
}

/// The signed distance of cores without a closed form of their own.
template <typename Observer>
SignedDistance coreDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                            double rounding, const CsoVertex* known_first, WarmStart& warm_start, SearchState& search,
                            Observer observer) {
  if (const auto turned = turnedByTilt(a, b, a_T_b, options.distance_tolerance)) {
    observer.reaches(Algorithm::ParallelAxes);
    return certified(parallelAxesDistance(a, b, a_T_b, options.distance_tolerance),
                     rounding + *turned + transposeError(b, a_T_b, departure2FromRotation(a_T_b)));
  }
  Cso cso(a, b, a_T_b, rounding, warm_start);
  const Vector3d direction = firstDirection(warm_start, cso);
  const CsoVertex first = known_first != nullptr ? *known_first : cso.vertex(direction);
  if (asksThreshold(options)) search.begun_with = warm_start;
  const SignedDistance result = iterative(cso, direction.normalized(), first, options, search, observer);
  search.newest = cso.newestNumbers();
  return result;
}

/// Computes the signed distance of the shapes from that of their cores: the margins move both surfaces outwards along
/// the normal.
[[gnu::always_inline]] inline SignedDistance withMargins(SignedDistance result, double margin_a, double margin_b) {
  result.distance -= margin_a + margin_b;
  result.lower_bound -= margin_a + margin_b;
  result.upper_bound -= margin_a + margin_b;
  result.point_a += margin_a * result.normal;
  // b's point is computed from a's, so that the invariant of SignedDistance holds to the last bit.
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

bool isDecided(const SignedDistance& result, const Options& options) {
  return result.lower_bound > options.stop_above || result.upper_bound <= options.stop_below;
}

/// True if a threshold lies between the bounds.
bool holdsThreshold(const SignedDistance& result, const Options& options) {
  const auto holds = [&](double threshold) {
    return result.lower_bound <= threshold && threshold < result.upper_bound;
  };
  return holds(options.stop_above) || holds(options.stop_below);
}

/// The status of a search that ended with these bounds and this status. Only here is it set to Converged or Threshold
/// for good: margins, points and rounding may have moved the bounds to either side of the tolerance.
Status statusByBounds(const SignedDistance& result, const Options& options) {
  const bool converged = result.has_points && result.upper_bound - result.lower_bound <= options.distance_tolerance;
  if (converged) return Status::Converged;
  if (isDecided(result, options)) return Status::Threshold;
  return result.status == Status::IterationLimit ? Status::IterationLimit : Status::Degenerate;
}

/// The answer of cores that have a closed form.
/// Evidence: as a call with the formula inlined it takes 28 ns (sphere and box) and 29 ns (capsules); inlined into
/// signedDistance(), 30 and 40 ns, and boxes in overlap 157 instead of 151, as both need more registers than there are.
[[gnu::noinline]] SignedDistance byClosedForm(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                              const Options& options, double rounding, WarmStart& warm_start) {
  SignedDistance result = withMargins(certified(closedForm(a, b, a_T_b), rounding), a.margin(), b.margin());
  warm_start.axis = result.normal;
  result.status = statusByBounds(result, options);
  if (result.status == Status::Converged && result.unique)
    result.unique = meetInOnePoint(a, b, a_T_b, result.normal, options.distance_tolerance);
  return result;
}

/// The answer of a threshold about a point or a segment and a segment or a box: by the support planes across the line of
/// the centres, by the inner balls, or by the closed form. Evidence: 330 instead of 490 instructions for a sphere and a
/// box that are apart, 320 instead of 540 for two capsules. The formulas of other pairs take no longer than this.
[[gnu::noinline]] SignedDistance byCentres(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                           const Options& options, double rounding, WarmStart& warm_start) {
  const Vector3d centres = a_T_b.translation();
  const double length2 = centres.squaredNorm(), length = std::sqrt(length2);
  if (!(length > support::kShortest)) return byClosedForm(a, b, a_T_b, options, rounding, warm_start);
  const double of_a = a.halfExtents().z() * std::abs(centres.z());
  const double of_b = b.kind() == Shape::Kind::Box ? heightAlong(b, a_T_b.linear().transpose() * centres)
                                                   : b.halfExtents().z() * std::abs(a_T_b.linear().col(2).dot(centres));
  const double lower_bound = boundByPlanes(a, b, length2 - of_a - of_b, length, rounding);
  if (lower_bound > options.stop_above) {
    warm_start.axis = centres / length;
    return separatedAlong(warm_start.axis, lower_bound, 0);
  }
  const double upper_bound = distanceOfInnerBalls(a, b, centres, rounding) - (a.margin() + b.margin());
  if (!(upper_bound <= options.stop_below)) return byClosedForm(a, b, a_T_b, options, rounding, warm_start);
  warm_start.axis = centres / length;
  return overlapAlong(warm_start.axis, lower_bound, upper_bound, 0);
}

/// A warm start without knowledge that keeps the storage of the polytope.
WarmStart coldStart(const WarmStart& warm_start) {
  WarmStart cold;
  cold.polytope = warm_start.polytope;
  if (cold.polytope != nullptr) cold.polytope->forget();
  return cold;
}

bool isOpen(Status status) { return status == Status::IterationLimit || status == Status::Degenerate; }

/// True if the answer of a second search says more than an open one.
bool saysMore(const SignedDistance& second, const SignedDistance& open) {
  const auto widthOf = [](const SignedDistance& result) { return result.upper_bound - result.lower_bound; };
  return !isOpen(second.status) || widthOf(second) < widthOf(open);
}

Options withoutThresholds(Options options) {
  options.stop_above = std::numeric_limits<double>::infinity();
  options.stop_below = -options.stop_above;
  return options;
}

/// The options for the cores of two shapes whose margins add up to `margins` [m].
Options optionsOfCores(Options options, double margins, double rounding) {
  // Two roundings are part of the bounds. If the search were asked for less than this, it would turn down what Newton's
  // method finds, and end farther from the truth.
  constexpr double kResolvable = 4.0;
  options.distance_tolerance = std::max(kResolvable * rounding, options.distance_tolerance);  // also if it is NaN
  // The thresholds are moved by some roundings, so that the final bounds, with margins, still decide them.
  const double beyond = 4.0 * rounding;
  options.stop_above += margins + beyond;
  options.stop_below += margins - beyond;
  return options;
}

/// Converts the answer about two shapes near the origins of their frames to the answer about the original shapes.
SignedDistance movedBack(SignedDistance result, const NearOrigin& near, const Options& options) {
  result.lower_bound -= near.error();
  result.upper_bound += near.error();
  result.point_a += near.from();
  result.point_b = result.point_a + result.distance * result.normal;
  result.status = statusByBounds(result, options);
  return result;
}

/// Calls signedDistance() once more, from its beginning.
SignedDistance ask(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                   WarmStart& warm_start, Unobserved) {
  return signedDistance(a, b, a_T_b, options, warm_start);
}
SignedDistance ask(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                   WarmStart& warm_start, const Recorder& recorder) {
  return signedDistance(a, b, a_T_b, options, warm_start, recorder.trace());
}

/// The answer by hulls that are moved to the origins of their frames. Returns nullopt if that would round little less.
template <typename Observer>
std::optional<SignedDistance> nearOrigins(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                          const Options& options, WarmStart& warm_start, Observer observer) {
  // a second search is worth its time only if its rounding is smaller by this factor
  constexpr double kMuchLess = 0.25;
  if (!a.isFarFromOrigin() && !b.isFarFromOrigin()) return std::nullopt;
  const NearOrigin near(a, b, a_T_b);
  if (!(csoRounding(near.a(), near.b(), near.pose()) < kMuchLess * csoRounding(a, b, a_T_b))) return std::nullopt;
  Options inner = withoutThresholds(options);
  inner.distance_tolerance -= 2.0 * near.error();
  return movedBack(ask(near.a(), near.b(), near.pose(), inner, warm_start, observer), near, options);
}

bool mayRecallFeatures(const Shape& a, const Shape& b, const WarmStart& warm_start) {
  return warm_start.simplex_size > 0 && a.isPolytope() && b.isPolytope() && !areBoxes(a, b);
}

/// The answer about two polytopes whose nearest features are those with which the last query ended. Otherwise, or if that
/// leaves the answer open, nullopt.
[[gnu::noinline]] std::optional<SignedDistance> byRecalledFeatures(const Shape& a, const Shape& b,
                                                                   const Isometry3d& a_T_b, const Options& options,
                                                                   double rounding, WarmStart& warm_start) {
  const Options core_options = optionsOfCores(options, a.margin() + b.margin(), rounding);
  const Cso cso(a, b, a_T_b, rounding, warm_start);
  const std::optional<GjkResult> recalled = recalledFeatures(cso, warm_start, core_options);
  if (!recalled) return std::nullopt;
  SignedDistance result = withMargins(fromGjk(cso, *recalled), a.margin(), b.margin());
  result.status = statusByBounds(result, options);
  // A search from another start may find bounds that meet a tolerance near to rounding.
  if (isOpen(result.status)) return std::nullopt;
  warm_start.axis = result.normal;
  return result;
}

/// The answer of a search without the threshold that `searched`, with the status of its search, has left undecided. Both
/// begin with the same warm start, `begun_with`, which becomes that of the next query. Returns nullopt where the search
/// without the threshold could not decide it either.
template <typename Observer>
[[gnu::noinline]] std::optional<SignedDistance> byWholeSearch(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                                              const Options& options, double rounding,
                                                              const SignedDistance& searched, WarmStart& begun_with,
                                                              Observer observer) {
  if (searched.status != Status::Threshold) {
    if (!holdsThreshold(searched, options)) return std::nullopt;
    if (!isOpen(statusByBounds(searched, options))) {
      // It has converged. The nearest features of the last query may have bounds that are narrower by a rounding.
      if (!mayRecallFeatures(a, b, begun_with)) return std::nullopt;
      const auto recalled = byRecalledFeatures(a, b, a_T_b, options, rounding, begun_with);
      return recalled && isDecided(*recalled, options) ? recalled : std::nullopt;
    }
  }
  // Points have widened the bounds that decided the threshold, or a limit or rounding has kept them wide.
  SignedDistance whole = ask(a, b, a_T_b, withoutThresholds(options), begun_with, observer);
  whole.status = statusByBounds(whole, options);
  return whole;
}

/// The answer about shapes without a closed form, and steps 6 to 8 of signedDistance(). `known_first`: the first vertex
/// of the CSO, or nullptr.
template <typename Observer>
[[gnu::noinline]] SignedDistance bySearch(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                          const Options& options, double rounding, const CsoVertex* known_first,
                                          WarmStart& warm_start, Observer observer) {
  const Options core_options = optionsOfCores(options, a.margin() + b.margin(), rounding);
  const bool is_warm = warm_start.simplex_size != 0 || !warm_start.axis.isZero(0.0);
  SearchState search;
  SignedDistance result =
      withMargins(coreDistance(a, b, a_T_b, core_options, rounding, known_first, warm_start, search, observer),
                  a.margin(), b.margin());
  if (search.begun_with && !isDecided(result, options)) {
    if (const auto whole = byWholeSearch(a, b, a_T_b, options, rounding, result, *search.begun_with, observer)) {
      warm_start = *search.begun_with;
      return *whole;
    }
  }
  result.status = statusByBounds(result, options);
  warm_start.axis = result.normal;
  if (result.status == Status::Converged && result.unique && !search.is_by_features)
    result.unique = meetInOnePoint(a, b, a_T_b, result, options.distance_tolerance, search.newest);
  if (isOpen(result.status) && is_warm) {
    // A search from another start meets other vertices, and rounding may stop it elsewhere.
    warm_start = coldStart(warm_start);
    const SignedDistance cold = ask(a, b, a_T_b, options, warm_start, observer);
    if (saysMore(cold, result)) result = cold;
  } else if (isOpen(result.status)) {
    const auto near = nearOrigins(a, b, a_T_b, options, warm_start, observer);
    if (near && saysMore(*near, result)) result = *near;
  }
  return result;
}

/// The answer of two boxes by their axes, if the gap of the support planes along the first direction leaves open whether
/// they overlap, or by their nearest points, or by a search.
template <typename Observer>
[[gnu::noinline]] SignedDistance byBoxes(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                         const Options& options, double rounding, WarmStart& warm_start,
                                         Observer observer) {
  const double* const direction = firstDirection(warm_start, a_T_b);
  const double gap = gapAlong(a, b, a_T_b, VectorInPlace(direction));
  const Options core_options = optionsOfCores(options, a.margin() + b.margin(), rounding);
  std::optional<SignedDistance> answer;
  observer.reaches(Algorithm::BoxAxes);
  if (gap <= 0.0) answer = byBoxAxes(a, b, a_T_b, core_options, rounding);
  if (!answer) {
    observer.reaches(Algorithm::BoxPoints);
    answer = byNearestPoints(a, b, a_T_b, core_options.distance_tolerance, rounding);
  }
  if (answer) {
    SignedDistance result = withMargins(*answer, a.margin(), b.margin());
    result.status = statusByBounds(result, options);
    if (result.status == Status::Converged && result.unique)
      result.unique =
          boxesMeetInOnePoint(a.halfExtents(), b.halfExtents(), a_T_b, result.normal, options.distance_tolerance);
    if (result.has_points || isDecided(result, options)) {
      if (isOpen(result.status) && hasDirection(warm_start.axis)) {
        // With a tolerance near to rounding, the bounds that begin with another direction may meet it.
        warm_start = coldStart(warm_start);
        return byBoxes(a, b, a_T_b, options, rounding, warm_start, observer);
      }
      warm_start.axis = result.normal;
      if (result.lower_bound > options.stop_above) return separatedAlong(result.normal, result.lower_bound, 0);
      return result.upper_bound <= options.stop_below
                 ? overlapAlong(result.normal, result.lower_bound, result.upper_bound, 0)
                 : result;
    }
  }
  return bySearch(a, b, a_T_b, options, rounding, nullptr, warm_start, observer);
}

/// The answer of a threshold about two shapes without a closed form, if hasFirstBounds(): by the support planes along the
/// first direction, by the inner balls, or by a search. It is a function of its own, because bySearch() stores many
/// registers and fills much of the stack.
template <typename Observer>
[[gnu::noinline]] SignedDistance byFirstBounds(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                               const Options& options, double rounding, WarmStart& warm_start,
                                               Observer observer) {
  const VectorInPlace centres(a_T_b.translation().data()), direction(firstDirection(warm_start, a_T_b));
  const double length = direction.norm();
  const double gap = gapAlong(a, b, a_T_b, direction);
  const auto endsBy = [&](Algorithm algorithm) {
    observer.endsAtFirst(algorithm, direction / length, gap / length - rounding,
                         [&] { return Cso(a, b, a_T_b, rounding, warm_start).vertex(direction); });
    warm_start.axis = direction / length;  // the direction may be that of the warm start: it is not read any more
  };
  const double lower_bound = boundByPlanes(a, b, gap, length, rounding);
  if (lower_bound > options.stop_above) {
    endsBy(Algorithm::FirstDirection);
    return separatedAlong(warm_start.axis, lower_bound);
  }
  const double upper_bound = distanceOfInnerBalls(a, b, centres, rounding) - (a.margin() + b.margin());
  if (upper_bound <= options.stop_below && !turnedByTilt(a, b, a_T_b, options.distance_tolerance)) {
    endsBy(Algorithm::InnerBalls);
    return overlapAlong(warm_start.axis, lower_bound, upper_bound);
  }
  if (!areBoxes(a, b)) return bySearch(a, b, a_T_b, options, rounding, nullptr, warm_start, observer);
  if (gap <= 0.0 && options.stop_below > -std::numeric_limits<double>::infinity()) {
    const double by_axes = overlapByAxes(a.halfExtents(), b.halfExtents(), a_T_b, rounding) - (a.margin() + b.margin());
    if (by_axes <= options.stop_below) {
      endsBy(Algorithm::BoxAxes);
      return overlapAlong(warm_start.axis, lower_bound, by_axes);
    }
  }
  return byBoxes(a, b, a_T_b, options, rounding, warm_start, observer);
}

/// True if the farthest vertex of the CSO along the last normal is one of the last simplex, as it is if the shapes have
/// moved little. Otherwise its features are hardly the nearest ones again.
bool isOfLastSimplex(const CsoVertex& farthest, const WarmStart& last) {
  for (int i = 0; i < std::clamp(last.simplex_size, 0, 3); ++i)
    if (last.simplex[i].a == farthest.numbers.a && last.simplex[i].b == farthest.numbers.b) return true;
  return false;
}

/// The answer that the last normal gives, if it proves a distance surely above stop_above, or the one that the last
/// nearest features give, if a search without the warm start has the same bits. Otherwise nullopt.
template <typename Observer>
[[gnu::noinline]] std::optional<SignedDistance> byRecalledBounds(const Shape& a, const Shape& b,
                                                                 const Isometry3d& a_T_b, const Options& options,
                                                                 double rounding, WarmStart& warm_start,
                                                                 Observer observer) {
  // With a smaller limit a search may end before it finds the features. Evidence: with limits of 1 to 5 iterations some
  // did; of 1,000,480 pairs of ./dev stress with this rule none did.
  constexpr int kEnoughIterations = 100;
  // A search that converges finds a lower bound within the tolerance of this one, which is above stop_above, too.
  const double surely_above = options.stop_above + usableTolerance(options.distance_tolerance);
  if (surely_above < std::numeric_limits<double>::infinity() && hasDirection(warm_start.axis)) {
    const CsoVertex farthest = Cso(a, b, a_T_b, rounding, warm_start).vertex(warm_start.axis);
    const double gap = -warm_start.axis.dot(farthest.point);
    const double lower_bound = boundByPlanes(a, b, gap, warm_start.axis.norm(), rounding);
    if (lower_bound > surely_above) {
      const SignedDistance result = separatedAlong(warm_start.axis.normalized(), lower_bound);
      observer.endsAtFirst(Algorithm::FirstDirection, result.normal, lower_bound + (a.margin() + b.margin()),
                           [&farthest] { return farthest; });
      return result;
    }
    if (!isOfLastSimplex(farthest, warm_start)) return std::nullopt;
  }
  if (!mayRecallFeatures(a, b, warm_start) || options.max_iterations < kEnoughIterations) return std::nullopt;
  observer.reaches(Algorithm::RecalledFeatures);
  const auto result = byRecalledFeatures(a, b, a_T_b, options, rounding, warm_start);
  if (!result || result->lower_bound > surely_above) return result;
  const bool is_between = result->upper_bound <= options.stop_above && result->lower_bound > options.stop_below;
  return is_between && result->status == Status::Converged ? result : std::nullopt;
}

/// The support planes of two cores along the first direction. Of two hulls the heights suffice for their gap, and the
/// vertex of the CSO is computed only if the search needs it. Evidence: 0.86 of the time of a threshold that the last
/// normal or the inner balls decide (rows "hull 200, apart?, coherent" and "deep?" of ./dev bench narrowphase), and 1.03
/// to 1.05 of one that needs a search ("shallow?").
class FirstPlanes {
 public:
  FirstPlanes(Cso& cso, const Vector3d& direction)
      : are_hulls_(cso.a().kind() == Shape::Kind::Hull && cso.b().kind() == Shape::Kind::Hull) {
    if (!are_hulls_) {
      vertex_ = cso.vertex(direction);
      gap_ = -direction.dot(vertex_.point);
      return;
    }
    const HullSupport::Farthest on_a = cso.a().hullSupport().farthest(direction);
    const HullSupport::Farthest on_b = cso.b().hullSupport().farthest(-(cso.bAxes().transpose() * direction));
    numbers_ = {on_a.vertex, on_b.vertex};
    gap_ = direction.dot(cso.bOrigin()) - on_a.height - on_b.height;
  }

  /// [m] times the length of the direction; its rounding is that of boundByPlanes().
  double gap() const { return gap_; }
  CsoVertex vertex(const Cso& cso) const { return are_hulls_ ? cso.recalled(numbers_) : vertex_; }

 private:
  bool are_hulls_;
  double gap_;
  WarmStart::Pair numbers_{0, 0};
  CsoVertex vertex_;
};

/// The answer of a threshold about two shapes without such formulas: by the first vertex of the CSO, by the inner balls,
/// or by a search. It is a function of its own, as byFirstBounds().
template <typename Observer>
[[gnu::noinline]] SignedDistance byFirstVertex(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                               const Options& options, double rounding, WarmStart& warm_start,
                                               Observer observer) {
  Cso cso(a, b, a_T_b, rounding, warm_start);
  const double margins = a.margin() + b.margin();
  const Options core_options = optionsOfCores(options, margins, rounding);
  const Vector3d direction = firstDirection(warm_start, cso);
  const double length = direction.norm();
  const FirstPlanes planes(cso, direction);
  const double lower_bound = planes.gap() / length - rounding;
  // The normal is that of the first vertex, so that the warm start keeps the axis of the last search.
  const auto endsBy = [&](Algorithm algorithm) {
    warm_start.axis = direction / length;
    observer.endsAtFirst(algorithm, warm_start.axis, lower_bound, [&] { return planes.vertex(cso); });
  };
  if (!turnedByTilt(a, b, a_T_b, core_options.distance_tolerance)) {
    if (planes.gap() > 0.0 && lower_bound > core_options.stop_above) {
      endsBy(Algorithm::FirstDirection);
      return separatedAlong(warm_start.axis, lower_bound - margins);
    }
    const double upper_bound = distanceOfInnerBalls(a, b, cso.centreDifference(), rounding);
    if (upper_bound <= core_options.stop_below) {
      endsBy(Algorithm::InnerBalls);
      return overlapAlong(warm_start.axis, lower_bound - margins, upper_bound - margins);
    }
  }
  const CsoVertex first = planes.vertex(cso);
  if (isOfLastSimplex(first, warm_start) && mayRecallFeatures(a, b, warm_start)) {
    observer.reaches(Algorithm::RecalledFeatures);
    if (const auto recalled = byRecalledFeatures(a, b, a_T_b, options, rounding, warm_start)) return *recalled;
  }
  return bySearch(a, b, a_T_b, options, rounding, &first, warm_start, observer);
}

/// Steps 2 to 8 of signedDistance() for a rotation within this departure, the square of which is given.
template <typename Observer>
[[gnu::always_inline]] inline SignedDistance ofRotation(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                                        double departure2, const Options& options, double rounding,
                                                        WarmStart& warm_start, Observer observer) {
  if (hasClosedForm(a.kind(), b.kind())) {
    observer.reaches(Algorithm::PointsAndSegments);
    const double error = rounding + transposeError(b, a_T_b, departure2);
    const bool pays = hasFirstBounds(a, b, options) && b.kind() != Shape::Kind::Point;
    return (pays ? byCentres : byClosedForm)(a, b, a_T_b, options, error, warm_start);
  }
  if (options.repeatability == Repeatability::Always) {
    if (const auto recalled = byRecalledBounds(a, b, a_T_b, options, rounding, warm_start, observer)) return *recalled;
    warm_start = coldStart(warm_start);
  }
  if (hasFirstBounds(a, b, options)) return byFirstBounds(a, b, a_T_b, options, rounding, warm_start, observer);
  if (areBoxes(a, b)) return byBoxes(a, b, a_T_b, options, rounding, warm_start, observer);
  if (asksThreshold(options)) return byFirstVertex(a, b, a_T_b, options, rounding, warm_start, observer);
  if (mayRecallFeatures(a, b, warm_start)) {
    observer.reaches(Algorithm::RecalledFeatures);
    if (const auto recalled = byRecalledFeatures(a, b, a_T_b, options, rounding, warm_start)) return *recalled;
  }
  return bySearch(a, b, a_T_b, options, rounding, nullptr, warm_start, observer);
}

/// The answer for the rotation nearest to a pose. It is a function of its own, because the other pose fills the stack.
template <typename Observer>
[[gnu::noinline]] SignedDistance ofNearestRotation(const Shape& a, const Shape& b, const Isometry3d& a_T_b,
                                                   const Options& options, double rounding, WarmStart& warm_start,
                                                   Observer observer) {
  const std::optional<Isometry3d> rigid = rigidPose(a_T_b);
  if (!rigid) return {};
  const double departure2 = departure2FromRotation(*rigid);
  if (!isRotation(departure2)) return {};
  return ofRotation(a, b, *rigid, departure2, options, rounding, warm_start, observer);
}

template <typename Observer>
SignedDistance observedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                                WarmStart& warm_start, Observer observer) {
  const double rounding = csoRounding(a, b, a_T_b), departure2 = departure2FromRotation(a_T_b);
  if (!isComputable(rounding)) return {};
  if (isRotation(departure2)) return ofRotation(a, b, a_T_b, departure2, options, rounding, warm_start, observer);
  return ofNearestRotation(a, b, a_T_b, options, rounding, warm_start, observer);
}

}  // namespace

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start) {
  return observedDistance(a, b, a_T_b, options, warm_start, Unobserved());
}

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start, QueryTrace& trace) {
  return observedDistance(a, b, a_T_b, options, warm_start, Recorder(trace));
}

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options) {
  WarmStart cold;
  return signedDistance(a, b, a_T_b, options, cold);
}

}  // namespace proximity_server::narrowphase
