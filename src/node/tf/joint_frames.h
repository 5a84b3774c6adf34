#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "node/robot/robot.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {

/// For each of RobotModel::joints the pose of its child link in its parent link; nullopt if it is not known.
using JointFrames = std::vector<std::optional<Eigen::Isometry3d>>;

/// For each of RobotModel::joints a number, or nullopt if none was given.
using JointValues = std::vector<std::optional<double>>;

/// The joints between the root and `bodies`, and those that carry the reference frame where that is a link.
std::vector<int> jointsTo(const Robot& robot, const std::vector<int>& bodies);

/// Whether `positions` [rad] or [m] give the position of a joint: its own, or that of its leader if it is a mimic
/// joint.
bool isGiven(const scene::RobotModel& robot, int joint, const JointValues& positions);

/// Joints at the given positions [rad] or [m], followers with their leaders; all others as in `others`.
JointFrames framesAt(const scene::RobotModel& robot, const JointValues& positions, const JointFrames& others);

/// The bodies in the root link's frame; nothing for what a joint carries that is not known. `room` are poses that are
/// not needed any more: their memory is used again.
scene::BodyPoses posesInRoot(const scene::RobotModel& robot, const JointFrames& joints, scene::BodyPoses room = {});

/// The root link in the reference frame. A link of the robot stands where `poses_in_root` have it, any other frame as
/// given in `foreign`.
std::optional<Eigen::Isometry3d> referenceToRoot(const Robot& robot, const scene::BodyPoses& poses_in_root,
                                                 const std::optional<Eigen::Isometry3d>& foreign);

/// Poses in the reference frame; all are nullopt if that frame is not known.
scene::BodyPoses inReference(const Robot& robot, scene::BodyPoses poses_in_root,
                             const std::optional<Eigen::Isometry3d>& foreign);

}  // namespace proximity_server::node
