#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/collision_geometry.h>
#include <fcl/math/bv/OBBRSS.h>

#include <memory>

namespace proximity_server::tools {

/// A convex shape as FCL 0.7 describes it, in the same frame.
///
/// Failure: throws std::invalid_argument for what FCL has no shape for: a margin about anything but a point or a
///          segment, and a hull that is no solid.
std::shared_ptr<fcl::CollisionGeometryd> fclShape(const narrowphase::Shape& shape);

using FclMesh = fcl::BVHModel<fcl::OBBRSSd>;

/// Adds the triangles of a box or a hull to a mesh that is begun, in the mesh's frame.
///
/// Failure: throws std::invalid_argument for a hull that is a point or a segment.
void addTriangles(FclMesh& mesh, const narrowphase::Shape& polytope, const Eigen::Isometry3d& mesh_T_shape);

}  // namespace proximity_server::tools
