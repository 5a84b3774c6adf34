#pragma once

#include "narrowphase/cso/simplex.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::narrowphase {

/// Two shapes with the CSO of their cores, which refers to all of them.
struct TwoCores {
  Shape a, b;
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  WarmStart warm_start = {};
  Cso cso{a, b, a_T_b, csoRounding(a, b, a_T_b), warm_start};

  TwoCores(const Shape& first, const Shape& second, const Eigen::Isometry3d& pose) : a(first), b(second), a_T_b(pose) {}
  TwoCores(const Shape& first, const Shape& second, const Eigen::Vector3d& offset)
      : TwoCores(first, second, Eigen::Isometry3d(Eigen::Translation3d(offset))) {}
  TwoCores(const TwoCores&) = delete;
  TwoCores& operator=(const TwoCores&) = delete;
};

inline Shape hullOf(const std::vector<Eigen::Vector3d>& points) { return ConvexHull(points); }
inline Shape pointAt(const Eigen::Vector3d& point) { return hullOf({point}); }

/// A box of 2 m, whose faces lie at +-1.
inline Shape cube() { return Box{{2.0, 2.0, 2.0}}; }

/// A vertex of a CSO that no shapes made: only its point counts.
inline CsoVertex vertexAt(const Eigen::Vector3d& point) { return {point, point, {0, 0}}; }

/// A simplex of these vertices in the first places.
inline Simplex simplexOf(const std::vector<CsoVertex>& vertices) {
  Simplex simplex;
  for (const CsoVertex& vertex : vertices) {
    const int place = simplex.freePlace();
    simplex[place] = vertex;
    simplex.members |= 1u << place;
  }
  return simplex;
}

}  // namespace proximity_server::narrowphase
