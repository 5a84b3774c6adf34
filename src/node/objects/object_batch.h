#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "node/objects/object_shapes.h"
#include "node/robot/robot.h"
#include "proximity_server/ObjectChange.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/objects.h"

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

/// An object with what it was made of, so that shapes can be added to it and moved in it.
struct StoredObject {
  std::shared_ptr<const std::vector<SourceShape>> shapes;  ///< shared by all places that the object has had
  double padding = 0.0;                                    ///< [m]
  scene::Object object;
};

/// By id. The entries never change.
using StoredObjects = std::map<std::string, std::shared_ptr<const StoredObject>>;

/// Where a tf frame is now, in the reference frame of a robot. Throws ChangeError naming the frame if that is not known.
using FindFrame = std::function<Eigen::Isometry3d(const Robot& robot, const std::string& frame)>;

/// The objects of changes, made before it is their turn, without a place.
using MadeObjects = std::map<const ObjectChange*, scene::Object>;

/// Makes the objects with meshes that are added. That may take seconds, but needs no other object, so that it need not
/// delay changes of them. What cannot be made is left out.
MadeObjects madeAhead(const Robot& robot, const ObjectChanges& message);

/// Reads messages of changes: each change sees what those before it have done, and nothing is changed outside of it.
///
/// 1. A change is checked, field by field.
/// 2. Its pose is carried over into the frame that its object moves with; every frame is looked up once for all changes.
/// 3. Objects with new shapes are made; where only the place is new, the geometry is shared.
/// 4. The difference to the objects of before becomes changes of the scene.
class ObjectBatch {
 public:
  /// All must outlive it; `made` was made with the same robot.
  ObjectBatch(const Robot& robot, const StoredObjects& before, const FindFrame& find_frame, const MadeObjects& made)
      : robot_(robot), before_(before), find_frame_(find_frame), made_(made) {}

  /// Failure: throws ChangeError naming the object, the field and the reason.
  void apply(const ObjectChange& change);

  /// Adds an object of a file or a parameter. Its pose is in the frame that carries it, so tf is not asked.
  /// Failure: throws std::invalid_argument naming its place in the file, the object, the field and the reason.
  void add(const scene::WrittenObject& object);

  /// All changes so far stay.
  void keep() { before_touched_.clear(); }

  /// Takes back all changes since keep().
  void undo();

  /// The objects that are different now; nullptr: it is gone.
  const StoredObjects& touched() const { return touched_; }

  /// What makes these objects of those of before.
  std::vector<scene::ObjectChange> difference() const;

 private:
  void add(const ObjectChange& change);
  void append(const ObjectChange& change);
  void move(const ObjectChange& change);
  void attach(const ObjectChange& change);
  void detach(const ObjectChange& change);
  void remove(const ObjectChange& change);

  const StoredObject* find(const std::string& id) const;
  const StoredObject& require(const std::string& id) const;
  void touch(const std::string& id, std::shared_ptr<const StoredObject> object);
  void put(const std::string& id, StoredObject object);
  void make(const std::string& id, StoredObject object);
  void requireNew(const std::string& id) const;
  void requireLegal(const std::string& id) const;

  std::string frameNamed(const std::string& name) const;
  const Eigen::Isometry3d& referenceTo(const std::string& frame);
  Eigen::Isometry3d seenFrom(const std::string& frame, const std::string& other, const Eigen::Isometry3d& pose);
  Eigen::Isometry3d placeIn(const std::string& frame, const ObjectChange& change);
  scene::Attached attachedTo(const std::string& link, const std::vector<std::string>& touch_links,
                             const Eigen::Isometry3d& link_T_object) const;
  scene::Placement placementIn(const std::string& frame, const Eigen::Isometry3d& frame_T_object) const;

  const Robot& robot_;
  const StoredObjects& before_;
  const FindFrame& find_frame_;
  const MadeObjects& made_;
  StoredObjects touched_;
  /// What touched_ had of ids before they were touched, in this order; nullopt: nothing.
  std::vector<std::pair<std::string, std::optional<std::shared_ptr<const StoredObject>>>> before_touched_;
  std::map<std::string, Eigen::Isometry3d> frames_;  ///< in the reference frame
  std::map<std::string, ChangeError> no_frames_;     ///< those that have no pose: none is waited for twice
};

/// Where an object is, in the frame that carries it.
struct Carried {
  std::string frame;
  Eigen::Isometry3d frame_T_object;
};
Carried carriedBy(const Robot& robot, const scene::Placement& placement);

}  // namespace proximity_server::node
