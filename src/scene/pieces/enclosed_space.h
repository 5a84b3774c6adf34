#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "scene/pieces/triangle_tree.h"

namespace proximity_server::scene {

/// The solid inside closed triangles, whichever way they overlap.
///
/// Source: crossings of a ray, counted with the sign of the triangle's side (the winding number). Two rays in
///         directions that no file prefers must agree, so that one which grazes an edge turns no outside into an
///         inside. A tree of boxes for each direction finds the triangles that a ray may cross.
class EnclosedSpace {
 public:
  explicit EnclosedSpace(const std::vector<Triangle>& closed);

  /// May throw Effort::Exceeded.
  bool holds(const Eigen::Vector3d& p, Effort& effort) const;

 private:
  /// The triangles in a frame whose z axis is the ray, which begins at a point and goes up.
  class View {
   public:
    View(const Eigen::Matrix3d& turn, const std::vector<Triangle>& closed);
    int winding(const Eigen::Vector3d& p, Effort& effort) const;

   private:
    struct Node {
      Eigen::AlignedBox3d box;
      int begin, end;  // its triangles
      int left = -1;   // its children are left and left + 1; -1: a leaf
    };
    void split(int node);

    Eigen::Matrix3d turn_;
    std::vector<Triangle> triangles_;
    std::vector<Node> nodes_;
  };

  std::array<View, 2> views_;
};

}  // namespace proximity_server::scene
