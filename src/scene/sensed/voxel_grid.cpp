#include "proximity_server/scene/sensed/voxel_grid.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Array3d;
using Eigen::Vector3d;

/// The error of a point divided by the resolution, and of a corner of a voxel, relative to the largest coordinate: two
/// roundings of eps / 2 each, and as much again.
constexpr double kRounding = 2.0 * std::numeric_limits<double>::epsilon();

/// [m]
double roundingAt(const Vector3d& point) { return kRounding * point.cwiseAbs().maxCoeff(); }

/// The brick of a voxel, and its bit in there.
VoxelGrid::Place brickOf(const VoxelGrid::Place& voxel) {
  return voxel.unaryExpr([](int i) { return i >> 3; });
}
std::uint32_t bitOf(const VoxelGrid::Place& voxel) {
  constexpr int kWithin = VoxelGrid::kEdge - 1;  // of two's complement, also left of the origin
  return static_cast<std::uint32_t>((voxel.x() & kWithin) | (voxel.y() & kWithin) << 3 | (voxel.z() & kWithin) << 6);
}

}  // namespace

VoxelGrid::VoxelGrid(double resolution) : resolution_(resolution) {
  if (!(resolution > 0.0) || !std::isfinite(resolution))
    throw std::invalid_argument("the resolution of a voxel grid must be a positive number");
}

void VoxelGrid::clear() {
  bricks_.clear();
  numbers_.clear();
  latest_ = 0;
}

std::uint64_t VoxelGrid::keyOf(const Place& brick) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) key = key << 21U | static_cast<std::uint64_t>(brick[axis] + kMostBricks);
  return key;
}

std::uint32_t VoxelGrid::brickAt(const Place& place) {
  if (!bricks_.empty() && (bricks_[latest_].place == place).all()) return latest_;
  const auto [number, is_new] = numbers_.try_emplace(keyOf(place), static_cast<std::uint32_t>(bricks_.size()));
  if (is_new) bricks_.push_back({place, {}});
  return latest_ = number->second;
}

VoxelGrid::Voxel VoxelGrid::add(const Vector3d& point) {
  const Array3d at = (point.array() / resolution_).floor();
  if (!(at.abs() < static_cast<double>(kEdge * (kMostBricks - 1))).all())
    throw std::invalid_argument("a point is not finite, or too far for the resolution of its voxels");
  return addAt(at.cast<int>());
}

VoxelGrid::Voxel VoxelGrid::addAt(const Place& place) {
  const std::uint32_t brick = brickAt(brickOf(place));
  const std::uint32_t bit = bitOf(place);
  bricks_[brick].layers[bit / 64] |= std::uint64_t{1} << (bit % 64);
  return {brick, bit};
}

bool VoxelGrid::hasAt(const Place& place) const {
  const auto found = numbers_.find(keyOf(brickOf(place)));
  return found != numbers_.end() && has({found->second, bitOf(place)});
}

std::vector<VoxelGrid::Place> VoxelGrid::places() const {
  std::vector<Place> places;
  for (const Brick& brick : bricks_)
    for (int z = 0; z < kEdge; ++z)
      for (std::uint64_t left = brick.layers[z]; left != 0; left &= left - 1)
        places.emplace_back(kEdge * brick.place + within(64 * z + __builtin_ctzll(left)));
  return places;
}

std::size_t VoxelGrid::size() const {
  std::size_t size = 0;
  for (const Brick& brick : bricks_)
    for (const std::uint64_t layer : brick.layers) size += static_cast<std::size_t>(__builtin_popcountll(layer));
  return size;
}

Vector3d VoxelGrid::centre(const Voxel& voxel) const {
  const Place place = kEdge * bricks_[voxel.brick].place + within(static_cast<int>(voxel.bit));
  return resolution_ * (place.cast<double>() + 0.5);
}

Vector3d VoxelGrid::centreOfBrick(std::size_t brick) const {
  return kEdge * resolution_ * (bricks_[brick].place.cast<double>() + 0.5);
}

double VoxelGrid::radius(const Vector3d& centre) const {
  return std::sqrt(3.0) * (0.5 * resolution_ * (1.0 + kRounding) + 2.0 * roundingAt(centre));
}

double VoxelGrid::radiusOfBrick(const Vector3d& centre) const {
  return std::sqrt(3.0) * (0.5 * kEdge * resolution_ * (1.0 + kRounding) + 2.0 * roundingAt(centre));
}

AlignedBox3d VoxelGrid::box(const Place& from, const Place& to, double resolution) {
  const Vector3d low = resolution * from.cast<double>(), high = resolution * to.cast<double>();
  const Vector3d rounding = Vector3d::Constant(std::max(roundingAt(low), roundingAt(high)));
  return {low - rounding, high + rounding};
}

std::vector<AlignedBox3d> VoxelGrid::boxes() const {
  std::vector<AlignedBox3d> boxes;
  for (const Brick& brick : bricks_) addBoxes(brick, boxes);
  return boxes;
}

/// Grows a box from the first voxel that is in none: along x, then y, then z, as far as there are voxels.
void VoxelGrid::addBoxes(const Brick& brick, std::vector<AlignedBox3d>& boxes) const {
  Layers left = brick.layers;
  for (int z = 0; z < kEdge; ++z) {
    while (left[z] != 0) {
      const int first = __builtin_ctzll(left[z]), x = first % kEdge, y = first / kEdge;
      Place size(1, 1, 1);
      const auto has = [&](int layer, std::uint64_t voxels) { return (left[layer] & voxels) == voxels; };
      const auto row = [&] { return ((std::uint64_t{1} << size.x()) - 1) << first; };
      while (x + size.x() < kEdge && has(z, row() | std::uint64_t{1} << (first + size.x()))) ++size.x();
      std::uint64_t face = row();
      while (y + size.y() < kEdge && has(z, row() << (kEdge * size.y()))) face |= row() << (kEdge * size.y()++);
      while (z + size.z() < kEdge && has(z + size.z(), face)) ++size.z();
      for (int layer = z; layer < z + size.z(); ++layer) left[layer] &= ~face;

      const Place from = kEdge * brick.place + Place(x, y, z);
      boxes.push_back(box(from, from + size, resolution_));
    }
  }
}

}  // namespace proximity_server::scene
