#include "scene/objects/placed_object.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {

Eigen::AlignedBox3d boxAround(const Bounds& bounds, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d centre = origin + rotation * bounds.centre;
  const double rounding = kPoseRounding * (origin.norm() + bounds.reach);
  const Eigen::Vector3d half = (rotation * bounds.axes).cwiseAbs() * bounds.half;
  return {centre - half - Eigen::Vector3d::Constant(rounding), centre + half + Eigen::Vector3d::Constant(rounding)};
}

/// The number is in the list, or otherwise in the tree.
void FixedObjects::remove(int number) {
  const auto loose = std::find(loose_.begin(), loose_.end(), number);
  if (loose == loose_.end())
    ++gone_;
  else
    loose_.erase(loose);
}

void FixedObjects::tidy(const std::vector<std::shared_ptr<const PlacedObject>>& slots) {
  // The list costs each question its length for each link; the tree costs each change its size divided by this number.
  const double wanted = 16.0 + 2.0 * std::sqrt(static_cast<double>(items_->size()));
  if (static_cast<double>(loose_.size() + gone_) <= wanted) return;
  std::vector<Item> items;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (std::size_t number = 0; number < slots.size(); ++number) {
    const PlacedObject* object = slots[number].get();
    if (!object || object->kind != PlacedObject::Kind::Fixed || object->isUnbounded()) continue;
    items.push_back({static_cast<int>(number), object->serial});
    boxes.push_back(object->box);
  }
  tree_ = std::make_shared<const BoxTree>(boxes);
  wide_tree_ = std::make_shared<const WideTree>(*tree_);
  items_ = std::make_shared<const std::vector<Item>>(std::move(items));
  loose_.clear();
  gone_ = 0;
}

}  // namespace proximity_server::scene
