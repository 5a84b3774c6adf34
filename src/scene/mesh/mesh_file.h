#pragma once

#include "proximity_server/scene/mesh/triangle_mesh.h"

#include <atomic>
#include <string>

namespace proximity_server::scene {

/// A mesh as its file has it.
struct MeshWithUnit {
  TriangleMesh mesh;  ///< in metres
  double unit = 1.0;  ///< [m] the unit of a Collada file, by which its lengths were multiplied
};

/// Reads a mesh as loadMesh() does, with its unit. Throws as requireNoStop() does once `stop` is set.
MeshWithUnit readMesh(const std::string& path, const Eigen::Vector3d& scale, const std::atomic<bool>* stop = nullptr);

/// Throws std::invalid_argument for more than kMaxTriangles, for a triangle with a vertex that there is not, and for a
/// vertex that is not finite, or farther than kFarthest from the origin along an axis.
void checkMesh(const TriangleMesh& mesh);

/// The sentence for a user about a unit that is not the metre, without a full stop; "" for the metre.
std::string unitRemark(double unit);

}  // namespace proximity_server::scene
