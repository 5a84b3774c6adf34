#include "proximity_server/scene/sensed/voxel_memory.h"

#include <algorithm>

namespace proximity_server::scene {

void VoxelMemory::clear() {
  grid_.clear();
  seen_.clear();
  persistent_ = 0;
}

void VoxelMemory::see(double time, const std::vector<Eigen::Vector3d>& points, const SightRays& rays) {
  if (time < time_) clear();
  time_ = time;
  grid_.clear();
  for (const Eigen::Vector3d& point : points) grid_.add(point);
  if (!isPersistent()) return;
  const auto has_left = [&](const Seen& voxel) {
    return voxel.time < time - persistence_ || grid_.hasAt(voxel.place) || rays.passThrough(grid_.box(voxel.place));
  };
  seen_.erase(std::remove_if(seen_.begin(), seen_.end(), has_left), seen_.end());
  persistent_ = seen_.size();
  for (const VoxelGrid::Place& place : grid_.places()) seen_.push_back({place, time});
  for (std::size_t i = 0; i < persistent_; ++i) grid_.addAt(seen_[i].place);
}

}  // namespace proximity_server::scene
