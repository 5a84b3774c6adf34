#pragma once

#include "proximity_server/scene/state/state.h"
#include "scene/bounds/box_tree.h"
#include "scene/state/placed_robot.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Some shapes of a state, with a tree of the boxes about those that are bounded.
class PlacedShapes {
 public:
  struct Place {
    ShapeRef ref;
    const Part& part;
    RelativePose pose;  ///< of its body in the frame of the poses
  };

  /// Takes the shapes of a state in their places. Valid until the state changes.
  void take(const State& state, const std::vector<ShapeRef>& shapes);

  bool empty() const { return bounded_.empty() && unbounded_.empty(); }
  const std::vector<Place>& unbounded() const { return unbounded_; }  ///< those with half-spaces
  const std::vector<ShapeRef>& unplaced() const { return unplaced_; }

  /// Around all that are bounded; empty if none is.
  Eigen::AlignedBox3d box() const { return bounded_.empty() ? Eigen::AlignedBox3d() : tree_[0].box; }

  /// Calls visit(place) for those that are bounded, the one with the smaller boundOf(box) first, as long as that is not
  /// above limit(), which may become smaller meanwhile.
  template <class BoundOf, class Limit, class Visit>
  void visitNearest(const BoundOf& boundOf, const Limit& limit, const Visit& visit) const {
    if (!bounded_.empty()) descend(0, boundOf(tree_[0].box), boundOf, limit, visit);
  }

 private:
  template <class BoundOf, class Limit, class Visit>
  void descend(int number, double bound, const BoundOf& boundOf, const Limit& limit, const Visit& visit) const {
    if (bound > limit()) return;
    const BoxTree::Node& node = tree_[number];
    if (node.isLeaf()) return visit(bounded_[static_cast<std::size_t>(node.item)]);
    std::array<int, 2> parts = node.parts;
    std::array<double, 2> bounds{boundOf(tree_[parts[0]].box), boundOf(tree_[parts[1]].box)};
    if (bounds[1] < bounds[0]) {
      std::swap(parts[0], parts[1]);
      std::swap(bounds[0], bounds[1]);
    }
    for (std::size_t i = 0; i < 2; ++i) descend(parts[i], bounds[i], boundOf, limit, visit);
  }

  std::vector<Place> bounded_, unbounded_;
  std::vector<ShapeRef> unplaced_;
  BoxTree tree_;  ///< the items are `bounded_`
};

}  // namespace proximity_server::scene
