#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// [m] A lower bound of the signed distance between the contents of two boxes along the axes of one frame: the distance
/// of the boxes, or, if they overlap, minus the shortest way along an axis that separates them. Infinity if one is
/// empty.
double boxGap(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b);

/// Puts the half of the items with the smaller keys first; of equal keys, the smaller numbers. Returns the end of that
/// half.
template <typename Key>
std::vector<int>::iterator halve(std::vector<int>::iterator begin, std::vector<int>::iterator end, const Key& keyOf) {
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    const double of_a = keyOf(a), of_b = keyOf(b);
    return of_a != of_b ? of_a < of_b : a < b;
  });
  return middle;
}

/// The two parts of a node with their bounds, the smaller bound first.
template <typename BoundOf>
std::array<std::pair<double, int>, 2> smallerFirst(const std::array<int, 2>& parts, const BoundOf& boundOf) {
  const std::pair<double, int> a(boundOf(parts[0]), parts[0]), b(boundOf(parts[1]), parts[1]);
  return b.first < a.first ? std::array{b, a} : std::array{a, b};
}

/// A binary tree of boxes along the axes of one frame.
///
/// 1. Build: halve the items along the longest edge of the box of their centres, down to single items; or in a given
///    order.
/// 2. Refit: take new boxes of the same items, and fit the nodes from the leaves up. Items that are near in the tree
///    need not be near any more, so a tree that has grown too loose should be built anew, see looseness().
///
/// Source: van den Bergen, Efficient Collision Detection of Complex Deformable Models Using AABB Trees, J. Graphics
///         Tools 1997.
class BoxTree {
 public:
  /// A leaf holds one item; every other node has two children, which come after it. The root is node 0.
  struct Node {
    Eigen::AlignedBox3d box;
    int item = -1;
    std::array<int, 2> parts{-1, -1};
    bool isLeaf() const { return item >= 0; }
  };

  BoxTree() = default;

  /// Builds a tree whose items are the indices of the boxes.
  explicit BoxTree(const std::vector<Eigen::AlignedBox3d>& boxes);

  /// Builds a tree by halving a list of items in its order. The items have no boxes before refit().
  static BoxTree inOrder(std::vector<int> items);

  bool empty() const { return nodes_.empty(); }
  const Node& operator[](int node) const { return nodes_[node]; }

  /// Takes the boxes boxOf(item). An item whose box is empty is infinitely far from everything.
  template <typename BoxOf>
  void refit(const BoxOf& boxOf) {
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      Node& node = nodes_[i];
      node.box = node.isLeaf() ? boxOf(node.item) : (*this)[node.parts[0]].box.merged((*this)[node.parts[1]].box);
    }
  }
  void refit(const std::vector<Eigen::AlignedBox3d>& boxes) {
    refit([&](int item) -> const Eigen::AlignedBox3d& { return boxes[item]; });
  }

  /// Calls visit(item) for the items, the one with the smaller boundOf(box) first, as long as that is not above limit(),
  /// which may become smaller meanwhile. The bound of a box must not be above those of the boxes within it.
  template <typename BoundOf, typename Limit, typename Visit>
  void visitNearest(const BoundOf& boundOf, const Limit& limit, const Visit& visit) const {
    if (!empty() && !(boundOf((*this)[0].box) > limit())) visitBelow(0, boundOf, limit, visit);
  }

  /// The sum of the diagonals of all boxes, divided by that sum when the tree was built; at least 1.
  double looseness() const;

 private:
  template <typename BoundOf, typename Limit, typename Visit>
  void visitBelow(int number, const BoundOf& boundOf, const Limit& limit, const Visit& visit) const {
    const Node& node = (*this)[number];
    if (node.isLeaf()) return visit(node.item);
    for (const auto& [bound, part] : smallerFirst(node.parts, [&](int each) { return boundOf((*this)[each].box); }))
      if (!(bound > limit())) visitBelow(part, boundOf, limit, visit);
  }

  template <typename Halve>
  int add(std::vector<int>::iterator begin, std::vector<int>::iterator end, const Halve& halve);
  double sumOfDiagonals() const;

  std::vector<Node> nodes_;
  double built_with_ = 0.0;  ///< [m] the sum of diagonals when it was built
};

}  // namespace proximity_server::scene
