#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "node/services/requests.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/model/kinematics.h"

// What a request means by its joints. `where` begins the messages: "state 2".
// Failure: throw RequestError INVALID_ARGUMENT naming `where` and the joint: one that is unknown (with the nearest one
//          that is known), repeated, fixed, or has not one position; too few or many numbers; one that is not finite.

namespace proximity_server::node {

/// The joints of these names, as indices into RobotModel::joints.
std::vector<int> jointsNamed(const scene::RobotModel& robot, const std::vector<std::string>& names,
                             const std::string& where);

/// One value for each of `joints`, which are not repeated; `what` they are, in the singular: "position".
JointValues valuesOf(const scene::RobotModel& robot, const std::vector<int>& joints, const std::vector<double>& values,
                     const std::string& what, const std::string& where);

/// Where joints stand that a request does not name.
enum class MissingJoints { FromTf, AtZero };
MissingJoints missingJoints(std::uint8_t code);

/// The positions of a request, with what it says about missing joints.
JointValues completed(JointValues positions, MissingJoints missing);

/// What tf has to add so that `bodies` have poses in all of `states`. Waits at most Config::tf_timeout; where nothing
/// is missing tf is not asked, and the stamp is 0.
JointSnapshot missingFromTf(const Robot& robot, TfPoses& tf, const std::vector<int>& bodies,
                            const std::vector<JointValues>& states, const ros::Time& stamp);

/// The bodies at these positions, all else as tf has it, in the frame of the root link.
scene::BodyPoses posesInRoot(const Robot& robot, const JointValues& positions, const JointSnapshot& from_tf);

}  // namespace proximity_server::node
