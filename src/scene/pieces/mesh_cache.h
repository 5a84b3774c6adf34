#pragma once

#include "proximity_server/scene/pieces/representation.h"
#include "scene/pieces/decomposition.h"

#include <limits>
#include <optional>
#include <string>

namespace proximity_server::scene {

/// The decomposition of a mesh without its hulls, which are computed from it.
struct Clustering {
  Partition partition;
  Representation representation = Representation::Exact;
  double tolerance = 0.0;  ///< [m] see MeshPieces
  double deviation = 0.0;  ///< [m] see MeshPieces
  double uncovered = 0.0;  ///< [m] see MeshPieces
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  bool is_complete = true;  ///< false if the effort was spent before the end
};

/// Keeps decompositions of meshes on disk. Each is one small text file, named by a hash of all that it depends on: the
/// vertices (which include the scale), the triangles, the tolerance, the time budget, and the version of file and
/// algorithm.
///
/// A file holds a partition of the mesh's own triangles, so no file can move a piece or leave one out. A file is used
/// only if its checksum is right, its numbers are such a partition, and convexPieces would have accepted its deviation;
/// otherwise it counts as absent.
class MeshCache {
 public:
  /// `folder` is created when something is stored. With "", nothing is found or stored.
  MeshCache(std::string folder, const TriangleMesh& mesh, double tolerance, double time_budget);

  std::optional<Clustering> find() const;

  /// Writes a temporary file and renames it, so that no reader sees an incomplete file. Returns what went wrong, or "".
  std::string store(const Clustering& clustering) const;

 private:
  std::string folder_, key_;
  std::size_t triangles_;
  double tolerance_;
};

}  // namespace proximity_server::scene
