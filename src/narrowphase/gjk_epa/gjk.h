#pragma once

#include "narrowphase/cso/nearest_features.h"
#include "narrowphase/cso/observer.h"
#include "narrowphase/cso/simplex.h"

#include <optional>

namespace proximity_server::narrowphase {

struct GjkResult {
  enum class Outcome : unsigned char {
    Apart,     ///< `points` are the witness points; `status` tells how good they are
    Overlap,   ///< the simplex contains the origin, within rounding or the tolerance; EPA finds the depth
    Threshold  ///< `normal` alone proves that the distance is above options.stop_above
  };
  Outcome outcome = Outcome::Apart;
  Status status = Status::Unknown;  ///< of the distance, if the outcome is Apart
  double distance = 0.0;            ///< [m] of the nearest point of the simplex
  double lower_bound = 0.0;         ///< [m] of the signed distance; proven by `normal`
  Eigen::Vector3d normal;           ///< unit, a towards b
  Simplex simplex;
  WitnessPoints points;  ///< of the distance, if the outcome is Apart
  /// True if the answer is by nearest features beside which no others are nearly as near: then only one pair of
  /// points has this distance.
  bool by_features = false;
  int iterations = 0;
};

/// Distance of two cores: finds the point of their CSO nearest to the origin.
///
/// 1. Start with `first`, the vertex of the CSO farthest along the unit vector `normal_guess`.
/// 2. The support plane at the newest vertex bounds the distance from below, the nearest point of the simplex from
///    above. Stop if the bounds are close enough, or if they decide options.stop_above or stop_below.
/// 3. Find the point of the simplex nearest to the origin, and remove the vertices that it does not need (simplex.h).
///    If the cores are polytopes, the first iteration also adds the vertices with which the last query ended.
/// 4. If the new nearest point is not nearer than the old one, the search ends: rounding prevents further progress.
///    Polytopes then take their lower bound from the best face at the newest vertex.
/// 5. Stop with an overlap if the simplex encloses the origin, or comes as near to it as rounding can tell; or if the
///    search ends by step 4 while nothing proves that the cores are apart.
/// 6. If a core is curved, let Newton's method finish from the third iteration on, if it can (refinement.h).
/// 7. Add the vertex of the CSO farthest towards the origin, and repeat from step 2.
/// 8. If options.repeatability asks for it, the converged answer about polytopes is by their nearest features
///    (nearest_features.h), if no others are nearly as near.
///
/// Error:   outcome Apart with Status::Converged: distance - lower_bound <= options.distance_tolerance, up to rounding.
/// Failure: none. A search without progress ends, and the bounds say how good the answer is.
/// Source:  Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance Between Complex Objects in
///          Three-Dimensional Space, IEEE J. Robotics and Automation 1988. The stop by the width of the bounds is from
///          van den Bergen, A Fast and Robust GJK Implementation for Collision Detection of Convex Objects, 1999.
/// Differs: the tolerance is absolute, not relative; the subalgorithm tests Voronoi regions instead of Johnson's
///          determinants; Newton's method finishes curved pairs.
template <typename Observer = Unobserved>
GjkResult gjk(Cso& cso, const Eigen::Vector3d& normal_guess, const CsoVertex& first, const Options& options,
              Observer observer = {});

/// The answer of gjk() about two polytopes whose nearest features are those with which the last query ended. Otherwise
/// nullopt.
std::optional<GjkResult> recalledFeatures(const Cso& cso, const WarmStart& warm_start, const Options& options);

}  // namespace proximity_server::narrowphase
