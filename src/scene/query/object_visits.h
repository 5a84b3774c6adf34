#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "scene/model/numbers.h"
#include "scene/state/placed_robot.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

namespace proximity_server::scene {

/// Finds the pairs with objects that are near, the nearest first, without looking at the objects that are far.
///
/// A searcher is a link, an attached object, or, if pairs of free objects are checked, a moving object. Each of them
/// searches the tree of the fixed objects and the tree of the moving ones. The objects that are in no tree are few, and
/// each searcher visits all of them: attached objects, objects with a half-space, and objects that came after the tree
/// was built. A searcher with a half-space visits all objects.
///
/// 1. Search all trees from their roots, the nearer part of each node first, for about kNearest leaves. A leaf is a pair.
///    The nodes that are farther are left out, and those beyond the limit of the question are forgotten.
/// 2. The caller takes the leaves one by one. When all are taken, search what was left out for twice as many.
/// If the limit cannot become smaller, all objects within it are found in one search.
class ObjectVisits {
 public:
  /// Adapts to new objects or new poses.
  void fit(const PlacedRobot& robot);

  /// Calls enter(a, b), two parts with a < b, for each checked pair that is in no tree, and begins the search of the
  /// trees.
  template <typename Enter>
  void begin(const PlacedRobot& robot, const Enter& enter) {
    placeBoxes(robot);
    forgetSearch();
    for (const Searcher& searcher : searchers_) {
      enterWhatIsInNoTree(robot, searcher, enter);
      if (searcher.is_unbounded) continue;
      for (const Tree tree : {Tree::Fixed, Tree::Moving})
        if (const BoxTree& boxes = treeOf(tree, robot); !boxes.empty())
          leaveOut({{boxGap(searcher.box, boxes[0].box), 0, Bounded::Kind::Inner}, tree, &searcher}, kInfinity);
    }
  }

  /// Calls enter(a, b) for each checked pair that is in no tree, and for each checked pair of the trees whose boxes are
  /// within `limit` [m] of each other.
  template <typename Enter>
  void enterAllWithin(const PlacedRobot& robot, double limit, const Enter& enter) {
    placeBoxes(robot);
    forgetSearch();
    for (const Searcher& searcher : searchers_) {
      enterWhatIsInNoTree(robot, searcher, enter);
      if (searcher.is_unbounded) continue;
      searchWithin(robot, searcher, Tree::Fixed, limit, enter);
      searchWithin(robot, searcher, Tree::Moving, limit, enter);
    }
  }

  bool empty() const { return lowestBound() == kInfinity; }

  /// [m] No pair of the trees that was not taken has a smaller lower bound. Infinity if there is none within the limit.
  double lowestBound() const { return near_.empty() ? lowest_left_out_ : near_.back().lower_bound; }

  /// Takes the pair with the smallest bound, and calls enter(a, b) if it is checked. Pairs farther than `limit` [m],
  /// which must not grow from call to call, may be left out.
  template <typename Enter>
  void open(const PlacedRobot& robot, double limit, const Enter& enter) {
    if (near_.empty()) findNearest(robot, limit);
    if (near_.empty()) return;
    const NodeVisit leaf = near_.back();
    near_.pop_back();
    enterItem(robot, *leaf.searcher, leaf.tree, treeOf(leaf.tree, robot)[leaf.node].item, enter);
  }

  /// The number of checked pairs that have no distance because a pose is missing.
  std::int64_t unknownPairs() const { return unknown_pairs_; }

 private:
  enum class Tree : unsigned char { Fixed, Moving };

  struct Searcher {
    int part;
    ShapeRef ref;
    bool is_unbounded;
    Eigen::AlignedBox3d box;    ///< empty if it is unbounded, and before placeBoxes()
    WideTree::Box rounded_box;  ///< not set before placeBoxes()
  };

