#include "proximity_server/scene/sensed/voxel_memory.h"

#include "chance.h"

#include <gtest/gtest.h>

#include <vector>

namespace proximity_server::scene::voxel_memory_test {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

SightRays raysTo(const Vector3d& origin, const Points& ends) {
  SightRays rays;
  rays.set(origin, ends);
  return rays;
}

VoxelGrid::Place placeOf(const Vector3d& point) {
  VoxelGrid grid(0.1);
  grid.add(point);
  return grid.places().front();
}

bool has(const VoxelMemory& memory, const Vector3d& point) { return memory.grid().hasAt(placeOf(point)); }

const Vector3d kWall(1.05, 0.05, 0.05), kHand(0.55, 0.05, 0.05), kBehind(2.05, 0.05, 0.05);

TEST(VoxelMemory, ForgetsTheCloudBeforeWithoutPersistence) {
  VoxelMemory memory(0.1, 0.0);
  memory.see(1.0, {kWall}, {});
  memory.see(1.1, {}, {});
  EXPECT_EQ(memory.grid().size(), 0U);
}

TEST(VoxelMemory, KeepsWhatIsHiddenUntilItIsTooOld) {
  VoxelMemory memory(0.1, 2.0);
  memory.see(1.0, {kWall}, raysTo(Vector3d::Zero(), {kWall}));
  memory.see(3.0, {}, raysTo(Vector3d::Zero(), {kHand}));
  EXPECT_TRUE(has(memory, kWall)) << "a point of the robot hides it";
  EXPECT_EQ(memory.persistent(), 1U);
  memory.see(3.01, {}, raysTo(Vector3d::Zero(), {kHand}));
  EXPECT_FALSE(has(memory, kWall));
}

TEST(VoxelMemory, IsAsOldAsTheLatestCloudThatShowsIt) {
  VoxelMemory memory(0.1, 2.0);
  for (const double time : {1.0, 2.5}) memory.see(time, {kWall}, raysTo(Vector3d::Zero(), {kWall}));
  EXPECT_EQ(memory.persistent(), 0U) << "the latest cloud has it";
  memory.see(4.5, {}, {});
  EXPECT_TRUE(has(memory, kWall));
}

TEST(VoxelMemory, LosesWhatARayPassesThrough) {
  VoxelMemory memory(0.1, 2.0);
  memory.see(1.0, {kWall, kHand}, raysTo(Vector3d::Zero(), {kWall, kHand}));
  memory.see(1.1, {kBehind}, raysTo(Vector3d::Zero(), {kBehind}));
  EXPECT_TRUE(has(memory, kBehind));
  EXPECT_FALSE(has(memory, kWall));
  EXPECT_FALSE(has(memory, kHand));
}

TEST(VoxelMemory, BeginsAnewWhereTheClockJumpsBack) {
  VoxelMemory memory(0.1, 2.0);
  memory.see(5.0, {kWall}, {});
  memory.see(4.0, {kHand}, {});
  EXPECT_FALSE(has(memory, kWall));
}

/// What should be there, point by point.
TEST(VoxelMemory, HasThePointsThatNothingHasShownToBeGoneAndNoOthers) {
  constexpr double kPersistence = 1.0;
  Chance chance(7);
  VoxelMemory memory(0.1, kPersistence);
  struct Seen {
    Vector3d point;
    double time;
  };
  std::vector<Seen> wanted;
  int seen_through = 0, hidden = 0;
  for (int cloud = 0; cloud < 60; ++cloud) {
    const double time = 0.3 * cloud;
    const Vector3d origin = 0.2 * chance.direction();
    Points points;
    for (int i = 0; i < 40; ++i) points.emplace_back(chance.between(0.4, 1.5) * chance.direction());
    const SightRays rays = raysTo(origin, points);
    memory.see(time, points, rays);
    VoxelGrid now(0.1);
    for (const Vector3d& point : points) now.add(point);
    std::vector<Seen> kept;
    for (const Seen& old : wanted) {
      const bool is_seen_through = !now.hasAt(placeOf(old.point)) && rays.passThrough(now.box(placeOf(old.point)));
      if (is_seen_through) ++seen_through;
      if (!is_seen_through && old.time >= time - kPersistence) kept.push_back(old);
    }
    hidden += static_cast<int>(kept.size());
    for (const Vector3d& point : points) kept.push_back({point, time});
    wanted = kept;
    VoxelGrid all(0.1);
    for (const Seen& seen : wanted) all.add(seen.point);
    ASSERT_EQ(memory.grid().size(), all.size()) << cloud;
    for (const Seen& seen : wanted) ASSERT_TRUE(has(memory, seen.point)) << cloud << ": " << seen.point.transpose();
  }
  EXPECT_GT(seen_through, 50);
  EXPECT_GT(hidden, 50);
}

}  // namespace proximity_server::scene::voxel_memory_test
