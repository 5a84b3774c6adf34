#include "node/answers/gradients.h"

#include "node/answers/conversions.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/motion/limited_motion.h"

#include <Eigen/Core>

#include <cstddef>
#include <optional>

namespace proximity_server::node {

double jointPositionAt(const scene::RobotModel& robot, const scene::Joint& joint, const scene::BodyPoses& poses) {
  const std::optional<Eigen::Isometry3d>& parent = poses[robot.links[joint.parent_link].body];
  const std::optional<Eigen::Isometry3d>& child = poses[robot.links[joint.child_link].body];
  if (!scene::hasOnePosition(joint) || !parent || !child) return kNaN;
  return scene::jointPosition(robot, joint, parent->inverse() * *child);
}

void assignGradient(Proximity& message, const scene::State& state, const scene::PairProximity& pair) {
  message.gradient.resize(static_cast<std::size_t>(state.degreesOfFreedom().size()));
  Eigen::Map<Eigen::VectorXd> gradient(message.gradient.data(), state.degreesOfFreedom().size());
  if (!scene::gradient(state, pair, gradient) || !gradient.allFinite()) message.gradient.clear();
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
