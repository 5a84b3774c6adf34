#pragma once

#include "oracle/oracle.h"

namespace proximity_server::narrowphase {

/// A reference for many poses: microseconds instead of the milliseconds of the branch and bound.
struct RefinedTruth {
  long double distance;     ///< [m] signed, with margins
  long double error_bound;  ///< the truth lies in [distance, distance + error_bound]; infinite where that is not proven
};

/// The signed distance in long double, found from a direction that is nearly right.
///
/// Cores apart: proven. GJK on coreSupport: the distance is what the support plane of a direction leaves, the error
///              bound ends at the norm of a convex combination of CSO points.
/// Overlapping: a local optimum. gapAlong(n) of any n is a lower bound of the signed distance, so `distance` is one,
///              and it is the largest near `normal`; nothing says that no other direction is better.
/// Method:      in overlap b is moved along n_k until the cores are apart by the shift; the axis of their distance is
///              n_(k+1). As it maximises gapAlong(n) + shift n . n_k, no step makes the gap smaller.
RefinedTruth refinedTruth(const ShapePair& pair, const Eigen::Vector3d& normal, double distance);

}  // namespace proximity_server::narrowphase
