#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "scene/small_robots.h"

#include <Eigen/Geometry>

#include <cmath>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The state of a robot with joints of every type, and its own forward kinematics. Planar and floating joints have any
/// pose, as tf would give it.
class Posture {
 public:
  /// All joints at 0. The roots of the robots stand at the origin.
  explicit Posture(const RobotModel& robot)
      : robot_(&robot),
        roots_(robot.robots.size(), Eigen::Isometry3d::Identity()),
        positions_(robot.joints.size(), 0.0),
        motions_(robot.joints.size(), Eigen::Isometry3d::Identity()) {}

  /// Within the limits of the joints; half a turn where there are none.
  static Posture random(const RobotModel& robot, Chance& chance) {
    Posture posture(robot);
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const Joint& joint = robot.joints[i];
      posture.positions_[i] = chance.between(std::max(joint.lower, -M_PI), std::min(joint.upper, M_PI));
      if (joint.type == Joint::Type::Floating) posture.motions_[i] = chance.pose(1.0);
      if (joint.type != Joint::Type::Planar) continue;
      const Eigen::Vector3d step = chance.direction();
      posture.motions_[i] = turned(posture.positions_[i], joint.axis, step - step.dot(joint.axis) * joint.axis);
    }
    return posture;
  }

  void placeRoot(int robot, const Eigen::Isometry3d& pose) { roots_[robot] = pose; }

  /// Sets the motion of a planar or floating joint.
  void setMotion(int joint, const Eigen::Isometry3d& motion) { motions_[joint] = motion; }

  /// The posture that a velocity leads to after the time `step` [s].
  Posture moved(const DegreesOfFreedom& columns, const Eigen::VectorXd& velocity, double step) const {
    Posture moved = *this;
    for (std::size_t i = 0; i < robot_->joints.size(); ++i) {
      if (robot_->joints[i].mimic) continue;
      const int first = columns.columnsOf(static_cast<int>(i)).first;
      moved.move(i, step * velocity.segment(first, columns.columnsOf(static_cast<int>(i)).count));
    }
    return moved;
  }

  BodyPoses poses() const {
    BodyPoses poses(robot_->bodies.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Body& body = robot_->bodies[i];
      if (body.joint < 0) {
        poses[i] = roots_[body.robot];
        continue;
      }
      const Joint& joint = robot_->joints[body.joint];
      poses[i] = *poses[body.parent] * robot_->links[joint.parent_link].body_T_link * joint.parent_T_joint *
                 motionOf(body.joint);
    }
    return poses;
  }

 private:
  Eigen::Isometry3d motionOf(int joint) const {
    const Joint& moving = robot_->joints[joint];
    if (!hasOnePosition(moving)) return motions_[joint];
    double position = positions_[joint];
    if (moving.mimic) {  // a mimic joint may follow another one
      const Joint::Mimic leader = robot_->leaderOf(joint);
      position = leader.offset + leader.multiplier * positions_[leader.joint];
    }
    return jointMotion(moving, position);
  }

  void move(std::size_t joint, const Eigen::VectorXd& step) {
    const Joint& moving = robot_->joints[joint];
    if (hasOnePosition(moving)) {
      positions_[joint] += step[0];
      return;
    }
    Eigen::Vector3d shift = step.head<3>(), turn = Eigen::Vector3d::Zero();
    if (moving.type == Joint::Type::Planar) {
      const Eigen::Quaterniond to_normal = turnFromZ(moving.axis);
      shift = to_normal * Eigen::Vector3d(step[0], step[1], 0.0);
      turn = step[2] * moving.axis;
    } else {
      turn = step.tail<3>();
    }
    const double angle = turn.norm();
    Eigen::Isometry3d& motion = motions_[joint];
    motion.translation() += shift;
    if (angle > 0.0) motion.linear() = Eigen::AngleAxisd(angle, turn / angle) * motion.linear();
  }

  const RobotModel* robot_;
  std::vector<Eigen::Isometry3d> roots_;    ///< by robot
  std::vector<double> positions_;           ///< by joint; [rad] or [m]
  std::vector<Eigen::Isometry3d> motions_;  ///< by joint
};

}  // namespace proximity_server::scene
