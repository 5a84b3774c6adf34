#include "narrowphase/shape/scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// Points coordinate by coordinate, filled up to the stride with the first, as a hull stores them.
struct Coordinates {
  int count;
  std::vector<double> x, y, z;

  explicit Coordinates(const std::vector<Vector3d>& points)
      : count((static_cast<int>(points.size()) + kScanStride - 1) / kScanStride * kScanStride) {
    for (int i = 0; i < count; ++i) {
      const auto from = static_cast<std::size_t>(i);
      const Vector3d& point = points[from < points.size() ? from : 0];
      x.push_back(point.x());
      y.push_back(point.y());
      z.push_back(point.z());
    }
  }
};

/// The index that every width of this processor gives; -1 where they differ.
int scanOfAllWidths(const std::vector<Vector3d>& points, const Vector3d& direction) {
  const Coordinates c(points);
  const int chosen = scan(c.x.data(), c.y.data(), c.z.data(), c.count, direction);
  for (const ScanOfWidth& width : availableScans())
    if (width.scan(c.x.data(), c.y.data(), c.z.data(), c.count, direction.data()) != chosen) return -1;
  return chosen;
}

/// The first of the greatest, one by one.
int firstFarthest(const std::vector<Vector3d>& points, const Vector3d& d) {
  int best = 0;
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double height = d.x() * points[i].x() + d.y() * points[i].y() + d.z() * points[i].z();
    if (!(height > highest)) continue;
    highest = height;
    best = static_cast<int>(i);
  }
  return best;
}

std::vector<Vector3d> randomPoints(int count, std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  return points;
}

TEST(Scan, HasTheNarrowestWidthOnEveryProcessorAndEachWidthOnce) {
  const std::vector<ScanOfWidth> scans = availableScans();
  ASSERT_FALSE(scans.empty());
  EXPECT_EQ(scans.front().lanes, 2);
  for (std::size_t i = 1; i < scans.size(); ++i) EXPECT_EQ(scans[i].lanes, 2 * scans[i - 1].lanes);
  for (const ScanOfWidth& width : scans) EXPECT_EQ(kScanStride % (2 * width.lanes), 0);
}

TEST(Scan, FindsTheFarthestPointInEveryPlaceOfEveryCount) {
  for (int count = 1; count <= 100; ++count)
    for (int place = 0; place < count; ++place) {
      std::vector<Vector3d> points(static_cast<std::size_t>(count), Vector3d(-1, -2, -3));
      points[static_cast<std::size_t>(place)] = Vector3d(1, 2, 3);
      ASSERT_EQ(scanOfAllWidths(points, {1, 1, 1}), place) << count;
    }
}

TEST(Scan, NamesTheFirstOfTwoThatAreAsFar) {
  for (const int count : {16, 37, 64})
    for (int first = 0; first < count; ++first)
      for (int second = first + 1; second < count; ++second) {
        std::vector<Vector3d> points(static_cast<std::size_t>(count), Vector3d::Zero());
        points[static_cast<std::size_t>(first)] = points[static_cast<std::size_t>(second)] = Vector3d(0, 1, 0);
        ASSERT_EQ(scanOfAllWidths(points, {0.25, 1, -0.5}), first) << count << " " << second;
      }
}

TEST(Scan, NamesTheFirstOfAllWhereTheDirectionIsAcrossThem) {
  for (int count = 1; count <= 100; ++count) {
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i) points.emplace_back(i, -i, 5);
    ASSERT_EQ(scanOfAllWidths(points, {1, 1, 0.5}), 0);
  }
}

TEST(Scan, NeverNamesThePointsThatFillTheStride) {
  std::mt19937 random(1);
  for (int count = 1; count <= 50; ++count)
    for (int i = 0; i < 20; ++i)
      ASSERT_LT(scanOfAllWidths(randomPoints(count, random), randomPoints(1, random)[0]), count);
}

TEST(Scan, GivesTheSameBitsAsALoopOverThePoints) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Vector3d> points = randomPoints(1 + i % 130, random);
    const Vector3d direction = randomPoints(1, random)[0];
    ASSERT_EQ(scanOfAllWidths(points, direction), firstFarthest(points, direction));
  }
}

// The product 0.1 * 0.1 is above 0.01 in double; fused with the sum it would differ from its own rounding by 9e-19, and
// the second point would be farther than the first.
TEST(Scan, RoundsEveryProductBeforeItIsAdded) {
  const double rounded = 0.1 * 0.1;
  std::vector<Vector3d> points(20, Vector3d(-1, -1, -1));
  points[3] = Vector3d(0, 0, 0);
  points[7] = Vector3d(-rounded, 0.1, 0);
  EXPECT_EQ(scanOfAllWidths(points, {1, 0.1, 0}), 3);
  points[3] = Vector3d(-rounded, 0.1, 0);
  points[7] = Vector3d(0, 0, 0);
  EXPECT_EQ(scanOfAllWidths(points, {1, 0.1, 0}), 3);
}

}  // namespace
}  // namespace proximity_server::narrowphase
