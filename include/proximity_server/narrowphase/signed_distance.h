#pragma once

#include <Eigen/Geometry>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// Signed distance between two convex shapes, with a witness point on each.
///
/// Frame:     that of `a`; `a_T_b` maps coordinates of b into a. Metres.
/// Error:     status Converged: within options.distance_tolerance. Otherwise the truth still lies in
///            [lower_bound, upper_bound].
/// Failure:   never throws, allocates or logs; shapes were validated when they were made. A pose that is not finite
///            gives Status::Unknown.
/// Source:    Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance Between Complex Objects in
///            Three-Dimensional Space, IEEE J. Robotics and Automation 1988; van den Bergen, Proximity Queries and
///            Penetration Depth Computation on 3D Game Objects, GDC 2001.
SignedDistance signedDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b,
                              const Options& options = {});
SignedDistance signedDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, const Options& options,
                              WarmStart& warm_start);

}  // namespace proximity_server::narrowphase
