#pragma once

#include "narrowphase/curved/stationary_direction.h"

#include <optional>

namespace proximity_server::narrowphase {

/// Refines a direction of GJK or EPA on a curved CSO by Newton's method.
///
/// The support function of the CSO is the maximum of the support functions of its smooth pieces (the circle of a rim,
/// an apex, a corner, an ellipsoid). In the stationary direction up to three of them are equal, and a convex
/// combination of their support points lies on the line through the origin.
///
/// 1. If the support point of the other core lies over the flat end of a cylinder or cone, the axis is the answer. If
///    the axes of two cylinders or segments cross, as seen along their common perpendicular, and the normal is nearly
///    perpendicular to both, this perpendicular is the answer. Two rims, or a rim and a mantle, are solved directly
///    (stationary_rims.h), and step 7 follows.
/// 2. Assign each vertex of the simplex to its smooth piece; at most three different pieces count.
/// 3. Evaluate height, slope and curvature of the support function of each piece along the normal. Two pieces get the
///    weights with which the slope across their kink vanishes at first.
/// 4. Solve the linear system for the turn of the normal and the weights of the pieces: after the turn the pieces have
///    the same height, and the weighted sum of their slopes vanishes.
/// 5. Turn the normal, and repeat from step 3 until the turn is below 1e-7 rad, sixteen times at most. Along a ring of
///    directions of nearly equal depth, go downhill where Newton's step would lead to the maximum.
/// 6. If a weight is negative, leave out its piece and repeat from step 4. Accept the direction if the weighted point
///    lies on the normal.
/// 7. If it is a depth, find the widest cap about the normal in which no direction can be shallower.
///
/// Error:   the convergence is quadratic and the last step below 1e-7 rad, so only rounding is left.
/// Failure: returns nullopt if the steps do not converge, if the point misses the normal, or if a core is a sweep of a
///          curved shape. A piece that the simplex does not know is not noticed here: the caller evaluates the support
///          point along the normal, which gives the proven bound.
/// Source:  Nocedal, Wright, Numerical Optimization, 2006, chapter 18 (sequential quadratic programming), for a maximum
///          of smooth functions on the unit sphere.
/// Differs: there is no line search, as GJK and EPA continue if the steps fail; the caps (step 7) are our own.
std::optional<StationaryDirection> refine(Cso& cso, const Simplex& simplex, const Eigen::Vector3d& normal);

}  // namespace proximity_server::narrowphase
