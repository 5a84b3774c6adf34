#pragma once

#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/mesh_deviation.h"

#include <vector>

namespace proximity_server::scene {

/// For each triangle of a mesh the number of its cluster. The hull of a cluster is a convex piece.
using Partition = std::vector<int>;

/// The hull of a part of a cluster lies in the hull of the cluster. If that one is within tolerance, so is the part, unless
/// a room is between: to trust in that saves most of the tests, and the hulls of the result are to be measured.
enum class PartsOfHulls : unsigned char { AreTrusted, AreTested };

struct Decomposition {
  Partition partition;
  bool is_complete = true;  ///< false: the effort of the mesh was spent before the end
};

/// Divides the triangles into few clusters whose hulls lie within `tolerance` [m] of the mesh. This holds for the
/// surfaces of the hulls, see MeshSolid::isSurfaceWithin. Few meshes have rooms, and to prove of each hull that it fills
/// none is slow: `rooms` are points of rooms that are known, and no solid hull contains one of them.
///
/// 1. The triangles of each component are halved across their longest side until the hull of each part lies within
///    tolerance, at the latest as a single triangle.
/// 2. Two clusters that share a vertex are merged if the hull of both lies within tolerance; the pair with the smallest
///    common box comes first.
/// 3. Clusters of any components whose boxes are no farther apart than twice the tolerance are merged in the same way.
///    Halfway between clusters that are farther apart, their hull is farther than the tolerance from both.
///
/// With PartsOfHulls::AreTrusted, steps 2 and 3 use only some vertices of the hull of a part. No other vertex of the part
/// rises above a face of the hull of these by more than 1 % of the tolerance.
///
/// A hull that deviates too much also does so as a part of a larger hull. So a pair that cannot be merged is not tried
/// again after one of the two has grown, and there are at most as many tries as pairs of neighbours at the start.
/// Every triangle belongs to a cluster at any time: when the effort is spent, the clusters at that time are the result.
///
/// `components`: for each triangle the number of its connected component.
/// Source:  bottom-up clustering as in Mamou, Ghorbel: A Simple and Efficient Approach for 3D Mesh Approximate Convex
///          Decomposition, ICIP 2009 (HACD). Unlike there, the distance of the hull from the mesh decides and not its
///          concavity, and the first clusters are parts instead of triangles.
Decomposition decompose(const TriangleMesh& mesh, const Partition& components, const MeshSolid& solid, double tolerance,
                        PartsOfHulls parts_of_hulls = PartsOfHulls::AreTrusted,
                        const std::vector<Eigen::Vector3d>& rooms = {});

/// Makes the hull of some points, and first spends the steps that this takes.
Cover coverOf(std::vector<Eigen::Vector3d> points, Effort& effort);

/// The points of some triangles of a mesh, each once.
std::vector<Eigen::Vector3d> pointsOf(const TriangleMesh& mesh, const std::vector<int>& triangles);

/// The points of each cluster, in the order of their numbers.
std::vector<std::vector<Eigen::Vector3d>> clusterPoints(const TriangleMesh& mesh, const Partition& partition);

}  // namespace proximity_server::scene
