#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

/// Signed distance between two convex shapes, with a witness point on each.
///
/// 1. Separate each shape into a core and a margin, and add the margins to the thresholds of the options.
/// 2. If the distance of the cores has a formula, evaluate it: points and segments, a point and a box
///    (points_segments.h), solids of revolution about parallel axes (parallel_axes.h).
/// 3. Otherwise take the first vertex of the CSO (cso.h), along the axis of the warm start or from centre to centre. If
///    it does not decide the threshold, see whether the balls inside of both cores do: the cores are not farther from
///    each other than these. Two boxes are tested by their fifteen axes if their support planes along this direction
///    leave open whether they overlap, and answered by their nearest points if they are apart (boxes.h).
/// 4. Otherwise find the distance by GJK (gjk.h), if the cores overlap, the depth by EPA (epa.h). Two polytopes with
///    a warm start need no GJK while their nearest features stay (nearest_features.h). If it has a WarmPolytope,
///    they begin with EPA while that proves an overlap.
/// 5. Move both points outwards along the normal by the margins.
/// 6. Set the status by the final bounds: here only is it decided whether they meet the tolerance or a threshold. If a
///    threshold ended the search, or lies between bounds that are wider than the tolerance, and the final bounds do not
///    decide it, search again without the threshold.
/// 7. If that leaves the answer open, and a hull lies thousands of its sizes away from the origin of its frame, search
///    again with the hull moved to that origin (Shape::nearOrigin()): its place, which fills the bounds with rounding,
///    is taken out exactly.
/// 8. Look whether the shapes meet along an edge or a face: the points are then one choice of many.
/// Frame:     the frame of `a`; `a_T_b` maps coordinates of b into a. Metres.
/// Pose:      a rotation and a translation. Axes that are a rotation within 7e-15 are used unchanged; axes of single
///            precision, within 2e-6, are replaced by the nearest rotation (rigidPose()).
/// Sign:      see SignedDistance.
/// Error:     status Converged: within options.distance_tolerance. Otherwise the truth still lies in
///            [lower_bound, upper_bound].
/// Failure:   never throws, allocates or logs; shapes were validated when they were made. A pose that is not finite, or
///            whose axes are no rotation (scaled, mirrored, zero), or lengths that add up to more than 1e30 m or less
///            than 1e-30 m, give Status::Unknown. A tolerance that is NaN counts as 0.
/// Source:    Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance Between Complex Objects in
///            Three-Dimensional Space, IEEE J. Robotics and Automation 1988; van den Bergen, Proximity Queries and
///            Penetration Depth Computation on 3D Game Objects, GDC 2001.
/// Differs:   GJK and EPA see cores only, margins are exact; each answer has proven bounds; curved cores are finished
///            by Newton's method. See gjk.h, epa.h and refinement.h.
SignedDistance signedDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b,
                              const Options& options = {});

/// For a series of queries of the same two shapes: begins with the state that the last query left in `warm_start`, and
/// updates it. If that does not converge, it begins anew without it. Options::repeatability tells how far the digits of
/// the answer may depend on it.
SignedDistance signedDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start);

struct QueryTrace;

/// Writes into `trace` what each step of the search did (cso/query_trace.h). The answer has the same bits; the trace
/// allocates.
SignedDistance signedDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start, QueryTrace& trace);

}  // namespace proximity_server::narrowphase
