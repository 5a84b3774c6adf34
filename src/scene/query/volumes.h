#pragma once

#include <vector>

#include "proximity_server/scene/query/question.h"
#include "scene/model/volume_tree.h"
#include "scene/query/leaf_boxes.h"

namespace proximity_server::scene {

/// The <collision> element of a piece (index into RobotModel::pieces).
const Collision& collisionOf(const RobotModel& model, int piece);

/// The links and <collision> elements of a robot as hierarchies of bounding volumes over their pieces.
class Volumes {
 public:
  explicit Volumes(const RobotModel& model);

  const Volume& operator[](int volume) const { return volumes_[volume]; }
  const Volume* data() const { return volumes_.data(); }
  int size() const { return static_cast<int>(volumes_.size()); }

  /// The number of a link or a <collision> element; that of an object follows after all volumes: size() plus the number
  /// of the object. Throws std::invalid_argument for a link or <collision> that does not exist, and for a part of an
  /// object; whether the object exists is not known here.
  int of(const ShapeRef& ref) const {
    return ref.collision == 0 && ref.link >= 0 && ref.link < link_count_ ? ref.link : ofOther(ref);
  }

  /// The volumes that `of` may return for a robot are 0 to rootCount() - 1, the links first.
  int rootCount() const { return root_count_; }

  /// The leaves of such a volume.
  const LeafBoxes& leavesOf(int root) const { return leaves_[static_cast<std::size_t>(root)]; }

 private:
  int ofOther(const ShapeRef& ref) const;

  const RobotModel& model_;
  std::vector<Volume> volumes_;
  std::vector<LeafBoxes> leaves_;  ///< by root
  int link_count_;
  int root_count_;
};

}  // namespace proximity_server::scene
