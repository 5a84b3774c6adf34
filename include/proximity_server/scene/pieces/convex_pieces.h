#pragma once

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/pieces/representation.h"

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

class Interior;

/// How a mesh becomes convex pieces.
struct MeshOptions {
  /// [m] The pieces may lie this far from the mesh. 0: the triangles are the pieces, unless hulls are exact.
  double tolerance = 0.005;
  std::string cache;  ///< The folder that keeps the pieces of earlier meshes. If it is "", nothing is read or written.
  std::function<void(const std::string&)> progress;  ///< Called before a step that takes long; may be empty.
  /// [s] The approximate time of one core of 2020. Steps are counted instead of time, so that every machine and every
  /// run computes the same pieces. Half of it is for the tolerance above. While that leaves more than 300 pieces, the
  /// tolerance is doubled, up to 8 times, with as much each time. The pieces found then are the result.
  /// Rooms are excluded with the same budget once again; those that are left when it is spent are filled.
  double time_budget = 10.0;
  /// If not nullptr, a flag that another thread, or the handler of a signal, may set while meshes are read and become
  /// pieces. Then that ends within a fraction of a second with a std::runtime_error, and keeps nothing.
  const std::atomic<bool>* stop = nullptr;
};

/// Convex pieces that stand for a mesh.
///
/// The mesh is its surface together with the space inside its closed components. Flat and open components are legal. A
/// mesh without triangles has no pieces.
struct MeshPieces {
  std::vector<narrowphase::ConvexHull> hulls;
  Representation representation = Representation::Exact;
  double tolerance = 0.0;  ///< [m] the tolerance of the options, or a coarser one because the time budget was spent
  /// [m] the largest distance from the mesh that was found for a point of the pieces outside of the mesh
  double deviation = 0.0;
  /// [m] the largest distance from the pieces that was found for a point of the mesh's triangles
  double uncovered = 0.0;
  /// The volume of the hulls of the components divided by the volume that the components enclose. NaN if a component is
  /// open, or if they enclose nothing.
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> warnings;  ///< not empty if the cache cannot be written
  /// If the time budget ended the search: a text that says how many pieces there are and how near to the mesh; else "".
  std::string shortfall;
  /// For each hull: true if it is a representative. A representative represents a connected component when other shapes
  /// test whether that component lies in their interiors. Every component has one.
  std::vector<bool> is_representative;
  /// The space inside the closed components, if hulls may leave some of it empty; else nullptr. It is not in the hulls.
  std::shared_ptr<const Interior> interior;
  /// A text that says which components enclose no volume, and what follows from that; "" for a closed mesh.
  std::string openness;
};

/// Finds the fewest pieces within tolerance of the mesh. These are tried in this order: the hull of the whole mesh; the
/// hulls of the connected components (vertices at the same place are connected; a component inside the hull of another
/// one has no hull of its own); the hulls of clusters of triangles, see decomposition.h; the triangles. A piece within
/// rounding, 1e-6 m, always counts as within tolerance.
///
/// Solid:   a component is closed if each of its edges, between vertices at the same places, occurs equally often in
///          both directions, and if it encloses a volume. The solid is where the winding number of all closed
///          components is not 0, see Interior. Clusters and triangles stand for its surface, hulls for all of it.
/// Limit:   a shape that lies wholly inside an open component may touch none of the pieces, and then counts as apart
///          from it. In overlap, the depth of the deepest two pieces is a lower bound of the depth of the solids.
/// Failure: throws std::invalid_argument for a tolerance that is negative or not finite, a time budget that is not above
///          0, more than 200,000 triangles, a triangle with a vertex that there is not, and a vertex that is not finite, or
///          farther than 1e6 m from the origin along an axis; std::runtime_error once MeshOptions::stop is set.
MeshPieces convexPieces(const TriangleMesh& mesh, const MeshOptions& options = {});

/// Returns the folder of the user's decompositions: $XDG_CACHE_HOME/proximity_server, else ~/.cache/proximity_server;
/// "" if neither is known.
std::string userMeshCache();

}  // namespace proximity_server::scene
