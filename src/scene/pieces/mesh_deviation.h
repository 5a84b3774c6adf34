#pragma once

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/mesh_parts.h"
#include "scene/pieces/rooms.h"
#include "scene/pieces/triangle_tree.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A convex piece with the points of the mesh that it covers.
struct Cover {
  narrowphase::ConvexHull hull;         ///< its vertices belong to the mesh
  std::vector<Eigen::Vector3d> points;  ///< hull contains all of them
};

/// The triangles of the surface of a hull. For a segment or a point this is one triangle without area.
std::vector<Triangle> surfaceOf(const narrowphase::ConvexHull& hull);

/// The solid of a mesh, from which distances are measured: its surface and the space that its closed parts enclose.
/// Every call but roomIn() may throw Effort::Exceeded.
///
/// The largest distance of a hull outside of the mesh is searched for on the surface of the hull:
///
/// 1. Measure at the triangles of the hull, and at the points of its surface that are nearest to points of the mesh.
/// 2. Halve the triangle whose upper bound of the distance is largest, and measure at both halves.
/// 3. Three facts give the upper bound. The distance changes by no more than the length of the way along the surface;
///    the distance from one triangle of the mesh is a convex function, so it is largest at a corner; and a triangle is
///    inside if one of its points is and it does not meet the surface. Therefore most triangles of a hull that lie
///    along the mesh, or cut through it, are settled by one measurement.
class MeshSolid {
 public:
  /// `surface`: all triangles, at least one; `closed`: the triangles of the closed parts. `effort` must outlive this.
  MeshSolid(std::vector<Triangle> surface, const std::vector<Triangle>& closed, Effort& effort, Rooms rooms = {});

  Effort& effort() const { return effort_; }

  /// [m] The distance from p to the surface, negative inside.
  double distance(const Eigen::Vector3d& p) const;

  /// [m] The largest distance outside of the mesh of the surfaces of the hulls, at least 0. Every hollow that contains a
  /// point of the mesh is found, however small. If a search ends before its limit of steps, the result is proven within
  /// kMeshRounding; otherwise it is a proven upper bound.
  double deviationOf(const std::vector<Cover>& covers) const;

  /// True if the surface of a hull is proven to lie outside of the mesh by no more than `tolerance` [m]. Distances
  /// slightly below the tolerance are refused, too.
  bool isSurfaceWithin(double tolerance, const Cover& cover) const {
    return isSurfaceWithin(tolerance, cover, surfaceOf(cover.hull));
  }

  /// For some triangles of the hull's surface only.
  bool isSurfaceWithin(double tolerance, const Cover& cover, std::vector<Triangle> surface) const;

  /// Searches for the deepest room that a hull fills, if it is deeper than the deviation [m] of the hull's surface. The
  /// search ends at a room that is deeper than `tolerance` [m], or nearly so.
  Rooms::Largest roomIn(const narrowphase::ConvexHull& hull, double deviation, double tolerance) const;

 private:
  friend class DeviationSearch;

  TriangleTree surface_;
  EnclosedSpace inside_;
  Rooms rooms_;
  Effort& effort_;
};

/// True if no plane of a face of a solid hull has the point in front of it. True for every point if the hull is flat.
bool isInHull(const narrowphase::ConvexHull& hull, const Eigen::Vector3d& p);

/// Returns the points that are not vertices of the hull.
std::vector<Eigen::Vector3d> pointsBelow(const narrowphase::ConvexHull& hull,
                                         const std::vector<Eigen::Vector3d>& points);

/// [m] The largest distance outside of the hull of a point that it covers. The distance from a convex set is a convex
/// function, so no point of a triangle lies farther outside than its corners.
double farthestOutside(const Cover& cover, Effort& effort);

}  // namespace proximity_server::scene
