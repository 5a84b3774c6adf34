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

/// The pose of the root link of each robot in the reference frame; if that is the frame of a link, which its joints may move, in
/// the root link of that robot. nullopt if it is not known, and of that robot itself.
using RootPoses = std::vector<std::optional<Eigen::Isometry3d>>;

/// The transforms that give the poses of `bodies` in the reference frame, as indices into Robot::tfEdges(): the joints between
/// the roots and these bodies, those above the reference frame if that is the frame of a link, and the edges to the roots of
/// the robots that have some of the bodies; of a single robot always.
std::vector<int> edgesTo(const Robot& robot, const std::vector<int>& bodies);

/// Whether `positions` [rad] or [m] give the position of a joint: its own, or that of its leader if it is a mimic
/// joint.
bool isGiven(const scene::RobotModel& robot, int joint, const JointValues& positions);

/// The frames of joints at the given positions [rad] or [m], with mimic joints at those of their leaders. The frames of
/// all other joints are those of `others`.
JointFrames framesAt(const scene::RobotModel& robot, const JointValues& positions, const JointFrames& others);

/// The poses of the bodies, each in the frame of the root link of its robot; nullopt for bodies beyond a joint whose frame is not known. `room`
/// are poses that are not needed any more: their memory is used again.
scene::BodyPoses posesInRoot(const scene::RobotModel& robot, const JointFrames& joints, scene::BodyPoses room = {});

/// The pose of a root link in the reference frame. If that is the frame of a link, the pose is that of the root of its robot,
/// and follows from `poses_in_root`; otherwise it is `foreign`.
std::optional<Eigen::Isometry3d> referenceToRoot(const Robot& robot, const scene::BodyPoses& poses_in_root,
                                                 const std::optional<Eigen::Isometry3d>& foreign);

/// Transforms the poses of posesInRoot() into the reference frame; those of a robot are nullopt if the pose of its root is not
/// known.
scene::BodyPoses inReference(const Robot& robot, scene::BodyPoses poses_in_root, const RootPoses& roots);

}  // namespace proximity_server::node
