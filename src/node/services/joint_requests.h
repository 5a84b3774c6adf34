#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "node/services/requests.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/model/kinematics.h"

// Reads the joints of a request. `where` begins the error messages: "state 2".
// Failure: throw RequestError INVALID_ARGUMENT naming `where` and the joint: an unknown joint (with the nearest known
//          name), a repeated or fixed one, a floating or planar one; too few or too many numbers; a number that is not
//          finite.

namespace proximity_server::node {

/// The joints of these names, as indices into RobotModel::joints.
std::vector<int> jointsNamed(const scene::RobotModel& robot, const std::vector<std::string>& names,
                             const std::string& where);

/// Checks the `values` of a request: one finite number for each of `joints`, of which none is repeated. `what` names
/// one value in error messages: "position".
JointValues valuesOf(const scene::RobotModel& robot, const std::vector<int>& joints, const std::vector<double>& values,
                     const std::string& what, const std::string& where);

/// The source of the positions of joints that a request does not name.
enum class MissingJoints { FromTf, AtZero };
MissingJoints missingJoints(std::uint8_t code);

/// The positions of a request; missing joints are at 0 if `missing` is AtZero.
JointValues completed(JointValues positions, MissingJoints missing);

/// Looks up in tf the joints that `bodies` need and that some of `states` does not give. Waits at most
/// Config::tf_timeout. If no joint is missing, tf is not asked and the stamp is 0.
JointSnapshot missingFromTf(const Robot& robot, TfPoses& tf, const std::vector<int>& bodies,
                            const std::vector<JointValues>& states, const ros::Time& stamp);

/// Looks up in tf the frames that are none of the robot's links, at the time of its joints. Waits at most
/// Config::tf_timeout.
FrameSnapshot framesFromTf(const Robot& robot, TfPoses& tf, AskedFrames frames, const JointSnapshot& joints,
                           const ros::Time& stamp);

/// The poses of the bodies in the frame of the root link, with the given positions and all other joints from tf.
scene::BodyPoses posesInRoot(const Robot& robot, const JointValues& positions, const JointSnapshot& from_tf);

}  // namespace proximity_server::node
