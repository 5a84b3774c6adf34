#pragma once

#include <Eigen/Core>

#include <array>

namespace proximity_server::benchmark {

/// Up to four affinely independent points; `size` says how many. The last is the newest: the point of the convex hull
/// nearest to the origin lies on a part that has it, as it does in GJK.
struct PointSet {
  std::array<Eigen::Vector3d, 4> points;
  int size = 0;
};

/// The point nearest to the origin, and bit i of each point i that carries it with a positive weight.
struct NearestInSet {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  unsigned members = 0;
};

/// Johnson's subalgorithm: determinants by recursion over the subsets (Cramer's rule), each computed once per call from
/// dot products that are computed once; where rounding leaves no subset valid, the nearest of those with positive ones.
/// Source: Gilbert, Johnson, Keerthi 1988.
NearestInSet nearestByJohnson(const PointSet& set);

/// lambda = A^-1 b for every subset, A from the conditions sum lambda = 1 and (y_i - y_0) . sum lambda y = 0; the
/// nearest of those with no negative weight.
NearestInSet nearestByExplicitSolve(const PointSet& set);

/// The Voronoi regions of the parts with the newest point: the library's own. Its time includes a copy of the points
/// into the library's simplex, which a query does not make.
NearestInSet nearestByVoronoiRegions(const PointSet& set);

/// Signed volumes, areas and lengths, each compared in the coordinates in which the simplex is largest.
/// Source: Montanari, Petrinic, Barbieri, Improving the GJK Algorithm for Faster and More Reliable Distance Queries
///         Between Convex Objects, ACM Transactions on Graphics 2017. Unlike there, the end of an edge is chosen by the
///         sign.
NearestInSet nearestBySignedVolumes(const PointSet& set);

}  // namespace proximity_server::benchmark
