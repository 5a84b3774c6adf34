#pragma once

#include "node/objects/object_store.h"
#include "proximity_server/ApplyObjects.h"

namespace proximity_server::node {

/// Answers a request of the service apply_objects. Never throws: an error becomes the status of the response.
ApplyObjectsResponse answer(ObjectStore& store, const ApplyObjectsRequest& request);

}  // namespace proximity_server::node
