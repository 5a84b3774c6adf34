#pragma once

#include "proximity_server/scene/objects/object_fields.h"
#include "proximity_server/scene/objects/objects.h"

#include <Eigen/Geometry>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// Operations on objects, as messages, files and scripts describe them. Each of them is implemented only here.

namespace proximity_server::scene {

/// Looks up frames and poses, in tf or in a state of the robot.
class ObjectFrames {
 public:
  virtual ~ObjectFrames() = default;

  /// The frame with a name. "" stands for the frame in which fixed objects stand.
  virtual std::string named(const std::string& name) const = 0;
  virtual std::string ofLink(const std::string& link) const = 0;

  /// Transforms a pose from the frame `other` into `frame`. Throws std::invalid_argument, with the name of the frame,
  /// if a frame has no pose.
  virtual Eigen::Isometry3d seenFrom(const std::string& frame, const std::string& other,
                                     const Eigen::Isometry3d& pose) = 0;
};

/// carrierOf(): the frame that carries an object. poseInCarrier(): its pose in that frame.
std::string carrierOf(const Object& object, const ObjectFrames& frames);
const Eigen::Isometry3d& poseInCarrier(const Object& object);

/// Applies operations on objects, each to the result of those before it. The original objects stay unchanged.
///
/// 1. The place is transformed into the frame with which the object moves from now on.
/// 2. New shapes get new geometry; if only the place is new, the geometry is shared.
/// 3. The difference from the original objects becomes changes of Objects, which check the rest.
class ObjectEditor {
 public:
  /// The changed objects by id; nullptr if the object was removed.
  using Changed = std::map<std::string, std::shared_ptr<const Object>>;

  /// All arguments must outlive it. The padding of `options` is not used.
  ObjectEditor(const Objects& before, ObjectFrames& frames, const ObjectOptions& options)
      : before_(before), frames_(frames), options_(options) {}

  /// Failure: throws std::invalid_argument, naming the object, the field and the reason, and changes nothing: an id that
  ///          cannot be used, exists already (Add), or does not exist (all but Add, Replace and Remove); a link or frame
  ///          that is not known; invalid shapes, see makeObject(); Move of an object that a link holds; Detach of an
  ///          object that no link holds; a link that holds a plane. Errors of ObjectFrames do not name the object.
  void apply(ObjectEdit edit);

  /// Makes all operations so far permanent.
  void keep() { kept_ = log_.size(); }
  /// Undoes all operations since keep().
  void undo();

  /// nullptr if there is no such object.
  const Object* find(const std::string& id) const;
  /// Throws std::invalid_argument, naming the nearest id, if there is no such object.
  const Object& require(const std::string& id) const;
  std::vector<std::string> ids() const;

  const Objects& before() const { return before_; }
  const Changed& changed() const { return changed_; }

  /// The changes that lead from the original objects to the present ones, in the order in which ids were first changed.
  std::vector<ObjectChange> difference() const;

 private:
  void check(const ObjectEdit& edit, const Object& before) const;
  void append(ObjectEdit& edit, Object& object);
  void remove(const std::string& id);
  void set(const std::string& id, std::shared_ptr<const Object> object);
  Placement placementFor(const ObjectEdit& edit, const Object& before);
  Eigen::Isometry3d poseIn(const std::string& frame, const ObjectPlace& place);

  const Objects& before_;
  ObjectFrames& frames_;
  const ObjectOptions& options_;
  Changed changed_;
  /// The steps that undo() takes back: the id, and its entry in changed_ before the step; nullopt if it had none.
  std::vector<std::pair<std::string, std::optional<std::shared_ptr<const Object>>>> log_;
  std::size_t kept_ = 0;  ///< the number of steps that are permanent
};

}  // namespace proximity_server::scene
