#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "scene/pieces/effort.h"

namespace proximity_server::scene {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// The point of a triangle nearest to `p`; any triangle is legal, a segment and a point too.
Eigen::Vector3d nearestPoint(const Triangle& triangle, const Eigen::Vector3d& p);

/// Triangles in a tree of boxes, for the point of them nearest to a given one.
class TriangleTree {
 public:
  /// At least one triangle.
  explicit TriangleTree(std::vector<Triangle> triangles);

  /// The point of the triangles that is nearest to a given one.
  struct Nearest {
    Eigen::Vector3d point;
    const Triangle* triangle;  ///< it is a point of that one
    double distance;           ///< [m]
  };
  /// May throw Effort::Exceeded.
  Nearest nearest(const Eigen::Vector3d& p, Effort& effort) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int begin, end;  // its triangles
    int left = -1;   // its children are left and left + 1; -1: a leaf
  };
  void split(int node);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace proximity_server::scene
