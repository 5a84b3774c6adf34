#pragma once

#include <optional>

#include "proximity_server/narrowphase/gjk_epa/simplex.h"

namespace proximity_server::narrowphase {

/// A direction in which the support plane of a curved CSO touches it perpendicular to the line from the origin: where
/// the distance has its maximum over all directions, and the depth a minimum.
struct StationaryDirection {
  Eigen::Vector3d normal;  ///< unit, a towards b
  double height;           ///< [m] of the support plane over the origin: the depth, or minus the distance
  WitnessPoints points;    ///< on_a - on_b is height * normal, but for rounding
  double cos_proven;       ///< of a cap about the normal, of less than 90 degrees, in all directions of which the CSO
                           ///< reaches at least as far as `height`; 1: nothing is proven
};

/// Newton's method from a normal near such a direction, and the CSO vertices that GJK or EPA found there: they tell
/// which smooth pieces (rims, apexes, corners, ellipsoids) meet in it, of which its point is a convex combination.
///
/// Error:   quadratic convergence; the last step is below 1e-7 rad, so what is left is rounding.
/// Failure: nothing where the steps do not converge, or the origin does not lie over the pieces. Whether a piece is
///          missing the caller sees from the support point along the normal, which proves everything anyway.
/// Source:  sequential quadratic programming for a maximum of smooth functions (Nocedal, Wright, Numerical
/// Optimization,
///          2006), on the unit sphere; the support functions and their derivatives are those of circle and ellipsoid.
std::optional<StationaryDirection> refine(Cso& cso, const Simplex& simplex, const Eigen::Vector3d& normal);

}  // namespace proximity_server::narrowphase
