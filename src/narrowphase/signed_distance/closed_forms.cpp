#include "narrowphase/signed_distance/closed_forms.h"

#include "narrowphase/closed_form/points_segments.h"
#include "narrowphase/signed_distance/stages.h"

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Vector3d;

SignedDistance byClosedForm(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                            double rounding, WarmStart& warm_start) {
  const Query query{a, b, a_T_b, options, warm_start, rounding};
  SignedDistance result = completed(query, certified(closedForm(a, b, a_T_b), rounding));
  warm_start.axis = result.normal;
  if (result.status == Status::Converged && result.unique)
    result.unique = meetInOnePoint(a, b, a_T_b, result.normal, options.distance_tolerance);
  return result;
}

SignedDistance byCentres(const Shape& a, const Shape& b, const Isometry3d& a_T_b, const Options& options,
                         double rounding, WarmStart& warm_start) {
  const Query query{a, b, a_T_b, options, warm_start, rounding};
  const Vector3d centres = a_T_b.translation();
  const double length2 = centres.squaredNorm(), length = std::sqrt(length2);
  if (!(length > support::kShortest)) return byClosedForm(a, b, a_T_b, options, rounding, warm_start);
  const double of_a = a.halfExtents().z() * std::abs(centres.z());
  const double of_b = b.kind() == Shape::Kind::Box ? heightAlong(b, a_T_b.linear().transpose() * centres)
                                                   : b.halfExtents().z() * std::abs(a_T_b.linear().col(2).dot(centres));
  const double lower_bound = boundByPlanes(query, length2 - of_a - of_b, length);
  double upper_bound = kNoThreshold;
  if (!(lower_bound > options.stop_above)) {
    upper_bound = distanceOfInnerBalls(query, centres) - query.margins();
    if (!(upper_bound <= options.stop_below)) return byClosedForm(a, b, a_T_b, options, rounding, warm_start);
  }
  warm_start.axis = centres / length;
  return decided(warm_start.axis, lower_bound, upper_bound, /*iterations=*/0);
}

}  // namespace proximity_server::narrowphase
