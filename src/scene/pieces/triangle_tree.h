#pragma once

#include <Eigen/Geometry>
#include <algorithm>
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

  /// Looks at the leaves below all boxes for which mayMatter(box), until look(leaf) returns true; returns whether one did.
  template <typename MayMatter, typename Look>
  bool anyLeaf(const MayMatter& mayMatter, const Look& look) const {
    std::array<int, kMostPending> pending{0};
    for (int count = 1; count > 0;) {
      const Node& node = nodes[pending[--count]];
      if (!mayMatter(node.box)) continue;
      if (node.left < 0) {
        if (look(node)) return true;
        continue;
      }
      pending[count++] = node.left + 1;
      pending[count++] = node.left;
    }
    return false;
  }

  /// Looks at the leaves, the nearer part of each node first, without those for which isFar(squared distance of the box from the
  /// point [m^2]) when their turn comes.
  template <typename IsFar, typename Look>
  void lookAround(const Eigen::Vector3d& p, const IsFar& isFar, const Look& look) const {
    struct Pending {
      int node;
      double squared;
    };
    const auto pendingOf = [&](int node) { return Pending{node, squaredDistance(nodes[node].box, p)}; };
    std::array<Pending, kMostPending> pending;
    pending[0] = pendingOf(0);
    for (int count = 1; count > 0;) {
      const Pending& next = pending[--count];
      if (isFar(next.squared)) continue;
      const Node& node = nodes[next.node];
      if (node.left < 0) {
        look(node);
        continue;
      }
      const Pending left = pendingOf(node.left), right = pendingOf(node.left + 1);
      const bool left_first = left.squared < right.squared;
      pending[count++] = left_first ? right : left;
      pending[count++] = left_first ? left : right;
    }
  }

  std::vector<Triangle> triangles;
  std::vector<Node> nodes;  ///< the first one is the root

 private:
  // Halving leaves at most 31 levels below an int's worth of triangles; each holds one sibling back.
  static constexpr std::size_t kMostPending = 64;

  /// box.squaredExteriorDistance(p) without branches, which no processor foretells here.
  static double squaredDistance(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p) {
    const auto outside = [&](int i) { return std::max(std::max(box.min()[i] - p[i], p[i] - box.max()[i]), 0.0); };
    const double x = outside(0), y = outside(1), z = outside(2);
    return x * x + y * y + z * z;
  }

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
    const auto reachesInto = [&](const Eigen::AlignedBox3d& other) {
      effort.spend(kStepsPerNode);
      return other.intersects(box);
    };
    return tree_.anyLeaf(reachesInto, [&](const TriangleBoxes::Node& leaf) {
      effort.spend(kStepsPerTriangle * static_cast<std::size_t>(leaf.end - leaf.begin));
      for (int i = leaf.begin; i < leaf.end; ++i)
        if (isSuch(tree_.triangles[i])) return true;
      return false;
    });
  }

 private:
  TriangleBoxes tree_;
};

}  // namespace proximity_server::scene
