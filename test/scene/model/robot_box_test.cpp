#include "proximity_server/scene/model/robot_box.h"

#include "proximity_server/scene/model/kinematics.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <string>

namespace proximity_server::scene::robot_box_test {

using namespace narrowphase;

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// A box from (-1, -2, 0) to (1, 2, 1) and, "turn" about z through (0, 0, 3), a bar of edge 0.2 from x = 0 to x = 4.
const std::string kBar =
    urdfOf(link("base", box("2 4 1", "0 0 0.5")) + link("bar", box("4 0.2 0.2", "2 0 0")) + link("bare") +
           hinge("turn", "base", "bar", "0 0 1", "0 0 3") + slider("far", "base", "bare", "1 0 0", "99 0 0"));

void expectBox(const AlignedBox3d& box, const Vector3d& lowest, const Vector3d& highest) {
  EXPECT_TRUE(box.min().isApprox(lowest, 1e-12)) << box.min().transpose();
  EXPECT_TRUE(box.max().isApprox(highest, 1e-12)) << box.max().transpose();
}

TEST(RobotBox, HoldsAllBodiesWhereTheyStand) {
  const RobotModel robot = robotOf(kBar);
  const RobotBox box(robot);
  const auto at = [&](double turn) { return box.at(forwardKinematics(robot, {{"turn", turn}})); };
  expectBox(at(0.0), {-1.0, -2.0, 0.0}, {4.0, 2.0, 3.1});
  expectBox(at(0.5 * M_PI), {-1.0, -2.0, 0.0}, {1.0, 4.0, 3.1});
  expectBox(at(M_PI), {-4.0, -2.0, 0.0}, {1.0, 2.0, 3.1});
}

TEST(RobotBox, LeavesOutBodiesWithoutAPose) {
  const RobotModel robot = robotOf(kBar);
  BodyPoses poses = forwardKinematics(robot, std::vector<double>{0.0, 0.0});
  poses[robot.links[robot.findLink("bar")].body].reset();
  expectBox(RobotBox(robot).at(poses), {-1.0, -2.0, 0.0}, {1.0, 2.0, 1.0});
  poses.assign(poses.size(), std::nullopt);
  EXPECT_TRUE(RobotBox(robot).at(poses).isEmpty());
}

TEST(RobotBox, HoldsTheMarginsOfTheShapes) {
  ModelOptions padded;
  padded.default_padding = 0.01;
  const RobotModel robot = robotOf(urdfOf(link("l", ball("0.5", "1 2 3"))), padded);
  expectBox(RobotBox(robot).at(forwardKinematics(robot, std::vector<double>{})), {0.49, 1.49, 2.49},
            {1.51, 2.51, 3.51});
}

}  // namespace proximity_server::scene::robot_box_test
