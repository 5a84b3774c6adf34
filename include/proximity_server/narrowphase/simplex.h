#pragma once

#include <array>

#include "proximity_server/narrowphase/support.h"

namespace proximity_server {

/// Up to four vertices of the CSO. After reduceToNearest the weights are the barycentric coordinates of the point
/// nearest to the origin: positive, sum 1.
struct Simplex {
  int size = 0;
  std::array<CsoVertex, 4> vertices;
  std::array<double, 4> weights;

  void add(const CsoVertex& w) { vertices[static_cast<std::size_t>(size++)] = w; }
  bool contains(const CsoVertex& w) const;
  Eigen::Vector3d pointOnA() const;
  Eigen::Vector3d pointOnB() const;
};

/// The point of a simplex nearest to the origin: -distance * normal.
struct Nearest {
  double distance;         ///< [m] not negative
  Eigen::Vector3d normal;  ///< unit, from the point to the origin: a towards b. Of a triangle it is the face normal, so
                           ///< that it stays good when the distance is lost in rounding.
  bool encloses_origin;    ///< a tetrahedron that surely holds the origin; the other members are then not set
};

/// Distance subalgorithm: the nearest point, and the smallest subset of the simplex that has it.
///
/// The last vertex is the newest; only subsets with it are tried, as only they can be nearer than before.
/// Error:  the point is within a few eps of the largest vertex norm. A sign that rounding leaves open counts as
///         outside, so that "encloses" is certain and the rest is projected.
/// Source: the subsets are those of Johnson (Gilbert, Johnson, Keerthi 1988), the tests are the signed areas and
/// volumes
///         of Voronoi regions (Ericson, Real-Time Collision Detection, 2005), with all products of edges, not of
///         vertices, so that they do not cancel far from the origin.
Nearest reduceToNearest(Simplex& simplex);

}  // namespace proximity_server
