#include "decomposition.h"

#include <hacdHACD.h>

#include <algorithm>
#include <numeric>

namespace proximity_server {
namespace {

using Eigen::Vector3d;
using Cluster = std::vector<int>;  // indices of triangles

// Its cost grows with the square of the triangles, 80 ns each (5000 that share one corner take 2 s); above this,
// halving alone has to do.
constexpr std::size_t kMostTriangles = 10000;
constexpr std::size_t kHacdSteps = 20;  // of Effort, by square of a triangle
constexpr double kHacdSize = 1000.0;    // HACD's normalised diagonal, its own default

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

bool isWithin(double tolerance, const MeshSolid& mesh, const TriangleMesh& component, const Cluster& cluster) {
  const std::vector<Vector3d> vertices = verticesOf(component, cluster);
  return mesh.isWithin(tolerance, ConvexHull(vertices), vertices);
}

/// The same triangles in clusters that are within tolerance, at the latest one by one.
std::vector<Cluster> halved(std::vector<Cluster> pending, const TriangleMesh& component, const MeshSolid& mesh,
                            double tolerance) {
  std::vector<Cluster> clusters;
  while (!pending.empty()) {
    Cluster cluster = std::move(pending.back());
    pending.pop_back();
    if (cluster.size() > 1 && !isWithin(tolerance, mesh, component, cluster)) {
      pending.push_back(takeHalf(component, cluster));
      pending.push_back(std::move(cluster));
    } else {
      clusters.push_back(std::move(cluster));
    }
  }
  return clusters;
}

/// Clusters that touch and are within tolerance together become one; the smallest look for a partner first.
class Fusion {
 public:
  Fusion(const TriangleMesh& component, const MeshSolid& mesh, double tolerance)
      : component_(component), mesh_(mesh), tolerance_(tolerance) {}

  std::vector<Cluster> fused(std::vector<Cluster> clusters) {
    for (Cluster& cluster : clusters) add(std::move(cluster));
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (!parts_[i].cluster.empty()) fuse(i);
    }
    std::vector<Cluster> result;
    for (Part& part : parts_) {
      if (!part.cluster.empty()) result.push_back(std::move(part.cluster));
    }
    return result;
  }

 private:
  struct Part {
    Cluster cluster;  // empty: it has become part of a later one
    std::vector<int> vertices;
    Eigen::AlignedBox3d box;
  };

  void add(Cluster cluster) {
    Part part{std::move(cluster), {}, {}};
    for (const int t : part.cluster)
      part.vertices.insert(part.vertices.end(), component_.triangles[t].begin(), component_.triangles[t].end());
    std::sort(part.vertices.begin(), part.vertices.end());
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
    for (const int vertex : part.vertices) part.box.extend(component_.vertices[vertex]);
    parts_.push_back(std::move(part));
  }

  static bool touch(const Part& a, const Part& b) {
    if (!a.box.intersects(b.box)) return false;
    std::vector<int> shared;
    std::set_intersection(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end(),
                          std::back_inserter(shared));
    return !shared.empty();
  }

  /// With the first of its neighbours, those that make the smallest box with it first; the result is appended.
  void fuse(std::size_t i) {
    mesh_.effort().spend(parts_.size());
    std::vector<std::pair<double, std::size_t>> neighbours;
    for (std::size_t j = 0; j < parts_.size(); ++j) {
      if (j != i && !parts_[j].cluster.empty() && touch(parts_[i], parts_[j]))
        neighbours.emplace_back(parts_[i].box.merged(parts_[j].box).diagonal().norm(), j);
    }
    std::sort(neighbours.begin(), neighbours.end());
    for (const auto& [size, j] : neighbours) {
      Cluster both = parts_[i].cluster;
      both.insert(both.end(), parts_[j].cluster.begin(), parts_[j].cluster.end());
      if (!isWithin(tolerance_, mesh_, component_, both)) continue;
      parts_[i].cluster.clear();
      parts_[j].cluster.clear();
      add(std::move(both));
      return;
    }
  }

  const TriangleMesh& component_;
  const MeshSolid& mesh_;
  const double tolerance_;
  std::vector<Part> parts_;
};

}  // namespace

Partition decompose(const TriangleMesh& component, const MeshSolid& mesh, double tolerance) {
  Cluster solid;
  std::vector<Cluster> flat;
  for (int t = 0; t < static_cast<int>(component.triangles.size()); ++t) {
    if (hasArea(component, component.triangles[t]))
      solid.push_back(t);
    else
      flat.push_back({t});
  }
  const bool too_many = solid.size() > kMostTriangles;
  if (!too_many) mesh.effort().spend(kHacdSteps * solid.size() * solid.size());
  std::vector<Cluster> clusters = too_many ? std::vector<Cluster>{solid} : propose(component, solid, tolerance);
  clusters.insert(clusters.end(), flat.begin(), flat.end());
  clusters = halved(std::move(clusters), component, mesh, tolerance);
  clusters = Fusion(component, mesh, tolerance).fused(std::move(clusters));

  Partition partition(component.triangles.size());
  for (std::size_t number = 0; number < clusters.size(); ++number)
    for (const int t : clusters[number]) partition[t] = static_cast<int>(number);
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
