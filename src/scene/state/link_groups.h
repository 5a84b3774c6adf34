#pragma once

#include "proximity_server/scene/scene_model/scene_model.h"
#include "scene/bounds/box_tree.h"
#include "scene/state/placed_robot.h"

#include <vector>

namespace proximity_server::scene {

/// The links of the candidate pairs in groups of neighbours: a binary tree of boxes, built along the kinematic tree, so
/// that one bound settles many pairs.
///
/// Source: Teschner et al., Collision Detection for Deformable Objects, 2005: hierarchies that are refitted, not
///         rebuilt.
class LinkGroups {
 public:
  explicit LinkGroups(const SceneModel& model);

  /// A group is a node; the items are links. The boxes are in the frame of the poses, moved to the origin of a body.
  const BoxTree& tree() const { return tree_; }

  /// Fits the boxes to the poses. Returns false if the pose of a link is missing.
  bool refit(const PlacedRobot& robot);

  /// [m] A lower bound of the signed distance of any link of one group from any link of the other one, minus their
  /// padding.
  double gap(int a, int b) const;

  /// The index of the pair among the candidates, or -1.
  int candidate(int link_a, int link_b) const;

 private:
  std::vector<int> links_;  ///< the links of the candidates
  BoxTree tree_;
  std::vector<int> candidates_;  ///< the index of each pair of links among the candidates, or -1
  std::size_t link_count_;
  double largest_padding_ = 0.0;  ///< [m]
  double rounding_ = 0.0;         ///< [m] of a gap
};

}  // namespace proximity_server::scene
