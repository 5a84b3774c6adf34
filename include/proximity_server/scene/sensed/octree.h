#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace proximity_server::scene {

constexpr std::size_t kMostOctreeNodes = 10'000'000;

/// An octree as octomap writes it into messages (octomap_msgs/Octomap) and files.
struct Octree {
  std::string id;     ///< the class: OcTree, OcTreeStamped or ColorOcTree
  bool is_binary;     ///< two bits for each child; else the log-odds of each node, in the byte order of this machine
  double resolution;  ///< [m] the edge of the smallest leaves, which are 16 levels below the root
  std::string_view bytes;  ///< without a header; of a tree without nodes there are none
};

/// The occupied space of an octree as boxes [m] in its frame, one for each leaf that is not part of a larger cube of
/// occupied leaves. They contain all points of the leaves, rounding included. Unknown space is left out. A leaf with
/// log-odds is occupied if they are not negative, which is octomap's default.
///
/// Failure: throws std::invalid_argument with the number of the byte and the reason, also for bytes that are left over,
///          for more than kMostOctreeNodes nodes, and for a resolution that is not positive or too large.
std::vector<Eigen::AlignedBox3d> occupiedBoxes(const Octree& octree);

}  // namespace proximity_server::scene
