#pragma once

#include <optional>
#include <string>

#include "decomposition.h"

namespace proximity_server {

/// Decompositions on disk, one small text file each, named by a hash of what it depends on: the vertices (so the scale
/// too), the triangles, the tolerance and the version of file and algorithm.
///
/// A file holds a partition of the mesh's own triangles, so nothing in it can move a piece or leave one out. It is
/// believed only if its checksum is right and its numbers are such a partition; else it counts as absent.
class MeshCache {
 public:
  /// `folder` is made when something is stored; "": never finds and never stores.
  explicit MeshCache(std::string folder) : folder_(std::move(folder)) {}

  std::optional<Partition> find(const TriangleMesh& component, double tolerance) const;

  /// Writes beside the file and renames, so that no reader sees half of it. Returns what went wrong, or "".
  std::string store(const TriangleMesh& component, double tolerance, const Partition& partition) const;

 private:
  std::string folder_;
};

}  // namespace proximity_server
