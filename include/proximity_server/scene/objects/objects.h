#pragma once

#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/objects/object_rules.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

// The changes of a set of objects. ObjectEditor makes them from operations on objects.

/// Adds an object with a new id.
struct AddObject {
  Object object;
};
/// Gives an existing id another geometry or placement.
struct ReplaceObject {
  Object object;
};
struct RemoveObject {
  std::string id;
};
using ObjectChange = std::variant<AddObject, ReplaceObject, RemoveObject>;

struct PlacedObject;
class FixedObjects;

/// The poses of the frames of moving objects, in the order of Objects::frames(); nullopt if a pose is not known.
using FramePoses = std::vector<std::optional<Eigen::Isometry3d>>;

/// The objects of one robot, and the pairs that they are part of. It never changes: a change makes a new set, which
/// shares all data that are the same, so that questions to scenes that use the old set are not disturbed.
///
/// An object has a number, which it keeps as long as it exists, even when it is moved, attached or replaced. The number
/// of a removed object is given to another object later.
///
/// Pairs: objects against links; attached objects also against all other objects; other objects against each other only
///        if one of them moves and the rules ask for it. Each pair has a reason, see reason().
class Objects {
 public:
  /// An empty set. Throws std::invalid_argument without a model.
  explicit Objects(std::shared_ptr<const SceneModel> model);

  /// The objects after these changes, which are made one after the other.
  ///
  /// Failure: throws std::invalid_argument, naming the object and the reason: an id that is empty or "*", the name of a
  ///          link, an id that exists already (to add) or does not exist; a link that does not exist; an empty name of
  ///          a frame; a pose that is not finite or not a rotation within single precision; a half-space that is
  ///          attached. Then none of the changes is made.
  Objects changed(const std::vector<ObjectChange>& changes) const;

  /// Returns a set of the same objects with other rules.
  Objects withRules(ObjectRules rules) const;

  const SceneModel& model() const { return *model_; }
  const ObjectRules& rules() const { return *rules_; }

  bool empty() const { return by_id_.empty(); }
  int size() const { return static_cast<int>(by_id_.size()); }

  /// The numbers of the objects, in the order of their ids.
  const std::vector<int>& numbers() const { return by_id_; }

  /// The number of an object, or -1.
  int find(const std::string& id) const;

  /// All numbers are smaller than this.
  int numberLimit() const { return static_cast<int>(slots_.size()); }

  /// nullptr if no object has the number.
  const Object* object(int number) const;

  /// The frames of moving objects, each once, ascending. Their poses are given in this order.
  const std::vector<std::string>& frames() const { return frames_; }

  /// The index of the frame of a moving object in frames(); -1 for any other object.
  int frameOf(int number) const { return frame_of_[number]; }

  /// The reason why a pair with an object is checked or not. The order of the two does not matter; an object and itself
  /// are one body. Throws std::invalid_argument for a link or an object that does not exist, and for two links.
  PairReason reason(const ShapeRef& a, const ShapeRef& b) const;
  bool isChecked(const ShapeRef& a, const ShapeRef& b) const { return reason(a, b) == PairReason::Checked; }

  /// Calls visit(a, b) for each checked pair with an object: first the links, each with all objects in the order of
  /// their ids, then the objects that are checked against other objects. If both are objects, a is the one with the
  /// smaller number.
  template <typename Visit>
  void forEachCheckedPair(const Visit& visit) const {
    for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
      for (const int number : by_id_)
        if (const ShapeRef object = ShapeRef::ofObject(number); isChecked(link, object)) visit(ShapeRef(link), object);
    for (const int searcher : searchers_)
      for (const int number : by_id_)
        if (isCheckedBy(ShapeRef::ofObject(searcher), number))
          visit(ShapeRef::ofObject(std::min(searcher, number)), ShapeRef::ofObject(std::max(searcher, number)));
  }

  /// The number of checked pairs with an object.
  std::int64_t pairCount() const { return pair_count_; }

  /// The number of convex pieces of all objects together.
  std::int64_t pieceCount() const { return piece_count_; }

  // For the queries:
  const PlacedObject* placed(int number) const;  ///< nullptr if no object has the number
  const FixedObjects& fixed() const { return *fixed_; }
  /// The objects that are checked against all others, ascending: attached objects, and moving objects if the rules ask
  /// for it. Each of them searches for objects that are near.
  const std::vector<int>& searchers() const { return searchers_; }
  /// True if the pair is checked and `searcher`, a link or one of searchers(), has to visit the object. If both are
  /// searchers, the one with the smaller number visits the other.
  bool isCheckedBy(const ShapeRef& searcher, int object) const;
  /// moving(): the moving objects. unbounded(): the objects with a half-space that are not attached. Both are
  /// ascending.
  const std::vector<int>& moving() const { return moving_; }
  const std::vector<int>& unbounded() const { return unbounded_; }

 private:
  void apply(const AddObject& change);
  void apply(const ReplaceObject& change);
  void apply(const RemoveObject& change);

  int require(const std::string& id) const;
  void insert(int number, const Object& object);
  void addToLists(int number);
  void removeFromLists(int number);
  bool isSearcher(int number) const;
  PairReason linkReason(int link, int object) const;
  PairReason objectReason(int object_a, int object_b) const;
  std::int64_t pairsOf(int number) const;
  void findFrames();

  std::shared_ptr<const SceneModel> model_;
  std::shared_ptr<const ObjectRules> rules_;
  std::vector<std::shared_ptr<const PlacedObject>> slots_;  ///< by number; nullptr: the number is free
  std::vector<int> by_id_;
  std::vector<int> free_;  ///< the numbers below slots_.size() that no object has
  std::vector<int> searchers_, moving_, unbounded_;
  std::vector<std::string> frames_;
  std::vector<int> frame_of_;            ///< by number of the object: index into frames_
  std::shared_ptr<FixedObjects> fixed_;  ///< changed only while a change makes the next set
  std::int64_t pair_count_ = 0, piece_count_ = 0;
  std::uint64_t next_serial_ = 1;
};

/// The name of a link, or of the link of a <collision>; the id of an object, or "" if it does not exist.
const std::string& nameOf(const ShapeRef& ref, const RobotModel& robot, const Objects* objects = nullptr);

}  // namespace proximity_server::scene
