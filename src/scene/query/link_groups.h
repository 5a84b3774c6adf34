#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "scene/query/placed_robot.h"

namespace proximity_server::scene {

/// The links of the candidate pairs in groups of neighbours: a binary tree of boxes along the kinematic tree, so that
/// many pairs are settled at once.
///
/// Source: Teschner et al., Collision Detection for Deformable Objects, 2005: hierarchies that are refitted, not
/// rebuilt.
class LinkGroups {
 public:
  explicit LinkGroups(const SceneModel& model);

  /// One link, or two groups that together are this one. The root is group 0.
  struct Group {
    int link = -1;
    std::array<int, 2> parts{-1, -1};
    Eigen::AlignedBox3d box;  ///< in the frame of the poses, moved to the origin of a body
    bool isLink() const { return link >= 0; }
  };
  const Group& operator[](int group) const { return groups_[group]; }
  bool empty() const { return groups_.empty(); }

  /// Fits the boxes to the poses. Returns false if the pose of a link is missing.
  bool refit(const PlacedRobot& robot);

  /// A lower bound [m] of the signed distance of any link of one from any of the other, less their padding.
  double gap(int a, int b) const;

  /// Index of the pair among the candidates, or -1.
  int candidate(int link_a, int link_b) const;

 private:
  int add(std::vector<int>::const_iterator begin, std::vector<int>::const_iterator end);

  std::vector<Group> groups_;  // parts behind their whole
  std::vector<int> candidates_;
  std::size_t links_;
  double largest_padding_ = 0.0;  ///< [m]
  double rounding_ = 0.0;         ///< [m] of a gap
};

}  // namespace proximity_server::scene
