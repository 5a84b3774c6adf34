#include "mesh_parts.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// For each vertex the representative of all vertices at the same place.
std::vector<int> weld(const std::vector<Vector3d>& vertices) {
  const auto before = [&](int a, int b) {
    const Vector3d &p = vertices[a], &q = vertices[b];
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  std::vector<int> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), before);

  std::vector<int> representative(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same_place = i > 0 && !before(order[i - 1], order[i]);
    representative[order[i]] = same_place ? representative[order[i - 1]] : order[i];
  }
  return representative;
}

/// Sets that grow together.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) { parent_[find(i)] = find(j); }

 private:
  std::vector<int> parent_;
};

}  // namespace

std::vector<TriangleMesh> connectedComponents(const TriangleMesh& mesh) {
  const std::vector<int> welded = weld(mesh.vertices);
  DisjointSets connected(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    connected.unite(welded[a], welded[b]);
    connected.unite(welded[b], welded[c]);
  }

  std::vector<TriangleMesh> result;
  std::map<int, std::size_t> component_of_set;
  std::vector<int> index_in_component(mesh.vertices.size(), -1);
  for (const auto& triangle : mesh.triangles) {
    const auto [entry, is_new] = component_of_set.emplace(connected.find(welded[triangle[0]]), result.size());
    if (is_new) result.emplace_back();
    TriangleMesh& component = result[entry->second];
    std::array<int, 3>& corners = component.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      int& index = index_in_component[welded[triangle[i]]];
      if (index < 0) {
        index = static_cast<int>(component.vertices.size());
        component.vertices.push_back(mesh.vertices[triangle[i]]);
      }
      corners[i] = index;
    }
  }
  return result;
}

bool isClosed(const TriangleMesh& component) {
  std::map<std::pair<int, int>, int> balance;  // of each edge: how often upwards less how often downwards
  for (const auto& t : component.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      balance[{low, high}] += t[i] == low ? 1 : -1;
    }
  }
  return !balance.empty() && std::all_of(balance.begin(), balance.end(), [](const auto& e) { return e.second == 0; });
}

double enclosedVolume(const TriangleMesh& component) {
  // About a corner of its own, so that a mesh far from the origin loses nothing.
  const Vector3d origin = component.vertices.front();
  double six_volumes = 0.0;
  for (const auto& [a, b, c] : trianglesOf(component.vertices, component.triangles)) {
    six_volumes += (a - origin).dot((b - origin).cross(c - origin));
  }
  return six_volumes / 6.0;
}

std::vector<Triangle> trianglesOf(const std::vector<Vector3d>& vertices,
                                  const std::vector<std::array<int, 3>>& triangles) {
  std::vector<Triangle> result;
  result.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) result.push_back({vertices[a], vertices[b], vertices[c]});
  return result;
}

}  // namespace proximity_server
