#pragma once

#include <proximity_server/ApplyObjects.h>
#include <proximity_server/ObjectChanges.h>

#include <shape_msgs/SolidPrimitive.h>

#include <string>
#include <utility>
#include <vector>

// Changes of objects as messages. The objects are balls of radius 0.1 m where nothing else is said.

namespace proximity_server::node {

inline shape_msgs::SolidPrimitive primitive(std::uint8_t type, const std::vector<double>& dimensions) {
  shape_msgs::SolidPrimitive result;
  result.type = type;
  result.dimensions.assign(dimensions.begin(), dimensions.end());
  return result;
}

/// A pose with a quaternion of zeros, which stands for no rotation.
inline geometry_msgs::Pose poseAt(double x, double y, double z) {
  geometry_msgs::Pose pose;
  pose.position.x = x;
  pose.position.y = y;
  pose.position.z = z;
  return pose;
}

inline ObjectChange change(std::uint8_t operation, const std::string& id) {
  ObjectChange result;
  result.operation = operation;
  result.id = id;
  return result;
}
inline ObjectChange addBall(const std::string& id, const geometry_msgs::Pose& pose = {}) {
  ObjectChange result = change(ObjectChange::ADD, id);
  result.primitives = {primitive(shape_msgs::SolidPrimitive::SPHERE, {0.1})};
  result.pose = pose;
  return result;
}
/// The ball moves with the frame in which it is placed.
inline ObjectChange addBallInFrame(const std::string& id, const std::string& frame,
                                   const geometry_msgs::Pose& pose = {}) {
  ObjectChange result = addBall(id, pose);
  result.frame = result.header.frame_id = frame;
  return result;
}
/// The link takes the object where it is.
inline ObjectChange attach(const std::string& id, const std::string& link) {
  ObjectChange result = change(ObjectChange::ATTACH, id);
  result.link = link;
  result.keep_pose = true;
  return result;
}
inline ObjectChange moveTo(const std::string& id, const geometry_msgs::Pose& pose) {
  ObjectChange result = change(ObjectChange::MOVE, id);
  result.pose = pose;
  return result;
}

inline ObjectChanges messageOf(std::vector<ObjectChange> changes) {
  ObjectChanges message;
  message.changes = std::move(changes);
  return message;
}
inline ApplyObjectsRequest requestOf(std::vector<ObjectChange> changes) {
  ApplyObjectsRequest request;
  request.changes = messageOf(std::move(changes));
  return request;
}

}  // namespace proximity_server::node
