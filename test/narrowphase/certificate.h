#pragma once

#include "oracle/oracle.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

/// Returns how far [m] rounding alone may move a bound that is evaluated in double.
///
/// With u = epsilon / 2: a dot product of three terms with |x| <= scale is off by 3 u scale, and there is one for each
/// shape; turning the normal into the frame of b costs 3 u, its length 3 u, the sum with the translation u: 13 u scale,
/// rounded up.
inline double roundingOf(const ShapePair& pair) { return 8.0 * std::numeric_limits<double>::epsilon() * pair.scale(); }

/// The same for what is evaluated in long double: the same sum with u = 2^-64.
inline constexpr long double kRoundingOfTruth = 0x1p-60L;

namespace certificate {

using Check = testing::AssertionResult;

inline Check fail(const char* what, long double excess) {
  return testing::AssertionFailure() << what << " by " << static_cast<double>(excess) << " m";
}

/// The bounds are in order, the distance lies between them, and every status means what it says.
inline Check statusFitsTheBounds(const SignedDistance& result, const Options& options) {
  if (result.status == Status::Unknown) return testing::AssertionFailure() << "status is Unknown";
  if (!(result.lower_bound <= result.upper_bound))
    return fail("lower bound above upper bound", result.lower_bound - result.upper_bound);
  if (result.has_points && !(result.lower_bound <= result.distance && result.distance <= result.upper_bound))
    return testing::AssertionFailure() << "distance outside of its bounds";
  const double gap = result.upper_bound - result.lower_bound;
  if (result.status == Status::Converged && !(gap <= options.distance_tolerance))
    return fail("converged, but the bounds are too far apart", gap - options.distance_tolerance);
  if (result.status == Status::Converged && !result.has_points)
    return testing::AssertionFailure() << "converged without points";
  const bool gave_up = result.status == Status::Degenerate || result.status == Status::IterationLimit;
  if (gave_up && result.has_points && gap <= options.distance_tolerance)
    return testing::AssertionFailure() << "gave up with the bounds within the tolerance";
  const bool decided = result.lower_bound > options.stop_above || result.upper_bound <= options.stop_below;
  if (result.status == Status::Threshold && !decided) return testing::AssertionFailure() << "no threshold was decided";
  return testing::AssertionSuccess();
}

/// No point of a lies further along the normal than lower_bound short of any point of b.
inline Check normalProvesLowerBound(const ShapePair& pair, const SignedDistance& result) {
  if (!(result.lower_bound > -std::numeric_limits<double>::infinity())) return testing::AssertionSuccess();
  // Three squares and a square root: 5/2 epsilon, rounded up.
  if (!(std::abs(result.normal.norm() - 1.0) <= 4.0 * std::numeric_limits<double>::epsilon()))
    return testing::AssertionFailure() << "normal has length " << result.normal.norm();
  const long double excess = result.lower_bound - pair.gapAlong(result.normal.cast<long double>().normalized());
  if (!(excess <= kRoundingOfTruth * pair.scale()))
    return fail("the normal does not prove the lower bound, short", excess);
  return testing::AssertionSuccess();
}

/// point_b = point_a + distance * normal.
inline Check pointsAreJoinedByTheNormal(const ShapePair& pair, const SignedDistance& result) {
  const double off = (result.point_a + result.distance * result.normal - result.point_b).norm();
  if (!(off <= roundingOf(pair))) return fail("point_b is not point_a + distance * normal, off", off);
  return testing::AssertionSuccess();
}

using Outside = long double (*)(const Shape&, const Eigen::Vector3d&);

/// The points lie in the shapes within what the bounds leave open, which is the tolerance where the search converged.
/// Apart, they prove the upper bound: from a to point_a to point_b to b is no farther.
inline Check pointsLieInTheShapes(const ShapePair& pair, const SignedDistance& result, Outside outside) {
  const double rounding = roundingOf(pair);
  const long double allowed = rounding + (result.upper_bound - result.lower_bound);
  const long double outside_a = outside(pair.a, result.point_a);
  const long double outside_b = outside(pair.b, pair.a_T_b.inverse(Eigen::Affine) * result.point_b);
  if (!(outside_a <= allowed)) return fail("point_a lies outside of a", outside_a);
  if (!(outside_b <= allowed)) return fail("point_b lies outside of b", outside_b);
  const long double path = (result.point_b - result.point_a).cast<long double>().norm();
  const long double excess = path + std::max(outside_a, 0.0L) + std::max(outside_b, 0.0L) - result.upper_bound;
  if (result.distance > 0.0 && !(excess <= rounding))
    return fail("the points do not prove the upper bound, short", excess);
  return testing::AssertionSuccess();
}

/// Asks the slow bound only if the fast one proves nothing.
inline Check pointsLieInTheShapes(const ShapePair& pair, const SignedDistance& result) {
  if (pointsLieInTheShapes(pair, result, outsideByAtMost)) return testing::AssertionSuccess();
  return pointsLieInTheShapes(pair, result, outsideBy);
}

}  // namespace certificate

/// Everything a result claims that can be checked without knowing the true distance, from the definition of the shapes.
inline testing::AssertionResult carriesItsProof(const ShapePair& pair, const SignedDistance& result,
                                                const Options& options = {}) {
  using namespace certificate;
  Check check = statusFitsTheBounds(result, options);
  if (check) check = normalProvesLowerBound(pair, result);
  if (!check || !result.has_points) return check;
  check = pointsAreJoinedByTheNormal(pair, result);
  if (check) check = pointsLieInTheShapes(pair, result);
  return check;
}

/// lower_bound <= truth <= upper_bound, within rounding.
inline testing::AssertionResult enclosesTruth(const ShapePair& pair, const SignedDistance& result, const Truth& truth) {
  const long double above = result.lower_bound - (truth.distance + truth.error_bound);
  const long double below = truth.distance - result.upper_bound;
  if (!(above <= roundingOf(pair))) return certificate::fail("the lower bound is above the truth", above);
  if (!(below <= roundingOf(pair))) return certificate::fail("the upper bound is below the truth", below);
  return testing::AssertionSuccess();
}

/// Returns how far [m] the distance is from the truth, beyond the uncertainty of the oracle.
inline double errorOf(const SignedDistance& result, const Truth& truth) {
  const long double low = truth.distance - result.distance;
  const long double high = result.distance - (truth.distance + truth.error_bound);
  return static_cast<double>(std::max({low, high, 0.0L}));
}

}  // namespace proximity_server::narrowphase
