#pragma once

#include <vector>

#include "mesh_deviation.h"
#include "proximity_server/scene/mesh.h"

namespace proximity_server {

/// For each triangle of a component the number of its cluster; the hull of a cluster is a convex piece.
using Partition = std::vector<int>;

/// Clusters of triangles whose hulls lie within `tolerance` [m] of the mesh, by MeshSolid::deviationOf.
///
/// Hierarchical approximate convex decomposition proposes; a cluster whose hull deviates too much is halved until it
/// does not, at the latest as a single triangle. So it always ends, the hulls cover every triangle, and what the
/// library gets wrong (meshes that are open or not manifold) costs pieces, not correctness.
/// Failure: throws Effort::Exceeded, of `mesh`.
/// Source:  Mamou, Ghorbel: A Simple and Efficient Approach for 3D Mesh Approximate Convex Decomposition, ICIP 2009
///          (HACD). Unlike there, only the clusters are taken: the hulls are ours, of all their vertices in double.
///          Not ConvexDecomposition: single precision, settings in global variables, a tolerance as part of the volume.
///          Not CGAL: it takes closed manifolds only, and its licence (GPL) would become that of the node.
Partition decompose(const TriangleMesh& component, const MeshSolid& mesh, double tolerance);

/// The vertices of each cluster.
std::vector<std::vector<Eigen::Vector3d>> clusterVertices(const TriangleMesh& component, const Partition& partition);

}  // namespace proximity_server
