#include "proximity_server/scene/model/robot_box.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"

#include <gtest/gtest.h>

#include <string>

namespace proximity_server::scene::robot_box_test {

using namespace narrowphase;

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// A box from (-1, -2, 0) to (1, 2, 1) and, "turn" about z through (0, 0, 3), a bar of edge 0.2 from x = 0 to x = 4.
const char* const kBar = R"(<robot name="bar">
  <link name="base"><collision><origin xyz="0 0 0.5"/><geometry><box size="2 4 1"/></geometry></collision></link>
  <link name="bar"><collision><origin xyz="2 0 0"/><geometry><box size="4 0.2 0.2"/></geometry></collision></link>
  <link name="bare"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="bar"/><origin xyz="0 0 3"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="far" type="prismatic"><parent link="base"/><child link="bare"/><origin xyz="99 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>)";

RobotModel load(const std::string& urdf, const ModelOptions& options = {}) {
  return loadRobotModel(urdf, packageResolver({}), options);
}

void expectBox(const AlignedBox3d& box, const Vector3d& lowest, const Vector3d& highest) {
  EXPECT_TRUE(box.min().isApprox(lowest, 1e-12)) << box.min().transpose();
  EXPECT_TRUE(box.max().isApprox(highest, 1e-12)) << box.max().transpose();
}

TEST(RobotBox, HoldsAllBodiesWhereTheyStand) {
  const RobotModel robot = load(kBar);
  const RobotBox box(robot);
  const auto at = [&](double turn) { return box.at(forwardKinematics(robot, {{"turn", turn}})); };
  expectBox(at(0.0), {-1.0, -2.0, 0.0}, {4.0, 2.0, 3.1});
  expectBox(at(0.5 * M_PI), {-1.0, -2.0, 0.0}, {1.0, 4.0, 3.1});
  expectBox(at(M_PI), {-4.0, -2.0, 0.0}, {1.0, 2.0, 3.1});
}

TEST(RobotBox, LeavesOutBodiesWithoutAPose) {
  const RobotModel robot = load(kBar);
  BodyPoses poses = forwardKinematics(robot, std::vector<double>{0.0, 0.0});
  poses[static_cast<std::size_t>(robot.links[static_cast<std::size_t>(robot.findLink("bar"))].body)].reset();
  expectBox(RobotBox(robot).at(poses), {-1.0, -2.0, 0.0}, {1.0, 2.0, 1.0});
  poses.assign(poses.size(), std::nullopt);
  EXPECT_TRUE(RobotBox(robot).at(poses).isEmpty());
}

TEST(RobotBox, HoldsTheMarginsOfTheShapes) {
  ModelOptions padded;
  padded.default_padding = 0.01;
  const RobotModel robot = load(
      "<robot name='ball'><link name='l'><collision><origin xyz='1 2 3'/><geometry><sphere radius='0.5'/></geometry>"
      "</collision></link></robot>",
      padded);
  expectBox(RobotBox(robot).at(forwardKinematics(robot, std::vector<double>{})), {0.49, 1.49, 2.49},
            {1.51, 2.51, 3.51});
}

}  // namespace proximity_server::scene::robot_box_test
