#pragma once

#include "node/objects/change_frames.h"
#include "node/robot/robot.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/ObjectList.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/object_shape.h"

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// Limits of all objects together, so that no client can use up the memory, or the time of the monitor's cycle.
struct ObjectLimits {
  std::int64_t objects = 200000;      ///< each takes about 4 kB, and is in every message on ~objects
  std::int64_t pieces = 1000000;      ///< convex pieces; a robot may have as many
  std::int64_t frames = 1000;         ///< each cycle looks them up; a frame that tf does not know takes about 3 us
  std::int64_t triangles = 10000000;  ///< triangles of meshes in messages; they are kept and take 24 bytes each
};

/// The shapes of the object of a source, at `place` in a frame.
struct SeenShapes {
  std::vector<scene::ObjectShape> shapes{};
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  std::string frame{};  ///< it moves with this tf frame; "": it stands in the reference frame of the robot
};

/// The objects of the node. It applies changes, one message after the other, and gives each result to the robot, from
/// which requests and the monitor take it. Thread-safe.
class ObjectStore {
 public:
  /// `node_start` is a number that is not 0 and that no other start of the node has. `on_change` is called after each
  /// change, before apply() returns. The robot gets the objects and rules of `at_start` at once.
  ///
  /// Failure: throws std::invalid_argument naming the place in the file, the object, the field and the reason.
  ObjectStore(
      std::shared_ptr<const Robot> robot, std::uint64_t node_start, FindFrame find_frame,
      std::function<void(const Robot&)> on_change = [](const Robot&) {}, const ObjectLimits& limits = {},
      const scene::ObjectFile& at_start = {});

  /// Is called for a message that removes objects which are not there, with a text that names the first of them.
  using Remarked = std::function<void(const std::string& remark)>;

  /// Applies all changes of a message, and returns the revision after it. It may take as long as its meshes need, while
  /// other changes go on, and as long as tf needs to tell the frames of its poses, while other changes wait.
  ///
  /// Failure: throws std::invalid_argument naming the change, the object, the field and the reason; it is a ChangeError
  ///          if it has a code. Nothing is changed then.
  std::uint64_t apply(const ObjectChanges& changes, const Remarked& remarked = {});

  /// Is called while the exception is handled, so that it may throw it again.
  using Refused = std::function<void(const std::exception& error)>;

  /// Applies messages one after the other, in one change of the robot's objects, and returns the revision after it. If
  /// a message is refused, none of its changes is applied, and `refused` is called with the reason.
  std::uint64_t applyTogether(const std::vector<const ObjectChanges*>& messages, const Refused& refused,
                              const Remarked& remarked = {});

  /// Replaces the object of a tracked or sensed source by these shapes, unless it has these boxes; without shapes it is
  /// removed. Calls `placed`
  /// before a reload can take the object away. If a reload has replaced the robot or changed the source, nothing is done.
  /// Failure: throws std::invalid_argument as apply() does.
  void track(const std::shared_ptr<const Robot>& robot, const TrackedSource& source, SeenShapes seen,
             const std::function<void()>& placed);

  /// Gives the objects to a reloaded robot, and then calls `replace`. No change is applied until both are done.
  ///
  /// Failure: throws std::invalid_argument naming an object that the new robot cannot have: its link or its reference
  ///          frame does not exist any more, or a link or a tracked source has its id. The store then keeps the previous
  ///          robot.
  void follow(const std::shared_ptr<const Robot>& robot, const std::function<void()>& replace);

  /// The present objects, and the robot that has them.
  struct CurrentObjects {
    std::shared_ptr<const Robot> robot;
    RobotObjects objects;
    std::vector<scene::WrittenRule> rules;
    std::uint64_t listed = 0;  ///< see revision()
  };
  CurrentObjects current() const;

  /// The same without those of sensed sources: a record keeps the objects of each revision for seconds, and such an
  /// object has up to a million boxes.
  CurrentObjects recorded() const;

  /// The present objects as a message, without a stamp and without those of tracked sources.
  ObjectList list() const { return list(current()); }
  ObjectList list(const CurrentObjects& now) const;

  /// The content of a file that gives a later start of the node the same objects and rules, but none of tracked
  /// sources, and the revision of these.
  struct Snapshot {
    scene::ObjectFile file;
    std::uint64_t revision = 0;
  };
  Snapshot snapshot() const;
  static scene::ObjectFile fileOf(const CurrentObjects& now);  ///< of all objects

  std::uint64_t nodeStart() const { return node_start_; }

  /// The revision of the latest change that was not by a tracked source: of what clients change, and of list().
  std::uint64_t revision() const;

 private:
  using Rules = std::optional<std::vector<scene::WrittenRule>>;

  void loadAtStart(const scene::ObjectFile& file);
  void applyLocked(const std::vector<const ObjectChanges*>& messages, const Refused& refused, const Remarked& remarked,
                   std::vector<ReadChanges> read);
  std::shared_ptr<const Robot> currentRobot() const;
  enum class By : unsigned char { Client, TrackedSource };
  bool commit(const scene::ObjectEditor& edited, const Rules& rules, std::uint64_t revision, By by = By::Client);

  const std::uint64_t node_start_;
  const FindFrame find_frame_;
  const std::function<void(const Robot&)> on_change_;
  const ObjectLimits limits_;
  std::mutex change_mutex_;  // held by each change or reload from its beginning to its end
  // Guards the members below, and keeps the robot's objects consistent with them. They are written with change_mutex_
  // held, too.
  mutable std::mutex mutex_;
  std::shared_ptr<const Robot> robot_;
  std::vector<scene::WrittenRule> rules_;
  std::uint64_t listed_ = 0;    // see revision()
  std::int64_t triangles_ = 0;  // number of triangles of all meshes that were sent
};

}  // namespace proximity_server::node
