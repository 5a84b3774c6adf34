#include "scene/objects/box_tree.h"

#include <algorithm>
#include <numeric>

#include "scene/model/bounds.h"

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
  std::vector<int> items(boxes.size());
  std::iota(items.begin(), items.end(), 0);
  nodes_.reserve(2 * boxes.size() - 1);
  add(items.begin(), items.end(), boxes);
  built_with_ = sumOfDiagonals();
}

int BoxTree::add(std::vector<int>::iterator begin, std::vector<int>::iterator end,
                 const std::vector<AlignedBox3d>& boxes) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  if (end - begin == 1) {
    nodes_[index].item = *begin;
    nodes_[index].box = boxes[static_cast<std::size_t>(*begin)];
    return static_cast<int>(index);
  }
  const auto twiceTheCentre = [&](int item) -> Eigen::Vector3d {
    const AlignedBox3d& box = boxes[static_cast<std::size_t>(item)];
    return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.min() + box.max());
  };
  AlignedBox3d centres;
  for (auto item = begin; item != end; ++item) centres.extend(twiceTheCentre(*item));
  Eigen::Index longest = 0;
  centres.sizes().maxCoeff(&longest);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    const double at_a = twiceTheCentre(a)[longest], at_b = twiceTheCentre(b)[longest];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  const int first = add(begin, middle, boxes), second = add(middle, end, boxes);
  Node& node = nodes_[index];
  node.parts[0] = first;
  node.parts[1] = second;
  node.box = (*this)[first].box.merged((*this)[second].box);
  return static_cast<int>(index);
}

void BoxTree::refit(const std::vector<AlignedBox3d>& boxes) {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    node.box = node.isLeaf() ? boxes[static_cast<std::size_t>(node.item)]
                             : (*this)[node.parts[0]].box.merged((*this)[node.parts[1]].box);
  }
}

double BoxTree::sumOfDiagonals() const {
  double sum = 0.0;
  for (const Node& node : nodes_)
    if (!node.box.isEmpty()) sum += node.box.diagonal().norm();
  return sum;
}

double BoxTree::looseness() const {
  const double sum = sumOfDiagonals();
  return sum > built_with_ ? sum / built_with_ : 1.0;  // infinity if it was built of boxes without a place
}

}  // namespace proximity_server::scene
