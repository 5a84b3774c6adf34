#pragma once

#include "proximity_server/scene/objects/object.h"
#include "scene/bounds/box_tree.h"
#include "scene/bounds/wide_tree.h"
#include "scene/objects/object_geometry.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// An object of a robot's scene, in the frame of the body that carries it. It never changes.
struct PlacedObject {
  enum class Kind : unsigned char { Fixed, Moving, Attached };

  Object object;
  Kind kind;
  /// In the frame of the link's body, in the tf frame, or, for a fixed object, in the frame of the object itself.
  std::shared_ptr<const ObjectGeometry> geometry;
  int body = -1;                   ///< of an attached object: index into RobotModel::bodies
  std::vector<int> touch_links{};  ///< of an attached object, ascending
  std::string frame{};             ///< of a moving object
  Eigen::Isometry3d world_T_object = Eigen::Isometry3d::Identity();  ///< of a fixed object
  Eigen::AlignedBox3d box{};  ///< [m] of a fixed object without half-spaces, in the world
  std::uint64_t serial = 0;   ///< unique among all objects of the sets that follow from one another

  bool isUnbounded() const { return !geometry->halfSpaces().empty(); }
};

/// Throws std::invalid_argument naming the object and the reason.
[[noreturn]] void refuseObject(const std::string& id, const std::string& reason);
/// Refuses the id of a new object that is empty, "*" or the name of a link.
void requireUsableId(const RobotModel& robot, const std::string& id);
/// The number of a link that `field` of an object names.
int requireLink(const RobotModel& robot, const std::string& link, const std::string& field, const std::string& id);

/// [m] The box along the axes of the world that contains the pieces of a geometry. It includes the rounding of the
/// pose.
Eigen::AlignedBox3d boxAround(const Bounds& bounds, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin);

/// The fixed objects without half-spaces: a tree of most of them, and a list of those that were added after the tree
/// was built. Objects that have been removed or changed since then are still in the tree, with the serial that they
/// had.
class FixedObjects {
 public:
  struct Item {
    int number;
    std::uint64_t serial;
  };

  const BoxTree& tree() const { return *tree_; }
  const WideTree& wideTree() const { return *wide_tree_; }
  const Item& item(int index) const { return (*items_)[index]; }
  const std::vector<int>& loose() const { return loose_; }

  void add(int number) { loose_.push_back(number); }
  void remove(int number);

  /// Builds the tree anew if so many objects have changed that it pays.
  void tidy(const std::vector<std::shared_ptr<const PlacedObject>>& slots);

 private:
  std::shared_ptr<const BoxTree> tree_ = std::make_shared<const BoxTree>();
  std::shared_ptr<const WideTree> wide_tree_ = std::make_shared<const WideTree>();
  std::shared_ptr<const std::vector<Item>> items_ = std::make_shared<const std::vector<Item>>();
  std::vector<int> loose_;
  std::size_t gone_ = 0;  ///< the number of items of the tree that do not exist any more
};

}  // namespace proximity_server::scene
