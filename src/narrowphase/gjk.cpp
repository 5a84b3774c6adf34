#include "proximity_server/narrowphase/gjk.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;
using Outcome = GjkResult::Outcome;

/// The support plane of `normal` leaves at least this much between the origin and the CSO.
double lowerBound(const Cso& cso, const Vector3d& normal, const CsoVertex& w) {
  return -normal.dot(w.point) - cso.rounding();
}

}  // namespace

GjkResult gjk(Cso& cso, const Vector3d& normal_guess, const Options& options) {
  GjkResult result;
  result.normal = normal_guess;
  CsoVertex w = cso.vertex(normal_guess);
  result.lower_bound = lowerBound(cso, normal_guess, w);
  result.simplex.add(w);
  Nearest nearest = reduceToNearest(result.simplex);
  const auto end = [&](Outcome outcome, Status status) {
    result.outcome = outcome;
    result.status = status;
    return result;
  };

  for (result.iterations = 1;; ++result.iterations) {
    result.distance = nearest.distance;
    if (result.lower_bound > options.stop_above) return end(Outcome::Threshold, Status::Threshold);
    // From here on the nearest point cannot be told from the origin.
    if (nearest.distance <= cso.rounding()) return end(Outcome::Overlap, Status::Converged);

    result.normal = nearest.normal;
    w = cso.vertex(nearest.normal);
    result.lower_bound = lowerBound(cso, nearest.normal, w);
    if (nearest.distance + cso.rounding() <= options.stop_below) return end(Outcome::Apart, Status::Threshold);
    if (nearest.distance + cso.rounding() - result.lower_bound <= options.distance_tolerance)
      return end(Outcome::Apart, Status::Converged);
    if (result.iterations >= options.max_iterations) return end(Outcome::Apart, Status::IterationLimit);

    Simplex grown = result.simplex;
    grown.add(w);
    const Nearest next = result.simplex.contains(w) ? nearest : reduceToNearest(grown);
    if (next.encloses_origin) {
      result.simplex = grown;
      return end(Outcome::Overlap, Status::Converged);
    }
    // Written as !(next < nearest) so that NaN ends the search instead of winning it.
    if (!(next.distance < nearest.distance)) {
      const bool touching = nearest.distance <= options.distance_tolerance;
      return end(touching ? Outcome::Overlap : Outcome::Apart, Status::Degenerate);
    }
    result.simplex = grown;
    nearest = next;
  }
}

}  // namespace proximity_server
