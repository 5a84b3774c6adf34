#pragma once

#include <map>
#include <memory>
#include <string>

#include "node/objects/change_frames.h"
#include "node/robot/robot.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/scene/objects/object_editor.h"

namespace proximity_server::node {

/// The geometry of changes, made before it is their turn.
using MadeAhead = std::map<const ObjectChange*, std::shared_ptr<const scene::ObjectGeometry>>;

/// Makes the geometry of objects with meshes that are added. That may take seconds, but needs no other object, so that it need not
/// delay changes of them. What cannot be made is left out.
MadeAhead madeAhead(const Robot& robot, const ObjectChanges& message);

/// Applies messages of changes to the editor of objects, and says which field is wrong before the editor says what is wrong.
class ObjectBatch {
 public:
  /// All must outlive it; `made` was made with the same robot.
  ObjectBatch(const Robot& robot, const scene::Objects& before, const FindFrame& find_frame, const MadeAhead& made);

  /// Failure: throws ChangeError naming the number of the change, the object, the field and the reason.
  void apply(const ObjectChanges& message);

  /// Adds an object of a file or a parameter. Its pose is in the frame that carries it, so tf is not asked.
  /// Failure: throws std::invalid_argument naming its place in the file, the object, the field and the reason.
  void add(const scene::ObjectEdit& object);

  scene::ObjectEditor& objects() { return objects_; }

 private:
  void apply(const ObjectChange& change);
  void check(const scene::ObjectEdit& edit) const;
  void checkPlace(const scene::ObjectEdit& edit, const scene::Object* before) const;
  void requireLegal(const std::string& id) const;
  const scene::Object& require(const std::string& id) const;

  const Robot& robot_;
  const MadeAhead& made_;
  ChangeFrames frames_;
  const scene::ObjectOptions options_;
  scene::ObjectEditor objects_;
};

}  // namespace proximity_server::node
