#include "proximity_server/narrowphase/signed_distance.h"

#include "narrowphase/closed_form/points_segments.h"
#include "narrowphase/cso/observer.h"
#include "narrowphase/gjk_epa/epa.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "narrowphase/shape/near_origin.h"
#include "narrowphase/signed_distance/closed_forms.h"
#include "narrowphase/signed_distance/query.h"
#include "narrowphase/signed_distance/stages.h"

#include <algorithm>
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

/// True if, within the tolerance, only one pair of points of the cores has this distance: the features of the cores
/// along the normal of the result (vertex, edge or face) have no direction in common. `numbers`: the numbers of the
/// vertices that are the farthest along the normal, if they are known.
bool meetInOnePoint(const Query& query, const SignedDistance& result, const WarmStart::Pair& numbers) {
  const double tolerance = query.options.distance_tolerance;
  const Vector3d& normal = result.normal;
  const SupportFeature on_a = supportFeature(query.a, normal, tolerance, numbers.a);
  if (on_a.dimension == 0) return true;
  const Vector3d towards_a = -(query.a_T_b.linear().transpose() * normal);
  const SupportFeature on_b = supportFeature(query.b, towards_a, tolerance, numbers.b);
  if (on_b.dimension == 0) return true;
  if (on_a.dimension + on_b.dimension > 2) return false;
  const Vector3d along_b = query.a_T_b.linear() * on_b.along;
  const double longer = std::max(on_a.along.norm(), along_b.norm());
  const double width = result.upper_bound - result.lower_bound;
  const double sideways = tolerance + sidewaysError(query.a, normal, width) + sidewaysError(query.b, towards_a, width);
  return on_a.along.cross(along_b).norm() > sideways * longer;
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

/// The signed distance of cores without a closed form of their own.
template <typename Observer>
SignedDistance coreDistance(const Query& query, const CsoVertex* known_first, SearchState& search, Observer observer) {
  const Options options = optionsOfCores(query);
  if (const auto turned = turnedByTilt(query, options.distance_tolerance)) {
    observer.reaches(Algorithm::ParallelAxes);
    return certified(parallelAxesDistance(query.a, query.b, query.a_T_b, options.distance_tolerance),
                     query.rounding + *turned + transposeError(query));
  }
  Cso cso = query.cso();
  const Vector3d direction = firstDirection(cso, query.warm_start);
  const CsoVertex first = known_first != nullptr ? *known_first : cso.vertex(direction);
  if (asksThreshold(query.options)) search.begun_with = query.warm_start;
  const SignedDistance result = iterative(cso, direction.normalized(), first, options, search, observer);
  search.newest = cso.newestNumbers();
  return result;
}

/// The answer to another query, from its beginning.
template <typename Observer>
SignedDistance askedAnew(const Query& query, Observer observer);

Options withoutThresholds(Options options) {
  options.stop_above = kNoThreshold;
  options.stop_below = -kNoThreshold;
  return options;
}

/// True if a threshold lies between the bounds.
bool holdsThreshold(const SignedDistance& result, const Options& options) {
  const auto holds = [&](double threshold) {
    return result.lower_bound <= threshold && threshold < result.upper_bound;
  };
  return holds(options.stop_above) || holds(options.stop_below);
}

/// The answer of a search without the threshold that `searched` has left undecided; `by_threshold`: the search had ended
/// by it. Both begin with the same warm start, `begun_with`, which becomes the warm start of the next query. Returns
/// nullopt where the search without the threshold could not decide it either.
template <typename Observer>
[[gnu::noinline]] std::optional<SignedDistance> byWholeSearch(const Query& query, const SignedDistance& searched,
                                                              bool by_threshold, WarmStart& begun_with,
                                                              Observer observer) {
  if (!by_threshold) {
    if (!holdsThreshold(searched, query.options)) return std::nullopt;
    if (searched.status == Status::Converged) {
      // The nearest features of the last query may have bounds that are narrower by a rounding.
      const Query begun{query.a, query.b, query.a_T_b, query.options, begun_with};
      if (!mayRecallFeatures(begun)) return std::nullopt;
      const auto recalled = byRecalledFeatures(begun);
      return recalled && isDecided(*recalled, query.options) ? recalled : std::nullopt;
    }
  }
  // Points have widened the bounds that decided the threshold, or a limit or rounding has kept them wide.
  const Options options = withoutThresholds(query.options);
  SignedDistance whole = askedAnew({query.a, query.b, query.a_T_b, options, begun_with}, observer);
  whole.status = statusByBounds(whole, query.options);
  return whole;
}

/// The answer by hulls that are moved to the origins of their frames. Returns nullopt if that would round little less.
template <typename Observer>
std::optional<SignedDistance> byNearOrigins(const Query& query, Observer observer) {
  // a second search is worth its time only if its rounding is smaller by this factor
  constexpr double kMuchLess = 0.25;
  if (!query.a.isFarFromOrigin() && !query.b.isFarFromOrigin()) return std::nullopt;
  const NearOrigin near(query.a, query.b, query.a_T_b);
  if (!(csoRounding(near.a(), near.b(), near.pose()) < kMuchLess * query.rounding)) return std::nullopt;
  Options inner = withoutThresholds(query.options);
  inner.distance_tolerance -= 2.0 * near.error();
  SignedDistance result = askedAnew({near.a(), near.b(), near.pose(), inner, query.warm_start}, observer);
  result.lower_bound -= near.error();
  result.upper_bound += near.error();
  result.point_a += near.from();
  result.point_b = result.point_a + result.distance * result.normal;
  result.status = statusByBounds(result, query.options);
  return result;
}

/// True if the answer of a second search says more than an open one.
bool saysMore(const SignedDistance& second, const SignedDistance& open) {
  const auto widthOf = [](const SignedDistance& result) { return result.upper_bound - result.lower_bound; };
  return !isOpen(second.status) || widthOf(second) < widthOf(open);
}

/// The answer about shapes without a closed form, and steps 6 to 8 of signedDistance(). `known_first`: the first vertex of
/// the CSO, or nullptr.
template <typename Observer>
[[gnu::noinline]] SignedDistance bySearch(const Query& query, const CsoVertex* known_first, Observer observer) {
  WarmStart& warm_start = query.warm_start;
  const bool is_warm = warm_start.simplex_size != 0 || !warm_start.axis.isZero(0.0);
  SearchState search;
  const SignedDistance of_cores = coreDistance(query, known_first, search, observer);
  SignedDistance result = completed(query, of_cores);
  if (search.begun_with && !isDecided(result, query.options)) {
    const bool by_threshold = of_cores.status == Status::Threshold;
    if (const auto whole = byWholeSearch(query, result, by_threshold, *search.begun_with, observer)) {
      warm_start = *search.begun_with;
      return *whole;
    }
  }
  warm_start.axis = result.normal;
  if (result.status == Status::Converged && result.unique && !search.is_by_features)
    result.unique = meetInOnePoint(query, result, search.newest);
  if (!isOpen(result.status)) return result;
  // A search from another start meets other vertices, and rounding may stop it elsewhere.
  if (is_warm) warm_start = coldStart(warm_start);
  const std::optional<SignedDistance> second = is_warm ? askedAnew(query, observer) : byNearOrigins(query, observer);
  return second && saysMore(*second, result) ? *second : result;
}

/// The answer by the features with which the last query ended, if they may be the nearest ones again, or by a search.
template <typename Observer>
[[gnu::always_inline]] inline SignedDistance byFeatures(const Query& query, const CsoVertex* first, Observer observer) {
  if ((first == nullptr || isOfLastSimplex(*first, query.warm_start)) && mayRecallFeatures(query)) {
    observer.reaches(Algorithm::RecalledFeatures);
    if (const auto recalled = byRecalledFeatures(query)) return *recalled;
  }
  return bySearch(query, first, observer);
}

/// Steps 2 to 8 of signedDistance(), by its stages, in the order in which they are tried:
///
///   stage               of which cores                        if this is asked         may answer
///   byCentres           as below, but b is not a point        above a threshold?       that the threshold is decided
///   byClosedForm        points, segments, a point and a box   always                   everything
///   byRecalledBounds    all others                            Repeatability::Always    a distance surely above, or by the
///                                                                                      last nearest features
///   byFirstPlanes       points, segments, boxes, cylinders    above? boxes: or below?  that the threshold is decided
///   byBoxes             two boxes                             always                   nearly everything
///   byFirstVertex       if not asked byFirstPlanes            above or below?          that the threshold is decided
///   byRecalledFeatures  polytopes, as byFirstVertex           with a warm start        by the last nearest features
///   bySearch            all                                   always                   everything: by parallel axes, GJK
///                                                                                      or EPA, and steps 6 to 8
template <typename Observer>
[[gnu::always_inline]] inline SignedDistance ofRotation(const Query& query, Observer observer) {
  const Shape &a = query.a, &b = query.b;
  if (hasClosedForm(a.kind(), b.kind())) {
    observer.reaches(Algorithm::PointsAndSegments);
    const double rounding = query.rounding + transposeError(query);
    const bool pays = asksFirstPlanes(query) && b.kind() != Shape::Kind::Point;
    return (pays ? byCentres : byClosedForm)(a, b, query.a_T_b, query.options, rounding, query.warm_start);
  }
  if (query.options.repeatability == Repeatability::Always) {
    if (const auto recalled = byRecalledBounds(query, observer)) return *recalled;
    query.warm_start = coldStart(query.warm_start);
  }
  const auto measure = [&query, observer] {
    const auto search = [&query, observer] { return bySearch(query, nullptr, observer); };
    return areBoxes(query) ? byBoxes(query, observer, search) : search();
  };
  const auto recall = [&query, observer](const CsoVertex& first) { return byFeatures(query, &first, observer); };
  if (asksFirstPlanes(query)) return byFirstPlanes(query, observer, measure);
  if (areBoxes(query)) return measure();
  if (asksThreshold(query.options)) return byFirstVertex(query, observer, recall);
  return byFeatures(query, nullptr, observer);
}

/// The answer for the rotation nearest to a pose. It is a function of its own, because the other pose fills the stack.
template <typename Observer>
[[gnu::noinline]] SignedDistance ofNearestRotation(const Query& query, Observer observer) {
  const std::optional<Isometry3d> rigid = rigidPose(query.a_T_b);
  if (!rigid) return {};
  const Query of_rotation{query.a, query.b, *rigid, query.options, query.warm_start};
  if (!isRotation(of_rotation.departure2)) return {};
  return ofRotation(of_rotation, observer);
}

template <typename Observer>
[[gnu::always_inline]] inline SignedDistance observedDistance(const Query& query, Observer observer) {
  if (!isComputable(query.rounding)) return {};
  return isRotation(query.departure2) ? ofRotation(query, observer) : ofNearestRotation(query, observer);
}

template <typename Observer>
[[gnu::noinline]] SignedDistance askedAnew(const Query& query, Observer observer) {
  return observedDistance(query, observer.anew());
}

}  // namespace

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start) {
  return observedDistance({a, b, a_T_b, options, warm_start}, Unobserved());
}

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start, QueryTrace& trace) {
  return observedDistance({a, b, a_T_b, options, warm_start}, Recorder(trace));
}

SignedDistance signedDistance(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options) {
  WarmStart cold;
  return signedDistance(a, b, a_T_b, options, cold);
}

}  // namespace proximity_server::narrowphase
