#include "node/answers/gradients.h"

#include "node/answers/conversions.h"
#include "proximity_server/scene/motion/limited_motion.h"

#include <Eigen/Core>

#include <optional>
#include <utility>

namespace proximity_server::node {

double jointPositionAt(const scene::RobotModel& robot, const scene::Joint& joint, const scene::BodyPoses& poses) {
  const std::optional<Eigen::Isometry3d>& parent = poses[robot.links[joint.parent_link].body];
  const std::optional<Eigen::Isometry3d>& child = poses[robot.links[joint.child_link].body];
  if (!scene::hasOnePosition(joint) || !parent || !child) return kNaN;
  return scene::jointPosition(robot, joint, parent->inverse() * *child);
}

Gradients::Gradients(const Robot& robot) : model_(robot.sharedModel()), derivatives_(model_) {
  for (const scene::DegreeOfFreedom& column : derivatives_.degreesOfFreedom().list()) names_.push_back(column.name);
}

void Gradients::use(std::shared_ptr<const scene::Objects> objects, scene::ObjectCarriers carriers) {
  derivatives_.use(std::move(objects), std::move(carriers));
}

void Gradients::assign(Proximity& message, const scene::PairProximity& pair) const {
  message.gradient.resize(names_.size());
  Eigen::Map<Eigen::VectorXd> gradient(message.gradient.data(), static_cast<Eigen::Index>(names_.size()));
  if (!derivatives_.gradient(pair, gradient) || !gradient.allFinite()) message.gradient.clear();
}

void Gradients::assignPositions(std::vector<double>& positions, const scene::BodyPoses& poses) const {
  positions.clear();
  for (const scene::DegreeOfFreedom& column : derivatives_.degreesOfFreedom().list())
    positions.push_back(jointPositionAt(model_->robot, model_->robot.joints[column.joint], poses));
}

}  // namespace proximity_server::node
