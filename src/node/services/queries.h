#pragma once

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/FirstContact.h"
#include "proximity_server/MinimumDistance.h"
#include "proximity_server/PenetrationDepth.h"
#include "proximity_server/QueryConfiguration.h"
#include "proximity_server/QueryPairs.h"
#include "proximity_server/QueryTrajectory.h"
#include "proximity_server/SeparationAxis.h"

// The services, one function each. They never throw: an error becomes the status of the response, and then every number
// that is not proven is NaN. They wait at most Config::tf_timeout for the robot, and as long
// for the frames of moving objects. Any number of threads may call them concurrently.

namespace proximity_server::node {

MinimumDistanceResponse answer(const Robot& robot, TfPoses& tf, const MinimumDistanceRequest& request);
SeparationAxisResponse answer(const Robot& robot, TfPoses& tf, const SeparationAxisRequest& request);
PenetrationDepthResponse answer(const Robot& robot, TfPoses& tf, const PenetrationDepthRequest& request);
QueryPairsResponse answer(const Robot& robot, TfPoses& tf, const QueryPairsRequest& request);
QueryConfigurationResponse answer(const Robot& robot, TfPoses& tf, const QueryConfigurationRequest& request);
FirstContactResponse answer(const Robot& robot, TfPoses& tf, const FirstContactRequest& request);
QueryTrajectoryResponse answer(const Robot& robot, TfPoses& tf, const QueryTrajectoryRequest& request);

}  // namespace proximity_server::node
