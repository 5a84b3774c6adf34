#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Geometry>

#include <optional>

namespace proximity_server::scene {

/// Returns the pose with the rotation nearest to its matrix; nullopt if the pose is missing or not finite, or if its
/// matrix is not a rotation within single precision.
std::optional<Eigen::Isometry3d> usablePose(const std::optional<Eigen::Isometry3d>& pose);

/// The pose of a body that a joint carries, in the frame in which its parent body has the pose `parent`; `motion` is
/// the jointMotion() of the joint. Poses that are computed by this function have the same bits as the poses of
/// forwardKinematics().
inline Eigen::Isometry3d poseOnParent(const RobotModel& model, const Body& body, const Eigen::Isometry3d& parent,
                                      const Eigen::Isometry3d& motion) {
  const Joint& joint = model.joints[body.joint];
  const Link& link = model.links[joint.parent_link];
  // Most joints are defined in the frame of their parent body, which is the frame of its first link.
  const bool is_first = model.bodies[link.body].link == joint.parent_link;
  Eigen::Isometry3d pose = is_first ? parent * joint.parent_T_joint : parent * link.body_T_link * joint.parent_T_joint;
  if (joint.type == Joint::Type::Prismatic)
    pose.translation() += pose.linear() * motion.translation();
  else
    pose.linear() = pose.linear() * motion.linear();
  return pose;
}

/// The position of a joint that follows `leader`, which is at `position`; see RobotModel::leaderOf().
inline double followedPosition(const Joint::Mimic& leader, double position) {
  return leader.offset + leader.multiplier * position;
}

}  // namespace proximity_server::scene
