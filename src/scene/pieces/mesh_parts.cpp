#include "scene/pieces/mesh_parts.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

/// For each vertex the index of the one vertex that represents all vertices at the same place.
std::vector<int> weld(const std::vector<Vector3d>& vertices) {
  const auto before = [&](int a, int b) { return isBefore(vertices[a], vertices[b]); };
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

/// Disjoint sets that can be united (union-find).
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

TriangleMesh welded(const TriangleMesh& mesh) {
  const std::vector<int> place = weld(mesh.vertices);
  TriangleMesh result = mesh;
  for (std::array<int, 3>& triangle : result.triangles) {
    for (int& corner : triangle) corner = place[corner];
  }
  return result;
}

std::vector<int> componentNumbers(const TriangleMesh& welded_mesh) {
  DisjointSets connected(welded_mesh.vertices.size());
  for (const auto& [a, b, c] : welded_mesh.triangles) {
    connected.unite(a, b);
    connected.unite(b, c);
  }
  std::vector<int> numbers, number_of_set(welded_mesh.vertices.size(), -1);
  int count = 0;
  for (const auto& triangle : welded_mesh.triangles) {
    int& number = number_of_set[connected.find(triangle[0])];
    if (number < 0) number = count++;
    numbers.push_back(number);
  }
  return numbers;
}

std::vector<std::vector<int>> byNumber(const std::vector<int>& numbers) {
  std::vector<std::vector<int>> triangles;
  for (std::size_t t = 0; t < numbers.size(); ++t) {
    const auto number = static_cast<std::size_t>(numbers[t]);
    if (number >= triangles.size()) triangles.resize(number + 1);
    triangles[number].push_back(static_cast<int>(t));
  }
  return triangles;
}

std::vector<TriangleMesh> partsOf(const TriangleMesh& mesh, const std::vector<int>& numbers) {
  const std::vector<std::vector<int>> triangles = byNumber(numbers);
  std::vector<TriangleMesh> parts(triangles.size());
  std::vector<int> index_in_part(mesh.vertices.size());
  for (std::size_t number = 0; number < parts.size(); ++number) {
    for (const int t : triangles[number]) {
      for (const int corner : mesh.triangles[t]) index_in_part[corner] = -1;
    }
    for (const int t : triangles[number]) {
      std::array<int, 3>& corners = parts[number].triangles.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const int corner = mesh.triangles[t][i];
        if (index_in_part[corner] < 0) {
          index_in_part[corner] = static_cast<int>(parts[number].vertices.size());
          parts[number].vertices.push_back(mesh.vertices[corner]);
        }
        corners[i] = index_in_part[corner];
      }
    }
  }
  return parts;
}

bool isClosed(const TriangleMesh& component) {
  struct Edge {
    int low, high, direction;  // 1 upwards, -1 downwards
    bool operator<(const Edge& other) const { return std::tie(low, high) < std::tie(other.low, other.high); }
  };
  std::vector<Edge> edges;
  edges.reserve(3 * component.triangles.size());
  for (const auto& t : component.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      edges.push_back({low, high, t[i] == low ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (auto edge = edges.begin(); edge != edges.end();) {
    const auto end = std::find_if(edge, edges.end(), [&](const Edge& other) { return *edge < other; });
    if (std::accumulate(edge, end, 0, [](int sum, const Edge& e) { return sum + e.direction; }) != 0) return false;
    edge = end;
  }
  return !edges.empty();
}

double enclosedVolume(const TriangleMesh& component) {
  // The volume is computed about a vertex of the component, so that a mesh far from the origin loses no digits.
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

}  // namespace proximity_server::scene
