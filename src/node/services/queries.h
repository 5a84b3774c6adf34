#pragma once

#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/FirstContact.h"
#include "proximity_server/MinimumDistance.h"
#include "proximity_server/PenetrationDepth.h"
#include "proximity_server/ProveJointBox.h"
#include "proximity_server/QueryConfiguration.h"
#include "proximity_server/QueryPairs.h"
#include "proximity_server/QueryPoints.h"
#include "proximity_server/QueryRays.h"
#include "proximity_server/QueryTrajectory.h"
#include "proximity_server/SeparationAxis.h"

// Each function answers a request of one service. It never throws: an error becomes the status of the response, in
// which every number that is not proven is then NaN. It waits at most Config::tf_timeout for the transforms of the
// robot, and then at most as long for the frames of moving objects. Several threads may call the functions at the same
// time.

namespace proximity_server::node {

MinimumDistanceResponse answer(const Robot& robot, TfPoses& tf, const MinimumDistanceRequest& request);
SeparationAxisResponse answer(const Robot& robot, TfPoses& tf, const SeparationAxisRequest& request);
PenetrationDepthResponse answer(const Robot& robot, TfPoses& tf, const PenetrationDepthRequest& request);
QueryPairsResponse answer(const Robot& robot, TfPoses& tf, const QueryPairsRequest& request);
QueryPointsResponse answer(const Robot& robot, TfPoses& tf, const QueryPointsRequest& request);
QueryRaysResponse answer(const Robot& robot, TfPoses& tf, const QueryRaysRequest& request);
QueryConfigurationResponse answer(const Robot& robot, TfPoses& tf, const QueryConfigurationRequest& request);
FirstContactResponse answer(const Robot& robot, TfPoses& tf, const FirstContactRequest& request);
QueryTrajectoryResponse answer(const Robot& robot, TfPoses& tf, const QueryTrajectoryRequest& request);
ProveJointBoxResponse answer(const Robot& robot, TfPoses& tf, const ProveJointBoxRequest& request);

}  // namespace proximity_server::node
