#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <vector>

namespace proximity_server::benchmark {

using namespace scene;

/// Returns states of a robot that have nothing to do with each other: every joint uniform within its limits, a full
/// turn either way where it has none. The same on every run.
std::vector<BodyPoses> randomStates(const RobotModel& robot, int states);

/// Joint positions [rad] or [m]: a row for each state, a column for each of RobotModel::joints.
using PositionTable = Eigen::MatrixXd;

/// Returns the positions of one state.
std::vector<double> positionsOf(const PositionTable& table, Eigen::Index state);

/// Returns the positions of random states as above.
PositionTable randomPositions(const RobotModel& robot, int states);

/// Returns states along edges as a planner checks them: from one random state to the next, linear in the joints, in
/// equal steps in which the fastest joint moves by no more than 1 degree (a prismatic joint: 1.75 cm). The same on
/// every run.
PositionTable edgePositions(const RobotModel& robot, int states);

/// Returns a smooth motion at 1 kHz: each joint swings about the middle of its limits as a sine of its own frequency,
/// between 0.1 and 0.5 Hz where its limits allow, at a peak of 1 rad/s (0.1 m/s of a prismatic joint) or of its own
/// limit where that is lower.
std::vector<BodyPoses> coherentMotion(const RobotModel& robot, int states);

/// Every joint at constant velocity for one second.
struct JointMotion {
  std::vector<double> from, to;  ///< [rad] or [m]
};

/// Returns such motions that have nothing to do with each other: starts as randomStates has them, velocities uniform
/// within those that the joint may have (1 rad/s or m/s where none is stated), and an end that is kept within the
/// limits. They are the same on every run.
std::vector<JointMotion> randomJointMotions(const RobotModel& robot, int motions);

}  // namespace proximity_server::benchmark
