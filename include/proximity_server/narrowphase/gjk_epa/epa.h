#pragma once

#include "proximity_server/narrowphase/gjk_epa/simplex.h"

namespace proximity_server::narrowphase {

/// How deep two cores overlap. Depths are >= 0 but for rounding: cores that only touch may come out apart by that much.
struct EpaResult {
  Status status;
  double depth;             ///< [m] moving b by depth * normal makes the cores touch: an upper bound but for rounding
  double lower_bound;       ///< [m] of the depth: the polytope inside the CSO reaches this far in every direction
  bool has_normal;          ///< false: lower_bound alone decided options.stop_below, and depth and normal are not set
  Eigen::Vector3d normal;   ///< unit, a towards b: the direction in which b leaves
  bool has_points;          ///< false: nothing is known of the surface along the normal
  Eigen::Vector3d point_a;  ///< point_a - point_b is the depth along the normal, within the gap of the bounds
  Eigen::Vector3d point_b;
  bool unique;  ///< false: another direction is as short
  int iterations;
};

/// Penetration depth by the expanding polytope algorithm, from a simplex of any dimension that holds the origin within
/// rounding (or the tolerance).
///
/// Error:   Converged: depth - lower_bound <= options.distance_tolerance. On polytopes the end is exact.
/// Failure: none; no allocation. A CSO without volume has depth 0 across it.
/// Source:  van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001. Unlike
///          there, every visible face is deleted, which leaves fewer slivers and needs no repair.
EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options);

}  // namespace proximity_server::narrowphase
