#pragma once

#include "node/services/requests.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/model/kinematics.h"

#include <cstdint>
#include <string>
#include <vector>

// These functions read the joints of a request. Error messages begin with `where`: "state 2".
// Failure: they throw RequestError INVALID_ARGUMENT naming `where` and the joint for a joint that is unknown (with the
//          nearest known name), repeated, fixed, floating or planar; for too few or too many numbers; for a number that
//          is not finite.

namespace proximity_server::node {

/// The joints with these names, as indices into RobotModel::joints.
std::vector<int> jointsNamed(const scene::RobotModel& robot, const std::vector<std::string>& names,
                             const std::string& where);

/// Returns the `values` of a request by joint. There must be one finite number for each of `joints`. Error messages
/// call a value `what`: "position".
JointValues valuesOf(const scene::RobotModel& robot, const std::vector<int>& joints, const std::vector<double>& values,
                     const std::string& what, const std::string& where);

/// The source of the positions of joints that a request does not name.
enum class MissingJoints { FromTf, AtZero };
MissingJoints missingJoints(std::uint8_t code);

/// Sets missing positions to 0 if `missing` is AtZero.
JointValues completed(JointValues positions, MissingJoints missing);

/// Looks up in tf those joints that the poses of `bodies` need and that are missing in at least one of `states`, and
/// the edges to the roots of robots. Waits at most Config::tf_timeout. If nothing is missing, tf is not asked, and the
/// stamp is 0. Those of `joints` are looked up in any case.
JointSnapshot missingFromTf(const Robot& robot, TfPoses& tf, const std::vector<int>& bodies,
                            const std::vector<JointValues>& states, const ros::Time& stamp,
                            const std::vector<int>& joints = {});

/// Looks up in tf the needed frames that are not frames of links, at the time of the joints. Waits at most
/// Config::tf_timeout.
FrameSnapshot framesFromTf(const Robot& robot, TfPoses& tf, CarrierFrames frames, const JointSnapshot& joints,
                           const ros::Time& stamp);

/// The turn of a revolute joint if nothing tells it. Returns the position within the limits that is nearest to `next`,
/// where the joint goes first; if none is within them, the one nearest to them.
double onTurnNearestTo(double next, double position, const scene::Joint& joint);

/// The position [rad] or [m] of a joint in tf, which `from_tf` must have, on the turn that joint_states tell, or else
/// onTurnNearestTo(next).
double presentPosition(const Robot& robot, int joint, const JointSnapshot& from_tf, double next);

/// Returns whether the turn of a joint at such a position is an assumption: joint_states do not tell it, and the limits
/// allow another one.
bool isTurnAssumed(const Robot& robot, int joint, const JointSnapshot& from_tf, double position);

/// The joints without a position in a state whose other joints share an inequality with them.
std::vector<int> coupledJoints(const scene::RobotModel& robot, const std::vector<JointValues>& states);

/// The positions of a state for inequalities: the given ones, or else the positions of tf; NaN where neither has one.
scene::Positions positionsOf(const Robot& robot, const JointValues& given, const JointSnapshot& from_tf);

/// A text about the inequality that these positions break most; "" if they break none.
std::string brokenText(const Robot& robot, const JointValues& given, const JointSnapshot& from_tf);

/// The poses of the bodies in the frame of the root link of their robot. Joints without a given position are taken from
/// tf.
scene::BodyPoses posesInRoot(const Robot& robot, const JointValues& positions, const JointSnapshot& from_tf);

}  // namespace proximity_server::node
