#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace proximity_server::scene {

/// The rays of a sensor, from its origin to what it has seen. Sorted by direction, so that a box meets few of them.
class SightRays {
 public:
  /// The rays from `origin` to each of `ends` [m], which are finite and in the frame of the boxes.
  void set(const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& ends);

  /// Whether a ray enters a box [m] and ends behind it: then what the ray has seen is not in the box, and nothing in it
  /// was in its way. The rounding of coordinates decides about rays that touch the box.
  bool passThrough(const Eigen::AlignedBox3d& box) const;

 private:
  static constexpr int kCells = 256;  ///< along an edge of a face of the cube around the origin; 0.2 to 0.45 degrees

  struct Cell {
    std::uint32_t begin = 0;  ///< its first ray; that of the next cell ends it
    float depth = 0.0F;       ///< [m] the farthest end of its rays along the axis of its face, rounded up
  };

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> ends_;   ///< [m] seen from the origin, by cell
  std::vector<Cell> cells_;             ///< by face, then row, then column, and one more
  std::vector<std::uint32_t> cell_of_;  ///< the rays as they were given
};

}  // namespace proximity_server::scene
