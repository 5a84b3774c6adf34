#include "narrowphase/gjk_epa/gjk.h"

#include "narrowphase/curved/refinement.h"
#include "narrowphase/shape/triangle.h"
#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <bitset>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;
using Outcome = GjkResult::Outcome;

// First iteration that tries Newton's method: in earlier ones the simplex seldom knows the smooth pieces on which the
// nearest point lies. Evidence: 400 random pairs apart each of cylinders, cones and ellipsoids, smallest processor time
// of 60 rounds. Against 3, the values 2, 4 and 5 change the time by -5 to +18 %, 1 by +7 to +37 %, 8 by +29 to +48 %.
// The rows "cylinder, apart" of ./dev bench narrowphase repeat it for cylinders.
constexpr int kFirstRefinement = 3;

// The search may change from an edge or a face to another face at the same distance, but must not cycle.
constexpr int kMaxSideways = 4;

/// Lower bound of the distance between the origin and the CSO, by the support plane at w, the vertex farthest along
/// `normal`.
double lowerBound(const Cso& cso, const Vector3d& normal, const CsoVertex& w) {
  return -normal.dot(w.point) - cso.rounding();
}

/// Tries to finish the search by Newton's method. Returns true, with a complete result, if the bounds that it gives
/// meet the tolerance.
bool refineDistance(Cso& cso, const Vector3d& normal, const Options& options, GjkResult& result) {
  const std::optional<StationaryDirection> stationary = refine(cso, result.simplex, normal);
  if (!stationary || !(stationary->height < 0.0)) return false;
  const double lower_bound = lowerBound(cso, stationary->normal, cso.vertex(stationary->normal));
  const double distance = (stationary->points.on_b - stationary->points.on_a).norm();
  if (!(distance + cso.rounding() - lower_bound <= options.distance_tolerance)) return false;
  result.outcome = Outcome::Apart;
  result.status = Status::Converged;
  result.distance = distance;
  result.lower_bound = lower_bound;
  result.normal = stationary->normal;
  result.points = stationary->points;
  return true;
}

/// Outcome of a search whose next vertex brings no progress, while its bounds are wider than the tolerance.
Outcome outcomeWithoutProgress(const Cso& cso, double lower_bound, double upper_bound, const Options& options) {
  // The vertices on a curve lie in one plane within rounding. Only EPA can tell whether the cores overlap.
  if (!cso.isPolytope()) return Outcome::Overlap;
  // The cores are not proven apart, for example because rounding hides that a simplex with a needle encloses the origin;
  // or they cannot be distinguished from touching ones, given the rounding of both bounds. EPA finds a small depth.
  const bool may_touch = lower_bound <= 0.0 || upper_bound + 3.0 * cso.rounding() <= options.distance_tolerance;
  return may_touch ? Outcome::Overlap : Outcome::Apart;
}

bool isTriangle(unsigned members) { return std::bitset<4>(members).count() == 3; }

/// True if a step leads to another face while the distance changes by no more than rounding. A face at the edge nearest
/// to the origin is not nearer than the edge, but its normal is more accurate. If the nearest point of a triangle is on
/// an edge within rounding, the triangle on the other side of the edge may have the normal that is needed.
bool isSideways(const Nearest& nearest, const Nearest& next, double rounding) {
  const bool has_all = (next.members & nearest.members) == nearest.members;
  return (has_all || isTriangle(next.members)) && next.members != nearest.members &&
         next.distance <= nearest.distance + rounding;
}

/// Improves the lower bound by the normals of the triangles at the newest vertex. If two parallel faces nearly touch,
/// the nearest point may lie on an edge across a face, so near to the origin that rounding spoils its direction.
void improveLowerBound(Cso& cso, const Simplex& simplex, int newest, GjkResult& result) {
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      if (!simplex.has(a) || !simplex.has(b) || a == newest || b == newest) continue;
      const Vector3d &p = simplex[newest].point, &pa = simplex[a].point, &pb = simplex[b].point;
      const Vector3d area = areaVector(pa - p, pb - pa, p - pb);
      constexpr double kLosesDigits = 1e-280;  // [m^4] two vertices coincide, or nearly so
      if (!(area.squaredNorm() > kLosesDigits)) continue;
      const Vector3d unit = area.normalized(), normal = unit.dot(result.normal) < 0.0 ? Vector3d(-unit) : unit;
      const double bound = lowerBound(cso, normal, cso.vertex(normal));
      if (!(bound > result.lower_bound)) continue;
      result.lower_bound = bound;
      result.normal = normal;
    }
}

