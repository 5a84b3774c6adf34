#pragma once

#include "narrowphase/curved/stationary_direction.h"

#include <optional>

namespace proximity_server::narrowphase {

/// The ends of two cylinders (1: upper, -1: lower) on whose rims the points of a stationary direction lie; 0: on the
/// mantle.
struct RimEnds {
  double of_a, of_b;
};

/// True if both cores are cylinders or segments.
bool haveMantles(const Cso& cso);

struct StationaryRims {
  StationaryDirection direction;  ///< without a cap
  RimEnds ends;
};

/// The stationary direction of two cylinders, or of a cylinder and a segment, if its points lie on two rims, or on a
/// rim and a mantle. A segment is a cylinder of radius 0. This is the common case of refine(), solved for the places on
/// the rims themselves: one or two unknowns instead of a direction and weights.
///
/// 1. The ends of the cores to which the vertices of the simplex belong tell the case: one end of each for two rims;
///    both ends of one core for its mantle.
/// 2. Two rims: Newton's method for half the squared distance of two points, each at an angle on its circle.
/// 3. A rim and a mantle: Newton's method for half the squared distance of a point of the rim from the axis. The point
///    of the mantle has the same height over the axis.
/// 4. The steps end when they turn by less than 1e-7 rad.
/// 5. If the normal points away from the end of a rim, take the mantle; if the point of a mantle lies beyond an end,
///    take its rim. Repeat from step 2, four times at most.
///
/// Error:   as refine().
/// Failure: returns nullopt for other cores, if the steps meet a place where the depth has no minimum or hardly changes
///          along a ring, if they do not converge, if both points lie on mantles, or if the rim meets the axis. As for
///          refine(), only the support point along the normal proves that the case was right.
/// Source:  Eberly, Distance Between Two Circles in 3D, 2019, has the equations; Newton's method from the nearby
///          direction of GJK or EPA replaces the roots of his polynomial of degree 8.
std::optional<StationaryRims> stationaryRims(const Cso& cso, const Simplex& simplex, const Eigen::Vector3d& normal);

}  // namespace proximity_server::narrowphase
