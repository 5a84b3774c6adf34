#pragma once

#include "proximity_server/scene/sensed/sight_rays.h"
#include "proximity_server/scene/sensed/voxel_grid.h"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace proximity_server::scene {

/// The voxels of the latest cloud of a sensor, and those of clouds before it that may still be there.
class VoxelMemory {
 public:
  /// A voxel that the latest cloud has not stays for `persistence` [s] after it was seen. 0: none stays.
  /// Failure: throws as VoxelGrid does.
  VoxelMemory(double resolution, double persistence) : grid_(resolution), persistence_(persistence) {}

  void clear();

  /// Adds a cloud of this time [s]. A voxel without a point leaves if it is too old, or if one of the rays passes through
  /// it. A time before that of the last cloud makes the memory begin anew.
  /// Failure: throws as VoxelGrid::add() does. The grid is undefined then, until the next cloud.
  void see(double time, const std::vector<Eigen::Vector3d>& points, const SightRays& rays);

  const VoxelGrid& grid() const { return grid_; }         ///< all voxels
  std::size_t persistent() const { return persistent_; }  ///< the number of those that the latest cloud has not
  bool isPersistent() const { return persistence_ > 0.0; }

 private:
  struct Seen {
    VoxelGrid::Place place;
    double time;  ///< [s] of the latest cloud that had it
  };

  VoxelGrid grid_;
  double persistence_;
  double time_ = 0.0;
  std::vector<Seen> seen_;  ///< all voxels, if they are to stay
  std::size_t persistent_ = 0;
};

}  // namespace proximity_server::scene
