#pragma once

#include <geometry_msgs/Pose.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "proximity_server/ObjectChange.h"
#include "proximity_server/scene/objects/object_editor.h"

namespace proximity_server::node {

/// Why a change is refused, with the code of its QueryStatus.
class ChangeError : public std::invalid_argument {
 public:
  ChangeError(std::int8_t code, const std::string& reason) : std::invalid_argument(reason), code_(code) {}

  /// The same error behind the words `where`.
  static ChangeError within(const std::string& where, const std::invalid_argument& error);

  std::int8_t code() const { return code_; }

 private:
  std::int8_t code_;
};

/// Throws std::invalid_argument naming the field and the reason.
[[noreturn]] void refuseField(const std::string& field, const std::string& reason);

/// Refuses a name of a client that is too long, as every cycle of the monitor may have to publish it.
void requireLength(const std::string& name, const std::string& field);

/// A name for an error, which is logged, of bounded length.
std::string shortened(const std::string& name);

/// The pose, which is finite and not too far from its frame.
Eigen::Isometry3d requireReach(const Eigen::Isometry3d& pose);

/// Reads a change; whether its objects, links and frames exist is not known here. The shapes of a MOVE are read by movedShapes().
/// Failure: throws std::invalid_argument naming the field and the reason.
scene::ObjectEdit editOf(const ObjectChange& change);

/// The shapes of an object in the poses that a MOVE has for kinds of them; empty if it has none.
/// Failure: throws std::invalid_argument naming the field and the reason.
std::vector<scene::ObjectShape> movedShapes(const ObjectChange& change, const std::vector<scene::ObjectShape>& shapes);

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose);

}  // namespace proximity_server::node
