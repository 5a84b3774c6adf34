#pragma once

#include "node/services/joint_requests.h"
#include "node/services/requests.h"
#include "node/tf/joint_frames.h"
#include "proximity_server/QueryTrajectoryRequest.h"
#include "proximity_server/scene/motion/joint_spline.h"

#include <trajectory_msgs/JointTrajectory.h>

#include <cstdint>
#include <string>
#include <vector>

// These functions read the trajectory of a request.
// Failure: they throw RequestError INVALID_ARGUMENT naming the field, point or joint that is wrong.

namespace proximity_server::node {

/// [rad] or [m] A position is beyond a limit by more than this: positions may be written with six decimals.
inline constexpr double kWritingError = 1e-6;

/// The points of a trajectory.
struct WayPoints {
  std::vector<int> joints;  ///< the joints that the trajectory names, as indices into RobotModel::joints
  MissingJoints missing =
      MissingJoints::FromTf;  ///< where all others rest; their positions in `points` are 0 and mean nothing
  /// With the velocities and accelerations that the interpolation of the request uses, if the point has them.
  std::vector<scene::TrajectoryPoint> points;
  std::vector<int> assumed;  ///< the joints of which the first point assumes the turn, see isTurnAssumed()

  /// The positions at a state of the trajectory; nullopt for a joint that rests as in tf.
  JointValues valuesAt(const scene::Positions& positions) const;
};
WayPoints wayPointsOf(const Robot& robot, const QueryTrajectoryRequest& request);

/// The points of a trajectory that names joints. `interpolation` is one of QueryTrajectoryRequest.
WayPoints wayPointsOf(const Robot& robot, const trajectory_msgs::JointTrajectory& trajectory,
                      std::uint8_t interpolation);

/// The points of a trajectory as a controller drives them from the state of tf at time 0, see scene::drivenFrom().
/// `from_tf` has all joints of the points.
WayPoints drivenFromPresent(const Robot& robot, const WayPoints& points, const JointSnapshot& from_tf,
                            const QueryTrajectoryRequest& request);

/// How far each of RobotModel::joints may be off the motion [rad] or [m]; empty: every joint follows it exactly.
std::vector<double> trackingErrorOf(const Robot& robot, const WayPoints& points, const QueryTrajectoryRequest& request);

/// The motion for which an answer holds, in words.
std::string motionText(const Robot& robot, const WayPoints& points, const std::vector<double>& tracking_error,
                       const QueryTrajectoryRequest& request);

}  // namespace proximity_server::node
