#include "scene/bounds/box_tree.h"

#include "scene/bounds/some_boxes.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace proximity_server::scene::box_tree_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// The items below a node, whose box has to hold theirs.
std::vector<int> itemsOf(const BoxTree& tree, int node, const std::vector<AlignedBox3d>& boxes) {
  const BoxTree::Node& here = tree[node];
  std::vector<int> items;
  if (here.isLeaf()) {
    items.push_back(here.item);
  } else {
    for (const int part : here.parts) {
      EXPECT_GT(part, node);
      const std::vector<int> of_part = itemsOf(tree, part, boxes);
      items.insert(items.end(), of_part.begin(), of_part.end());
    }
  }
  for (const int item : items) EXPECT_TRUE(here.box.contains(boxes[item]));
  return items;
}

void expectHoldsAll(const BoxTree& tree, const std::vector<AlignedBox3d>& boxes) {
  std::vector<int> items = itemsOf(tree, 0, boxes);
  std::sort(items.begin(), items.end());
  ASSERT_EQ(items.size(), boxes.size());
  for (int i = 0; i < static_cast<int>(items.size()); ++i) EXPECT_EQ(items[i], i);
}

AlignedBox3d cube(double x, double y, double z) { return {Vector3d(x, y, z), Vector3d(x + 1, y + 1, z + 1)}; }

TEST(BoxGap, IsTheDistanceOfBoxesThatLieApart) {
  EXPECT_NEAR(boxGap(cube(0, 0, 0), cube(3, 0.5, -0.5)), 2.0, 1e-12);
  EXPECT_NEAR(boxGap(cube(3, 0.5, -0.5), cube(0, 0, 0)), 2.0, 1e-12);
  EXPECT_NEAR(boxGap(cube(0, 0, 0), cube(-4, 5, 0)), 5.0, 1e-12);  // 3 and 4
  EXPECT_LE(boxGap(cube(0, 0, 0), cube(3, 0.5, -0.5)), 2.0);
}

TEST(BoxGap, IsMinusTheShortestWayAlongAnAxisThatSeparatesBoxesInOverlap) {
  EXPECT_NEAR(boxGap(cube(0, 0, 0), cube(0.25, -0.75, 0.5)), -0.25, 1e-12);  // overlaps of 0.75, 0.25 and 0.5
  EXPECT_LE(boxGap(cube(0, 0, 0), cube(0.25, -0.75, 0.5)), -0.25);
}

TEST(BoxGap, IsInfiniteToABoxWithoutAPlace) {
  EXPECT_EQ(boxGap(cube(0, 0, 0), AlignedBox3d()), std::numeric_limits<double>::infinity());
  EXPECT_EQ(boxGap(AlignedBox3d(), cube(0, 0, 0)), std::numeric_limits<double>::infinity());
}

TEST(BoxTree, OfNothingIsEmpty) { EXPECT_TRUE(BoxTree(std::vector<AlignedBox3d>()).empty()); }

TEST(BoxTree, HoldsEachItemOnceAndItsBoxInAllNodesAbove) {
  Chance chance(1);
  for (const int count : {1, 2, 3, 17, 200}) {
    const std::vector<AlignedBox3d> boxes = someBoxes(count, chance);
    expectHoldsAll(BoxTree(boxes), boxes);
  }
}

TEST(BoxTree, InOrderKeepsTheItemsAsListed) {
  const std::vector<int> items{4, 0, 3, 1, 2};
  Chance chance(4);
  const std::vector<AlignedBox3d> boxes = someBoxes(5, chance);
  BoxTree tree = BoxTree::inOrder(items);
  tree.refit(boxes);
  EXPECT_EQ(itemsOf(tree, 0, boxes), items);
  EXPECT_TRUE(BoxTree::inOrder({}).empty());
}

TEST(BoxTree, HoldsItemsThatStandInOnePlace) {
  const std::vector<AlignedBox3d> boxes(9, AlignedBox3d(Vector3d(0, 0, 0), Vector3d(1, 1, 1)));
  expectHoldsAll(BoxTree(boxes), boxes);
}

TEST(BoxTree, HoldsTheItemsWhereTheyAreAfterARefit) {
  Chance chance(2);
  BoxTree tree(someBoxes(50, chance));
  const std::vector<AlignedBox3d> moved = someBoxes(50, chance);
  tree.refit(moved);
  expectHoldsAll(tree, moved);
}

TEST(BoxTree, IsLooseAfterItsItemsHaveMixed) {
  Chance chance(3);
  BoxTree tree(someBoxes(50, chance));
  EXPECT_EQ(tree.looseness(), 1.0);
  tree.refit(someBoxes(50, chance));
  EXPECT_GT(tree.looseness(), 1.5);
}

TEST(BoxTree, PutsAnItemWithoutAPlaceInfinitelyFarAway) {
  const BoxTree tree(std::vector<AlignedBox3d>{{Vector3d(0, 0, 0), Vector3d(1, 1, 1)}, AlignedBox3d()});
  EXPECT_EQ(tree[0].box.max(), Vector3d(1, 1, 1));
  for (const int part : tree[0].parts) {
    const BoxTree::Node& leaf = tree[part];
    const double gap = boxGap(leaf.box, cube(2, 0, 0));
    EXPECT_NEAR(std::min(gap, 9.0), leaf.item == 0 ? 1.0 : 9.0, 1e-12);
  }
}

TEST(BoxTree, VisitsTheItemsWithinALimitThatShrinks) {
  std::vector<AlignedBox3d> boxes;
  for (const double x : {9.0, 1.0, 5.0, 3.0, 7.0}) boxes.push_back(cube(x, 0, 0));
  boxes.emplace_back();
  const BoxTree tree(boxes);
  const auto distance = [](const AlignedBox3d& box) { return box.exteriorDistance(Vector3d(4.5, 0.5, 0.5)); };
  const double infinity = std::numeric_limits<double>::infinity();
  const auto itemsWithin = [&](double limit, double shrunk) {
    std::vector<int> items;
    tree.visitNearest(
        distance, [&] { return items.empty() ? limit : shrunk; }, [&](int item) { items.push_back(item); });
    std::sort(items.begin(), items.end());
    return items;
  };
  EXPECT_EQ(itemsWithin(2.5, 2.5), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(itemsWithin(100.0, 100.0), (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_EQ(itemsWithin(infinity, infinity).size(), 6U) << "the empty box is infinitely far away";
  EXPECT_EQ(itemsWithin(2.5, 0.25).size(), 1U) << "one of the two that are 0.5 m away";
  EXPECT_EQ(itemsWithin(0.25, 0.25).size(), 0U);
  BoxTree().visitNearest(
      distance, [] { return 1.0; }, [](int) { ADD_FAILURE(); });
}

}  // namespace proximity_server::scene::box_tree_test
