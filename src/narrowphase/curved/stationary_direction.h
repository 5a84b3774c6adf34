#pragma once

#include "narrowphase/cso/simplex.h"

namespace proximity_server::narrowphase {

/// A direction n in which the support point of a curved CSO lies on the line through the origin along n. There the
/// distance has its maximum over all directions, or the depth a local minimum.
struct StationaryDirection {
  Eigen::Vector3d normal;  ///< unit, a towards b
  double height;           ///< [m] of the support plane over the origin: the depth, or minus the distance
  WitnessPoints points;    ///< on_a - on_b is height * normal, up to rounding
  double cos_proven;       ///< cosine of the angle of a cap (below 90 degrees) about the normal: in all directions of
                           ///< the cap the CSO reaches at least as far as `height`. 1: no cap is proven
};

/// [rad] Newton's method ends after such a step: the error that is left, about its square, is below rounding.
inline constexpr double kLastTurn = 1e-7;

/// A curvature below this part of the greatest, of either sign, is that along a ring of nearly equal depths.
inline constexpr double kRing = 0.05;

}  // namespace proximity_server::narrowphase
