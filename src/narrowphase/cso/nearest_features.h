#pragma once

#include "narrowphase/cso/simplex.h"

#include <array>
#include <optional>

namespace proximity_server::narrowphase {

/// The features (vertex, edge or triangle) of two polytopes that contain their nearest points, by the numbers of their
/// vertices. The face of the CSO that they span contains its point nearest to the origin.
struct NearestFeatures {
  struct Vertices {
    std::array<int, 3> numbers{};  ///< ascending
    int count = 0;
    bool has(int number) const;
    void add(int number);
  };
  Vertices a, b;

  NearestFeatures(const Cso& cso, const Simplex& simplex);
  NearestFeatures(const Cso& cso, const WarmStart& warm_start);

 private:
  void add(const Cso& cso, const WarmStart::Pair& numbers);
};

/// The distance of two cores apart, if it is that of these features, and no other features are nearly as near. Otherwise
/// nullopt.
///
/// 1. The nearest points of a vertex and a vertex, an edge or a triangle, or of two edges, by a closed form. They must
///    lie inside of the features, away from their ends.
/// 2. All vertices beside those of the features must lie behind the support planes through the nearest points. Only the
///    neighbours of the features are tested: a vertex of a convex polytope that is farther than its neighbours along a
///    direction is farther than all others.
///
/// The answer is a function of the cores and the pose alone. As no other features are nearly as near, every search that
/// converges ends at these features: so a search that is completed by this function has the same answer to the last bit,
/// with whichever simplex it began.
///
/// Error:  the bounds differ by three roundings of the CSO, or more if the features are narrow.
/// Source: Lin, Canny, A Fast Algorithm for Incremental Distance Calculation, 1991 (the nearest features of two convex
///         polyhedra, and the proof by their neighbours).
/// Differs: no Voronoi regions are stored; the support planes of the nearest points prove the features.
struct DistanceOfFeatures {
  double distance, lower_bound;  ///< [m]; lower_bound <= true distance
  Eigen::Vector3d normal;        ///< unit, a towards b
  WitnessPoints points;
};
std::optional<DistanceOfFeatures> distanceOf(const NearestFeatures& features, const Cso& cso, double tolerance);

}  // namespace proximity_server::narrowphase
