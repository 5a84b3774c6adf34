#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// True if a core is a solid of revolution about z: points, segments, cylinders and cones.
inline bool isSolidOfRevolution(Shape::Kind kind) {
  return kind == Shape::Kind::Point || kind == Shape::Kind::Segment || kind == Shape::Kind::Cylinder ||
         kind == Shape::Kind::Cone;
}

/// [rad] Angle between the axes of two solids of revolution, to first order. It is 0 if one of them is a point.
double axesTilt(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

/// Signed distance of the cores of two solids of revolution about parallel axes, without margins and bounds.
///
/// The CSO is a solid of revolution, too. Its profile is the sum of both profiles, a convex polygon in the half plane
/// (radius, height), so the problem is the signed distance of a point from this polygon. EPA would be slow here, as a
/// ring of directions has the same depth.
///
/// Frame, sign, invariant: as signedDistance().
/// Error:   a few eps of the sizes and the offset, and the tilt of the axes times the reach of b.
SignedDistance parallelAxesDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double tolerance);

/// A lower bound of the depth of the cores of two solids of revolution whose axes are tilted against each other. Where
/// the depth is nearly the same in a ring of directions, EPA would have to cover the ring with faces.
///
/// 1. In the frame of the straight solid, a unit direction is n = (x cos(v), sin(v)) with a unit vector x of the plane.
///    The tilted solid has the axis (s y, c), with the sine s and the cosine c of the tilt and a unit vector y.
/// 2. A corner of the sum of both profiles belongs to a disc of the straight solid (radius r, height z) and to one of
///    the tilted solid (radius p, height q on its axis, which begins at o). The support function of a tilted disc of
///    radius 1 is at least c cos(v) - s sin(v) x . y, which is the support function of the point to which the tilt
///    turns (x, 0). So the support function of both discs is at least (r + c p) cos(v) + (z + c q + o_z) sin(v)
///    - |cos(v) (o_xy + s q y) - sin(v) s p y|.
/// 3. Between the normals m and n of the two edges that meet in the corner, a unit direction is j m + k n with
///    j, k >= 0 and j + k >= 1. The bound is concave there, so it is at least the smaller of its values at m and
///    n, if that is positive.
/// 4. The smallest of these values over all corners bounds the depth. Each of the solids is once the straight one.
///
/// Returns: [m] the bound, up to rounding; a negative number says nothing. It is exact if the nearest edge belongs to
///          the straight solid, but for the square of the tilt times half the size of the tilted one.
double depthOfTiltedAxes(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

}  // namespace proximity_server::narrowphase
