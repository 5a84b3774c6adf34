#include "scene/bounds/volume_tree.h"

#include "scene/bounds/box_tree.h"
#include "system/append.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {
namespace {

/// More boxes than this along the axes of the body are bounded along these axes only. There may be a hundred thousand of
/// them, in a map or in what a camera sees, and trying other directions would take seconds.
constexpr std::size_t kFewBoxes = 64;

bool isAlignedBox(const Piece& piece) {
  return piece.shape.kind() == narrowphase::Shape::Kind::Box &&
         piece.body_T_piece.linear() == Eigen::Matrix3d::Identity();
}

Eigen::AlignedBox3d alignedBoxOf(const Piece& piece) {
  const Eigen::Vector3d centre = piece.body_T_piece.translation();
  const Eigen::Vector3d half = piece.shape.halfExtents().array() + piece.shape.margin();
  return {centre - half, centre + half};
}

bool hasClosedForm(const narrowphase::Shape& shape) {
  return shape.kind() == narrowphase::Shape::Kind::Point || shape.kind() == narrowphase::Shape::Kind::Segment;
}

}  // namespace

bool splitsFirst(const Volume& a, const Volume& b) {
  return !a.isLeaf() && (b.isLeaf() || a.bounds.radius >= b.bounds.radius);
}

VolumeBuilder::VolumeBuilder(const std::vector<Piece>& pieces, std::vector<Representation> representations)
    : pieces_(pieces), representations_(std::move(representations)) {
  bounds_of_pieces_.reserve(pieces.size());
  are_aligned_ = pieces.size() > kFewBoxes && std::all_of(pieces.begin(), pieces.end(), isAlignedBox);
  for (const Piece& piece : pieces)
    bounds_of_pieces_.push_back(are_aligned_ ? boundsOf(alignedBoxOf(piece)) : boundsOf(piece));
}

Volume VolumeBuilder::over(std::vector<int> pieces, std::vector<Volume>& volumes) const {
  return volumeOf(pieces.begin(), pieces.end(), volumes);
}

Volume VolumeBuilder::leafOf(int piece) const {
  Volume leaf;
  leaf.piece = piece;
  leaf.representation = representations_[piece];
  leaf.has_closed_form = hasClosedForm(pieces_[piece].shape);
  leaf.has_interior = pieces_[piece].interior != nullptr;
  leaf.has_representative = pieces_[piece].is_representative;
  leaf.bounds = bounds_of_pieces_[piece];
  return leaf;
}

/// Halves the pieces along the longest edge of their box, by their centres, down to single pieces.
Volume VolumeBuilder::volumeOf(std::vector<int>::iterator begin, std::vector<int>::iterator end,
                               std::vector<Volume>& volumes) const {
  if (end - begin == 1) return leafOf(*begin);
  Volume volume;
  if (begin == end) return volume;

  for (auto piece = begin; piece != end; ++piece) {
    volume.representation = std::max(volume.representation, representations_[*piece]);
    volume.has_interior |= pieces_[*piece].interior != nullptr;
    volume.has_representative |= pieces_[*piece].is_representative;
  }
  volume.bounds = boundsOver(begin, end);

  Eigen::Index longest = 0;
  volume.bounds.half.maxCoeff(&longest);
  const Eigen::Vector3d axis = volume.bounds.axes.col(longest);
  const auto middle = halve(begin, end, [&](int piece) { return axis.dot(bounds_of_pieces_[piece].centre); });
  const Volume first = volumeOf(begin, middle, volumes), second = volumeOf(middle, end, volumes);
  const int first_part = system::append(volumes, first);
  volume.parts = {first_part, system::append(volumes, second)};
  return volume;
}

Bounds VolumeBuilder::boundsOver(std::vector<int>::iterator begin, std::vector<int>::iterator end) const {
  if (are_aligned_) {
    Eigen::AlignedBox3d box;
    double reach = 0.0;
    for (auto piece = begin; piece != end; ++piece) {
      const Bounds& bounds = bounds_of_pieces_[*piece];
      box.extend(Eigen::AlignedBox3d(bounds.centre - bounds.half, bounds.centre + bounds.half));
      reach = std::max(reach, bounds.reach);
    }
    Bounds bounds = boundsOf(box);
    bounds.reach = reach;
    return bounds;
  }
  std::vector<const Piece*> pieces;
  std::vector<const Bounds*> bounds;
  for (auto piece = begin; piece != end; ++piece) {
    pieces.push_back(&pieces_[*piece]);
    bounds.push_back(&bounds_of_pieces_[*piece]);
  }
  return boundsOf(pieces, bounds);
}

}  // namespace proximity_server::scene
