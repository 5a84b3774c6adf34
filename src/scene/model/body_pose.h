#pragma once

#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::scene {

/// The pose of a body that a joint carries, in the frame in which its parent body has the pose `parent`; the joint stands at
/// `position` [rad] or [m]. Whoever computes poses by this function gets the bits of forwardKinematics().
inline Eigen::Isometry3d poseOnParent(const RobotModel& model, const Body& body, const Eigen::Isometry3d& parent,
                                      double position) {
  const Joint& joint = model.joints[body.joint];
  const Link& link = model.links[joint.parent_link];
  // Most joints begin in the frame of their parent body, which is that of its first link.
  const bool is_first = model.bodies[link.body].link == joint.parent_link;
  Eigen::Isometry3d pose = is_first ? parent * joint.parent_T_joint : parent * link.body_T_link * joint.parent_T_joint;
  const Eigen::Isometry3d motion = jointMotion(joint, position);
  if (joint.type == Joint::Type::Prismatic)
    pose.translation() += pose.linear() * motion.translation();
  else
    pose.linear() = pose.linear() * motion.linear();
  return pose;
}

/// Where a joint stands that follows `leader`, which is at `position`; see RobotModel::leaderOf().
inline double followedPosition(const Joint::Mimic& leader, double position) {
  return leader.offset + leader.multiplier * position;
}

}  // namespace proximity_server::scene
