#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace proximity_server::scene {

/// A lower bound [m] of the signed distance of what two boxes along the axes of one frame hold: their distance, or, where
/// they overlap, minus the shortest way along an axis that separates them. Infinity if one is empty.
double boxGap(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b);

/// A binary tree of boxes along the axes of one frame.
///
/// 1. Build: halve the items along the longest edge of the box of their centres, down to single ones.
/// 2. Refit: new boxes of the same items, from the leaves up; what is near in the tree need not be near any more, so
///    that a tree which has grown too loose is better built anew, see looseness().
///
/// Source: van den Bergen, Efficient Collision Detection of Complex Deformable Models Using AABB Trees, J. Graphics
///         Tools 1997.
class BoxTree {
 public:
  /// A leaf holds one item (its index in the list of boxes), all others two nodes behind themselves. The root is node 0.
  struct Node {
    Eigen::AlignedBox3d box;
    int item = -1;
    int parts[2] = {-1, -1};
    bool isLeaf() const { return item >= 0; }
  };

  BoxTree() = default;
  explicit BoxTree(const std::vector<Eigen::AlignedBox3d>& boxes);

  bool empty() const { return nodes_.empty(); }
  const Node& operator[](int node) const { return nodes_[static_cast<std::size_t>(node)]; }

  /// An item whose box is empty is infinitely far from everything.
  void refit(const std::vector<Eigen::AlignedBox3d>& boxes);

  /// How much larger the boxes are, in the sum of their diagonals, than they were when the tree was built; at least 1.
  double looseness() const;

 private:
  int add(std::vector<int>::iterator begin, std::vector<int>::iterator end,
          const std::vector<Eigen::AlignedBox3d>& boxes);
  double sumOfDiagonals() const;

  std::vector<Node> nodes_;
  double built_with_ = 0.0;  ///< [m] sum of diagonals
};

}  // namespace proximity_server::scene
