#pragma once

#include "narrowphase/closed_form/boxes.h"
#include "narrowphase/cso/observer.h"
#include "narrowphase/signed_distance/query.h"

#include <cmath>
#include <optional>

// The stages of signedDistance() before a search, which come in the order of ofRotation(). Each is a function of its own,
// because a search stores many registers and fills much of the stack. A stage without an answer ends with `otherwise`, and
// returns no optional, so that an answer is made in its place and need not be copied.

namespace proximity_server::narrowphase {

/// True for a core whose support planes have formulas without support points. Its centre is the origin of its frame.
inline bool hasFormula(const Shape& shape) {
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

/// [m] Height of the support plane of such a core along `direction`, times the length of the direction.
template <typename Vector>
[[gnu::always_inline]] inline double heightAlong(const Shape& shape, const Vector& direction) {
  const Eigen::Vector3d& half = shape.halfExtents();
  if (shape.kind() == Shape::Kind::Cylinder)
    return half.x() * support::radialPart(Eigen::Vector3d(direction)) + half.z() * std::abs(direction.z());
  return half.dot(direction.cwiseAbs());
}

/// [m] Gap between the support planes of two such cores along `direction`, times the length of the direction.
[[gnu::always_inline]] inline double gapAlong(const Query& query, const VectorInPlace& direction) {
  const double of_b = heightAlong(query.b, Eigen::Vector3d(query.a_T_b.linear().transpose() * direction));
  return direction.dot(query.a_T_b.translation()) - heightAlong(query.a, direction) - of_b;
}

/// [m] Lower bound of the distance of two shapes by the gap between the support planes of their cores along a direction
/// of this length; `gap` is multiplied by it.
/// The rounding of the CSO covers the rounding of heights, too.
/// To first order in eps, a height has an error of 2 eps of the
/// reach, and the turned direction adds 2.6 eps of it to the height of b. The last sum adds eps / 2, the norm and the
/// quotient 1.75 eps, rounding and margins 1 eps: together 7.85 eps of b's reach, and less of a's reach and of the
/// offset.
inline double boundByPlanes(const Query& query, double gap, double length) {
  return gap / length - query.rounding - query.margins();
}

/// True if a threshold is asked about two cores with formulas, so that byFirstPlanes() may decide it.
inline bool asksFirstPlanes(const Query& query) {
  const bool is_asked =
      query.options.stop_above < kNoThreshold || (areBoxes(query) && query.options.stop_below > -kNoThreshold);
  return is_asked && hasFormula(query.a) && hasFormula(query.b);
}

/// [m] Upper bound of the distance of two cores, by the ball inside of each of them.
///
/// A translation that parts the cores parts the balls. So the signed distance of the cores is at most the distance of
/// the balls: the distance of the centres less both radii. The rounding of the CSO covers the distance of the centres,
/// too: it is computed as the norm of a CSO vertex is, from points of the cores, and the radii have the error of a
/// support point.
template <typename Vector>
double distanceOfInnerBalls(const Query& query, const Vector& centres) {
  return centres.norm() - (query.a.innerRadius() + query.b.innerRadius()) + query.rounding;
}

/// The support planes of two cores along the first direction. The heights of two hulls suffice for their gap, and the
/// vertex of the CSO is computed only if the search needs it. Evidence: 0.86 of the time of a threshold that the last
/// normal or the inner balls decide (rows "hull 200, apart?, coherent" and "deep?" of ./dev bench narrowphase), and 1.03
/// to 1.05 of one that needs a search ("shallow?").
class FirstPlanes {
 public:
  [[gnu::always_inline]] FirstPlanes(Cso& cso, const Eigen::Vector3d& direction)
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

  /// [m] times the length of the direction; its rounding is in boundByPlanes().
  double gap() const { return gap_; }
  CsoVertex vertex(const Cso& cso) const { return are_hulls_ ? cso.recalled(numbers_) : vertex_; }

 private:
  bool are_hulls_;
  double gap_;
  WarmStart::Pair numbers_{0, 0};
  CsoVertex vertex_;
};

/// The answer of a threshold about two cores with formulas: by the support planes along the first direction, by the inner
/// balls, by the axes of two boxes, or otherwise().
template <typename Observer, typename Otherwise>
[[gnu::noinline]] SignedDistance byFirstPlanes(const Query& query, Observer observer, Otherwise otherwise) {
  const VectorInPlace centres(query.a_T_b.translation().data()), direction(firstDirection(query));
  const double length = direction.norm(), gap = gapAlong(query, direction);
  const double lower_bound = boundByPlanes(query, gap, length), stop_below = query.options.stop_below;
  const auto endsBy = [&](Algorithm algorithm, double upper_bound) {
    observer.endsAtFirst(algorithm, direction / length, gap / length - query.rounding,
                         [&] { return query.cso().vertex(direction); });
    query.warm_start.axis = direction / length;  // the direction may be the warm start's: it is not read any more
    return decided(query.warm_start.axis, lower_bound, upper_bound);
  };
  if (lower_bound > query.options.stop_above) return endsBy(Algorithm::FirstDirection, kNoThreshold);
  const double by_balls = distanceOfInnerBalls(query, centres) - query.margins();
  if (by_balls <= stop_below && !turnedByTilt(query, query.options.distance_tolerance))
    return endsBy(Algorithm::InnerBalls, by_balls);
  if (areBoxes(query) && gap <= 0.0 && stop_below > -kNoThreshold) {
    const double by_axes =
        overlapByAxes(query.a.halfExtents(), query.b.halfExtents(), query.a_T_b, query.rounding) - query.margins();
    if (by_axes <= stop_below) return endsBy(Algorithm::BoxAxes, by_axes);
  }
  return otherwise();
}

/// The answer of a threshold about any cores: by the first vertex of the CSO, by the inner balls, or otherwise(vertex).
template <typename Observer, typename Otherwise>
[[gnu::noinline]] SignedDistance byFirstVertex(const Query& query, Observer observer, Otherwise otherwise) {
  Cso cso = query.cso();
  const Options options = optionsOfCores(query);
  const Eigen::Vector3d direction = firstDirection(cso, query.warm_start);
  const double length = direction.norm();
  const FirstPlanes planes(cso, direction);
  const double lower_bound = planes.gap() / length - query.rounding;
  // The normal belongs to the first vertex, so that the warm start keeps the axis of the last search.
  const auto endsBy = [&](Algorithm algorithm, double upper_bound) {
    query.warm_start.axis = direction / length;
    observer.endsAtFirst(algorithm, query.warm_start.axis, lower_bound, [&] { return planes.vertex(cso); });
    return decided(query.warm_start.axis, lower_bound - query.margins(), upper_bound - query.margins());
  };
  if (!turnedByTilt(query, options.distance_tolerance)) {
    if (planes.gap() > 0.0 && lower_bound > options.stop_above) return endsBy(Algorithm::FirstDirection, kNoThreshold);
    const double by_balls = distanceOfInnerBalls(query, cso.centreDifference());
    if (by_balls <= options.stop_below) return endsBy(Algorithm::InnerBalls, by_balls);
  }
  return otherwise(planes.vertex(cso));
}

/// The answer that the fifteen axes of two boxes give: the signed distance of boxes that overlap, or that a threshold
/// is decided. Returns nullopt if the distance is not along one of the axes, or if the points are not unique.
inline std::optional<SignedDistance> byBoxAxes(const Query& query, const Options& options) {
  const BoxPair boxes(query.a.halfExtents(), query.b.halfExtents(), query.a_T_b);
  const double separation = boxes.separation(), lower = separation - query.rounding,
               upper = separation + query.rounding;
  if (lower > options.stop_above) return decided(boxes.normal(), lower, kNoThreshold);
  if (separation < -query.rounding && upper <= options.stop_below) return decided(boxes.normal(), lower, upper);
  const std::optional<SignedDistance> exact = boxes.distanceAlongNormal(options.distance_tolerance, query.rounding);
  if (!exact) return std::nullopt;
  return certified(*exact, query.rounding + transposeError(query));
}

/// The answer of two boxes that are apart by their nearest points. Returns nullopt if these are not found.
inline std::optional<SignedDistance> byNearestPoints(const Query& query, double tolerance) {
  const auto nearest = nearestOfBoxes(query.a.halfExtents(), query.b.halfExtents(), query.a_T_b,
                                      finalWidth(tolerance, query.rounding) - 2.0 * query.rounding);
  if (!nearest) return std::nullopt;
  const Eigen::Vector3d normal = (nearest->on_b - nearest->on_a) / nearest->distance;
  SignedDistance result = decided(normal, nearest->gap - query.rounding, nearest->distance + query.rounding, 0);
  result.distance = nearest->distance;
  setPoints(result, nearest->on_a, nearest->on_b, query.rounding);
  return result;
}

/// The answer of two boxes: by their axes, if the gap of the support planes along the first direction leaves open whether
/// they overlap, by their nearest points, or otherwise().
template <typename Observer, typename Otherwise>
[[gnu::noinline]] SignedDistance byBoxes(const Query& query, Observer observer, Otherwise otherwise) {
  WarmStart& warm_start = query.warm_start;
  const Options core_options = optionsOfCores(query);
  const bool may_overlap = gapAlong(query, VectorInPlace(firstDirection(query))) <= 0.0;
  std::optional<SignedDistance> answer;
  observer.reaches(Algorithm::BoxAxes);
  if (may_overlap) answer = byBoxAxes(query, core_options);
  if (!answer) {
    observer.reaches(Algorithm::BoxPoints);
    answer = byNearestPoints(query, core_options.distance_tolerance);
  }
  if (!answer) return otherwise();
  SignedDistance result = completed(query, *answer);
  if (result.status == Status::Converged && result.unique)
    result.unique = boxesMeetInOnePoint(query.a.halfExtents(), query.b.halfExtents(), query.a_T_b, result.normal,
                                        query.options.distance_tolerance);
  if (isOpen(result.status) && hasDirection(warm_start.axis)) {
    // With a tolerance near to rounding, the bounds that begin with another direction may meet it.
    warm_start = coldStart(warm_start);
    return byBoxes(query, observer, otherwise);
  }
  warm_start.axis = result.normal;
  if (result.lower_bound > query.options.stop_above)
    return decided(result.normal, result.lower_bound, kNoThreshold, /*iterations=*/0);
  return result.upper_bound <= query.options.stop_below
             ? decided(result.normal, result.lower_bound, result.upper_bound, /*iterations=*/0)
             : result;
}

/// True for two polytopes with a last simplex, the features of which may be the nearest ones again.
inline bool mayRecallFeatures(const Query& query) {
  return query.warm_start.simplex_size > 0 && query.a.isPolytope() && query.b.isPolytope() && !areBoxes(query);
}

/// True if the farthest vertex of the CSO along the last normal is one of the last simplex, as it is if the shapes have
/// moved little. Otherwise its features are hardly the nearest ones again.
inline bool isOfLastSimplex(const CsoVertex& farthest, const WarmStart& last) {
  for (int i = 0; i < std::clamp(last.simplex_size, 0, 3); ++i)
    if (last.simplex[i].a == farthest.numbers.a && last.simplex[i].b == farthest.numbers.b) return true;
  return false;
}

/// The answer of two polytopes whose nearest features are those with which the last query ended. Otherwise, or if that
/// leaves the answer open, nullopt.
[[gnu::noinline]] inline std::optional<SignedDistance> byRecalledFeatures(const Query& query) {
  const Cso cso = query.cso();
  const std::optional<GjkResult> recalled = recalledFeatures(cso, query.warm_start, optionsOfCores(query));
  if (!recalled) return std::nullopt;
  SignedDistance result = completed(query, fromGjk(cso, *recalled));
  // A search from another start may find bounds that meet a tolerance near to rounding.
  if (isOpen(result.status)) return std::nullopt;
  query.warm_start.axis = result.normal;
  return result;
}

/// The answer that the last normal gives, if it proves a distance surely above stop_above, or the one that the last
/// nearest features give, if a search without the warm start has the same bits. Otherwise nullopt.
template <typename Observer>
[[gnu::noinline]] std::optional<SignedDistance> byRecalledBounds(const Query& query, Observer observer) {
  // With a smaller limit a search may end before it finds the features. Evidence: with limits of 1 to 5 iterations some
  // did; of 1,000,480 pairs of ./dev stress with this rule none did.
  constexpr int kEnoughIterations = 100;
  const Options& options = query.options;
  const Eigen::Vector3d& axis = query.warm_start.axis;
  // A search that converges finds a lower bound within the tolerance of this one, which is above stop_above, too.
  const double surely_above = options.stop_above + usableTolerance(options.distance_tolerance);
  if (surely_above < kNoThreshold && hasDirection(axis)) {
    const CsoVertex farthest = query.cso().vertex(axis);
    const double lower_bound = boundByPlanes(query, -axis.dot(farthest.point), axis.norm());
    if (lower_bound > surely_above) {
      const SignedDistance result = decided(axis.normalized(), lower_bound, kNoThreshold);
      observer.endsAtFirst(Algorithm::FirstDirection, result.normal, lower_bound + query.margins(),
                           [&] { return farthest; });
      return result;
    }
    if (!isOfLastSimplex(farthest, query.warm_start)) return std::nullopt;
  }
  if (!mayRecallFeatures(query) || options.max_iterations < kEnoughIterations) return std::nullopt;
  observer.reaches(Algorithm::RecalledFeatures);
  const auto result = byRecalledFeatures(query);
  if (!result || result->lower_bound > surely_above) return result;
  const bool is_between = result->upper_bound <= options.stop_above && result->lower_bound > options.stop_below;
  return is_between && result->status == Status::Converged ? result : std::nullopt;
}

}  // namespace proximity_server::narrowphase
