#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "scene/small_robots.h"

#include <Eigen/Geometry>

#include <memory>
#include <sstream>
#include <string>

namespace proximity_server::scene {

/// The pose of a joint's child in the frame of its parent body after the degrees of freedom of the joint moved by `by`:
/// straight, with constant velocities of the child's origin and of its turn.
inline Eigen::Isometry3d movedBy(const RobotModel& robot, const Joint& joint, const Eigen::VectorXd& by,
                                 const Eigen::Isometry3d& parent_T_child) {
  if (hasOnePosition(joint)) return parent_T_child * jointMotion(joint, by[0]);
  const Eigen::Matrix3d at_rest = (robot.links[joint.parent_link].body_T_link * joint.parent_T_joint).linear();
  Eigen::Vector3d way, turn;
  if (joint.type == Joint::Type::Planar) {
    const Eigen::Matrix3d axes = turnFromZ(joint.axis).toRotationMatrix();
    way = axes * Eigen::Vector3d(by[0], by[1], 0.0);
    turn = axes * Eigen::Vector3d(0.0, 0.0, by[2]);
  } else {
    way = by.head<3>();
    turn = by.tail<3>();
  }
  Eigen::Isometry3d moved = parent_T_child;
  moved.translation() += at_rest * way;
  if (turn.norm() > 0.0)
    moved.linear() = Eigen::AngleAxisd(turn.norm(), at_rest * turn.normalized()) * parent_T_child.linear();
  return moved;
}

/// The poses of all bodies after a motion [rad, m] of all degrees of freedom, joint by joint, from poses that are all
/// known.
inline BodyPoses moved(const RobotModel& robot, const DegreesOfFreedom& columns, const BodyPoses& poses,
                       const Eigen::VectorXd& motion) {
  BodyPoses result(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Body& body = robot.bodies[i];
    if (body.joint < 0) {
      result[i] = poses[i];
      continue;
    }
    const auto& own = columns.columnsOf(body.joint);
    const Eigen::VectorXd by = own.multiplier * motion.segment(own.first, own.count);
    result[i] =
        *result[body.parent] * movedBy(robot, robot.joints[body.joint], by, poses[body.parent]->inverse() * *poses[i]);
  }
  return result;
}

/// A robot of seven links with random shapes, and random joints of all kinds between them; some follow others.
inline std::shared_ptr<const SceneModel> someRobot(Chance& chance) {
  const auto numbers = [&](double low, double high, int count) {
    std::ostringstream text;
    for (int i = 0; i < count; ++i) text << (i > 0 ? " " : "") << chance.between(low, high);
    return text.str();
  };
  const auto shape = [&] {
    const std::string xyz = numbers(-0.15, 0.15, 3), rpy = numbers(-3, 3, 3);
    switch (chance.below(3)) {
      case 0:
        return ball(numbers(0.03, 0.1, 1), xyz);
      case 1:
        return box(numbers(0.03, 0.3, 3), xyz, rpy);
      default:
        return cylinder(numbers(0.03, 0.1, 1), numbers(0.05, 0.4, 1), xyz, rpy);
    }
  };
  std::ostringstream urdf;
  std::string leader;
  urdf << "<robot name='some'>";
  for (int i = 0; i < 7; ++i) {
    urdf << "<link name='" << i << "'>" << shape() << (chance.below(3) == 0 ? shape() : "") << "</link>";
    if (i == 0) continue;
    const int kind = chance.below(9);
    const char* const type = kind < 4    ? "revolute"
                             : kind < 6  ? "prismatic"
                             : kind == 6 ? "continuous"
                             : kind == 7 ? "planar"
                                         : "floating";
    urdf << "<joint name='j" << i << "' type='" << type << "'><parent link='" << chance.below(i) << "'/><child link='"
         << i << "'/><origin xyz='" << numbers(-0.3, 0.3, 3) << "' rpy='" << numbers(-3, 3, 3) << "'/>";
    const Eigen::Vector3d axis = chance.direction();
    if (kind < 8) urdf << "<axis xyz='" << axis.x() << ' ' << axis.y() << ' ' << axis.z() << "'/>";
    if (kind < 6) urdf << "<limit lower='-3' upper='3' effort='1' velocity='1'/>";
    if (kind < 7 && !leader.empty() && chance.below(3) == 0)
      urdf << "<mimic joint='" << leader << "' multiplier='" << chance.between(-2, 2) << "' offset='0.1'/>";
    else if (kind < 7)
      leader = "j" + std::to_string(i);
    urdf << "</joint>";
  }
  urdf << "</robot>";
  return modelOf(urdf.str());
}

/// Poses of a robot far from where its joints are at 0.
inline BodyPoses somePoses(const RobotModel& robot, const DegreesOfFreedom& columns, Chance& chance) {
  Eigen::VectorXd way(columns.size());
  for (int i = 0; i < columns.size(); ++i)
    way[i] = columns[i].kind == DegreeOfFreedom::Kind::Rotation ? chance.between(-3, 3) : chance.between(-0.3, 0.3);
  return moved(robot, columns, forwardKinematics(robot, {}), way);
}

}  // namespace proximity_server::scene
