#pragma once

#include <urdf_model/link.h>

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "proximity_server/narrowphase/shape.h"
#include "proximity_server/scene/mesh.h"

namespace proximity_server {

Eigen::Isometry3d toEigen(const urdf::Pose& pose);

/// What stands for a <geometry>.
struct CollisionGeometry {
  std::string description;
  std::vector<Shape> shapes;
  Representation representation = Representation::Exact;
  double deviation = 0.0;  ///< [m] see MeshPieces, as the next two
  double uncovered = 0.0;
  double volume_ratio = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> warnings = {};
};

/// Turns <geometry> elements into shapes; a mesh that is used again, with the same tolerance, is read once.
class GeometryReader {
 public:
  explicit GeometryReader(MeshResolver resolve) : resolve_(std::move(resolve)) {}

  /// Throws std::invalid_argument: a size that is zero or not finite, a mesh that cannot be read.
  CollisionGeometry read(const urdf::Geometry& geometry, const MeshOptions& options);

 private:
  struct MeshKey {
    std::string file;
    std::array<double, 3> scale;
    double tolerance;
    bool operator<(const MeshKey& other) const {
      return std::tie(file, scale, tolerance) < std::tie(other.file, other.scale, other.tolerance);
    }
  };

  CollisionGeometry readMesh(const urdf::Mesh& mesh, const MeshOptions& options);

  MeshResolver resolve_;
  std::map<MeshKey, CollisionGeometry> meshes_;
};

/// Three <collision> elements of a link that together are one capsule; it lies in the cylinder's frame.
struct CapsuleParts {
  int cylinder;                ///< index into the link's collisions
  std::array<int, 2> spheres;  ///< the same, at its lower and upper end
  Capsule capsule;
};

/// All cylinders of a link that have a sphere of their radius at both ends. A sphere may end several of them.
std::vector<CapsuleParts> findCapsules(const std::vector<urdf::CollisionSharedPtr>& collisions);

}  // namespace proximity_server
