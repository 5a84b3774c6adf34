#pragma once

#include <vector>

#include "proximity_server/scene/mesh.h"
#include "triangle_tree.h"

namespace proximity_server {

/// The connected components of a mesh, in the order of their first triangles. Vertices at the same place become one,
/// and each component has only those that it needs.
std::vector<TriangleMesh> connectedComponents(const TriangleMesh& mesh);

/// Whether each edge of a component is passed as often in either direction: it encloses a volume and says where outside
/// is. Triangles with a corner twice do not count.
bool isClosed(const TriangleMesh& component);

/// [m^3] positive where the triangles face outwards.
double enclosedVolume(const TriangleMesh& component);

std::vector<Triangle> trianglesOf(const std::vector<Eigen::Vector3d>& vertices,
                                  const std::vector<std::array<int, 3>>& triangles);

}  // namespace proximity_server
