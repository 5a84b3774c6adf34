#pragma once

#include <vector>

#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/mesh_deviation.h"

namespace proximity_server::scene {

/// For each triangle of a mesh the number of its cluster; the hull of a cluster is a convex piece.
using Partition = std::vector<int>;

struct Decomposition {
  Partition partition;
  bool is_complete = true;  ///< false: the effort of the mesh was spent before the end
};

/// Clusters of triangles whose hulls lie within `tolerance` [m] of the mesh, by MeshSolid::isWithin, few of them.
///
/// 1. The triangles of each component are halved across their longest side until the hull of each part lies within
///    tolerance, at the latest as a single triangle.
/// 2. Two clusters that share a vertex become one where the hull of both lies within tolerance; those that make the
///    smallest box first.
/// 3. The same for clusters, of any component, whose boxes are no farther apart than the tolerance.
///
/// A hull that deviates too much does so as a part of every larger one. So a pair that may not become one is not tried
/// again, whatever the two become part of, and the number of tries is at most that of the first neighbours.
/// Every triangle is covered at any time: where the effort ends, the clusters of that moment are the result.
///
/// `components`: for each triangle the number of its connected component.
/// Source:  bottom-up clustering as of Mamou, Ghorbel: A Simple and Efficient Approach for 3D Mesh Approximate Convex
///          Decomposition, ICIP 2009 (HACD). Unlike there, what decides is the distance of the hull from the mesh and
///          not its concavity, and the first clusters are parts instead of triangles.
Decomposition decompose(const TriangleMesh& mesh, const Partition& components, const MeshSolid& solid,
                        double tolerance);

/// The steps, see Effort, that building the hull of so many points takes.
std::size_t stepsOfHull(std::size_t points);

/// The points of each cluster, in the order of their numbers.
std::vector<std::vector<Eigen::Vector3d>> clusterPoints(const TriangleMesh& mesh, const Partition& partition);

}  // namespace proximity_server::scene
