#pragma once

#include "proximity_server/scene/objects/object_shape.h"
#include "scene/bounds/leaf_boxes.h"
#include "scene/bounds/volume_tree.h"

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// A half-space of an object, with its padding.
struct PlacedHalfSpace {
  Eigen::Vector3d normal;  ///< unit, outwards
  double offset;           ///< [m] the distance of the plane from the origin along the normal
  int shape;               ///< the index of the shape in its object
  double chain_length;     ///< [m] see ObjectGeometry
};

/// The shapes from which an object was made.
struct ObjectSource {
  std::vector<ObjectShape> shapes;
  double padding;  ///< [m]
};

/// The convex pieces and half-spaces of an object in one frame, with the bounding volumes of the pieces.
///
/// The chain length of a piece or a half-space is the sum of the lengths of all transforms that brought it into this
/// frame, and of its own reach. The rounding of its pose depends on this sum, even if the transforms have cancelled
/// each other; so the bounds count it as reach.
class ObjectGeometry {
 public:
  /// Piece::collision is the index of a shape. `chain_lengths` [m] has one entry for each piece.
  ObjectGeometry(std::shared_ptr<const ObjectSource> source, std::vector<Piece> pieces,
                 std::vector<double> chain_lengths, std::vector<PlacedHalfSpace> half_spaces,
                 std::vector<ObjectShapeInfo> shapes, std::vector<std::string> warnings);

  /// The geometry in another frame; the same object if the pose is the identity.
  static std::shared_ptr<const ObjectGeometry> in(const Eigen::Isometry3d& frame_T_object,
                                                  const std::shared_ptr<const ObjectGeometry>& geometry);

  const ObjectSource& source() const { return *source_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<PlacedHalfSpace>& halfSpaces() const { return half_spaces_; }
  const std::vector<ObjectShapeInfo>& shapes() const { return shapes_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// The volumes of the pieces; the first is the root. The root is empty if there are half-spaces only. Its
  /// representation and its reach are about the whole object.
  const std::vector<Volume>& volumes() const { return volumes_; }
  const Volume& root() const { return volumes_.front(); }
  const std::vector<WideVolume>& wideVolumes() const { return wide_volumes_; }

  /// [m] An upper bound of the rounding of a chain of transforms that the reach of the result does not include.
  double excessRounding() const { return kPoseRounding * excess_; }

 private:
  double addChainLengths(Volume& volume);

  std::vector<Piece> pieces_;
  std::vector<double> chain_lengths_;
  std::vector<PlacedHalfSpace> half_spaces_;
  std::vector<ObjectShapeInfo> shapes_;
  std::vector<std::string> warnings_;
  std::vector<Volume> volumes_;
  std::vector<WideVolume> wide_volumes_;
  double excess_ = 0.0;                         ///< [m] how much a chain length exceeds the reach
  std::shared_ptr<const ObjectSource> source_;  ///< shared by the geometry in all frames
};

}  // namespace proximity_server::scene
