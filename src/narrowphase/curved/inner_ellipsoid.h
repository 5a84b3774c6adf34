#pragma once

#include "narrowphase/curved/stationary_direction.h"

namespace proximity_server::narrowphase {

/// A lower bound of the depth of two overlapping cores, by an ellipsoid inside of their CSO. If the depth is the same
/// in a ring of directions, or nearly so, EPA would have to cover the ring with faces; the ellipsoid covers it at once.
///
/// 1. Write the support function of each core as p . n + sum |S_k n|, with symmetric S_k: a segment of half length H
///    along u has S = H u u', a disc S = r (1 - u u'), a cylinder is the sum of both, a box of three segments. A
///    cone is replaced by its apex or its base, whichever lies farther along the stationary direction n; if both lie as
///    far, by the spheroid inside of it that touches the slant where the witness point lies. A hull or a sweep is
///    replaced by its witness point.
/// 2. A part with S_k n = 0 is split at the witness point t: H |u . n| is at least t u . n + (H - |t|) |u . n|. Two
///    segments, of which one is split, span a parallelogram: |x| + |y| is at least the root of x^2 + y^2 + 2 k x y for
///    |k| <= 1, an ellipse inside of it. A second attempt takes only one end of each segment.
/// 3. Rotate the vectors S_k n onto each other by U_k. By the triangle inequality the CSO contains the ellipsoid with
///    the support function c . n + |Q n|, where Q = sum U_k S_k. It touches the CSO in the direction n.
/// 4. With M = Q' Q, a ball of radius r about the origin lies in the ellipsoid if r^2 <= s (1 - c' (M - s)^-1 c) for a
///    number s below all eigenvalues of M. If the ball touches in the direction n, s = r |Q n|.
///
/// Source:  Kurzhanski, Valyi, Ellipsoidal Calculus for Estimation and Control, 1997 (step 3); Boyd, Vandenberghe,
///          Convex Optimization, 2004, appendix B (step 4, the S-procedure).
/// Returns: [m] the greater r for s = depth |Q n| and s = (depth - tolerance / 4) |Q n|, less rounding; -infinity if
///          neither is below all eigenvalues of M.
double depthOfInnerEllipsoid(const Cso& cso, const StationaryDirection& direction, double depth, double tolerance);

}  // namespace proximity_server::narrowphase