/// Adds those vertices of the last simplex of the previous query that bring the simplex nearer to the origin. It is
/// inlined explicitly, because the compiler inlines only functions that one observer calls: a call costs 45
/// instructions, 1 to 2 % of a query of polytopes apart.
[[gnu::always_inline]] inline Nearest recall(Cso& cso, Simplex& simplex, Nearest nearest) {
  const WarmStart& warm_start = cso.warmStart();
  const auto count = static_cast<std::size_t>(std::clamp(warm_start.simplex_size, 0, 3));
  for (std::size_t i = 0; i < count && !nearest.encloses_origin; ++i) {
    const int place = simplex.freePlace();
    const CsoVertex& w = simplex[place] = cso.recalled(warm_start.simplex[i]);
    // A vertex that does not lie beyond the nearest point, as every support point does, brings no progress; and
    // nearestToOrigin() relies on it.
    if (!(nearest.normal().dot(w.point) > cso.rounding() - nearest.distance)) continue;
    const Nearest next = nearestToOrigin(simplex, place);
    if (!next.encloses_origin && !(next.distance < nearest.distance)) continue;
    nearest = next;
    simplex.members = nearest.members;
  }
  return nearest;
}

/// Stores the simplex for the next query.
void remember(Cso& cso, const Simplex& simplex) {
  PROXIMITY_ASSERT(simplex.members != 0,
                   "The simplex is empty: an ending of GJK without a vertex has nothing to remember.");
  WarmStart& warm_start = cso.warmStart();
  warm_start.simplex_size = 0;
  for (int place = 0; place < 4 && warm_start.simplex_size < 3; ++place)
    if (simplex.has(place)) warm_start.simplex[warm_start.simplex_size++] = simplex[place].numbers;
}

/// Sets the answer of two polytopes by the nearest features with which the last query ended. Returns false, and
/// changes nothing, if it is not, or if the bounds do not meet the tolerance.
[[gnu::noinline]] bool takeFeatures(const Cso& cso, const WarmStart& last, const Options& options, GjkResult& result) {
  const std::optional<DistanceOfFeatures> exact = distanceOfFeatures(cso, last, options.distance_tolerance);
  if (!exact || !(exact->distance + cso.rounding() - exact->lower_bound <= options.distance_tolerance)) return false;
  result.outcome = Outcome::Apart;
  result.status = Status::Converged;
  result.distance = exact->distance;
  result.lower_bound = exact->lower_bound;
  result.normal = exact->normal;
  result.points = exact->points;
  result.by_features = true;
  return true;
}

struct Ending {
  Outcome outcome;
  Status status;
};

/// Completes the result of a search that ends with this nearest point.
void finish(Cso& cso, const Nearest& nearest, const Options& options, const Ending& ending, GjkResult& result) {
  const bool converged = nearest.distance + cso.rounding() - result.lower_bound <= options.distance_tolerance;
  result.outcome = ending.outcome;
  // A search that a threshold has ended is not the whole search, even if its bounds meet the tolerance.
  const bool whole = ending.outcome == Outcome::Apart && ending.status != Status::Threshold;
  result.status = converged && whole ? Status::Converged : ending.status;
  result.distance = nearest.distance;
  if (cso.isPolytope() && ending.outcome != Outcome::Threshold) remember(cso, result.simplex);
  if (ending.outcome != Outcome::Apart) return;
  if (options.repeatability != Repeatability::WithinTolerance && cso.isPolytope() &&
      result.status == Status::Converged && takeFeatures(cso, cso.warmStart(), options, result))
    return;
  result.points = witnessPoints(result.simplex);
}

