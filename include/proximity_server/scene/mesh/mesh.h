#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "proximity_server/narrowphase/shape/convex_hull.h"

namespace proximity_server::scene {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m], in the frame of the <geometry>
  std::vector<std::array<int, 3>> triangles;
};

/// Turns a mesh URI of a URDF (package://, file://, a plain path) into a path that can be opened.
/// Throws std::invalid_argument naming the URI where it cannot.
using MeshResolver = std::function<std::string(const std::string& uri)>;

/// The resolver for everybody without ROS: file:// and plain paths as they are (relative ones against `base_dir`),
/// package://name/path (two or three slashes) searched for below `roots` as ROS_PACKAGE_PATH does it: a folder with a
/// package.xml that names the package; no path of it leaves the package through "..". Any other scheme is refused.
MeshResolver packageResolver(const std::vector<std::string>& roots, const std::string& base_dir = {});

/// The same files, but only those that lie below one of `roots` once all links are followed; all where there are none.
/// Throws std::invalid_argument for a root that does not exist; the resolver does so for a file below none.
MeshResolver withinRoots(MeshResolver resolve, const std::vector<std::string>& roots);

/// The folders of the environment variable ROS_PACKAGE_PATH.
std::vector<std::string> rosPackagePath();

/// All triangles of a mesh file (.stl and .ply, binary or ASCII, .dae, .obj), instances and node transforms applied,
/// then scaled.
///
/// Units are taken as metres and axes as they stand, as ROS tools do (a Collada up axis is ignored, its unit counts).
/// A mirrored scale (one or three negative factors) turns the triangles so that they still face outwards.
/// A child process reads the file, so that none of what may be in it harms this one.
/// Limit:   at most 256 MiB, 200,000 triangles, and 1e6 m from the origin; 1 GiB of memory, 10 s of processor time and
///          60 s to read it.
/// Failure: throws std::invalid_argument naming the file: missing, unreadable, malformed, cut off (where its format
///          tells), no triangle, a number not finite, beyond a limit.
TriangleMesh loadMesh(const std::string& path, const Eigen::Vector3d& scale);

/// What stands for a mesh in the queries.
enum class Representation : unsigned char {
  Exact = 0,       ///< a primitive, or a mesh that is its hull (or hulls) within rounding
  ConvexHull = 1,  ///< the convex hull of a mesh that is not convex
  Decomposed = 2,  ///< several convex pieces that are not exactly the mesh
  Triangles = 3,   ///< the triangles themselves
};
const char* toString(Representation representation);

/// How a mesh becomes convex pieces.
struct MeshOptions {
  double tolerance = 0.005;  ///< [m] how far the pieces may lie from the mesh; 0: the triangles, unless hulls are exact
  std::string cache;         ///< folder of what meshes have become before; "": none is read or written
  std::function<void(const std::string&)> progress;  ///< told what is about to take time; may be empty
  /// [s] of one core, roughly: steps are counted instead of time, so that every machine and every run comes to the same
  /// pieces. Where it ends those found so far stand for the mesh, all of them within tolerance.
  double time_budget = 10.0;
};

/// Convex pieces that stand for a mesh.
///
/// "Of the mesh" is: of its surface, and of the space inside its closed components. Flat and open components are legal;
/// no triangles, no pieces.
struct MeshPieces {
  std::vector<narrowphase::ConvexHull> hulls;
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] farthest that a point of the pieces was found to lie outside of the mesh
  double uncovered = 0.0;  ///< [m] farthest that a point of the mesh's triangles was found to lie outside of the pieces
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();  ///< hulls of the components over what they enclose;
                                                                   ///< NaN where one is open or encloses nothing
  std::vector<std::string> warnings;                               ///< the cache cannot be written
  std::string shortfall;  ///< why these may be more pieces than need be, where the time budget ended; else ""
};

/// The fewest pieces within tolerance of the mesh, tried in this order: the hull of all; the hulls of the connected
/// components (vertices at the same place are connected; none for a component inside another one's hull); the hulls of
/// clusters of triangles, see decomposition.h; the triangles. "Within rounding", 1e-6 m, always counts as within.
///
/// Limit:   clusters and triangles stand for the surface. What lies wholly inside a closed mesh, away from its surface,
///          may be in none of the pieces, and then counts as apart from it; in overlap the depth of the deepest two
///          pieces is a lower bound of that of the solids.
/// Failure: throws std::invalid_argument for a tolerance that is negative or not finite, or a time budget that is not
///          above 0.
MeshPieces convexPieces(const TriangleMesh& mesh, const MeshOptions& options = {});

/// Where a user's decompositions are kept: $XDG_CACHE_HOME/proximity_server, else ~/.cache/proximity_server; "" where
/// neither is known.
std::string userMeshCache();

}  // namespace proximity_server::scene
