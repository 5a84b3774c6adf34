#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// Whether a core is a solid of revolution about z: points, segments, cylinders and cones.
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

}  // namespace proximity_server::narrowphase
