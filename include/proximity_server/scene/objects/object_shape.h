#pragma once

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/mesh/triangle_mesh.h"
#include "proximity_server/scene/pieces/representation.h"

#include <Eigen/Geometry>

#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// An unbounded solid: all points x with normal . x <= offset. Its boundary is a plane.
struct HalfSpace {
  Eigen::Vector3d normal;  ///< outwards; need not be of unit length
  double offset = 0.0;     ///< [m] of the plane from the origin, along the unit normal
};

/// Many boxes along the axes of the shape's frame, for example from a map.
struct Boxes {
  std::vector<Eigen::AlignedBox3d> boxes;  ///< [m]
};

/// A mesh that is read from a file, see loadMesh().
struct MeshFile {
  std::string uri;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// A part of an object, in its pose.
struct ObjectShape {
  std::variant<narrowphase::Shape, Boxes, TriangleMesh, MeshFile, HalfSpace> geometry;
  Eigen::Isometry3d object_T_shape = Eigen::Isometry3d::Identity();
};

/// A shape of an object in the form that the queries use.
struct ObjectShapeInfo {
  std::string description;  ///< for people: "sphere", "mesh package://..."
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] see MeshPieces, also for the next two
  double uncovered = 0.0;
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  int pieces = 0;    ///< convex pieces and half-spaces
  int vertices = 0;  ///< of all hulls together
};

}  // namespace proximity_server::scene
