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

/// The joints between the root and `bodies`, and those above the reference frame if that is the frame of a link.
std::vector<int> jointsTo(const Robot& robot, const std::vector<int>& bodies);

/// Whether `positions` [rad] or [m] give the position of a joint: its own, or that of its leader if it is a mimic
/// joint.
bool isGiven(const scene::RobotModel& robot, int joint, const JointValues& positions);

/// The frames of joints at the given positions [rad] or [m], with mimic joints at those of their leaders. The frames of
/// all other joints are those of `others`.
JointFrames framesAt(const scene::RobotModel& robot, const JointValues& positions, const JointFrames& others);

/// The poses of the bodies in the root link's frame; nullopt for bodies beyond a joint whose frame is not known. `room`
/// are poses that are not needed any more: their memory is used again.
scene::BodyPoses posesInRoot(const scene::RobotModel& robot, const JointFrames& joints, scene::BodyPoses room = {});

/// The pose of the root link in the reference frame. If that is the frame of a link, the pose follows from
/// `poses_in_root`; otherwise it is `foreign`.
std::optional<Eigen::Isometry3d> referenceToRoot(const Robot& robot, const scene::BodyPoses& poses_in_root,
                                                 const std::optional<Eigen::Isometry3d>& foreign);

/// Transforms poses into the reference frame; all are nullopt if the pose of that frame is not known.
scene::BodyPoses inReference(const Robot& robot, scene::BodyPoses poses_in_root,
                             const std::optional<Eigen::Isometry3d>& foreign);

}  // namespace proximity_server::node
