#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "scene/bounds/leaf_boxes.h"
#include "scene/bounds/volume_tree.h"
#include "scene/objects/placed_object.h"

#include <vector>

namespace proximity_server::scene {

/// Two parts by their numbers, see PlacedRobot; or a volume of each of two parts.
struct PartPair {
  int a, b;
};

/// The geometry of a link, of a <collision> or of an object, in the frame of its body: volumes over convex pieces, and
/// the half-spaces of an object.
struct Part {
  const Volume* volumes = nullptr;  ///< an array that contains its volumes
  const Piece* pieces = nullptr;
  int root = 0;  ///< the volume of the whole part
  /// The body that carries it. An object that no link holds has a body of its own, whose number depends on the owner of
  /// the part.
  int body = -1;
  const PlacedObject* object = nullptr;      ///< nullptr if it belongs to the robot
  const WideVolume* wide_volumes = nullptr;  ///< an array, by Volume::wide
  int first_piece = 0;                       ///< the number of the first of `pieces` in WarmStarts

  const Volume& operator[](int volume) const { return volumes[volume]; }
  const WideVolume& wide(int volume) const { return wide_volumes[volumes[volume].wide]; }
  const Volume& whole() const { return volumes[root]; }

  /// True if it has half-spaces. Then its bounds are infinite, and it must be the second part of a pair.
  bool isUnbounded() const { return object && object->isUnbounded(); }
  const std::vector<PlacedHalfSpace>& halfSpaces() const { return object->geometry->halfSpaces(); }

  /// The shape of the object that a half-space belongs to, counted from 1.
  int shapeNumber(int half_space) const { return 1 + halfSpaces()[half_space].shape; }

  /// True if it is an object that no link holds.
  bool isFree() const { return object && object->kind != PlacedObject::Kind::Attached; }
};

/// The <collision> of the link, or the shape of the object, that a piece belongs to; counted from 1.
inline int collisionNumber(const RobotModel& robot, const Piece& piece, bool is_of_object) {
  return is_of_object ? 1 + piece.collision : robot.collisionOf(piece).number;
}

/// Two parts in their places. Only the second one may have half-spaces.
struct PlacedPair {
  const Part &a, &b;
  RelativePose a_T_b;
  double padding = 0.0;    ///< [m] see Visit
  double threshold = 0.0;  ///< [m]
};

inline Part partOf(const PlacedObject& object) {
  const ObjectGeometry& geometry = *object.geometry;
  return {geometry.volumes().data(), geometry.pieces().data(), 0, object.body, &object, geometry.wideVolumes().data()};
}

}  // namespace proximity_server::scene
