#define PROXIMITY_LANES 4
#include "scene/bounds/wide_tree.h"

#include "scene/kernels/lane_vectors.h"
#include "scene/model/numbers.h"

#include <limits>
#include <type_traits>

namespace proximity_server::scene {

using lanes::all;
using lanes::larger;
static_assert(std::is_same_v<WideTree::Lanes, lanes::Float>);

WideTree::Box WideTree::boxOf(const Eigen::AlignedBox3d& box) {
  Box rounded;
  for (int k = 0; k < 3; ++k) {
    rounded.low[k] = roundedDown(box.min()[k]);
    rounded.high[k] = roundedUp(box.max()[k]);
  }
  return rounded;
}

WideTree::WideTree(const BoxTree& tree) {
  if (tree.empty()) return;
  add(tree, 0);
  refit(tree);
}

int WideTree::add(const BoxTree& tree, int in_box_tree) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  int count = 0;
  const auto addChild = [&](int child) {
    const int node = tree[child].isLeaf() ? -1 : add(tree, child);
    nodes_[index].children[count++] = {child, node};
  };
  if (tree[in_box_tree].isLeaf()) {
    addChild(in_box_tree);
    return static_cast<int>(index);
  }
  for (const int part : tree[in_box_tree].parts) {
    if (tree[part].isLeaf())
      addChild(part);
    else
      for (const int child : tree[part].parts) addChild(child);
  }
  return static_cast<int>(index);
}

void WideTree::refit(const BoxTree& tree) {
  for (Node& node : nodes_)
    for (int lane = 0; lane < kLanes; ++lane) {
      const int child = node.children[lane].in_box_tree;
      const Box box = boxOf(child < 0 ? Eigen::AlignedBox3d() : tree[child].box);
      for (int k = 0; k < 3; ++k) {
        node.low[k][lane] = box.low[k];
        node.high[k][lane] = box.high[k];
      }
    }
}

WideTree::Lanes WideTree::gaps(const Box& box, int node) const {
  constexpr float kLargestSquared = 1e18f;  // the squares of longer gaps overflow
  Lanes along[3];
  for (int k = 0; k < 3; ++k) along[k] = larger(nodes_[node].low[k] - box.high[k], box.low[k] - nodes_[node].high[k]);
  const Lanes longest = larger(larger(along[0], along[1]), along[2]);
  const Lanes gap = longest > kLargestSquared ? longest : lanes::fromBox(along);
  return lanes::smaller(gap - kLess * lanes::absolute(gap), all(std::numeric_limits<float>::max()));
}

}  // namespace proximity_server::scene
