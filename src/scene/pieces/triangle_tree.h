#pragma once

#include "scene/pieces/effort.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace proximity_server::scene {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// The point of a triangle that is nearest to `p`. A triangle that is a segment or a point is legal.
Eigen::Vector3d nearestPoint(const Triangle& triangle, const Eigen::Vector3d& p);

/// The point of a triangle that is nearest to `p`, computed as a convex combination of the corners. So it lies on the
/// triangle within a few eps of the coordinates, and its distance from `p` is an upper bound of the distance of the
/// triangle, however thin the triangle is.
Eigen::Vector3d nearestCombination(const Triangle& triangle, const Eigen::Vector3d& p);

/// Triangles in a binary tree of bounding boxes.
///
/// A node with more than two triangles is divided by their centroids, along the longest edge of the box of these, where
/// the sum over both children of triangles times surface of the box is smallest: the
/// expected work of a query. Files of CAD have long thin triangles among small ones, with which children of equally many
/// triangles overlap widely.
/// Source: Wald, On fast Construction of SAH-based Bounding Volume Hierarchies, 2007 (16 bins).
struct TriangleBoxes {
  struct Node {
    Eigen::AlignedBox3d box;
    int begin, end;  ///< the range of its triangles
    int left = -1;   ///< The index of its first child; the second child is left + 1. -1: a leaf.
  };

  explicit TriangleBoxes(std::vector<Triangle> all);

  /// The triangles of another tree in its nodes, turned.
  /// Evidence: it is made in 0.15 to 0.3 of the time of a tree for rays along z only, and a ray takes 0.77 to 0.96 of the
  /// time (the four largest meshes of a Unitree G1, 2026-11).
  TriangleBoxes(const TriangleBoxes& tree, const Eigen::Matrix3d& turn);

  /// Calls look(leaf) for the leaves below boxes for which mayMatter(box) is true, until look returns true. Returns
  /// true if it did.
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

  /// Calls look(leaf) for the leaves, the nearer part of each node first. Skips nodes for which isFar is true when
  /// their turn comes; its argument is the squared distance [m^2] of the box from the point.
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
  // Each level leaves one sibling waiting. Below kMostUnequal levels nodes are halved, which ends after 31 more levels for as
  // many triangles as an int can count.
  static constexpr std::size_t kMostPending = 64;
  static constexpr int kMostUnequal = 32;

  /// Like box.squaredExteriorDistance(p), but without branches, which the processor cannot predict here.
  static double squaredDistance(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p) {
    const auto outside = [&](int i) { return std::max(std::max(box.min()[i] - p[i], p[i] - box.max()[i]), 0.0); };
    const double x = outside(0), y = outside(1), z = outside(2);
    return x * x + y * y + z * z;
  }

  void split(int node, int level);
};

/// Finds the point of some triangles that is nearest to a given one.
class TriangleTree {
 public:
  /// Needs at least one triangle.
  explicit TriangleTree(std::vector<Triangle> triangles) : tree_(std::move(triangles)) {}

  const TriangleBoxes& boxes() const { return tree_; }

  /// The point of the triangles that is nearest to a given one.
  struct Nearest {
    Eigen::Vector3d point;
    const Triangle* triangle;  ///< the triangle that contains the point
    double distance;           ///< [m]
  };
  /// The part of the distances [m] that matters to a search; the smaller it is, the quicker is the search. It ends at the
  /// first triangle found within `enough`, which need not be the nearest. If no triangle is nearer than `far`, the
  /// triangle in the result is nullptr, and its point means nothing.
  struct Range {
    double enough = 0.0, far = std::numeric_limits<double>::infinity();
  };
  /// `guess`: one of the triangles; the search is quick if it is near. May throw Effort::Exceeded.
  Nearest nearest(const Eigen::Vector3d& p, Effort& effort, const Triangle* guess, const Range& range) const;
  Nearest nearest(const Eigen::Vector3d& p, Effort& effort) const { return nearest(p, effort, nullptr, Range()); }

  /// True if any of the triangles may have a point in common with another triangle. False only if it is proven that
  /// none has. May throw Effort::Exceeded.
  bool mayMeet(const Triangle& other, Effort& effort) const;

  /// True if isSuch is true for a triangle of a leaf whose box meets `box`. Stops at the first one. May throw
  /// Effort::Exceeded.
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
