#pragma once

#include <geometry_msgs/Pose.h>

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "proximity_server/ObjectChange.h"
#include "proximity_server/scene/objects/object.h"

// Reads the shapes and poses of a change.
// Failure: throw std::invalid_argument naming the field and the reason.

namespace proximity_server::node {

/// The kinds of shapes of an ObjectChange, each a list with a list of poses.
enum class ShapeKind : unsigned char { Primitive, Boxes, Mesh, MeshFile, Plane };
constexpr std::array<ShapeKind, 5> kShapeKinds = {ShapeKind::Primitive, ShapeKind::Boxes, ShapeKind::Mesh,
                                                  ShapeKind::MeshFile, ShapeKind::Plane};

/// The name of the list of poses: "primitive_poses".
const char* posesFieldOf(ShapeKind kind);

/// A shape of an object, in the object's frame. What a client sends for the kind may give it another pose later.
struct SourceShape {
  ShapeKind kind;
  scene::ObjectShape shape;
};

/// The kind of the list from which a shape comes.
ShapeKind kindOf(const scene::ObjectShape& shape);

/// All shapes of a change, kind by kind.
std::vector<SourceShape> shapesOf(const ObjectChange& change);

/// Whether a change has any shape.
bool hasShapes(const ObjectChange& change);

/// The poses of one kind.
std::vector<Eigen::Isometry3d> posesOf(const ObjectChange& change, ShapeKind kind);

/// A quaternion of zeros is the identity; any other is normalised. `field` begins the error message.
Eigen::Isometry3d poseFrom(const geometry_msgs::Pose& pose, const std::string& field);

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose);

}  // namespace proximity_server::node
