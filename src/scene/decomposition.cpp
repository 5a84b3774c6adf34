#include "decomposition.h"

#include <hacdHACD.h>

#include <algorithm>
#include <numeric>

namespace proximity_server {
namespace {

using Eigen::Vector3d;
using Cluster = std::vector<int>;  // indices of triangles

// Its cost grows with the square of the triangles; above this, halving alone has to do.
constexpr std::size_t kMostTriangles = 20000;
constexpr double kHacdSize = 1000.0;  // HACD's normalised diagonal, its own default

bool hasArea(const TriangleMesh& mesh, const std::array<int, 3>& t) {
  const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  return (b - a).cross(c - a).squaredNorm() > 0.0;
}

double diagonal(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box.diagonal().norm();
}

/// The clusters that HACD makes of these triangles; one with all of them where it makes nothing of them.
std::vector<Cluster> propose(const TriangleMesh& mesh, const Cluster& triangles, double tolerance) {
  if (triangles.empty()) return {};
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const Vector3d& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<HACD::Vec3<long>> corners;
  for (const int t : triangles) {
    const auto& [a, b, c] = mesh.triangles[t];
    corners.emplace_back(a, b, c);
  }
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(corners.data());
  hacd.SetNTriangles(corners.size());
  hacd.SetScaleFactor(kHacdSize);
  hacd.SetConcavity(tolerance * kHacdSize / diagonal(mesh));
  hacd.SetNClusters(1);
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddFacesPoints(true);
  hacd.NormalizeData();
  if (!hacd.Compute()) return {triangles};

  std::vector<Cluster> clusters(hacd.GetNClusters());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const long cluster = hacd.GetPartition()[i];
    if (cluster < 0 || cluster >= static_cast<long>(clusters.size())) return {triangles};
    clusters[static_cast<std::size_t>(cluster)].push_back(triangles[i]);
  }
  clusters.erase(std::remove_if(clusters.begin(), clusters.end(), [](const Cluster& c) { return c.empty(); }),
                 clusters.end());
  return clusters;
}

std::vector<Vector3d> verticesOf(const TriangleMesh& mesh, const Cluster& cluster) {
  std::vector<int> indices;
  for (const int t : cluster) indices.insert(indices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  std::vector<Vector3d> vertices;
  vertices.reserve(indices.size());
  for (const int i : indices) vertices.push_back(mesh.vertices[i]);
  return vertices;
}

/// Splits a cluster in the middle of its longest side; returns the upper half.
Cluster takeHalf(const TriangleMesh& mesh, Cluster& cluster) {
  const auto centre = [&](int t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return Vector3d(mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]);
  };
  Eigen::AlignedBox3d box;
  for (const int t : cluster) box.extend(centre(t));
  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const auto middle = cluster.begin() + static_cast<std::ptrdiff_t>(cluster.size() / 2);
  std::nth_element(cluster.begin(), middle, cluster.end(),
                   [&](int s, int t) { return centre(s)[axis] < centre(t)[axis]; });
  Cluster upper(middle, cluster.end());
  cluster.erase(middle, cluster.end());
  return upper;
}

}  // namespace

Partition decompose(const TriangleMesh& component, const MeshSolid& mesh, double tolerance) {
  Cluster solid;
  std::vector<Cluster> pending;
  for (int t = 0; t < static_cast<int>(component.triangles.size()); ++t) {
    if (hasArea(component, component.triangles[t]))
      solid.push_back(t);
    else
      pending.push_back({t});
  }
  const bool too_many = solid.size() > kMostTriangles;
  for (Cluster& cluster : too_many ? std::vector<Cluster>{solid} : propose(component, solid, tolerance)) {
    pending.push_back(std::move(cluster));
  }

  Partition partition(component.triangles.size());
  for (int number = 0; !pending.empty();) {
    Cluster cluster = std::move(pending.back());
    pending.pop_back();
    const std::vector<Vector3d> vertices = verticesOf(component, cluster);
    if (cluster.size() > 1 && mesh.deviationOf(ConvexHull(vertices), vertices) > tolerance) {
      pending.push_back(takeHalf(component, cluster));
      pending.push_back(std::move(cluster));
      continue;
    }
    for (const int t : cluster) partition[t] = number;
    ++number;
  }
  return partition;
}

std::vector<std::vector<Vector3d>> clusterVertices(const TriangleMesh& component, const Partition& partition) {
  std::vector<Cluster> clusters;
  for (std::size_t t = 0; t < partition.size(); ++t) {
    const auto number = static_cast<std::size_t>(partition[t]);
    if (number >= clusters.size()) clusters.resize(number + 1);
    clusters[number].push_back(static_cast<int>(t));
  }
  std::vector<std::vector<Vector3d>> vertices;
  for (const Cluster& cluster : clusters) {
    if (!cluster.empty()) vertices.push_back(verticesOf(component, cluster));
  }
  return vertices;
}

}  // namespace proximity_server
