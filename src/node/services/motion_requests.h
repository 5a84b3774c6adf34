#pragma once

#include <vector>

#include "node/services/requests.h"
#include "node/services/timed_motion.h"
#include "node/tf/joint_frames.h"
#include "proximity_server/FirstContactRequest.h"
#include "proximity_server/QueryTrajectoryRequest.h"
#include "proximity_server/scene/model/kinematics.h"

// What a request means by its motion.
// Failure: throw RequestError INVALID_ARGUMENT naming the number, point, joint or link.

namespace proximity_server::node {

/// The numbers of both requests, without a deadline.
scene::MotionQuestion motionQuestion(double contact_distance, double tolerance);

/// [s] Throws RequestError OVER_BUDGET where that is more than Config::max_request_time.
double timeBudget(const Robot& robot, const ros::Duration& asked);

/// From poses in the reference frame on.
TimedMotion motionOf(const Robot& robot, const scene::BodyPoses& poses, const FirstContactRequest& request);

/// The points of a trajectory.
struct WayPoints {
  std::vector<int> joints;             ///< those that are named, indices into RobotModel::joints
  std::vector<JointValues> positions;  ///< [rad] or [m] of each point
  std::vector<double> times;           ///< [s]
};
WayPoints wayPointsOf(const Robot& robot, const QueryTrajectoryRequest& request);

/// What every joint travels [rad] or [m] from one state to another; 0 where nothing is given.
std::vector<double> travelBetween(const JointValues& from, const JointValues& to);

}  // namespace proximity_server::node
