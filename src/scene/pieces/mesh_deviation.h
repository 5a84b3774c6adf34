#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/triangle_tree.h"

namespace proximity_server::scene {

// Mesh files hold floats or six-digit texts: a coordinate of one metre is rounded by up to 1e-6 m.
constexpr double kMeshRounding = 1e-6;

/// A convex piece with the points of the mesh that it stands for.
struct Cover {
  narrowphase::ConvexHull hull;
  std::vector<Eigen::Vector3d> points;  ///< hull is theirs, or that of more
};

/// The solid of a mesh, to measure distances from: its surface and the space that its closed parts enclose. Every call
/// may throw Effort::Exceeded.
///
/// How far a hull lies outside is searched for over its surface, first at its triangles, then where a point of the mesh
/// lies under it, then at ever smaller triangles, first where the distance may still be largest. Two facts bound the
/// distance over a triangle: it grows by no more than one walks; and the distance from one triangle of the mesh is a
/// convex function, which is nowhere larger than at the corners. So most parts that lie along the mesh are settled by
/// one look.
class MeshSolid {
 public:
  /// `surface`: all triangles, at least one; `closed`: those of the closed parts. `effort` must outlive this.
  MeshSolid(std::vector<Triangle> surface, const std::vector<Triangle>& closed, Effort& effort);

  Effort& effort() const { return effort_; }

  /// [m] from p to the surface, negative inside.
  double distance(const Eigen::Vector3d& p) const;

  /// The farthest that the surface of one of the hulls was found to lie outside of the mesh [m], at least 0; at once
  /// for all of them. No hollow with a point of the mesh in it is too small. What ends early has been proven within
  /// kMeshRounding.
  double deviationOf(const std::vector<Cover>& covers) const;

  /// Whether it was proven that these triangles lie outside by no more than `tolerance` [m]; false for nearly as much.
  /// `below`: points of the mesh under them.
  bool isWithin(double tolerance, const std::vector<Triangle>& surface,
                const std::vector<Eigen::Vector3d>& below) const;

 private:
  friend class DeviationSearch;

  TriangleTree surface_;
  EnclosedSpace inside_;
  Effort& effort_;
};

/// A hull's surface; a segment or a point as a triangle without area.
std::vector<Triangle> surfaceOf(const narrowphase::ConvexHull& hull);

/// Those of the points that are no vertices of the hull.
std::vector<Eigen::Vector3d> pointsBelow(const narrowphase::ConvexHull& hull,
                                         const std::vector<Eigen::Vector3d>& points);

/// The farthest that one of the points lies outside of the hull [m]. Distance from a convex set is a convex function,
/// so no point of a triangle lies farther than its corners.
double farthestOutside(const Cover& cover, Effort& effort);

}  // namespace proximity_server::scene
