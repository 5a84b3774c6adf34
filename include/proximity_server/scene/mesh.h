#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "proximity_server/narrowphase/convex_hull.h"

namespace proximity_server {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m], in the frame of the <geometry>
  std::vector<std::array<int, 3>> triangles;
};

/// Turns a mesh URI of a URDF (package://, file://, a plain path) into a path that can be opened.
/// Throws std::invalid_argument naming the URI where it cannot.
using MeshResolver = std::function<std::string(const std::string& uri)>;

/// The resolver for everybody without ROS: file:// and plain paths as they are (relative ones against `base_dir`),
/// package://name/path (two or three slashes) searched for below `roots` as ROS_PACKAGE_PATH does it: a folder with a
/// package.xml that names the package.
MeshResolver packageResolver(const std::vector<std::string>& roots, const std::string& base_dir = {});

/// The folders of the environment variable ROS_PACKAGE_PATH.
std::vector<std::string> rosPackagePath();

/// All triangles of a mesh file (STL binary or ASCII, DAE, OBJ), instances and node transforms applied, then scaled.
///
/// Units are taken as metres and axes as they stand, as ROS tools do (a Collada up axis is ignored, its unit counts).
/// A mirrored scale (one or three negative factors) turns the triangles so that they still face outwards.
/// Failure: throws std::invalid_argument naming the file: missing, unreadable, no triangle, a number not finite.
TriangleMesh loadMesh(const std::string& path, const Eigen::Vector3d& scale);

/// What stands for a mesh in the queries.
enum class Representation : unsigned char {
  Exact = 0,       ///< a primitive, or a mesh that is its hull (or hulls) within rounding
  ConvexHull = 1,  ///< the convex hull of a mesh that is not convex
  Decomposed = 2,  ///< several convex pieces that are not exactly the mesh
  Triangles = 3,   ///< the triangles themselves
};

/// Convex pieces that stand for a mesh: one hull per connected component (vertices at the same place are connected),
/// but none for a component inside another one's hull. Flat and open components are legal; no triangles, no pieces.
struct MeshPieces {
  std::vector<ConvexHull> hulls;
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] farthest that a point of the pieces' surface was found to lie from the mesh
};
MeshPieces convexPieces(const TriangleMesh& mesh);

}  // namespace proximity_server
