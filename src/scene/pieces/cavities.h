#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/effort.h"

namespace proximity_server::scene {

/// The closed spaces inside of a mesh that do not belong to its solid: a closed part encloses them, but the winding
/// number of all parts is 0, because another part faces into them.
///
/// The surface of a hull tells nothing about a cavity that is wholly inside of the hull. So points are kept that lie
/// deeper in the cavities than the tolerance, one beside each triangle of their walls as far as there are such: a hull
/// whose surface is within tolerance of the mesh holds a cavity, where it is deeper than the tolerance, wholly or not at
/// all.
class Cavities {
 public:
  Cavities() = default;

  /// Costs nothing if all parts face the same way.
  Cavities(const std::vector<TriangleMesh>& closed_parts, double tolerance);

  /// Whether the hull fills one that is deeper than the tolerance. May throw Effort::Exceeded.
  bool areFilledBy(const narrowphase::ConvexHull& hull, Effort& effort) const;

 private:
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace proximity_server::scene
