#pragma once

#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "scene/bounds/box_tree.h"
#include "scene/parts/placed_robot.h"

namespace proximity_server::scene {

/// The links of the candidate pairs in groups of neighbours: a binary tree of boxes along the kinematic tree, so that
/// many pairs are settled at once.
///
/// Source: Teschner et al., Collision Detection for Deformable Objects, 2005: hierarchies that are refitted, not
/// rebuilt.
class LinkGroups {
 public:
  explicit LinkGroups(const SceneModel& model);

  /// A group is a node; the items are links. The boxes are in the frame of the poses, moved to the origin of a body.
  const BoxTree& tree() const { return tree_; }

  /// Fits the boxes to the poses. Returns false if the pose of a link is missing.
  bool refit(const PlacedRobot& robot);

  /// A lower bound [m] of the signed distance of any link of one from any of the other, less their padding.
  double gap(int a, int b) const;

  /// Index of the pair among the candidates, or -1.
  int candidate(int link_a, int link_b) const;

 private:
  std::vector<int> links_;  ///< of the candidates
  BoxTree tree_;
  std::vector<int> candidates_;  ///< by both links
  std::size_t link_count_;
  double largest_padding_ = 0.0;  ///< [m]
  double rounding_ = 0.0;         ///< [m] of a gap
};

}  // namespace proximity_server::scene
