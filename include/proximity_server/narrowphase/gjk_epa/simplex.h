#pragma once

#include <array>

#include "proximity_server/narrowphase/gjk_epa/cso.h"

namespace proximity_server::narrowphase {

/// Up to four vertices of the CSO, each in a place of its own: reducing a simplex only takes the names of the places
/// that leave from `members`.
struct Simplex {
  std::array<CsoVertex, 4> places;
  unsigned members = 0;  ///< bit i: places[i] belongs to it

  bool has(int place) const { return (members >> place & 1u) != 0; }
  int freePlace() const {
    static constexpr std::array<signed char, 16> kFirstZero{0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0, 4};
    return kFirstZero[members];
  }
  CsoVertex& operator[](int place) { return places[static_cast<std::size_t>(place)]; }
  const CsoVertex& operator[](int place) const { return places[static_cast<std::size_t>(place)]; }
};

/// The point of a simplex nearest to the origin: -distance * normal().
struct Nearest {
  double distance;            ///< [m] not negative
  Eigen::Vector3d direction;  ///< of any length, from the point to the origin: a towards b. Of a triangle it is the
                              ///< face normal, so that it stays good when the distance is lost in rounding.
  double scale;          ///< 1 / |direction|; apart from it, as the next support point does not need to wait for it
  unsigned members;      ///< of the smallest part of the simplex that has the point
  bool encloses_origin;  ///< a tetrahedron that surely holds the origin; the direction is then not set

  Eigen::Vector3d normal() const { return scale * direction; }
};

/// Distance subalgorithm: the nearest point, and the smallest part of the simplex that has it.
///
/// `newest` is the place of the vertex that came since the members were reduced; only parts with it are tried, as only
/// they can be nearer than before.
/// Error:  the point is within a few eps of the largest vertex norm. A sign that rounding leaves open counts as
///         outside, so that "encloses" is certain and the rest is projected.
/// Source: the parts are those of Johnson (Gilbert, Johnson, Keerthi 1988), the tests are the signed areas and volumes
///         of Voronoi regions (Ericson, Real-Time Collision Detection, 2005), with all products of edges, not of
///         vertices, so that they do not cancel far from the origin.
Nearest nearestToOrigin(const Simplex& simplex, int newest);

/// [m] radius of a ball about the origin that a tetrahedron which encloses it surely holds; less than its true one by
/// rounding, or negative where rounding leaves everything open.
double enclosedRadius(const Simplex& tetrahedron);

/// The points on a and b that make the point of a reduced simplex (up to three members) nearest to the origin.
struct WitnessPoints {
  Eigen::Vector3d on_a, on_b;
};
WitnessPoints witnessPoints(const Simplex& simplex);

}  // namespace proximity_server::narrowphase
