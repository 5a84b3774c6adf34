#include "scene/state/volumes.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

VolumeBuilder builderFor(const RobotModel& model) {
  std::vector<Representation> representations;
  for (const Piece& piece : model.pieces) representations.push_back(model.collisionOf(piece).representation);
  return {model.pieces, std::move(representations)};
}

}  // namespace

Volumes::Volumes(const RobotModel& model)
    : model_(model),
      link_count_(static_cast<int>(model.links.size())),
      root_count_(static_cast<int>(model.links.size() + model.collisions.size())) {
  const VolumeBuilder builder = builderFor(model);
  volumes_.resize(root_count_);
  const auto add = [&](const Link& link, std::vector<int> pieces) {
    const Volume root = builder.over(std::move(pieces), volumes_);
    volumes_[bodies_.size()] = root;
    bodies_.push_back(link.body);
  };
  for (int link = 0; link < link_count_; ++link) add(model.links[link], model.piecesOf(link));
  for (const Collision& collision : model.collisions) add(model.links[collision.link], collision.pieces);
  for (int root = 0; root < root_count_; ++root) addWideVolumes(volumes_, root, wide_volumes_);
}

/// The number of an object or a <collision>; throws for all that does not exist.
int Volumes::ofOther(const ShapeRef& ref) const {
  if (ref.isObject()) {
    if (ref.object() < 0) throw std::invalid_argument("there is no object " + std::to_string(ref.object()));
    if (ref.collision() != 0) throw std::invalid_argument("a part of an object cannot be asked about");
    return root_count_ + ref.object();
  }
  if (!ref.isLink() || ref.link() >= link_count_)
    throw std::invalid_argument("there is no link " + std::to_string(ref.link()));
  const Link& link = model_.links[ref.link()];
  if (ref.collision() < 0 || ref.collision() > static_cast<int>(link.collisions.size()))
    throw std::invalid_argument("link \"" + link.name + "\" has no <collision> " + std::to_string(ref.collision()));
  return link_count_ + link.collisions[ref.collision() - 1];
}

Part Volumes::part(const ShapeRef& ref, const Objects* objects) const {
  if (!ref.isObject()) return part(of(ref));
  const PlacedObject* object = objects ? objects->placed(ref.object()) : nullptr;
  if (!object) throw std::invalid_argument("there is no object " + std::to_string(ref.object()));
  return partOf(*object);
}

}  // namespace proximity_server::scene
