#pragma once

#include "narrowphase/cso/simplex.h"

#include <optional>

namespace proximity_server::narrowphase {

/// The distance of two polytopes apart by their nearest features: the vertex, edge or triangle of each that contains
/// its nearest point.
struct DistanceOfFeatures {
  double distance, lower_bound;  ///< [m]; lower_bound <= true distance
  Eigen::Vector3d normal;        ///< unit, a towards b
  WitnessPoints points;
};

/// The distance of two cores, if their nearest features are the ones of the simplex with which the last query ended,
/// and no other features are nearly as near. Otherwise nullopt.
///
/// 1. The nearest points of a vertex and a vertex, an edge or a triangle, or of two edges, by a closed form. They must
///    lie inside of the features, away from their ends.
/// 2. All vertices beside the features must lie behind the support planes through the nearest points. Only the
///    neighbours of the features are tested: a vertex of a convex polytope that is farther than its neighbours along a
///    direction is farther than all others.
///
/// The answer is a function of the cores and the pose alone. As no other features are nearly as near, every search
/// that converges ends at these features: so a search that is completed by this function has the same answer to the
/// last bit, with whichever simplex it began.
///
/// Error:  the bounds differ by little more than two roundings of the CSO, see csoRounding(), if no feature is narrow.
/// Source: Lin, Canny, A Fast Algorithm for Incremental Distance Calculation, 1991 (the nearest features of two convex
///         polyhedra, and the proof by their neighbours).
/// Differs: no Voronoi regions are stored; the support planes of the nearest points prove the features.
std::optional<DistanceOfFeatures> distanceOfFeatures(const Cso& cso, const WarmStart& last, double tolerance);

}  // namespace proximity_server::narrowphase
