#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace proximity_server::scene {

/// The voxels of a grid that contain points: cubes along the axes of the frame of the points, one with a corner at its
/// origin. Bricks of 8 x 8 x 8 voxels have a bit for each of them.
class VoxelGrid {
 public:
  static constexpr int kEdge = 8;                                     ///< voxels along an edge of a brick
  static constexpr int kVoxels = kEdge * kEdge * kEdge;               ///< voxels of a brick
  static constexpr std::int64_t kMostBricks = std::int64_t{1} << 20;  ///< from the origin along an axis

  /// Throws std::invalid_argument for a resolution [m], the edge of a voxel, that is not positive or not finite.
  explicit VoxelGrid(double resolution);

  double resolution() const { return resolution_; }
  void clear();  ///< keeps the memory

  /// A voxel, by its brick, in the order in which bricks were found, and its place in the brick.
  struct Voxel {
    std::uint32_t brick, bit;
  };

  /// The number of a voxel along each axis. Its lowest corner [m] is this number times the resolution.
  using Place = Eigen::Array3i;

  /// Adds the voxel of a point [m].
  /// Failure: throws std::invalid_argument for a point that is not finite, or farther than kMostBricks.
  Voxel add(const Eigen::Vector3d& point);
  Voxel addAt(const Place& place);  ///< a place of this or another grid

  std::size_t bricks() const { return bricks_.size(); }
  std::size_t size() const;  ///< the number of voxels
  bool has(const Voxel& voxel) const { return (bricks_[voxel.brick].layers[voxel.bit / 64] >> (voxel.bit % 64)) & 1U; }
  bool hasAt(const Place& place) const;

  std::vector<Place> places() const;  ///< of all voxels

  /// The centres of a voxel and of a brick [m].
  Eigen::Vector3d centre(const Voxel& voxel) const;
  Eigen::Vector3d centreOfBrick(std::size_t brick) const;

  /// [m] All points of a voxel are so near to its centre, and those of a brick to that of the brick, rounding included.
  double radius(const Eigen::Vector3d& centre) const;
  double radiusOfBrick(const Eigen::Vector3d& centre) const;

  /// Few boxes [m] that are the voxels together; each voxel is in one box. They contain all points, rounding included.
  std::vector<Eigen::AlignedBox3d> boxes() const;
  Eigen::AlignedBox3d box(const Place& place) const { return box(place, place + 1, resolution_); }  ///< of one voxel

  /// The box [m] from the corner at one place to that at another one, with the rounding of corners and of points.
  static Eigen::AlignedBox3d box(const Place& from, const Place& to, double resolution);

 private:
  using Layers = std::array<std::uint64_t, kEdge>;  ///< of a brick, along z; bit x + kEdge y
  struct Brick {
    Place place;  ///< its first corner is kEdge * resolution times this
    Layers layers{};
  };

  static std::uint64_t keyOf(const Place& brick);
  static Place within(int bit) { return {bit % kEdge, bit / kEdge % kEdge, bit / (kEdge * kEdge)}; }
  std::uint32_t brickAt(const Place& place);
  void addBoxes(const Brick& brick, std::vector<Eigen::AlignedBox3d>& boxes) const;

  double resolution_;
  std::vector<Brick> bricks_;
  std::unordered_map<std::uint64_t, std::uint32_t> numbers_;  ///< of the bricks, by their places
  std::uint32_t latest_ = 0;                                  ///< the brick of the latest point
};

}  // namespace proximity_server::scene
