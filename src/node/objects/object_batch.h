#pragma once

#include "node/objects/change_frames.h"
#include "node/robot/robot.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/scene/objects/object_editor.h"

#include <map>
#include <memory>
#include <string>

namespace proximity_server::node {

/// The geometry of objects that changes add, made before the changes are applied.
using PreparedGeometry = std::map<const ObjectChange*, std::shared_ptr<const scene::ObjectGeometry>>;

/// Makes the geometry of all objects with meshes that `message` adds or replaces. That may take seconds, but it does
/// not depend on other objects, so it can be done before other changes have to wait. It ends at the first change that
/// is wrong.
PreparedGeometry prepareGeometry(const Robot& robot, const ObjectChanges& message);

/// Applies messages of changes to an ObjectEditor. It checks them first, so that an error names the field of the
/// message that is wrong.
class ObjectBatch {
 public:
  /// All arguments must outlive the batch. `prepared` must have been made with the same robot.
  ObjectBatch(const Robot& robot, const scene::Objects& before, const FindFrame& find_frame,
              const PreparedGeometry& prepared);

  /// Failure: throws ChangeError naming the number of the change, the object, the field and the reason.
  void apply(const ObjectChanges& message);

  /// Adds an object of a file or a parameter. tf is not needed, because the pose is in the frame that carries the
  /// object.
  /// Failure: throws std::invalid_argument naming its place in the file, the object, the field and the reason.
  void add(const scene::ObjectEdit& object);

  scene::ObjectEditor& objects() { return objects_; }

 private:
  void apply(const ObjectChange& change);
  void check(const scene::ObjectEdit& edit) const;
  void checkPlace(const scene::ObjectEdit& edit, const scene::Object* before) const;
  void requireUsableId(const std::string& id) const;
  const scene::Object& require(const std::string& id) const;

  const Robot& robot_;
  const PreparedGeometry& prepared_;
  ChangeFrames frames_;
  const scene::ObjectOptions options_;
  scene::ObjectEditor objects_;
};

}  // namespace proximity_server::node
