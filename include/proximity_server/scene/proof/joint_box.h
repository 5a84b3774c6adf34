#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// A box of joint positions: an interval for each joint that has one position and follows no other one. The two ends of
/// an interval may be equal; then the joint is fixed. Mimic joints follow their leader, whatever their own limits are.
using JointBox = std::vector<JointRange>;

/// The box of all states that the URDF allows: jointRanges() without the joints whose range is not known, and without
/// those that a joint follows whose range is not known, see hasKnownRange().
JointBox knownRanges(const RobotModel& robot);

/// The positions within the limits that differ from `state` [rad] or [m] by at most `radii` [rad] or [m], both with one
/// entry for each of RobotModel::joints; mimic joints are ignored. Joints without limits are not cut, and a
/// continuous joint may go beyond a turn.
/// Throws std::invalid_argument, naming the joint, if there are none, for a state that is not finite, for radii that
/// are negative or not finite, and for a wrong size of either.
JointBox boxAbout(const RobotModel& robot, const Positions& state, const std::vector<double>& radii);

/// Reads YAML with an interval, or one position, for each joint that it names; all others have the intervals of `box`:
///
///   elbow: [-0.5, 1.2]
///   lift: 0.3
///
/// Failure: throws std::invalid_argument with `source`, the line, the joint and the reason: a joint that does not
///          exist, that has no single position or that follows another one, a lower end above the upper one, no finite
///          number.
JointBox jointBoxFrom(const std::string& yaml, const std::string& source, const RobotModel& robot, JointBox box);

}  // namespace proximity_server::scene
