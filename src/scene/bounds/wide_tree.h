#pragma once

#include "scene/bounds/box_tree.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// The boxes of a BoxTree in nodes of four, side by side in float, so that a search bounds four gaps at once.
///
/// 1. The children of a node are the grandchildren of a node of the BoxTree, or its children that are leaves.
/// 2. Boxes are rounded outwards. A gap of two of them is lowered by kLess of it; its rounding error is at most 6 u,
///    u = 2^-24.
///
/// Source: Dammertz, Hanika, Keller, Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays,
///         2008.
class WideTree {
 public:
  static constexpr int kLanes = 4;
  using Lanes = float __attribute__((vector_size(4 * kLanes)));
  static constexpr float kLess = 0x1p-20f;

  struct Child {
    int in_box_tree = -1;  ///< its node in the BoxTree; -1: there is no child
    int node = -1;         ///< its node in this tree; -1: it is a leaf
  };

  struct Node {
    Lanes low[3], high[3];
    Child children[kLanes];
  };

  /// A box whose sides are rounded outwards.
  struct Box {
    float low[3], high[3];
  };
  static Box boxOf(const Eigen::AlignedBox3d& box);

  WideTree() = default;
  explicit WideTree(const BoxTree& tree);

  /// Node 0 is the root. Its only child is a leaf if there is one item.
  const Node& operator[](int node) const { return nodes_[node]; }

  /// Takes the boxes of the tree that it was made from.
  void refit(const BoxTree& tree);

  /// [m] Lower bounds of boxGap() of a box and each child of a node. None is infinity, even to an empty box.
  Lanes gaps(const Box& box, int node) const;

 private:
  int add(const BoxTree& tree, int in_box_tree);

  std::vector<Node> nodes_;
};

}  // namespace proximity_server::scene
