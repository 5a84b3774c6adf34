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
  Places places;
  places[0] = cso.vertex(normal_guess);
  Nearest nearest = nearestToOrigin(places, {}, 0);

  GjkResult result;
  result.normal = normal_guess;
  result.lower_bound = lowerBound(cso, normal_guess, places[0]);
  const double final_gap = cso.finalGap(options.distance_tolerance);
  const auto end = [&](Outcome outcome, Status status) {
    const bool converged = nearest.distance + cso.rounding() - result.lower_bound <= options.distance_tolerance;
    result.outcome = outcome;
    result.status = converged && outcome == Outcome::Apart ? Status::Converged : status;
    result.distance = nearest.distance;
    result.simplex = Simplex(places, nearest.subset);
    return result;
  };

  for (result.iterations = 1;; ++result.iterations) {
    if (result.lower_bound > options.stop_above) return end(Outcome::Threshold, Status::Threshold);
    // From here on the nearest point cannot be told from the origin.
    if (nearest.distance <= cso.rounding()) return end(Outcome::Overlap, Status::Converged);

    const int newest = nearest.subset.freePlace();
    const CsoVertex& w = places[static_cast<std::size_t>(newest)] = cso.vertex(nearest.normal);
    result.normal = nearest.normal;
    result.lower_bound = lowerBound(cso, nearest.normal, w);
    const double upper_bound = nearest.distance + cso.rounding();
    const double gap = upper_bound - result.lower_bound;
    if (gap <= final_gap) return end(Outcome::Apart, Status::Converged);
    if (upper_bound <= options.stop_below) return end(Outcome::Apart, Status::Threshold);
    if (result.iterations >= options.max_iterations) return end(Outcome::Apart, Status::IterationLimit);

    const Nearest next = nearestToOrigin(places, nearest.subset, newest);
    // Written as !(next < nearest) so that NaN ends the search instead of winning it.
    if (!next.encloses_origin && !(next.distance < nearest.distance)) {
      // Nearer than can be told from touching, with the rounding of both bounds: the depth is small in any direction.
      const bool touching =
          gap > options.distance_tolerance && upper_bound + 3.0 * cso.rounding() <= options.distance_tolerance;
      return end(touching ? Outcome::Overlap : Outcome::Apart, Status::Degenerate);
    }
    nearest = next;
    if (nearest.encloses_origin) return end(Outcome::Overlap, Status::Converged);
  }
}

}  // namespace proximity_server
