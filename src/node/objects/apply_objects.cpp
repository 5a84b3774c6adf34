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

FindFrame frameFinder(TfPoses& tf) {
  return [&tf](const Robot& robot, const std::string& frame) -> Eigen::Isometry3d {
    const AskedFrames asked{{frame}, {0}};
    const PoseSnapshot at = tf.await(robot, bodiesOf(robot, asked), ros::Time());
    const FrameSnapshot found = tf.awaitFrames(robot, asked, at, ros::Time());
    if (found.poses.front()) return *found.poses.front();
    const QueryStatus& why = at.status.code == QueryStatus::OK ? found.status : at.status;
    const bool says_why = why.code != QueryStatus::OK;
    throw ChangeError(says_why ? why.code : static_cast<std::int8_t>(QueryStatus::TF_UNAVAILABLE),
                      "frame '" + frame + "' has no pose: " + why.message);
  };
}

}  // namespace proximity_server::node
