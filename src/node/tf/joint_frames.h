#pragma once

#include "node/robot/robot.h"
#include "proximity_server/scene/model/kinematics.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace proximity_server::node {

/// The pose of the child link in the parent link for each of RobotModel::joints; nullopt if it is not known.
using JointFrames = std::vector<std::optional<Eigen::Isometry3d>>;

/// A number for each of RobotModel::joints; nullopt if none was given.
using JointValues = std::vector<std::optional<double>>;

/// The pose of each robot's root link. It is in the reference frame, or, if the reference frame is the frame of a link
/// (which joints may move), in the root link of the robot with that link. It is nullopt for that robot itself, and if
/// it is not known.
using RootPoses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Real joints exceed the velocity limits of their URDF. They are taken to be at most so many times as fast.
inline constexpr double kVelocityFactor = 2.0;

/// The transforms that are needed for the poses of `bodies` in the reference frame, as indices into Robot::tfEdges():
/// * the joints between the roots and these bodies,
/// * the joints above the reference frame, if it is the frame of a link,
/// * the edges to the roots of the robots that have some of the bodies; if there is a single robot, always the edge to
///   it.
std::vector<int> edgesTo(const Robot& robot, const std::vector<int>& bodies);

/// The position [rad] in (-pi, pi], or [m], of a joint with one position.
double positionAt(const scene::RobotModel& robot, int joint, const Eigen::Isometry3d& parent_T_child);

/// Returns whether `positions` has the position of a joint. For a mimic joint this is the position of its leader.
bool hasPosition(const scene::RobotModel& robot, int joint, const JointValues& positions);

/// The frames of joints at the given positions [rad] or [m]; mimic joints follow their leaders. A joint without a
/// position has its frame in `others`.
JointFrames framesAt(const scene::RobotModel& robot, const JointValues& positions, const JointFrames& others);

/// The poses of the bodies, each in the frame of the root link of its robot. Bodies beyond a joint whose frame is not
/// known have no pose. The result uses the memory of `reused`.
scene::BodyPoses posesInRoot(const scene::RobotModel& robot, const JointFrames& joints, scene::BodyPoses reused = {});

/// The pose of a root link in the reference frame. If the reference frame is the frame of a link, the root is the root
/// of the link's robot, and its pose follows from `poses_in_root`. Otherwise `pose_from_tf` is returned.
std::optional<Eigen::Isometry3d> referenceToRoot(const Robot& robot, const scene::BodyPoses& poses_in_root,
                                                 const std::optional<Eigen::Isometry3d>& pose_from_tf);

/// Transforms the poses of posesInRoot() into the reference frame. All poses of a robot become nullopt if the pose of
/// its root is not known.
scene::BodyPoses inReference(const Robot& robot, scene::BodyPoses poses_in_root, const RootPoses& roots);

}  // namespace proximity_server::node
