#pragma once

#include "narrowphase/closed_form/parallel_axes.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "proximity_server/narrowphase/cso/cso.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {

/// A question to signedDistance().
struct Query {
  const Shape& a;
  const Shape& b;
  const Eigen::Isometry3d& a_T_b;
  const Options& options;
  WarmStart& warm_start;
  double rounding = csoRounding(a, b, a_T_b);  ///< [m]
  double departure2 = departure2FromRotation(a_T_b);

  double margins() const { return a.margin() + b.margin(); }
  Cso cso() const { return {a, b, a_T_b, rounding, warm_start}; }
};

constexpr double kNoThreshold = std::numeric_limits<double>::infinity();

inline bool asksThreshold(const Options& options) {
  return options.stop_above < kNoThreshold || options.stop_below > -kNoThreshold;
}

inline bool areBoxes(const Query& query) {
  return query.a.kind() == Shape::Kind::Box && query.b.kind() == Shape::Kind::Box;
}

/// [m] An upper bound of how far the tilt of the axes of two solids of revolution moves a point of b. Returns nullopt
/// if that is more than a small part of the tolerance, because the axes then do not count as parallel.
inline std::optional<double> turnedByTilt(const Query& query, double tolerance) {
  if (!isSolidOfRevolution(query.a.kind()) || !isSolidOfRevolution(query.b.kind())) return std::nullopt;
  const double turned = axesTilt(query.a, query.b, query.a_T_b) * query.b.coreReach();
  return turned <= tolerance / 16.0 ? std::optional<double>(turned) : std::nullopt;
}

/// The options for the cores.
inline Options optionsOfCores(const Query& query) {
  // Two roundings are part of the bounds. If the search were asked for less than this, it would turn down what Newton's
  // method finds, and end farther from the truth.
  constexpr double kResolvable = 4.0;
  Options options = query.options;
  options.distance_tolerance = std::max(kResolvable * query.rounding, options.distance_tolerance);  // also if it is NaN
  // The thresholds are moved by some roundings, so that the final bounds, with margins, still decide them.
  const double beyond = 4.0 * query.rounding;
  options.stop_above += query.margins() + beyond;
  options.stop_below += query.margins() - beyond;
  return options;
}

/// A warm start without knowledge that keeps the storage of the polytope.
inline WarmStart coldStart(const WarmStart& warm_start) {
  WarmStart cold;
  cold.polytope = warm_start.polytope;
  if (cold.polytope != nullptr) cold.polytope->forget();
  return cold;
}

/// A vector where it stands: a copy would pass through memory, and be read there in other pieces than it was written in,
/// which the processor must wait for.
using VectorInPlace = Eigen::Map<const Eigen::Vector3d>;

/// False if the square of the length might underflow or overflow.
inline bool hasDirection(const Eigen::Vector3d& axis) {
  const double length2 = axis.squaredNorm();
  return length2 > 1e-200 && length2 < 1e200;
}

/// First direction of the search, roughly from a to b. It is not normalised, so that the first support point need not
/// wait for a root and a division.
inline Eigen::Vector3d firstDirection(const Cso& cso, const WarmStart& warm_start) {
  if (hasDirection(warm_start.axis)) return warm_start.axis;
  const Eigen::Vector3d centres = cso.centreDifference();
  return centres.squaredNorm() > 1e-200 ? centres : Eigen::Vector3d(Eigen::Vector3d::UnitX());
}

/// The coordinates of the first direction of cores whose centres are the origins of their frames.
inline const double* firstDirection(const Query& query) {
  static constexpr std::array<double, 3> kUnitX{1.0, 0.0, 0.0};
  if (hasDirection(query.warm_start.axis)) return query.warm_start.axis.data();
  const VectorInPlace centres(query.a_T_b.translation().data());
  return centres.squaredNorm() > 1e-200 ? centres.data() : kUnitX.data();
}

// How an answer gets its bounds, its points and its status.

/// The answer of shapes whose bounds [m] decide a threshold; if the lower one does, the upper one is infinite. The normal
/// proves the lower bound.
[[gnu::always_inline]] inline SignedDistance decided(const Eigen::Vector3d& normal, double lower_bound,
                                                     double upper_bound, int iterations = 1) {
  SignedDistance result;
  result.status = Status::Threshold;
  result.distance = upper_bound < kNoThreshold ? upper_bound : lower_bound;
  result.lower_bound = lower_bound;
  result.upper_bound = upper_bound;
  result.normal = normal;
  result.iterations = iterations;
  return result;
}

inline bool isDecided(const SignedDistance& result, const Options& options) {
  return result.lower_bound > options.stop_above || result.upper_bound <= options.stop_below;
}

inline bool isOpen(Status status) { return status == Status::IterationLimit || status == Status::Degenerate; }

/// [m] The error of a closed form that uses the transpose of the axes as their inverse: the two differ by twice the
/// distance from a rotation. The rounding allows for axes whose entries have been rounded.
inline double transposeError(const Query& query) {
  constexpr double kRoundedEntries = 4.0 * std::numeric_limits<double>::epsilon();
  if (query.departure2 <= kRoundedEntries * kRoundedEntries) return 0.0;
  return 6.0 * std::sqrt(query.departure2) * (query.b.coreReach() + query.a_T_b.translation().lpNorm<1>());
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

/// Sets the points of the result. complete() will derive b's point from a's along the normal; the distance between this
/// point and `point_b` widens the upper bound: for shapes apart the points prove it, and in overlap the points lie on
/// the shapes within the width of the bounds.
inline void setPoints(SignedDistance& result, const Eigen::Vector3d& point_a, const Eigen::Vector3d& point_b,
                      double rounding) {
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

/// The status of a search that ended with these bounds and this status. Only here is it set to Converged or Threshold
/// for good: margins, points and rounding may have moved the bounds to either side of the tolerance.
inline Status statusByBounds(const SignedDistance& result, const Options& options) {
  const bool converged = result.has_points && result.upper_bound - result.lower_bound <= options.distance_tolerance;
  if (converged) return Status::Converged;
  if (isDecided(result, options)) return Status::Threshold;
  return result.status == Status::IterationLimit ? Status::IterationLimit : Status::Degenerate;
}

/// Steps 5 and 6: makes the signed distance of the shapes from the distance of the cores. The margins move both
/// surfaces outwards along the normal.
[[gnu::always_inline]] inline SignedDistance completed(const Query& query, SignedDistance result) {
  const double margins = query.margins();
  result.distance -= margins;
  result.lower_bound -= margins;
  result.upper_bound -= margins;
  result.point_a += query.a.margin() * result.normal;
  // b's point is computed from a's, so that the invariant of SignedDistance holds to the last bit.
  result.point_b = result.point_a + result.distance * result.normal;
  result.status = statusByBounds(result, query.options);
  return result;
}

}  // namespace proximity_server::narrowphase
