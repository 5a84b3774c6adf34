#pragma once

#include <limits>
#include <optional>
#include <string>

#include "proximity_server/scene/pieces/representation.h"
#include "scene/pieces/decomposition.h"

namespace proximity_server::scene {

/// The decomposition of a mesh, without the hulls, which follow from it.
struct Clustering {
  Partition partition;
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] as those of MeshPieces
  double uncovered = 0.0;  ///< [m]
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  bool is_complete = true;  ///< false: the effort was spent before the end
};

/// Decompositions of meshes on disk: one small text file each, named by a hash of what it depends on: the vertices (so
/// the scale too), the triangles, the tolerance, the time budget and the version of file and algorithm.
///
/// A file holds a partition of the mesh's own triangles, so nothing in it can move a piece or leave one out. It is
/// believed only if its checksum is right, its numbers are such a partition, and its deviation is one that convexPieces
/// would have accepted; else it counts as absent.
class MeshCache {
 public:
  /// `folder` is made when something is stored; "": never finds and never stores.
  MeshCache(std::string folder, const TriangleMesh& mesh, double tolerance, double time_budget);

  std::optional<Clustering> find() const;

  /// Writes beside the file and renames, so that no reader sees half of it. Returns what went wrong, or "".
  std::string store(const Clustering& clustering) const;

 private:
  std::string folder_, key_;
  std::size_t triangles_;
  double tolerance_;
};

}  // namespace proximity_server::scene
