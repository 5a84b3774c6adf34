#pragma once

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/pieces/convex_pieces.h"

#include <urdf_model/link.h>
#include <Eigen/Geometry>

#include <array>
#include <exception>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace proximity_server::scene {

Eigen::Isometry3d toEigen(const urdf::Pose& pose);

/// The convex shapes that represent a <geometry> element.
struct CollisionGeometry {
  std::string description;
  std::vector<narrowphase::Shape> shapes;
  /// the pieces of a mesh without their hulls, which are in `shapes`; its sentences name the mesh
  MeshPieces mesh = {};
  std::string unit_remark = {};  ///< see unitRemark()
};

/// A mesh of a link, and the options of its pieces.
struct MeshRequest {
  const urdf::Mesh* mesh;
  MeshOptions options;
};

/// Converts <geometry> elements into shapes. A mesh that occurs several times with the same tolerance is read once.
class GeometryReader {
 public:
  explicit GeometryReader(MeshResolver resolve) : resolve_(std::move(resolve)) {}

  /// The reaction to a mesh that cannot be read: it ends everything with an error, or it is passed over with a warning
  /// and has no geometry.
  enum class Failure : unsigned char { EndsIt, IsPassedOver };

  /// Reads meshes in up to `threads` threads (0: one for each core), so that read() finds them. Errors are kept, and
  /// read() throws them. The calling thread reports progress.
  void readAhead(const std::vector<MeshRequest>& requests, int threads, Failure failure);

  /// Throws std::invalid_argument for a size that is zero or not finite, and for a mesh that cannot be read.
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
  struct Outcome {
    CollisionGeometry geometry;
    std::exception_ptr error;  // instead of the geometry
  };

  struct MeshAhead {
    MeshKey key;
    const MeshRequest* request;
    Outcome outcome = {};
    bool is_done = false;
  };

  MeshKey keyOf(const urdf::Mesh& mesh, const MeshOptions& options) const;
  static Outcome outcomeOf(const MeshKey& key, const std::string& uri, const MeshOptions& options);
  static void readAll(std::vector<MeshAhead>& meshes, int threads, Failure failure);

  MeshResolver resolve_;
  std::map<MeshKey, Outcome> meshes_;
};

/// Three <collision> elements of a link that together form a capsule. The frame of the capsule is the frame of the
/// cylinder.
struct CapsuleParts {
  int cylinder;                ///< index into the link's collisions
  std::array<int, 2> spheres;  ///< indices of the spheres at its lower and upper end
  narrowphase::Capsule capsule;
};

/// Finds all cylinders of a link that have a sphere of their radius at both ends. A sphere may be the end of several
/// cylinders.
std::vector<CapsuleParts> findCapsules(const std::vector<urdf::CollisionSharedPtr>& collisions);

}  // namespace proximity_server::scene
