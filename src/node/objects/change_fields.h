#pragma once

#include "node/robot/robot.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/object_editor.h"

#include <geometry_msgs/Pose.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The reason why a change is refused, with the code of its QueryStatus.
class ChangeError : public std::invalid_argument {
 public:
  ChangeError(std::int8_t code, const std::string& reason) : std::invalid_argument(reason), code_(code) {}

  std::int8_t code() const { return code_; }

 private:
  std::int8_t code_;
};

/// How objects of a robot are made.
scene::ObjectOptions objectOptions(const Robot& robot);

/// The operation that removes an object.
scene::ObjectEdit removalOf(const std::string& id);

/// The changes of a message, read but not yet checked against the present objects. `error` is about the first field that
/// is wrong; then `edits` has only the changes before it.
struct ReadChanges {
  std::vector<scene::ObjectEdit> edits;
  std::optional<std::vector<scene::WrittenRule>> rules;
  std::optional<ChangeError> error;
  std::vector<std::string> tracked;  ///< names of tracked sources, whose objects the removal of all leaves
};

/// Reads a message, and makes the geometry of all objects with meshes that it adds or replaces. That may take seconds,
/// but it does not depend on other objects, so it can be done before other changes have to wait.
ReadChanges readChanges(const Robot& robot, const ObjectChanges& message);

/// Applies the changes of a message, which are moved away. Returns a text that names the first object that was to be
/// removed but was not there; "" if there is none.
/// Failure: throws ChangeError naming the number of the change, the object, the field and the reason.
std::string apply(ReadChanges& changes, scene::ObjectEditor& objects);

/// Adds an object of a file or a parameter. tf is not needed, because the pose is in the frame that carries the object.
/// Failure: throws std::invalid_argument naming its place in the file, the object, the field and the reason.
void add(const scene::ObjectEdit& object, scene::ObjectEditor& objects);

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose);

}  // namespace proximity_server::node
