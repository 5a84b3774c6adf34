#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

/// The point of the shape's core (no margin) farthest along `direction`, in the shape's frame. Written from the
/// definition of each shape, in long double; shares no code with the library.
Vector3l coreSupport(const Shape& shape, const Vector3l& direction);

/// Two shapes at a relative pose, in the frame of a, with the pose's doubles taken as they are.
struct ShapePair {
  const Shape& a;
  const Shape& b;
  const Eigen::Isometry3d& a_T_b;

  /// Radius [m] of a ball around a's origin that holds both: the unit of every rounding error of a query.
  double scale() const;

  /// Smallest n . (y - x) over x in a, y in b, for a unit n: a lower bound of the signed distance.
  long double gapAlong(const Vector3l& n) const;
};

/// The signed distance, known to lie in [distance, distance + error_bound].
struct Truth {
  long double distance = 0;
  long double error_bound = 0;
  Vector3l normal = Vector3l::UnitZ();
};

/// Signed distance by branch and bound over all directions; no simplex and no polytope.
///
/// Sign:   positive apart, negative overlapping. It is the largest gapAlong(n) over the unit sphere.
/// Method: the sphere is cut into triangles. The point c of the CSO that is lowest along a triangle's centre n0 bounds
///         the gap of every direction n of the triangle, gapAlong(n) <= c . n, so a triangle is dropped only with a
///         proof that it holds nothing better than what is known.
/// Error:  error_bound is what is left unproven, plus rounding. It meets 1e-17 of the scale unless whole arcs of
///         directions are equally good (coaxial round shapes); there the search gives up at `max_cells`.
/// Source: Horst, Tuy, Global Optimization, 1996 (branch and bound with Lipschitz-like bounds).
Truth signedDistanceOracle(const ShapePair& pair, int max_cells = 200000);

/// How far `point` (in the shape's frame) lies outside of the shape with its margin [m]; negative or zero inside.
/// Error: rounding in long double; of a hull, no less than the truth and no more than double epsilon * radius above it.
long double outsideBy(const Shape& shape, const Eigen::Vector3d& point);

/// No less than outsideBy, and fast for hulls too: a point in the middle of a hull is as far outside as its nearest
/// triangle is away. Within rounding the same on the surface and outside of it.
long double outsideByAtMost(const Shape& shape, const Eigen::Vector3d& point);

}  // namespace proximity_server::narrowphase
