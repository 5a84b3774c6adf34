#include "scene/query/half_space.h"

#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace proximity_server::scene::half_space_test {

/// The gap between the content of a link at (0, 0, 5), turned by an eighth about x, and all below z = 1.
double gapOf(const std::string& collision) {
  const RobotModel robot = floatingLinks({collision});
  const Volumes volumes(robot);
  const Volume& whole = volumes[volumes.of({robot.findLink("0")})];
  const Eigen::Isometry3d floor_T_link = turned(M_PI / 4, Eigen::Vector3d::UnitX(), {0, 0, 5});
  const Eigen::Isometry3d link_T_floor = floor_T_link.inverse();
  return halfSpaceGap(whole, {Eigen::Vector3d::UnitZ(), 1.0, 0, 1.0},
                      {link_T_floor.linear(), link_T_floor.translation()}, 0.0);
}

// The ball fills its sphere, and the cube its box; both have the same box.
TEST(HalfSpaceGap, IsThatOfTheBoxOrOfTheSphereWhicheverIsNarrower) {
  EXPECT_NEAR(gapOf(robots::ball("1")), 4.0 - 1.0, 1e-12);
  EXPECT_NEAR(gapOf(robots::box("2 2 2")), 4.0 - std::sqrt(2.0), 1e-12);
}

}  // namespace proximity_server::scene::half_space_test
