#pragma once

#include "proximity_server/narrowphase/cso/cso.h"

#include <array>

namespace proximity_server::narrowphase {

/// Up to four vertices of the CSO, each stored in one of four places. A vertex is removed by clearing its bit in
/// `members`; no vertex is ever moved.
struct Simplex {
  std::array<CsoVertex, 4> places;
  unsigned members = 0;  ///< bit i: places[i] is a vertex of the simplex

  bool has(int place) const { return (members >> place & 1u) != 0; }
  int freePlace() const {
    static constexpr std::array<signed char, 16> kFirstZero{0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0, 4};
    return kFirstZero[members];
  }
  CsoVertex& operator[](int place) { return places[place]; }
  const CsoVertex& operator[](int place) const { return places[place]; }
};

/// The point of a simplex nearest to the origin: -distance * normal().
struct Nearest {
  double distance;            ///< [m] not negative
  Eigen::Vector3d direction;  ///< from the point to the origin (a towards b), of any length. For a triangle it is the
                              ///< face normal, which stays accurate if the distance is lost in rounding.
  double scale;          ///< 1 / |direction|; separate, so that the next support point need not wait for the division
  unsigned members;      ///< vertices of the smallest face (vertex, edge, triangle) that contains the point
  bool encloses_origin;  ///< true: the tetrahedron surely contains the origin, and `direction` is not set

  Eigen::Vector3d normal() const { return scale * direction; }
};

/// Distance subalgorithm: finds the point of the simplex nearest to the origin, and the smallest face that contains it.
///
/// 1. One vertex: it is the nearest point.
/// 2. An edge: project the origin onto its line; outside of the edge an end is nearest.
/// 3. A triangle: the signed areas that the projection of the origin spans with the edges tell the Voronoi region; the
///    nearest point lies inside of the triangle, or on an edge at the newest vertex.
/// 4. A tetrahedron: the signed volumes tell which faces at the newest vertex have the origin on their outer side. If
///    none has, the tetrahedron encloses the origin; otherwise the nearest of the points of these faces is taken.
///
/// `newest` is the place of the vertex added since the last call. Only faces that contain it are tested, as no other
/// can be nearer than before.
///
/// Error:   the point is within a few eps of the largest vertex norm. A sign that rounding leaves open counts as
///          outside, so that encloses_origin is certain.
/// Failure: none. If the point is the origin itself, the distance is 0 and the direction arbitrary.
/// Source:  Gilbert, Johnson, Keerthi 1988 (Johnson's subalgorithm); Ericson, Real-Time Collision Detection, 2005, 5.1
///          (Voronoi regions).
/// Differs: all products are of edges, not of vertices, so that they do not cancel far from the origin.
Nearest nearestToOrigin(const Simplex& simplex, int newest);

/// [m] Radius of a ball about the origin that surely lies inside of a tetrahedron which encloses the origin. It is less
/// than the true radius by rounding, and negative if rounding leaves open whether there is such a ball.
double enclosedRadius(const Simplex& tetrahedron);

/// The points on a and b whose difference is the point of the simplex nearest to the origin. The simplex has been
/// reduced by nearestToOrigin() to at most three members.
struct WitnessPoints {
  Eigen::Vector3d on_a, on_b;
};
WitnessPoints witnessPoints(const Simplex& simplex);

/// The points on a and b whose difference is the point nearest to the origin of the triangle w a b; this may be on an
/// edge or a corner. Computes points by the face and by the edges, and takes those with the smallest difference. They
/// are accurate for a triangle without width, too, because none of them needs its normal.
WitnessPoints pointsOfTriangle(const CsoVertex& w, const CsoVertex& a, const CsoVertex& b);

}  // namespace proximity_server::narrowphase