/// The end of a search whose next vertex brings no progress. Returns nullopt if Newton's method has completed the
/// result.
template <typename Observer>
std::optional<Ending> endWithoutProgress(Cso& cso, const Nearest& nearest, int newest, const Options& options,
                                         Observer observer, GjkResult& result) {
  const double upper_bound = nearest.distance + cso.rounding();
  const auto isOpen = [&] { return upper_bound - result.lower_bound > options.distance_tolerance; };
  if (isOpen() && cso.isPolytope()) improveLowerBound(cso, result.simplex, newest, result);
  if (isOpen() && !cso.isPolytope() && refineDistance(cso, nearest.normal(), options, result)) {
    observer.reaches(Algorithm::GjkNewton);
    return std::nullopt;
  }
  return Ending{isOpen() ? outcomeWithoutProgress(cso, result.lower_bound, upper_bound, options) : Outcome::Apart,
                Status::Degenerate};
}

/// Searches until the result is decided, and sets all of it except the parts that finish() sets. Returns nullopt if
/// Newton's method has completed it.
template <typename Observer>
std::optional<Ending> search(Cso& cso, const CsoVertex& first, const Options& options, Observer observer,
                             Nearest& nearest, GjkResult& result) {
  Simplex& simplex = result.simplex;
  const double rounding = cso.rounding(), final_width = cso.finalWidth(options.distance_tolerance);

  int newest = 0, sideways = 0;
  simplex[newest] = first;
  for (result.iterations = 1;; ++result.iterations) {
    const CsoVertex& w = simplex[newest];
    result.normal = nearest.normal();
    result.lower_bound = lowerBound(cso, result.normal, w);
    observer.supports(w, result.normal, result.lower_bound);
    if (result.lower_bound > options.stop_above) return Ending{Outcome::Threshold, Status::Threshold};
    const double upper_bound = nearest.distance + rounding;
    const double width = upper_bound - result.lower_bound;
    if (width <= final_width) return Ending{Outcome::Apart, Status::Converged};
    if (upper_bound <= options.stop_below) return Ending{Outcome::Apart, Status::Threshold};

    const Nearest next = nearestToOrigin(simplex, newest);
    const bool is_nearer = next.encloses_origin || next.distance < nearest.distance;  // false for NaN
    if (!is_nearer && !(isSideways(nearest, next, rounding) && sideways++ < kMaxSideways))
      return endWithoutProgress(cso, nearest, newest, options, observer, result);
    nearest = next;
    simplex.members = nearest.members;
    if (result.iterations == 1 && cso.isPolytope()) nearest = recall(cso, simplex, nearest);
    observer.reduces(simplex, nearest, rounding);
    // The simplex encloses the origin, or its nearest point cannot be distinguished from the origin.
    if (nearest.encloses_origin || nearest.distance <= rounding) return Ending{Outcome::Overlap, Status::Converged};
    if (result.iterations >= options.max_iterations) return Ending{Outcome::Apart, Status::IterationLimit};
    if (!cso.isPolytope() && result.lower_bound > 0.0 && result.iterations >= kFirstRefinement &&
        refineDistance(cso, nearest.normal(), options, result)) {
      observer.reaches(Algorithm::GjkNewton);
      return std::nullopt;
    }
    newest = simplex.freePlace();
    simplex[newest] = cso.vertex(nearest.direction);
  }
}

}  // namespace

template <typename Observer>
GjkResult gjk(Cso& cso, const Vector3d& normal_guess, const CsoVertex& first, const Options& options,
              Observer observer) {
  GjkResult result;
  Nearest nearest{std::numeric_limits<double>::infinity(), normal_guess, 1.0, 0, false};
  if (const auto ending = search(cso, first, options, observer, nearest, result))
    finish(cso, nearest, options, *ending, result);
  return result;
}

std::optional<GjkResult> recalledFeatures(const Cso& cso, const WarmStart& warm_start, const Options& options) {
  std::optional<GjkResult> result(std::in_place);
  if (!takeFeatures(cso, warm_start, options, *result)) result.reset();
  return result;
}

template GjkResult gjk(Cso&, const Vector3d&, const CsoVertex&, const Options&, Unobserved);
template GjkResult gjk(Cso&, const Vector3d&, const CsoVertex&, const Options&, Recorder);

}  // namespace proximity_server::narrowphase
