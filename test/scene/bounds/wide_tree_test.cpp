#include "scene/bounds/wide_tree.h"

#include "scene/bounds/some_boxes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace proximity_server::scene::wide_tree_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// The leaves below a node, whose bounds and those of all nodes above may not be larger than their own gap.
void expectBounds(const BoxTree& tree, const WideTree& wide, int node, const AlignedBox3d& box, double bound,
                  std::multiset<int>& items) {
  const WideTree::Lanes gaps = wide.gaps(WideTree::boxOf(box), node);
  for (int lane = 0; lane < WideTree::kLanes; ++lane) {
    const WideTree::Child& child = wide[node].children[lane];
    if (child.in_box_tree < 0) continue;
    const double gap = boxGap(box, tree[child.in_box_tree].box), below = static_cast<double>(gaps[lane]);
    EXPECT_LE(below, gap);
    const double loss = gap - below;
    const bool fits_float = gap < 1e38 && box.max().norm() < 1e38;
    EXPECT_TRUE(loss <= 4e-6 * (10.0 + std::abs(gap)) || !fits_float) << gap << " " << below;
    EXPECT_LE(bound, gap);
    if (child.node >= 0)
      expectBounds(tree, wide, child.node, box, below, items);
    else
      items.insert(tree[child.in_box_tree].item);
  }
}

void expectBoundsOf(const std::vector<AlignedBox3d>& boxes, const AlignedBox3d& box) {
  const BoxTree tree(boxes);
  std::multiset<int> items, all;
  for (std::size_t i = 0; i < boxes.size(); ++i) all.insert(static_cast<int>(i));
  expectBounds(tree, WideTree(tree), 0, box, -std::numeric_limits<double>::infinity(), items);
  EXPECT_EQ(items, all);
}

TEST(WideTree, BoundsEachItemOnceFromBelow) {
  Chance chance(1);
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 30, 100})
    for (const AlignedBox3d& box : someBoxes(10, chance)) expectBoundsOf(someBoxes(count, chance), box);
}

// The squares of these gaps overflow in float, and so do the numbers of the last box.
TEST(WideTree, BoundsGapsThatFloatCannotHold) {
  Chance chance(2);
  std::vector<AlignedBox3d> boxes = someBoxes(6, chance);
  boxes[3].translate(Vector3d(0, -1e25, 0));
  boxes[4].translate(Vector3d(1e300, 0, 0));
  boxes[5] = AlignedBox3d();
  expectBoundsOf(boxes, boxes[0]);
  expectBoundsOf(boxes, boxes[4]);
}

TEST(WideTree, TakesTheBoxesOfARefit) {
  Chance chance(3);
  BoxTree tree(someBoxes(50, chance));
  WideTree wide(tree);
  const std::vector<AlignedBox3d> moved = someBoxes(50, chance);
  tree.refit(moved);
  wide.refit(tree);
  std::multiset<int> items;
  expectBounds(tree, wide, 0, moved[7], -std::numeric_limits<double>::infinity(), items);
  EXPECT_EQ(items.size(), 50u);
}

}  // namespace proximity_server::scene::wide_tree_test
