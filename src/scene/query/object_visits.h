#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "scene/bounds/heap.h"
#include "scene/parts/placed_robot.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Finds the pairs with objects that are near, the nearest first, without looking at the objects that are far.
///
/// A searcher is a link, an attached object, or, if pairs of free objects are checked, a moving object. Each of them
/// searches the tree of the fixed objects and that of the moving ones. The objects that are in no tree are few, and
/// each searcher visits all of them: attached objects, objects with a half-space, and objects that came after the tree
/// was built. A searcher with a half-space visits all objects.
///
/// 1. Enter each searcher with the root of each tree into a queue.
/// 2. Take the node with the smallest lower bound, and go down to its nearer part while no other node is nearer; the
///    other part enters the queue. A leaf is a pair. A node beyond the limit of the question is left out.
/// If the limit cannot become smaller, all objects within it are found in one search without a queue.
class ObjectVisits {
 public:
  /// Adapts to new objects or new poses.
  void fit(const PlacedRobot& robot);

  /// Calls enter(a, b), two parts with a < b, for each checked pair that is in no tree, and puts the searchers with the
  /// roots of the trees into the queue. Pairs farther than `limit` [m] may be left out.
  template <typename Enter>
  void begin(const PlacedRobot& robot, double limit, const Enter& enter) {
    queue_.clear();
    for (const Searcher& searcher : searchers_) {
      enterWhatIsInNoTree(robot, searcher, enter);
      if (searcher.is_unbounded) continue;
      for (const Tree tree : {Tree::Fixed, Tree::Moving})
        if (const BoxTree& boxes = treeOf(tree, robot); !boxes.empty())
          push({boxGap(searcher.box, boxes[0].box), &searcher, 0, tree}, limit);
    }
  }

  /// Calls enter(a, b) for each checked pair that is in no tree, and for each checked pair of the trees whose boxes are
  /// within `limit` [m] of each other.
  template <typename Enter>
  void enterAllWithin(const PlacedRobot& robot, double limit, const Enter& enter) {
    queue_.clear();
    for (const Searcher& searcher : searchers_) {
      enterWhatIsInNoTree(robot, searcher, enter);
      if (searcher.is_unbounded) continue;
      searchWithin(robot, searcher, Tree::Fixed, limit, enter);
      searchWithin(robot, searcher, Tree::Moving, limit, enter);
    }
  }

  bool empty() const { return queue_.empty(); }

  /// [m] The smallest lower bound in the queue; infinity if the queue is empty.
  double lowestBound() const {
    return queue_.empty() ? std::numeric_limits<double>::infinity() : queue_.first().lower_bound;
  }

  /// Takes the node with the smallest bound and opens it. Calls enter(a, b) if it ends at a checked pair.
  template <typename Enter>
  void open(const PlacedRobot& robot, double limit, const Enter& enter) {
    NodeVisit visit = queue_.pop();
    const BoxTree& boxes = treeOf(visit.tree, robot);
    const Searcher& searcher = *visit.searcher;
    while (!boxes[visit.node].isLeaf()) {
      NodeVisit near = visit, far = visit;
      near.node = boxes[visit.node].parts[0];
      far.node = boxes[visit.node].parts[1];
      near.lower_bound = boxGap(searcher.box, boxes[near.node].box);
      far.lower_bound = boxGap(searcher.box, boxes[far.node].box);
      if (far.lower_bound < near.lower_bound) std::swap(near, far);
      push(far, limit);
      if (near.lower_bound > std::min(limit, lowestBound())) return push(near, limit);
      visit = near;
    }
    enterItem(robot, searcher, visit.tree, boxes[visit.node].item, enter);
  }

  /// The number of checked pairs that have no distance because a pose is missing.
  std::int64_t unknownPairs() const { return unknown_pairs_; }

 private:
  enum class Tree : unsigned char { Fixed, Moving };

  struct Searcher {
    int part;
    ShapeRef ref;
    bool is_unbounded;
    Eigen::AlignedBox3d box;  ///< empty if it is unbounded
  };

  struct NodeVisit {
    double lower_bound;  ///< [m]
    const Searcher* searcher;
    int node;
    Tree tree;
    bool operator<(const NodeVisit& other) const {
      if (lower_bound != other.lower_bound) return lower_bound > other.lower_bound;
      if (searcher != other.searcher) return searcher > other.searcher;
      return tree != other.tree ? tree > other.tree : node > other.node;
    }
  };

  template <typename Enter>
  void enterObject(const PlacedRobot& robot, const Searcher& searcher, int number, const Enter& enter) {
    const int object = robot.numberOfObject(number);
    if (robot.objects()->isCheckedBy(searcher.ref, number) && robot.isPlaced(object))
      enter(std::min(searcher.part, object), std::max(searcher.part, object));
  }

  template <typename Enter>
  void enterWhatIsInNoTree(const PlacedRobot& robot, const Searcher& searcher, const Enter& enter) {
    const auto enterAll = [&](const std::vector<int>& numbers) {
      for (const int number : numbers) enterObject(robot, searcher, number, enter);
    };
    if (searcher.is_unbounded) return enterAll(robot.objects()->numbers());
    enterAll(robot.objects()->fixed().loose());
    enterAll(robot.objects()->unbounded());
    enterAll(attached_);
  }

  template <typename Enter>
  void enterItem(const PlacedRobot& robot, const Searcher& searcher, Tree tree, int item, const Enter& enter) {
    const int number = objectOf(tree, item, robot);
    if (number >= 0) enterObject(robot, searcher, number, enter);
  }

  template <typename Enter>
  void searchWithin(const PlacedRobot& robot, const Searcher& searcher, Tree tree, double limit, const Enter& enter) {
    const BoxTree& boxes = treeOf(tree, robot);
    if (boxes.empty()) return;
    scratch_.assign(1, 0);
    while (!scratch_.empty()) {
      const BoxTree::Node& node = boxes[scratch_.back()];
      scratch_.pop_back();
      if (boxGap(searcher.box, node.box) > limit) continue;
      if (node.isLeaf())
        enterItem(robot, searcher, tree, node.item, enter);
      else
        scratch_.insert(scratch_.end(), std::begin(node.parts), std::end(node.parts));
    }
  }

  void push(const NodeVisit& visit, double limit) {
    if (!(visit.lower_bound > limit)) queue_.push(visit);
  }
  void addSearcher(const PlacedRobot& robot, int part);
  void fitMoving(const PlacedRobot& robot);
  void countUnknown(const PlacedRobot& robot);
  int objectOf(Tree tree, int item, const PlacedRobot& robot) const;
  const BoxTree& treeOf(Tree tree, const PlacedRobot& robot) const {
    return tree == Tree::Fixed ? robot.objects()->fixed().tree() : moving_tree_;
  }

  std::vector<Searcher> searchers_;  ///< the searchers whose pose is known
  std::vector<int> attached_;        ///< the numbers of the attached objects
  std::vector<int> moving_;          ///< the numbers of the objects in the tree of moving objects
  std::vector<int> missing_;         ///< the numbers of the objects whose pose is missing
  std::vector<int> scratch_;
  std::vector<Eigen::AlignedBox3d> moving_boxes_;
  BoxTree moving_tree_;
  Heap<NodeVisit> queue_;
  std::int64_t unknown_pairs_ = 0;
};

/// True if a pair of parts with an object is checked. False if the object does not exist.
bool isCheckedPair(const PlacedRobot& robot, int a, int b);

}  // namespace proximity_server::scene
