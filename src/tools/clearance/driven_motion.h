#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/motion/joint_spline.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"

#include <string>
#include <vector>

// Options about how far joints may be off, and about the motion that a controller makes of a trajectory.

namespace proximity_server::tools {

/// How far each joint may be off its motion.
struct TrackingError {
  std::vector<double> of_joints;  ///< [rad] or [m] for each of RobotModel::joints; empty: every joint follows exactly
  std::vector<std::string> warnings;
};

/// Reads --tracking-error: a number [rad] or [m] of every joint, an angle ("0.5deg") of those that turn, or the name of
/// a YAML file with {JOINT: number or angle} ("*" for all others), or with the `constraints` of a
/// joint_trajectory_controller, of which `trajectory` counts. A joint that the file does not name is exact.
/// Failure: throws std::invalid_argument naming the option or the file with the line, and the joint; also for a joint
///          whose error the controller does not limit.
TrackingError trackingErrorFrom(const std::string& text, const scene::RobotModel& robot);

/// How far the true state may be from the one that is stated.
struct JointUncertainty {
  scene::Uncertainty of_robot;
  std::vector<std::string> warnings{};
};

/// Reads --joint-uncertainty: a number [rad] or [m] of every joint, an angle of those that turn, or the name of a file, see
/// scene::uncertaintyFrom().
/// Failure: throws std::invalid_argument naming the option or the file.
JointUncertainty uncertaintyFrom(const std::string& text, const scene::RobotModel& robot);

/// Reads --start: positions as "JOINT=POSITION,...", all others at 0 and at rest; or the name of a file with one state,
/// with velocities if there are columns of them. The time is 0, and the accelerations are 0.
/// Failure: throws std::invalid_argument naming the option or the file, and the joint.
scene::TrajectoryPoint startFrom(const std::string& text, const scene::RobotModel& robot);

}  // namespace proximity_server::tools
