#pragma once

#include "proximity_server/ObjectChange.h"
#include "proximity_server/scene/objects/object_editor.h"

#include <geometry_msgs/Pose.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The reason why a change is refused, with the code of its QueryStatus.
class ChangeError : public std::invalid_argument {
 public:
  ChangeError(std::int8_t code, const std::string& reason) : std::invalid_argument(reason), code_(code) {}

  /// Returns the error with `where` in front of its text. The code is that of `error` if it is a ChangeError, otherwise
  /// INVALID_ARGUMENT.
  static ChangeError within(const std::string& where, const std::invalid_argument& error);

  std::int8_t code() const { return code_; }

 private:
  std::int8_t code_;
};

/// Throws std::invalid_argument naming the field and the reason.
[[noreturn]] void refuseField(const std::string& field, const std::string& reason);

/// Refuses a name that is too long, because every cycle of the monitor may have to publish it. `field` has the name.
void requireLength(const std::string& name, const std::string& field);

/// Returns the pose. Refuses it if it is not finite or too far from its frame.
Eigen::Isometry3d requireReach(const Eigen::Isometry3d& pose);

/// Reads a change, except for the shapes of a MOVE, which movedShapes() reads. It is not checked whether the objects,
/// links and frames exist.
/// Failure: throws std::invalid_argument naming the field and the reason.
scene::ObjectEdit editOf(const ObjectChange& change);

/// Returns the shapes of an object at the poses that a MOVE has for shapes. Kinds of shapes for which it has no poses
/// stay where they are. Returns no shapes if it has no poses at all.
/// Failure: throws std::invalid_argument naming the field and the reason.
std::vector<scene::ObjectShape> movedShapes(const ObjectChange& change, const std::vector<scene::ObjectShape>& shapes);

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose);

}  // namespace proximity_server::node
