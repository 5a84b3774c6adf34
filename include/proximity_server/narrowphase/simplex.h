#pragma once

#include <array>

#include "proximity_server/narrowphase/support.h"

namespace proximity_server {

/// Some of the four places of a simplex, the newest last, with the weights (positive, of any sum) of a point in them.
struct Subset {
  int size = 0;
  std::array<int, 4> places{};
  std::array<double, 4> weights{};

  int freePlace() const;
};

/// Up to four vertices of the CSO, in four places. Reducing a simplex only names the places that stay.
using Places = std::array<CsoVertex, 4>;

/// The vertices that a search ends with, and the weights of the point nearest to the origin: positive, sum 1.
struct Simplex {
  int size = 0;
  Places vertices;
  std::array<double, 4> weights;

  Simplex() = default;
  Simplex(const Places& places, const Subset& subset);
  Eigen::Vector3d pointOnA() const;
  Eigen::Vector3d pointOnB() const;
};

/// The point of a simplex nearest to the origin: -distance * normal.
struct Nearest {
  double distance;         ///< [m] not negative
  Eigen::Vector3d normal;  ///< unit, from the point to the origin: a towards b. Of a triangle it is the face normal, so
                           ///< that it stays good when the distance is lost in rounding.
  Subset subset;           ///< the smallest that has the point; all four where the origin is enclosed
  bool encloses_origin;    ///< a tetrahedron that surely holds the origin; distance and normal are then not set
};

/// Distance subalgorithm: the nearest point, and the smallest subset of the simplex that has it.
///
/// `subset` was the last answer, `newest` is the place of the vertex that came since (in an empty subset: the first);
/// only subsets with it are tried, as only they can be nearer than before.
/// Error:  the point is within a few eps of the largest vertex norm. A sign that rounding leaves open counts as
///         outside, so that "encloses" is certain and the rest is projected.
/// Source: the subsets are those of Johnson (Gilbert, Johnson, Keerthi 1988), the tests are the signed areas and
/// volumes
///         of Voronoi regions (Ericson, Real-Time Collision Detection, 2005), with all products of edges, not of
///         vertices, so that they do not cancel far from the origin.
Nearest nearestToOrigin(const Places& places, const Subset& subset, int newest);

}  // namespace proximity_server
