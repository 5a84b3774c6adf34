#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <vector>

#include "proximity_server/narrowphase/convex_hull.h"
#include "triangle_tree.h"

namespace proximity_server {

// Mesh files hold floats or six-digit texts: a coordinate of one metre is rounded by up to 1e-6 m.
constexpr double kMeshRounding = 1e-6;

/// The solid inside closed triangles, whichever way they overlap.
///
/// Source: crossings of a ray, counted with the sign of the triangle's side (the winding number). Two rays in
/// directions
///         that no file prefers must agree, so that one which grazes an edge turns no outside into an inside.
class EnclosedSpace {
 public:
  explicit EnclosedSpace(const std::vector<Triangle>& closed);
  bool holds(const Eigen::Vector3d& p) const;
  std::size_t size() const { return seen_[0].size(); }

 private:
  static constexpr int kRays = 2;
  /// A triangle in a frame whose z axis is the ray, with its bounds.
  struct Seen {
    Triangle corners;
    Eigen::AlignedBox3d box;
  };
  int winding(std::size_t ray, const Eigen::Vector3d& p) const;

  std::array<Eigen::Matrix3d, kRays> turns_;
  std::array<std::vector<Seen>, kRays> seen_;
};

/// [m] a deviation that is surely below, or found to be above, need not be known closer.
struct Enough {
  double below = -std::numeric_limits<double>::infinity(), above = std::numeric_limits<double>::infinity();
};

/// A mesh as something to lie far from: its surface, and the space that its closed parts enclose. Every call may throw
/// Effort::Exceeded.
class MeshSolid {
 public:
  /// `surface`: all triangles, at least one; `closed`: those of the closed parts. `effort` must outlive this.
  MeshSolid(std::vector<Triangle> surface, const std::vector<Triangle>& closed, Effort& effort);

  Effort& effort() const { return effort_; }

  /// [m] from p to the surface, negative inside.
  double distance(const Eigen::Vector3d& p) const;

  /// The farthest that the surface of a hull of `vertices` was found to lie outside of the mesh [m], at least 0.
  ///
  /// Looks at the points of the hull's surface nearest to the vertices, so that no hollow with a vertex in it is too
  /// small, then over the surface: at ever smaller triangles, first where the distance may still be largest. It grows
  /// by no more than one walks, so what ends early has been proven within kMeshRounding.
  double deviationOf(const ConvexHull& hull, const std::vector<Eigen::Vector3d>& vertices) const;

  /// Whether that is at most `tolerance` [m], which takes less.
  bool isWithin(double tolerance, const ConvexHull& hull, const std::vector<Eigen::Vector3d>& vertices) const;

 private:
  double deviationOf(const ConvexHull& hull, const std::vector<Eigen::Vector3d>& vertices, const Enough& enough) const;

  TriangleTree surface_;
  EnclosedSpace inside_;
  Effort& effort_;
};

/// The farthest that a point of the triangles was found to lie outside of every hull [m]; the same search.
double uncovered(const std::vector<Triangle>& triangles, const std::vector<ConvexHull>& hulls, Effort& effort);

}  // namespace proximity_server