  /// About so many leaves are looked for first. Measured on Panda among 1000 boxes (AMD EPYC, 2026-11): in small steps a
  /// question takes 1 to 6 of them; a random state takes 10 % longer with 2, and 40 % with 24.
  static constexpr std::size_t kNearest = 8;

  /// A leaf of a BoxTree or another node of the WideTree, with a lower bound of the gap of its box.
  struct Bounded {
    double lower_bound;  ///< [m]
    int node;
    enum class Kind : unsigned char { Leaf, Inner } kind;
  };

  struct NodeVisit : Bounded {
    Tree tree;
    const Searcher* searcher;
    bool operator<(const NodeVisit& other) const {  // the nearest first
      if (lower_bound != other.lower_bound) return lower_bound < other.lower_bound;
      if (searcher != other.searcher) return searcher < other.searcher;
      return tree != other.tree ? tree < other.tree : node < other.node;
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
    const WideTree& wide = wideTreeOf(tree, robot);
    scratch_.assign(1, 0);
    while (!scratch_.empty()) {
      const int node = scratch_.back();
      scratch_.pop_back();
      const WideTree::Lanes gaps = wide.gaps(searcher.rounded_box, node);
      for (int lane = 0; lane < WideTree::kLanes; ++lane) {
        const WideTree::Child& child = wide[node].children[lane];
        if (child.in_box_tree < 0 || static_cast<double>(gaps[lane]) > limit) continue;
        if (child.node >= 0)
          scratch_.push_back(child.node);
        else if (const BoxTree::Node& leaf = boxes[child.in_box_tree]; !(boxGap(searcher.box, leaf.box) > limit))
          enterItem(robot, searcher, tree, leaf.item, enter);
      }
    }
  }

  void placeBoxes(const PlacedRobot& robot);
  void forgetSearch();
  void findNearest(const PlacedRobot& robot, double limit);
  double searchBelow(const PlacedRobot& robot, const NodeVisit& start, double farthest, double limit);
  void openChildren(const PlacedRobot& robot, const NodeVisit& parent, double farthest, double limit);
  void leaveOut(const NodeVisit& visit, double limit);
  double keepNearest(double limit);
  void addSearcher(const PlacedRobot& robot, int part);
  void fitMoving(const PlacedRobot& robot);
  void countUnknown(const PlacedRobot& robot);
  int objectOf(Tree tree, int item, const PlacedRobot& robot) const;
  const BoxTree& treeOf(Tree tree, const PlacedRobot& robot) const {
    return tree == Tree::Fixed ? robot.objects()->fixed().tree() : moving_tree_;
  }
  const WideTree& wideTreeOf(Tree tree, const PlacedRobot& robot) const {
    return tree == Tree::Fixed ? robot.objects()->fixed().wideTree() : moving_wide_tree_;
  }

  std::vector<Searcher> searchers_;  ///< the searchers whose pose is known
  std::vector<int> attached_;        ///< the numbers of the attached objects
  std::vector<int> moving_;          ///< the numbers of the objects in the tree of moving objects
  std::vector<int> missing_;         ///< the numbers of the objects whose pose is missing
  std::vector<int> scratch_;
  std::vector<Eigen::AlignedBox3d> moving_boxes_;
  BoxTree moving_tree_;
  WideTree moving_wide_tree_;
  bool are_boxes_placed_ = false;
  std::vector<NodeVisit> near_;         ///< leaves that were found and not taken, with their gaps, the nearest last
  std::vector<NodeVisit> left_out_;     ///< nodes that are not nearer than these, in no order
  double lowest_left_out_ = kInfinity;  ///< [m]
  std::vector<NodeVisit> starts_;       ///< of the current search
  std::vector<Bounded> open_;           ///< of the current search below one of them, the next one last
  std::size_t most_ = kNearest;         ///< about as many leaves are looked for next
  std::int64_t unknown_pairs_ = 0;
};

/// True if a pair of parts with an object is checked. False if the object does not exist.
bool isCheckedPair(const PlacedRobot& robot, int a, int b);

}  // namespace proximity_server::scene
