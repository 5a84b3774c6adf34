#pragma once

#include "oracle/oracle.h"

#include <gmpxx.h>

#include <vector>

namespace proximity_server::narrowphase {

/// The core (no margin) is the convex hull of finitely many points: point, segment, box or hull.
bool hasPolytopeCore(const Shape& shape);

/// How far apart or how deep two polytope cores are, in rational numbers.
struct ExactDistance {
  bool overlap;       ///< the cores share a point; touching is overlap of depth 0
  mpq_class squared;  ///< [m^2] of the distance, or in overlap of the penetration depth

  /// The signed distance of the shapes with their margins [m], rounded once to long double.
  long double withMargins(const ShapePair& pair) const;
};

/// Signed distance of two shapes with polytope cores, without any rounding.
///
/// Input:  the doubles of vertices, half extents and pose as they are. b's points are a_T_b * p with the nine entries
///         of the rotation as given: where they are not orthonormal to the last bit, b is that slightly sheared solid.
/// Method: all vertices are brought to one power of two as unit, so that they are integers. Apart, GJK in integers: the
///         nearest point V / D of a simplex by Cramer's rule, until no vertex p has V . p < V . V / D. In overlap, the
///         hull of CSO vertices grows at its face nearest to the origin until that face is one of the CSO. Each step
///         is strict, so both end, and what they end with is optimal without a tolerance.
/// Source: Gilbert, Johnson, Keerthi 1988; van den Bergen 2001. Shares no code with the library.
ExactDistance exactDistance(const ShapePair& pair);

/// Distance of the origin to the convex hull of up to four points, rounded once to long double.
long double exactDistanceToOrigin(const std::vector<Eigen::Vector3d>& points);

}  // namespace proximity_server::narrowphase
