#pragma once

#include "node/robot/robot.h"
#include "node/tf/stated_joints.h"
#include "proximity_server/QueryStatus.h"

#include <ros/time.h>

#include <vector>

namespace proximity_server::node {

/// The joint velocities of joint_states, with a status that says why one is missing.
struct VelocitySnapshot {
  /// [rad/s] or [m/s] of each of RobotModel::joints; 0 if it was not requested, NaN if it is missing or too old. Empty if
  /// nobody needs velocities.
  std::vector<double> velocities;
  std::vector<ros::Time> stamps;  ///< of the messages with the velocities
  QueryStatus roots;              ///< of TfPoses::standingStill(); OK if it was not asked
  QueryStatus status;             ///< OK, or NO_VELOCITY with the name of a joint whose velocity is missing or too old
};

/// The latest velocities of `joints`. The status is not OK if one of them is farther from `now` than
/// Config::max_tf_age.
VelocitySnapshot velocitiesOf(const Robot& robot, const StatedJoints& stated, const std::vector<int>& joints,
                              const ros::Time& now);

}  // namespace proximity_server::node
