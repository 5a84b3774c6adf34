#pragma once

#include "proximity_server/scene/mesh/mesh.h"
#include "scene/pieces/triangle_tree.h"

#include <algorithm>
#include <vector>

namespace proximity_server::scene {

// Mesh files hold floats or texts of six digits: a coordinate of one metre is rounded by up to 1e-6 m.
constexpr double kMeshRounding = 1e-6;

/// Orders points by x, then y, then z.
inline bool isBefore(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// Merges vertices at the same place. All triangles and their order are kept, even triangles that become degenerate.
TriangleMesh welded(const TriangleMesh& mesh);

/// For each triangle of a welded mesh the number of its connected component. Components are numbered in the order of
/// their first triangles.
std::vector<int> componentNumbers(const TriangleMesh& welded_mesh);

/// For each number the indices of the triangles that have it.
std::vector<std::vector<int>> byNumber(const std::vector<int>& numbers);

/// For each number a mesh of the triangles that have it, with only the vertices that they need.
std::vector<TriangleMesh> partsOf(const TriangleMesh& mesh, const std::vector<int>& numbers);

/// True if each edge of a component occurs equally often in both directions. Then the component encloses a volume, and
/// its orientation defines the outside. Triangles with two equal corners do not count.
bool isClosed(const TriangleMesh& component);

/// [m^3] The volume inside a component; positive if its triangles face outwards.
double enclosedVolume(const TriangleMesh& component);

std::vector<Triangle> trianglesOf(const std::vector<Eigen::Vector3d>& vertices,
                                  const std::vector<std::array<int, 3>>& triangles);

}  // namespace proximity_server::scene
