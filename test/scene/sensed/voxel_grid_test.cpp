#include "proximity_server/scene/sensed/voxel_grid.h"

#include "chance.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace proximity_server::scene::voxel_grid_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

bool contains(const std::vector<AlignedBox3d>& boxes, const Vector3d& point) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const AlignedBox3d& box) { return box.contains(point); });
}

double volumeOf(const std::vector<AlignedBox3d>& boxes) {
  double volume = 0.0;
  for (const AlignedBox3d& box : boxes) volume += box.volume();
  return volume;
}

/// The boxes contain all points, and their volume is that of the voxels: so they are these voxels, each once.
void expectBoxesAreTheVoxels(const VoxelGrid& grid, const std::vector<Vector3d>& points) {
  const std::vector<AlignedBox3d> boxes = grid.boxes();
  for (const Vector3d& point : points) ASSERT_TRUE(contains(boxes, point)) << point.transpose();
  const double voxels = static_cast<double>(grid.size()) * std::pow(grid.resolution(), 3);
  EXPECT_NEAR(volumeOf(boxes), voxels, 1e-9 * voxels);
}

TEST(VoxelGrid, HasBoxesThatAreItsVoxels) {
  Chance chance(1);
  for (const double resolution : {0.003, 0.02, 0.1, 7.0}) {
    for (const double spread : {2.0, 9.0, 40.0}) {
      VoxelGrid grid(resolution);
      std::vector<Vector3d> points;
      for (int i = 0; i < 400; ++i) points.emplace_back(spread * resolution * chance.pose(1.0).translation());
      for (const Vector3d& point : points) grid.add(point);
      expectBoxesAreTheVoxels(grid, points);
    }
  }
}

/// Rounding puts one in nine of these points into the voxel beside it.
TEST(VoxelGrid, ContainsThePointsOnItsCorners) {
  for (const double resolution : {0.02, 0.1, 0.7}) {
    VoxelGrid grid(resolution);
    std::vector<Vector3d> points;
    for (int i = -2000; i < 2000; i += 9) {
      const double corner = resolution * i;
      points.emplace_back(corner, std::nextafter(corner, 1e9), std::nextafter(corner, -1e9));
    }
    for (const Vector3d& point : points) grid.add(point);
    expectBoxesAreTheVoxels(grid, points);
  }
}

TEST(VoxelGrid, HasOneBoxForAFullBrickAndOneForAPlate) {
  VoxelGrid grid(1.0);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) grid.add({x + 0.5, y + 0.5, z - 7.5});
  EXPECT_EQ(grid.size(), 512U);
  EXPECT_EQ(grid.boxes().size(), 1U);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) grid.add({x + 16.5, y + 0.5, 3.5});
  EXPECT_EQ(grid.boxes().size(), 2U);
  grid.clear();
  EXPECT_EQ(grid.size(), 0U);
  EXPECT_TRUE(grid.boxes().empty());
}

TEST(VoxelGrid, BoundsThePointsOfAVoxelAndOfABrick) {
  Chance chance(2);
  VoxelGrid grid(0.02);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d point = chance.pose(i % 2 ? 3.0 : 3000.0).translation();
    const VoxelGrid::Voxel voxel = grid.add(point);
    const Vector3d centre = grid.centre(voxel), of_brick = grid.centreOfBrick(voxel.brick);
    EXPECT_TRUE(grid.has(voxel));
    EXPECT_LE((point - centre).norm(), grid.radius(centre));
    EXPECT_LE((point - of_brick).norm(), grid.radiusOfBrick(of_brick));
    EXPECT_LE(grid.radius(centre), 0.0175);
  }
}

TEST(VoxelGrid, RefusesWhatHasNoVoxel) {
  const double kInfinity = std::numeric_limits<double>::infinity(), kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double resolution : {0.0, -1.0, kInfinity, kNaN})
    EXPECT_EQ(errorOf([&] { VoxelGrid grid(resolution); }), "the resolution of a voxel grid must be a positive number");
  VoxelGrid grid(0.01);
  for (const double far : {kInfinity, -kInfinity, kNaN, 1e5, -1e5, 1e300})
    EXPECT_EQ(errorOf([&] {
                grid.add({0.0, far, 0.0});
              }),
              "a point is not finite, or too far for the resolution of its voxels")
        << far;
  EXPECT_EQ(grid.size(), 0U);
  grid.add({8e4, -8e4, 0.0});
  EXPECT_EQ(grid.size(), 1U);
}

}  // namespace proximity_server::scene::voxel_grid_test
