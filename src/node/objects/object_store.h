#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "node/objects/object_batch.h"
#include "node/robot/robot.h"
#include "proximity_server/ObjectChanges.h"
#include "proximity_server/ObjectList.h"
#include "proximity_server/scene/object_files/object_file.h"

namespace proximity_server::node {

/// Limits on all objects together, so that no client fills the memory or the time of the monitor's cycle.
struct ObjectLimits {
  std::int64_t objects = 200000;      ///< each takes about 4 kB, and a place in every message on ~objects
  std::int64_t pieces = 1000000;      ///< convex pieces, as many as a robot may have
  std::int64_t frames = 1000;         ///< each cycle looks them up; one that tf does not know takes about 3 us
  std::int64_t triangles = 10000000;  ///< of meshes that were sent, which are kept: 24 bytes each
};

/// The objects of the node: applies changes, one message after the other, and gives each result to the robot, from which
/// requests and the monitor take it. Thread-safe.
class ObjectStore {
 public:
  /// `node_start` is a number that no other start of the node has, not 0. `in_use` is called after each change, before
  /// apply() returns. The objects and rules of `at_start` are given to the robot at once.
  ///
  /// Failure: throws std::invalid_argument naming the place in the file, the object, the field and the reason.
  ObjectStore(
      std::shared_ptr<const Robot> robot, std::uint64_t node_start, FindFrame find_frame,
      std::function<void(const Robot&)> in_use = [](const Robot&) {}, const ObjectLimits& limits = {},
      const scene::ObjectFile& at_start = {});

  /// Applies all changes of a message, and returns the revision after it. May take as long as its meshes need, which
  /// delays no other change, and as tf needs to tell where the frames of its poses are, which does.
  ///
  /// Failure: throws std::invalid_argument naming the change, the object, the field and the reason: a ChangeError where
  ///          it has a code. Nothing is changed then.
  std::uint64_t apply(const ObjectChanges& changes);

  /// Called while the exception is handled, so that it may be thrown again.
  using Refused = std::function<void(const std::exception& error)>;

  /// Applies messages one after the other, in one change of the robot's objects. A message that is refused is left out
  /// as a whole, and `refused` gets its reason.
  std::uint64_t applyTogether(const std::vector<const ObjectChanges*>& messages, const Refused& refused);

  /// Gives the objects to a reloaded robot, and calls `replace` before any other change.
  ///
  /// Failure: throws std::invalid_argument naming the object that the new robot cannot have: its link or its reference
  ///          frame is gone, or a link has its id. The robot of before stays then.
  void follow(const std::shared_ptr<const Robot>& robot, const std::function<void()>& replace);

  /// The objects that are there now, and the robot that has them.
  struct Present {
    std::shared_ptr<const Robot> robot;
    RobotObjects objects;
    std::vector<scene::WrittenRule> rules;
  };
  Present present() const;

  /// The same as a message, without a stamp.
  ObjectList list() const { return list(present()); }
  ObjectList list(const Present& now) const;

  /// What a later start of the node needs to have the same objects and rules; and its revision.
  struct Snapshot {
    scene::ObjectFile file;
    std::uint64_t revision = 0;
  };
  Snapshot snapshot() const;

  std::uint64_t nodeStart() const { return node_start_; }
  std::uint64_t revision() const;

 private:
  using Rules = std::optional<std::vector<scene::WrittenRule>>;

  void begin(const scene::ObjectFile& file);
  void applyLocked(const std::vector<const ObjectChanges*>& messages, const Refused& refused, const MadeAhead& made);
  std::shared_ptr<const Robot> robotNow() const;
  bool commit(const scene::ObjectEditor& edited, const Rules& rules, std::uint64_t revision);

  const std::uint64_t node_start_;
  const FindFrame find_frame_;
  const std::function<void(const Robot&)> in_use_;
  const ObjectLimits limits_;
  std::mutex changing_;  // held by one change or reload from its beginning to its end
  mutable std::mutex
      mutex_;  // guards the members below, and that the objects of the robot fit to them; only who holds changing_ writes them
  std::shared_ptr<const Robot> robot_;
  std::vector<scene::WrittenRule> rules_;
  std::int64_t triangles_ = 0;  ///< of all meshes that were sent
};

}  // namespace proximity_server::node
