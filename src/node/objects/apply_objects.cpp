#include "node/objects/apply_objects.h"

#include <ros/console.h>

#include <exception>
#include <stdexcept>
#include <string>

namespace proximity_server::node {

ApplyObjectsResponse answer(ObjectStore& store, const ApplyObjectsRequest& request) {
  ApplyObjectsResponse response;
  response.node_start = store.nodeStart();
  try {
    response.revision = store.apply(request.changes);
    response.success = true;
    return response;
  } catch (const ChangeError& error) {
    response.status.code = error.code();
    response.status.message = error.what();
  } catch (const std::invalid_argument& error) {
    response.status.code = QueryStatus::INVALID_ARGUMENT;
    response.status.message = error.what();
  } catch (const std::exception& error) {
    response.status.code = QueryStatus::INTERNAL_ERROR;
    response.status.message = std::string("internal error: ") + error.what();
    ROS_ERROR_STREAM("objects were not changed because of a defect of proximity_server: " << error.what());
  }
  response.revision = store.revision();
  return response;
}

}  // namespace proximity_server::node
