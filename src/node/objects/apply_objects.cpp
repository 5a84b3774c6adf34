#include "node/objects/apply_objects.h"

#include "node/robot/query_status.h"

#include <ros/console.h>

#include <exception>
#include <stdexcept>
#include <string>

namespace proximity_server::node {

ApplyObjectsResponse answer(ObjectStore& store, const ApplyObjectsRequest& request) {
  ApplyObjectsResponse response;
  response.node_start = store.nodeStart();
  try {
    const auto remarked = [&](const std::string& remark) { response.status = statusOf(QueryStatus::OK, remark); };
    response.revision = store.apply(request.changes, remarked);
    response.success = true;
    return response;
  } catch (const ChangeError& error) {
    response.status = statusOf(error.code(), error.what());
  } catch (const std::invalid_argument& error) {
    response.status = statusOf(QueryStatus::INVALID_ARGUMENT, error.what());
  } catch (const std::exception& error) {
    response.status = statusOf(QueryStatus::INTERNAL_ERROR, std::string("internal error: ") + error.what());
    ROS_ERROR_STREAM("objects were not changed because of a defect of proximity_server: " << response.status.message);
  }
  response.revision = store.revision();
  return response;
}

}  // namespace proximity_server::node
