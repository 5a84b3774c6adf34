#pragma once

#include "proximity_server/scene/state/state.h"
#include "scene/bounds/box_tree.h"
#include "scene/state/placed_robot.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace proximity_server::scene {

/// Some shapes of a state, with a tree of the boxes about those that are bounded.
class PlacedShapes {
 public:
  struct Place {
    ShapeRef ref;
    std::size_t number;  ///< in the list that was asked
    const Part& part;
    RelativePose pose;  ///< of its body in the frame of the poses
  };

  using All = std::vector<ShapeRef>(const RobotModel& robot, const Objects& objects);

  /// Takes the shapes of a state in their places; all() if there are none. Valid until the state changes. Does nothing if
  /// it has them already. `all` must be the same in each call.
  void take(const State& state, const std::vector<ShapeRef>& shapes, All* all);

  bool empty() const { return bounded_.empty() && unbounded_.empty(); }
  const std::vector<Place>& unbounded() const { return unbounded_; }  ///< those with half-spaces
  const std::vector<ShapeRef>& unplaced() const { return unplaced_; }

  /// Around all that are bounded; at least one must be.
  const Eigen::AlignedBox3d& box() const { return tree_[0].box; }

  /// Calls visit(place) for those that are bounded, the one with the smaller boundOf(box) first, as long as that is not
  /// above limit(), which may become smaller meanwhile.
  template <class BoundOf, class Limit, class Visit>
  void visitNearest(const BoundOf& boundOf, const Limit& limit, const Visit& visit) const {
    tree_.visitNearest(boundOf, limit, [&](int item) { visit(bounded_[static_cast<std::size_t>(item)]); });
  }

 private:
  std::uint64_t revision_ = 0;   ///< of the state
  std::vector<ShapeRef> asked_;  ///< as they were given
  std::vector<Place> bounded_, unbounded_;
  std::vector<ShapeRef> unplaced_;
  BoxTree tree_;  ///< the items are `bounded_`
};

}  // namespace proximity_server::scene
