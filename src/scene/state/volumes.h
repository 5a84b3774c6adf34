#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/shape_ref.h"
#include "scene/state/part.h"

#include <vector>

namespace proximity_server::scene {

/// The links and <collision> elements of a robot, each as a hierarchy of bounding volumes over its pieces.
class Volumes {
 public:
  explicit Volumes(const RobotModel& model);

  const Volume& operator[](int volume) const { return volumes_[volume]; }

  /// The number of a part: first the links, then the <collision> elements, then the objects by their own numbers.
  /// Throws std::invalid_argument for a link or <collision> that does not exist. It does not check that an object
  /// exists.
  int of(const ShapeRef& ref) const {
    return ref.isLink() && ref.collision() == 0 && ref.link() < link_count_ ? ref.link() : ofOther(ref);
  }

  /// The number of parts of the robot. Their root volumes are the first of its volumes.
  int rootCount() const { return root_count_; }
  Part part(int number) const {
    return {volumes_.data(), model_.pieces.data(), number, bodies_[number], nullptr, wide_volumes_.data()};
  }

  /// The part that a reference names. Throws std::invalid_argument as of() does, and for an object that does not exist.
  Part part(const ShapeRef& ref, const Objects* objects) const;

 private:
  int ofOther(const ShapeRef& ref) const;

  const RobotModel& model_;
  std::vector<Volume> volumes_;
  std::vector<WideVolume> wide_volumes_;
  std::vector<int> bodies_;  ///< by root
  int link_count_;
  int root_count_;
};

}  // namespace proximity_server::scene
