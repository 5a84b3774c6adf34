#pragma once

#include "proximity_server/scene/mesh/mesh.h"

namespace proximity_server::scene {

/// Twelve triangles that face outwards; inwards where one of the edges is negative. Every triangle has vertices of its
/// own, as in an STL file.
inline TriangleMesh boxMesh(const Eigen::Vector3d& low, const Eigen::Vector3d& edges) {
  // Two triangles for each side, by the corners' coordinates as bits x, y, z.
  constexpr int kCorners[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  TriangleMesh mesh;
  for (const auto& corners : kCorners) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const int corner : corners) {
      const Eigen::Vector3d place(corner & 1, (corner >> 1) & 1, corner >> 2);
      mesh.vertices.push_back(low + place.cwiseProduct(edges));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

inline TriangleMesh together(const std::vector<TriangleMesh>& meshes) {
  TriangleMesh all;
  for (const TriangleMesh& mesh : meshes) {
    const int offset = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& [a, b, c] : mesh.triangles) all.triangles.push_back({a + offset, b + offset, c + offset});
  }
  return all;
}

}  // namespace proximity_server::scene
