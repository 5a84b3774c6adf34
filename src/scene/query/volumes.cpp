#include "scene/query/volumes.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace proximity_server::scene {
namespace {

bool hasClosedForm(const narrowphase::Shape& shape) {
  return shape.kind() == narrowphase::Shape::Kind::Point || shape.kind() == narrowphase::Shape::Kind::Segment;
}

/// The pieces of its body that represent a whole link.
std::vector<int> piecesOfLink(const RobotModel& model, int link) {
  const int body = model.links[link].body;
  std::vector<int> pieces;
  for (const int piece : model.bodies[body].pieces)
    if (collisionOf(model, piece).link == link) pieces.push_back(piece);
  return pieces;
}

}  // namespace

bool splitsFirst(const Volume& a, const Volume& b) {
  return !a.isLeaf() && (b.isLeaf() || a.bounds.radius >= b.bounds.radius);
}

const Collision& collisionOf(const RobotModel& model, int piece) {
  return model.collisions[model.pieces[piece].collision];
}

Volumes::Volumes(const RobotModel& model)
    : model_(model), root_count_(static_cast<int>(model.links.size() + model.collisions.size())) {
  for (const Piece& piece : model.pieces) bounds_of_pieces_.push_back(boundsOf(piece));
  volumes_.resize(static_cast<std::size_t>(root_count_));
  const auto fill = [&](int root, int link, std::vector<int> pieces) {
    const int body = model.links[link].body;
    const Volume volume = volumeOf(body, pieces.begin(), pieces.end());
    volumes_[root] = volume;
  };
  int root = 0;
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) fill(root++, link, piecesOfLink(model, link));
  for (const Collision& collision : model.collisions) fill(root++, collision.link, collision.pieces);
}

int Volumes::add(const Volume& volume) {
  volumes_.push_back(volume);
  return static_cast<int>(volumes_.size()) - 1;
}

Volume Volumes::leafOf(int piece) const {
  const Collision& collision = collisionOf(model_, piece);
  Volume leaf;
  leaf.body = model_.links[collision.link].body;
  leaf.piece = piece;
  leaf.representation = collision.representation;
  leaf.has_closed_form = hasClosedForm(model_.pieces[piece].shape);
  leaf.bounds = bounds_of_pieces_[piece];
  return leaf;
}

/// Halves the pieces along the longest edge of their box, by their centres, down to single ones.
Volume Volumes::volumeOf(int body, std::vector<int>::iterator begin, std::vector<int>::iterator end) {
  if (end - begin == 1) return leafOf(*begin);
  Volume volume;
  volume.body = body;
  if (begin == end) return volume;

  std::vector<const Piece*> pieces;
  std::vector<const Bounds*> bounds;
  for (auto piece = begin; piece != end; ++piece) {
    pieces.push_back(&model_.pieces[*piece]);
    bounds.push_back(&bounds_of_pieces_[*piece]);
    volume.representation = std::max(volume.representation, collisionOf(model_, *piece).representation);
  }
  volume.bounds = boundsOf(pieces, bounds);

  Eigen::Index longest = 0;
  volume.bounds.half.maxCoeff(&longest);
  const Eigen::Vector3d axis = volume.bounds.axes.col(longest);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    const auto along = [&](int piece) { return axis.dot(bounds_of_pieces_[piece].centre); };
    return along(a) != along(b) ? along(a) < along(b) : a < b;
  });
  const Volume first = volumeOf(body, begin, middle), second = volumeOf(body, middle, end);
  volume.parts = {add(first), add(second)};
  return volume;
}

int Volumes::of(const ShapeRef& ref) const {
  const int links = static_cast<int>(model_.links.size());
  if (ref.link < 0 || ref.link >= links) throw std::invalid_argument("there is no link " + std::to_string(ref.link));
  if (ref.collision == 0) return ref.link;

  const Link& link = model_.links[ref.link];
  if (ref.collision < 0 || ref.collision > static_cast<int>(link.collisions.size()))
    throw std::invalid_argument("link \"" + link.name + "\" has no <collision> " + std::to_string(ref.collision));
  return links + link.collisions[ref.collision - 1];
}

}  // namespace proximity_server::scene
