#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// Points, segments, cylinders and cones.
inline bool isSolidOfRevolution(Shape::Kind kind) {
  return kind == Shape::Kind::Point || kind == Shape::Kind::Segment || kind == Shape::Kind::Cylinder ||
         kind == Shape::Kind::Cone;
}

/// The angle [rad] between the axes of two cores of revolution; 0 where one is a point.
double axesTilt(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

/// Signed distance of two cores of revolution about parallel axes, margins and bounds left out.
///
/// Their CSO is a solid of revolution too, whose profile is the sum of theirs, so what is left is the distance of a
/// point from a convex polygon in the half plane (radius, height). Here EPA would see a ring of equal directions.
/// Frame, sign and invariant as signedDistance.
/// Error: a few eps of the sizes and the offset, and the tilt times the reach of b.
SignedDistance parallelAxesDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double tolerance);

}  // namespace proximity_server::narrowphase
