#pragma once

#include "node/objects/object_store.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/ApplyObjects.h"

namespace proximity_server::node {

/// The service apply_objects. Never throws: an error becomes the status of the response.
ApplyObjectsResponse answer(ObjectStore& store, const ApplyObjectsRequest& request);

/// Finds frames in tf; waits at most Config::tf_timeout for the robot, and as long for the frame.
FindFrame frameFinder(TfPoses& tf);

}  // namespace proximity_server::node
