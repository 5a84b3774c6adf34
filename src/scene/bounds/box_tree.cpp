#include "scene/bounds/box_tree.h"

#include "scene/bounds/bounds.h"

#include <numeric>

namespace proximity_server::scene {

using Eigen::AlignedBox3d;

double boxGap(const AlignedBox3d& a, const AlignedBox3d& b) {
  const Eigen::Vector3d gaps = (b.min() - a.max()).cwiseMax(a.min() - b.max());
  const double largest = gaps.maxCoeff();
  // Written as products, so that infinity stays infinity.
  return largest > 0.0 ? (1.0 - kPoseRounding) * gaps.cwiseMax(0.0).norm() : (1.0 + kPoseRounding) * largest;
}

BoxTree::BoxTree(const std::vector<AlignedBox3d>& boxes) {
  if (boxes.empty()) return;
  const auto twiceTheCentre = [&](int item) -> Eigen::Vector3d {
    const AlignedBox3d& box = boxes[item];
    return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.min() + box.max());
  };
  std::vector<int> items(boxes.size());
  std::iota(items.begin(), items.end(), 0);
  nodes_.reserve(2 * boxes.size() - 1);
  add(items.begin(), items.end(), [&](auto begin, auto end) {
    AlignedBox3d centres;
    for (auto item = begin; item != end; ++item) centres.extend(twiceTheCentre(*item));
    Eigen::Index longest = 0;
    centres.sizes().maxCoeff(&longest);
    return halve(begin, end, [&](int item) { return twiceTheCentre(item)[longest]; });
  });
  refit(boxes);
  built_with_ = sumOfDiagonals();
}

BoxTree BoxTree::inOrder(std::vector<int> items) {
  BoxTree tree;
  if (!items.empty())
    tree.add(items.begin(), items.end(), [](auto begin, auto end) { return begin + (end - begin) / 2; });
  return tree;
}

template <typename Halve>
int BoxTree::add(std::vector<int>::iterator begin, std::vector<int>::iterator end, const Halve& halve) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  if (end - begin == 1) {
    nodes_[index].item = *begin;
  } else {
    const auto middle = halve(begin, end);
    const int first = add(begin, middle, halve), second = add(middle, end, halve);
    nodes_[index].parts = {first, second};
  }
  return static_cast<int>(index);
}

double BoxTree::sumOfDiagonals() const {
  double sum = 0.0;
  for (const Node& node : nodes_)
    if (!node.box.isEmpty()) sum += node.box.diagonal().norm();
  return sum;
}

double BoxTree::looseness() const {
  const double sum = sumOfDiagonals();
  return sum > built_with_ ? sum / built_with_ : 1.0;  // infinity if all boxes were empty when it was built
}

}  // namespace proximity_server::scene
