#include "node/answers/gradients.h"

#include "node/answers/conversions.h"
#include "proximity_server/scene/motion/limited_motion.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>

namespace proximity_server::node {

double jointPositionAt(const scene::RobotModel& robot, const scene::Joint& joint, const scene::BodyPoses& poses) {
  const std::optional<Eigen::Isometry3d>& parent = poses[robot.links[joint.parent_link].body];
  const std::optional<Eigen::Isometry3d>& child = poses[robot.links[joint.child_link].body];
  if (!scene::hasOnePosition(joint) || !parent || !child) return kNaN;
  return scene::jointPosition(robot, joint, parent->inverse() * *child);
}

void assignColumns(std::vector<std::string>& names, const scene::DegreesOfFreedom& columns) {
  names.resize(static_cast<std::size_t>(columns.size()));
  for (int i = 0; i < columns.size(); ++i) names[i] = columns[i].name;
}

void assignPositions(std::vector<double>& positions, const scene::State& state, const scene::BodyPoses& poses) {
  positions.clear();
  for (const scene::DegreeOfFreedom& column : state.degreesOfFreedom().list())
    positions.push_back(jointPositionAt(state.robot(), state.robot().joints[column.joint], poses));
}

}  // namespace proximity_server::node
