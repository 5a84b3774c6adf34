#include "proximity_server/scene/sensed/sight_rays.h"

#include "chance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace proximity_server::scene::sight_rays_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// Clips the way to `end` by each of the six planes.
bool passes(const Vector3d& origin, const Vector3d& end, const AlignedBox3d& box) {
  long double enter = 0.0L, leave = 1.0L;
  for (int axis = 0; axis < 3; ++axis) {
    const long double step = static_cast<long double>(end[axis]) - origin[axis];
    for (const bool is_high : {false, true}) {
      const long double gap = (is_high ? box.max() : box.min())[axis] - static_cast<long double>(origin[axis]);
      const long double inwards = is_high ? -step : step;
      if (inwards == 0.0L && (is_high ? gap <= 0.0L : gap >= 0.0L)) return false;
      if (inwards > 0.0L) enter = std::max(enter, gap / step);
      if (inwards < 0.0L) leave = std::min(leave, gap / step);
    }
  }
  return enter < leave && leave < 1.0L;
}

/// How many boxes of `edge` [m] a ray passes through; expects that `rays` says of each what its rays say one by one.
int passed(const Vector3d& origin, const std::vector<Vector3d>& ends, double edge, Chance& chance) {
  SightRays rays;
  rays.set(origin, ends);
  int count = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d low = origin + (i % 10 == 0 ? 0.5 * edge : 2.0) * chance.between(0.0, 1.0) * chance.direction();
    const AlignedBox3d box(low, low + Vector3d::Constant(edge));
    const bool wanted =
        std::any_of(ends.begin(), ends.end(), [&](const Vector3d& e) { return passes(origin, e, box); });
    EXPECT_EQ(rays.passThrough(box), wanted) << low.transpose();
    count += wanted ? 1 : 0;
  }
  return count;
}

TEST(SightRays, PassThroughWhatOneOfThemPassesThrough) {
  Chance chance(3);
  int count = 0;
  for (const double edge : {0.02, 0.1, 0.5}) {
    for (const int many : {1, 30, 3000}) {
      const Vector3d origin = chance.pose(1.0).translation();
      std::vector<Vector3d> ends;
      for (int i = 0; i < many; ++i) ends.emplace_back(origin + chance.between(0.1, 3.0) * chance.direction());
      count += passed(origin, ends, edge, chance);
    }
  }
  EXPECT_GT(count, 500);
  EXPECT_LT(count, 9 * 300 - 500);
}

/// Along the axes, the edges and the diagonals of the cube around the origin.
TEST(SightRays, KnowRaysBetweenTheFacesOfTheCube) {
  Chance chance(4);
  const Vector3d origin(0.3, -0.2, 0.7);
  std::vector<Vector3d> ends;
  for (int number = 0; number < 27; ++number) {
    const Vector3d way(number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1);
    if (number == 13) continue;
    ends.emplace_back(origin + 2.5 * way);
    SightRays rays;
    rays.set(origin, ends);
    const auto at = [&](double part) {
      return AlignedBox3d(origin + part * way - Vector3d::Constant(0.013),
                          origin + part * way + Vector3d::Constant(0.01));
    };
    EXPECT_TRUE(rays.passThrough(at(0.01)) && rays.passThrough(at(1.0))) << way.transpose();
    EXPECT_FALSE(rays.passThrough(at(2.5))) << "it ends there";
    EXPECT_FALSE(rays.passThrough(at(2.6))) << "behind its end";
  }
  EXPECT_GT(passed(origin, ends, 0.3, chance), 20);
}

TEST(SightRays, WithoutRaysOrFromTheOriginToItPassThroughNothing) {
  const AlignedBox3d around(Vector3d::Constant(-1.0), Vector3d::Constant(1.0));
  SightRays rays;
  EXPECT_FALSE(rays.passThrough(around));
  rays.set(Vector3d::Zero(), {Vector3d::Zero()});
  EXPECT_FALSE(rays.passThrough(around));
}

}  // namespace proximity_server::scene::sight_rays_test
