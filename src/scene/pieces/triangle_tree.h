#pragma once

#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

#include "scene/pieces/effort.h"

namespace proximity_server::scene {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// The point of a triangle nearest to `p`; any triangle is legal, a segment and a point too.
Eigen::Vector3d nearestPoint(const Triangle& triangle, const Eigen::Vector3d& p);

/// The same as a convex combination of the corners, so that it lies on the triangle within a few eps of the coordinates
/// and its distance from `p` is an upper bound of that of the triangle, however thin the triangle is.
Eigen::Vector3d nearestCombination(const Triangle& triangle, const Eigen::Vector3d& p);

/// Triangles in a binary tree of bounding boxes.
///
/// A node with more than four triangles is halved by their centroids along the longest of its box's edges that may be
/// split, so that both children have equally many.
struct TriangleBoxes {
  enum class SplitAxes : unsigned char { XY = 2, XYZ = 3 };

  struct Node {
    Eigen::AlignedBox3d box;
    int begin, end;  ///< its triangles
    int left = -1;   ///< its children are left and left + 1; -1: a leaf
  };

  TriangleBoxes(std::vector<Triangle> all, SplitAxes axes);

  std::vector<Triangle> triangles;
  std::vector<Node> nodes;  ///< the first one is the root

 private:
  void split(int node, SplitAxes axes);
};

/// Finds the point of some triangles that is nearest to a given one.
class TriangleTree {
 public:
  /// At least one triangle.
  explicit TriangleTree(std::vector<Triangle> triangles) : tree_(std::move(triangles), TriangleBoxes::SplitAxes::XYZ) {}

  /// The point of the triangles that is nearest to a given one.
  struct Nearest {
    Eigen::Vector3d point;
    const Triangle* triangle;  ///< the one with this point
    double distance;           ///< [m]
  };
  /// `likely`: one of the triangles, which is near if this is to be quick. May throw Effort::Exceeded.
  Nearest nearest(const Eigen::Vector3d& p, Effort& effort, const Triangle* likely = nullptr) const;

  /// Whether any of them may have a point in common with another triangle. False only where that is proven. May throw
  /// Effort::Exceeded.
  bool mayMeet(const Triangle& other, Effort& effort) const;

  /// Whether any of the triangles whose boxes reach into a box is such a one; asks until one is. May throw Effort::Exceeded.
  template <typename IsSuch>
  bool anyIn(const Eigen::AlignedBox3d& box, Effort& effort, const IsSuch& isSuch) const {
    constexpr std::size_t kStepsPerNode = 2, kStepsPerTriangle = 20;
    // Halving leaves at most 31 levels below an int's worth of triangles; each holds one sibling back.
    std::array<int, 64> pending{0};
    for (int count = 1; count > 0;) {
      const TriangleBoxes::Node& node = tree_.nodes[pending[--count]];
      effort.spend(kStepsPerNode);
      if (!node.box.intersects(box)) continue;
      if (node.left >= 0) {
        pending[count++] = node.left + 1;
        pending[count++] = node.left;
        continue;
      }
      effort.spend(kStepsPerTriangle * static_cast<std::size_t>(node.end - node.begin));
      for (int i = node.begin; i < node.end; ++i)
        if (isSuch(tree_.triangles[i])) return true;
    }
    return false;
  }

 private:
  TriangleBoxes tree_;
};

}  // namespace proximity_server::scene
