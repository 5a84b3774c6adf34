#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/pieces/representation.h"

namespace proximity_server::scene {

class Interior;

/// How a mesh becomes convex pieces.
struct MeshOptions {
  double tolerance = 0.005;  ///< [m] how far the pieces may lie from the mesh; 0: the triangles, unless hulls are exact
  std::string cache;         ///< folder of what meshes have become before; "": none is read or written
  std::function<void(const std::string&)> progress;  ///< is called before a step that takes long; may be empty
  /// [s] of one core, roughly: steps are counted instead of time, so that every machine and every run comes to the same
  /// pieces. When it is spent, the pieces found so far are the result; all of them are within tolerance. A mesh whose clusters
  /// fill a room is divided a second time, with as much again.
  double time_budget = 10.0;
};

/// Convex pieces that stand for a mesh.
///
/// The mesh is its surface together with the space inside its closed components. Flat and open components are legal. A
/// mesh without triangles has no pieces.
struct MeshPieces {
  std::vector<narrowphase::ConvexHull> hulls;
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] farthest that a point of the pieces was found to lie outside of the mesh
  double uncovered = 0.0;  ///< [m] farthest that a point of the mesh's triangles was found to lie outside of the pieces
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();  ///< hulls of the components over what they enclose;
                                                                   ///< NaN where one is open or encloses nothing
  std::vector<std::string> warnings;                               ///< the cache cannot be written
  std::string shortfall;  ///< why these may be more pieces than need be, where the time budget ended; else ""
  /// For each hull whether it is the one that stands for a connected component when others look for it in their
  /// interiors. Every component has one.
  std::vector<bool> is_anchor;
  /// The space inside the closed components, if hulls may leave some of it empty; else nullptr. It is not in the hulls.
  std::shared_ptr<const Interior> interior;
  std::string openness;  ///< which of its components enclose no volume, and what follows; "" for a closed mesh
};

/// The fewest pieces within tolerance of the mesh, tried in this order: the hull of all; the hulls of the connected
/// components (vertices at the same place are connected; none for a component inside another one's hull); the hulls of
/// clusters of triangles, see decomposition.h; the triangles. "Within rounding", 1e-6 m, always counts as within.
///
/// Solid:   a component is closed if each of its edges, between vertices at the same places, occurs equally often in both
///          directions, and if it encloses a volume. The solid is where the winding number of all closed components
///          is not 0, see Interior. Clusters and triangles stand for its surface, hulls for all of it.
/// Limit:   what lies wholly inside an open component may be in none of the pieces, and then counts as apart from it; in
///          overlap the depth of the deepest two pieces is a lower bound of that of the solids.
/// Failure: throws std::invalid_argument for a tolerance that is negative or not finite, or a time budget that is not
///          above 0.
MeshPieces convexPieces(const TriangleMesh& mesh, const MeshOptions& options = {});

/// The folder of a user's decompositions: $XDG_CACHE_HOME/proximity_server, else ~/.cache/proximity_server; "" if
/// neither is known.
std::string userMeshCache();

}  // namespace proximity_server::scene
