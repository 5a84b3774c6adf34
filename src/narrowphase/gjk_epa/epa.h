#pragma once

#include "narrowphase/cso/observer.h"
#include "narrowphase/cso/simplex.h"

#include <optional>

namespace proximity_server::narrowphase {

/// How deep two cores overlap. A depth may be negative by rounding if the cores only touch.
struct EpaResult {
  Status status = Status::Unknown;
  double depth = 0.0;        ///< [m] moving b by depth * normal makes the cores touch: an upper bound, up to rounding
  double lower_bound = 0.0;  ///< [m] of the depth: proven by the polytope, by caps, or by a solid inside
  bool has_normal = false;   ///< false: lower_bound alone decided options.stop_below; depth and normal are not set
  Eigen::Vector3d normal;    ///< unit, a towards b: the direction in which b leaves
  bool has_points = false;   ///< false: no point of the CSO's surface along the normal is known
  Eigen::Vector3d point_a;   ///< point_a - point_b is the depth along the normal, within the width of the bounds
  Eigen::Vector3d point_b;
  bool unique = true;  ///< false: another direction has the same depth
  int iterations = 0;
};

/// Penetration depth by the expanding polytope algorithm, from a simplex of any dimension that contains the origin
/// within rounding (or the tolerance).
///
/// 1. If the simplex is a tetrahedron and the ball that it surely contains decides options.stop_below, stop.
/// 2. Extend the simplex to a tetrahedron (epa_start.h). If the CSO has no volume, or if the origin lies on its
///    surface, the answer is a support plane through the origin, and the search ends.
/// 3. Take the face of the polytope closest to the origin: its distance is a lower bound of the depth. Skip the faces
///    whose directions step 5 has proven to be no shallower than the best one.
/// 4. Find the vertex w of the CSO farthest along the normal of the face: the depth along this normal is an upper
///    bound. Keep the shallowest direction. Stop if the bounds are close enough, or if they decide a threshold.
/// 5. If a core is curved and the face is near its support plane, refine the normal by Newton's method (refinement.h),
///    and look after some expansions whether an ellipsoid inside of the CSO proves the refined depth
///    (inner_ellipsoid.h). Solids of revolution about nearly parallel axes have a lower bound from the start
///    (depthOfTiltedAxes() in parallel_axes.h), and after many expansions, cores that are round about such axes, and
///    needles in round cores, are searched by patches of directions (depth_about_axis.h). Repeat from step 3 if a cap
///    proves the directions about the face.
/// 6. Replace all faces that w sees by triangles from w to their horizon (polytope.h), and repeat from step 3.
/// 7. At the end, the witness points are the ones of the face that the ray from the origin along the normal leaves
///    through, or if rounding hides this face, the nearest ones of a face or of GJK's simplex.
///
/// A query of two polytopes may also begin with the polytope that the last one has kept (WarmPolytope): step 3 follows
/// if it still surrounds the origin, and without GJK.
///
/// Error:   Converged: depth - lower_bound <= options.distance_tolerance, up to rounding. On polytopes the last face is
///          a face of the CSO itself, so only rounding is left.
/// Failure: none; no allocation. A CSO without volume has depth 0 in the direction across it.
/// Source:  van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001.
/// Differs: every visible face is deleted instead of splitting edges, which leaves fewer slivers and needs no repair;
///          Newton's method, its proven caps and solids inside of the CSO finish curved pairs.
template <typename Observer = Unobserved>
EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options, Observer observer = {});

/// The depth by EPA, begun with the polytope that the last query of two polytopes has kept, and without GJK. The warm
/// start must have a WarmPolytope. `w` is the vertex of the CSO farthest along the unit vector `normal`. Returns
/// nullopt if no polytope was kept, if it does not surround the origin in the present pose, or if it leads to no
/// answer; then it is not kept any more.
template <typename Observer = Unobserved>
std::optional<EpaResult> epaRecalled(Cso& cso, const Eigen::Vector3d& normal, const CsoVertex& w,
                                     const Options& options, Observer observer = {});

}  // namespace proximity_server::narrowphase
