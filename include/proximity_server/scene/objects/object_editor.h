#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/objects/objects.h"

// Operations on objects, as messages, files and scripts describe them: the one place where each of them is done.

namespace proximity_server::scene {

/// The place of an object, in the frame of the link that holds it or of the frame that it moves with.
struct ObjectPlace {
  std::string link;                                        ///< "": none holds it
  std::vector<std::string> touch_links;                    ///< that it may touch besides its own link
  std::string frame;                                       ///< if no link holds it; "": the frame of the answers
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the frame of link or `frame`
  std::optional<std::string> pose_frame = {};              ///< in which the pose is given, if not there
};

/// One operation on one object, before any name of it is looked up.
struct ObjectEdit {
  enum class Operation : unsigned char { Add, Replace, Append, Move, Attach, Detach, Remove };
  /// Attach and Detach: the object is put at the place's pose, or stays where it is then.
  enum class Pose : unsigned char { Given, Kept };

  std::string id;  ///< Remove: "*" stands for all objects
  ObjectPlace place;
  double padding = 0.0;  ///< [m] Add, Replace
  /// Add, Replace: all of the object. Append: those that it gets, placed as if they were an object of their own. Move: all of the
  /// object, if it has them in other poses than before.
  std::vector<ObjectShape> shapes;
  std::string source;  ///< begins messages about it: "cell.yaml, line 3: objects[0] "table""
  Operation operation = Operation::Add;
  Pose pose = Pose::Given;
  std::shared_ptr<const ObjectGeometry> geometry = nullptr;  ///< Add, Replace: of the shapes, if it is made already
};

/// Looks up frames and poses: in tf, or in a state of the robot.
class ObjectFrames {
 public:
  virtual ~ObjectFrames() = default;

  /// The frame that a name means; that of "" is the one in which fixed objects stand.
  virtual std::string named(const std::string& name) const = 0;
  virtual std::string ofLink(const std::string& link) const = 0;

  /// Transforms a pose from the frame `other` into `frame`. Throws std::invalid_argument naming a frame without a pose.
  virtual Eigen::Isometry3d seenFrom(const std::string& frame, const std::string& other,
                                     const Eigen::Isometry3d& pose) = 0;
};

/// The frame that carries an object, and its pose there.
std::string carrierOf(const Object& object, const ObjectFrames& frames);
const Eigen::Isometry3d& poseInCarrier(const Object& object);

/// Does operations on objects, each on what those before it have left; the objects of before stay as they are.
///
/// 1. The place is carried over into the frame that the object moves with from now on.
/// 2. Geometry is made of new shapes; where only the place is new, it is shared.
/// 3. The difference to the objects of before becomes changes of Objects, which check what is left to check.
class ObjectEditor {
 public:
  /// By id; nullptr: it is gone.
  using Touched = std::map<std::string, std::shared_ptr<const Object>>;

  /// All must outlive it. The padding of `options` is that of each object.
  ObjectEditor(const Objects& before, ObjectFrames& frames, const ObjectOptions& options)
      : before_(before), frames_(frames), options_(options) {}

  /// Failure: throws std::invalid_argument naming the object and the reason, and changes nothing: an id that is there already (Add), or
  ///          not there (all but Add, Replace and Remove); a frame that is not known; shapes as makeObject(); to move an
  ///          object that a link holds; to detach another one.
  void apply(ObjectEdit edit);

  /// All operations so far stay.
  void keep() { kept_ = log_.size(); }
  /// Takes back all since keep().
  void undo();

  /// nullptr if it is not there.
  const Object* find(const std::string& id) const;
  /// Throws std::invalid_argument naming the nearest id if it is not there.
  const Object& require(const std::string& id) const;
  std::vector<std::string> ids() const;

  const Objects& before() const { return before_; }
  const Touched& touched() const { return touched_; }

  /// The changes that lead from the objects of before to these, in the order in which ids were first changed.
  std::vector<ObjectChange> difference() const;

 private:
  void append(ObjectEdit& edit, Object& object);
  void remove(const std::string& id);
  void touch(const std::string& id, std::shared_ptr<const Object> object);
  Placement placementFor(const ObjectEdit& edit, const Object& before);
  Eigen::Isometry3d poseIn(const std::string& frame, const ObjectPlace& place);

  const Objects& before_;
  ObjectFrames& frames_;
  const ObjectOptions& options_;
  Touched touched_;
  /// The steps that undo() takes back: the id, and its entry in touched_ before the step; nullopt: it had none.
  std::vector<std::pair<std::string, std::optional<std::shared_ptr<const Object>>>> log_;
  std::size_t kept_ = 0;  ///< how much of the log stays
};

}  // namespace proximity_server::scene
