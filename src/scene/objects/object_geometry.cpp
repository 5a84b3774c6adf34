#include "scene/objects/object_geometry.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;

std::vector<Volume> volumesOf(const std::vector<Piece>& pieces, const std::vector<ObjectShapeInfo>& shapes) {
  std::vector<Representation> representations;
  representations.reserve(pieces.size());
  for (const Piece& piece : pieces) representations.push_back(shapes[piece.collision].representation);
  std::vector<int> all(pieces.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<Volume> volumes(1);
  volumes.reserve(2 * pieces.size());
  const Volume root = VolumeBuilder(pieces, std::move(representations)).over(std::move(all), volumes);
  volumes.front() = root;
  return volumes;
}

}  // namespace

ObjectGeometry::ObjectGeometry(std::shared_ptr<const ObjectSource> source, std::vector<Piece> pieces,
                               std::vector<double> chain_lengths, std::vector<PlacedHalfSpace> half_spaces,
                               std::vector<ObjectShapeInfo> shapes, std::vector<std::string> warnings)
    : pieces_(std::move(pieces)),
      chain_lengths_(std::move(chain_lengths)),
      half_spaces_(std::move(half_spaces)),
      shapes_(std::move(shapes)),
      warnings_(std::move(warnings)),
      volumes_(volumesOf(pieces_, shapes_)),
      source_(std::move(source)) {
  if (!volumes_.front().isEmpty()) addChainLengths(volumes_.front());
  addWideVolumes(volumes_, 0, wide_volumes_);
  for (const PlacedHalfSpace& half_space : half_spaces_) {
    Bounds& bounds = volumes_.front().bounds;
    bounds.reach = std::max(bounds.reach, half_space.chain_length);
    excess_ = std::max(excess_, half_space.chain_length - std::abs(half_space.offset));
  }
}

/// Adds the chain lengths to the bounds of a volume. Returns the largest one in it [m].
double ObjectGeometry::addChainLengths(Volume& volume) {
  const auto ofPart = [&](int part) { return addChainLengths(volumes_[part]); };
  const double chain_length =
      volume.isLeaf() ? chain_lengths_[volume.piece] : std::max(ofPart(volume.parts[0]), ofPart(volume.parts[1]));
  Bounds& bounds = volume.bounds;
  const double more = std::max(0.0, chain_length - bounds.reach);
  if (volume.isLeaf()) excess_ = std::max(excess_, more);
  bounds.reach += more;
  bounds.radius += kPoseRounding * more;
  bounds.half.array() += kPoseRounding * more;
  return chain_length;
}

std::shared_ptr<const ObjectGeometry> ObjectGeometry::in(const Isometry3d& frame_T_object,
                                                         const std::shared_ptr<const ObjectGeometry>& geometry) {
  if (frame_T_object.matrix() == Isometry3d::Identity().matrix()) return geometry;
  const double length = frame_T_object.translation().norm();
  std::vector<double> chain_lengths = geometry->chain_lengths_;
  for (double& chain_length : chain_lengths) chain_length += length;
  std::vector<Piece> pieces = geometry->pieces_;
  for (Piece& piece : pieces) piece.body_T_piece = frame_T_object * piece.body_T_piece;
  std::vector<PlacedHalfSpace> half_spaces = geometry->half_spaces_;
  for (PlacedHalfSpace& half_space : half_spaces) {
    half_space.normal = (frame_T_object.linear() * half_space.normal).normalized();
    half_space.offset += half_space.normal.dot(frame_T_object.translation());
    half_space.chain_length += length;
  }
  return std::make_shared<const ObjectGeometry>(geometry->source_, std::move(pieces), std::move(chain_lengths),
                                                std::move(half_spaces), geometry->shapes_, geometry->warnings_);
}

}  // namespace proximity_server::scene
