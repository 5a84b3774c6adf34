#include "scene/query/volumes.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

/// The pieces of its body that represent a whole link.
std::vector<int> piecesOfLink(const RobotModel& model, int link) {
  const int body = model.links[link].body;
  std::vector<int> pieces;
  for (const int piece : model.bodies[body].pieces)
    if (collisionOf(model, piece).link == link) pieces.push_back(piece);
  return pieces;
}

VolumeBuilder builderFor(const RobotModel& model) {
  std::vector<Representation> representations;
  for (const Piece& piece : model.pieces) representations.push_back(model.collisions[piece.collision].representation);
  return {model.pieces, std::move(representations)};
}

}  // namespace

const Collision& collisionOf(const RobotModel& model, int piece) {
  return model.collisions[model.pieces[piece].collision];
}

Volumes::Volumes(const RobotModel& model)
    : model_(model),
      link_count_(static_cast<int>(model.links.size())),
      root_count_(static_cast<int>(model.links.size() + model.collisions.size())) {
  const VolumeBuilder builder = builderFor(model);
  volumes_.resize(static_cast<std::size_t>(root_count_));
  const auto fill = [&](int root, int link, std::vector<int> pieces) {
    const Volume volume = builder.over(model.links[link].body, std::move(pieces), volumes_);
    volumes_[root] = volume;
  };
  int root = 0;
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) fill(root++, link, piecesOfLink(model, link));
  for (const Collision& collision : model.collisions) fill(root++, collision.link, collision.pieces);
  leaves_.reserve(static_cast<std::size_t>(root_count_));
  for (root = 0; root < root_count_; ++root) leaves_.emplace_back(volumes_, root);
}

/// Of anything but a whole link.
int Volumes::ofOther(const ShapeRef& ref) const {
  if (ref.link < 0 || ref.link >= link_count_) {
    if (ref.object < 0) throw std::invalid_argument("there is no link " + std::to_string(ref.link));
    if (ref.collision != 0) throw std::invalid_argument("a part of an object cannot be asked about");
    return size() + ref.object;
  }
  const Link& link = model_.links[ref.link];
  if (ref.collision < 0 || ref.collision > static_cast<int>(link.collisions.size()))
    throw std::invalid_argument("link \"" + link.name + "\" has no <collision> " + std::to_string(ref.collision));
  return link_count_ + link.collisions[ref.collision - 1];
}

}  // namespace proximity_server::scene
