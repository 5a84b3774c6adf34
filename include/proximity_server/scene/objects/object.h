#pragma once

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/objects/object_shape.h"
#include "proximity_server/scene/pieces/convex_pieces.h"

#include <Eigen/Geometry>

#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

// Objects that the robot holds or that stand around it.

/// The object stands still in the world, which is the frame of the poses of an update.
struct Fixed {
  Eigen::Isometry3d world_T_object = Eigen::Isometry3d::Identity();
};

/// The object moves with a frame whose pose is given in every update.
struct Moving {
  std::string frame;
  Eigen::Isometry3d frame_T_object = Eigen::Isometry3d::Identity();
};

/// The object moves with a link. It may touch that link and all links that are joined to it by fixed joints.
struct Attached {
  std::string link;
  std::vector<std::string> touch_links = {};  ///< other links that it may touch
  Eigen::Isometry3d link_T_object = Eigen::Isometry3d::Identity();
};

using Placement = std::variant<Fixed, Moving, Attached>;

class ObjectGeometry;
struct Piece;

/// An object that can be added to a scene. Copies share the geometry, which never changes.
struct Object {
  std::string id;
  std::shared_ptr<const ObjectGeometry> geometry;
  Placement placement;
};

struct ObjectOptions {
  double padding = 0.0;     ///< [m] added to every shape as margin
  MeshResolver resolve;     ///< finds the files of mesh URIs; may be empty if there are none
  MeshOptions meshes = {};  ///< how meshes become convex pieces, as for the meshes of links
};

/// Makes an object from its shapes: reads meshes, and makes convex pieces and their bounding volumes. That may take
/// long, but needs no scene. The object can then be placed, moved and attached quickly.
///
/// Failure: throws std::invalid_argument, naming the object and the shape: no shape; a size that is zero, negative or
///          not finite; a pose that is not valid; a mesh that cannot be read; geometry farther than 1e6 m from the
///          frame of the object; more than a million convex pieces.
Object makeObject(const std::string& id, std::vector<ObjectShape> shapes, const Placement& placement,
                  const ObjectOptions& options = {});

/// givenShapesOf(): the shapes from which an object was made. paddingOf(): the padding [m] of each of them.
const std::vector<ObjectShape>& givenShapesOf(const Object& object);
double paddingOf(const Object& object);

/// The shapes of an object, in the order in which they were given.
const std::vector<ObjectShapeInfo>& shapesOf(const Object& object);

/// The convex pieces of an object in its frame, with their padding. Piece::collision is the index of a shape.
/// Half-spaces have no pieces.
const std::vector<Piece>& piecesOf(const Object& object);
bool hasHalfSpace(const Object& object);

/// Each warning is one sentence about input that is odd but legal.
const std::vector<std::string>& warningsOf(const Object& object);

}  // namespace proximity_server::scene
