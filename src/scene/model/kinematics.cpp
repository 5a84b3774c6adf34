#include "proximity_server/scene/model/kinematics.h"

#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/scene/model/names.h"
#include "scene/model/body_pose.h"

#include <cmath>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The position of a joint; mimic joints follow their leader.
double positionIn(const std::vector<double>& positions, const RobotModel& model, int joint) {
  const Joint::Mimic leader = model.leaderOf(joint);
  return followedPosition(leader, positions[leader.joint]);
}

}  // namespace

Matrix3d rotationAbout(const Vector3d& axis, double angle) {
  const auto [sine, cosine] = narrowphase::sineAndCosine(angle);
  const Vector3d s = sine * axis;
  Matrix3d turned;
  turned << cosine, -s.z(), s.y(), s.z(), cosine, -s.x(), -s.y(), s.x(), cosine;
  return turned + ((1.0 - cosine) * axis) * axis.transpose();
}

Isometry3d jointMotion(const Joint& joint, double position) {
  switch (joint.type) {
    case Joint::Type::Revolute:
    case Joint::Type::Continuous:
      return Isometry3d(rotationAbout(joint.axis, position));
    case Joint::Type::Prismatic:
      return Isometry3d(Eigen::Translation3d(position * joint.axis));
    case Joint::Type::Floating:
    case Joint::Type::Planar:
      break;
  }
  return Isometry3d::Identity();
}

double jointPosition(const RobotModel& model, const Joint& joint, const Isometry3d& parent_T_child) {
  const Link& parent = model.links[joint.parent_link];
  const Isometry3d moved = (parent.body_T_link * joint.parent_T_joint).inverse() * parent_T_child;
  if (joint.type == Joint::Type::Prismatic) return joint.axis.dot(moved.translation());
  const Eigen::Quaterniond turned(moved.linear());
  // The angle is between -2 pi and 2 pi, because two quaternions stand for the same rotation.
  const double angle = 2.0 * narrowphase::angleOf(joint.axis.dot(turned.vec()), turned.w());
  return std::remainder(angle, 2.0 * M_PI);
}

// Eigen's FromTwoVectors() computes the same, but compiling its templates takes seven seconds in each source.
Eigen::Quaterniond turnFromZ(const Vector3d& unit) {
  const double sine2 = unit.head<2>().squaredNorm();
  if (unit.z() < 0.0 && sine2 == 0.0) return {0.0, 1.0, 0.0, 0.0};
  const double one_plus_cosine = unit.z() < 0.0 ? sine2 / (1.0 - unit.z()) : 1.0 + unit.z();  // avoids cancellation
  return Eigen::Quaterniond(one_plus_cosine, -unit.y(), unit.x(), 0.0).normalized();
}

BodyPoses forwardKinematics(const RobotModel& model, const std::vector<double>& positions) {
  if (positions.size() != model.joints.size()) {
    throw std::invalid_argument("the robot has " + std::to_string(model.joints.size()) +
                                " movable joints, but there are " + std::to_string(positions.size()) + " positions");
  }
  BodyPoses poses(model.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.joint < 0) {
      poses[i] = Isometry3d::Identity();
      continue;
    }
    const Isometry3d motion = jointMotion(model.joints[body.joint], positionIn(positions, model, body.joint));
    poses[i] = poseOnParent(model, body, *poses[body.parent], motion);
  }
  return poses;
}

BodyPoses forwardKinematics(const RobotModel& model, const std::map<std::string, double>& positions) {
  std::vector<double> by_joint(model.joints.size(), 0.0);
  for (const auto& [name, position] : positions) {
    const int joint = findNamed(model.joints, name);
    if (joint < 0) throw std::invalid_argument("no movable joint " + unknownName(name, namesOf(model.joints)));
    by_joint[joint] = position;
  }
  return forwardKinematics(model, by_joint);
}

BodyPoses forwardKinematics(const RobotModel& model,
                            std::initializer_list<std::pair<const std::string, double>> positions) {
  return forwardKinematics(model, std::map<std::string, double>(positions));
}

BodyPoses placedAt(const RobotModel& model, BodyPoses in_roots,
                   const std::vector<std::optional<Isometry3d>>& common_T_roots) {
  for (std::size_t i = 0; i < in_roots.size(); ++i) {
    std::optional<Isometry3d>& pose = in_roots[i];
    const std::optional<Isometry3d>& common_T_root = common_T_roots[model.bodies[i].robot];
    if (pose && common_T_root) {
      pose = *common_T_root * *pose;
    } else {
      pose.reset();
    }
  }
  return in_roots;
}

}  // namespace proximity_server::scene
