#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <queue>

#include "proximity_server/scene/mesh.h"
#include "triangle_tree.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

// Mesh files hold floats or six-digit texts: a coordinate of one metre is rounded by up to 1e-6 m.
constexpr double kRounding = 1e-6;

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

/// The vertices of each connected component, in the order of the components' first triangles.
std::vector<std::vector<Vector3d>> connectedVertices(const TriangleMesh& mesh) {
  const std::vector<int> welded = weld(mesh.vertices);
  DisjointSets connected(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    connected.unite(welded[a], welded[b]);
    connected.unite(welded[b], welded[c]);
  }

  std::vector<std::vector<Vector3d>> result;
  std::map<int, std::size_t> component_of_set;
  std::vector<bool> taken(mesh.vertices.size(), false);
  for (const auto& triangle : mesh.triangles) {
    const auto [entry, is_new] = component_of_set.emplace(connected.find(welded[triangle[0]]), result.size());
    if (is_new) result.emplace_back();
    for (const int corner : triangle) {
      if (taken[welded[corner]]) continue;
      taken[welded[corner]] = true;
      result[entry->second].push_back(mesh.vertices[corner]);
    }
  }
  return result;
}

std::vector<Triangle> trianglesOf(const std::vector<Vector3d>& vertices,
                                  const std::vector<std::array<int, 3>>& triangles) {
  std::vector<Triangle> result;
  result.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) result.push_back({vertices[a], vertices[b], vertices[c]});
  return result;
}

/// A connected component of the mesh and its hull.
struct Component {
  explicit Component(std::vector<Vector3d> points) : vertices(std::move(points)), hull(vertices) {}
  std::vector<Vector3d> vertices;
  ConvexHull hull;
};

/// Whether all of `inner` lies in `outer`, within the rounding of the test.
bool contains(const ConvexHull& outer, const ConvexHull& inner) {
  if (outer.dimension() < 3) return false;
  double scale = 0.0;
  for (const Vector3d& vertex : outer.vertices()) scale = std::max(scale, vertex.norm());
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * scale;
  for (const auto& [a, b, c] : trianglesOf(outer.vertices(), outer.triangles())) {
    const Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for (const Vector3d& vertex : inner.vertices()) {
      if (normal.dot(vertex - a) > rounding) return false;
    }
  }
  return true;
}

/// The components that no other one's hull hides, largest first: the union of the hulls stays the same.
std::vector<Component> outermost(std::vector<Component> components) {
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.hull.volume() > b.hull.volume(); });
  std::vector<Component> kept;
  for (Component& component : components) {
    const bool hidden = std::any_of(kept.begin(), kept.end(),
                                    [&](const Component& other) { return contains(other.hull, component.hull); });
    if (!hidden) kept.push_back(std::move(component));
  }
  return kept;
}

/// The farthest that a hull's surface lies from the mesh over the hollows that have a vertex of the mesh in them,
/// however small: looks at the points of the hull's surface nearest to the vertices.
double deviationOverVertices(const Component& component, const TriangleTree& mesh) {
  const ConvexHull& hull = component.hull;
  if (hull.triangles().empty()) return 0.0;
  const TriangleTree surface(trianglesOf(hull.vertices(), hull.triangles()));
  double farthest = 0.0;
  for (const Vector3d& vertex : component.vertices) {
    const Vector3d above = surface.nearest(vertex);
    if ((above - vertex).norm() > farthest) farthest = std::max(farthest, mesh.distance(above));
  }
  return farthest;
}

/// The farthest that the hulls' surfaces lie from the mesh, or `at_least` where that is more.
///
/// Looks at the centroid of each triangle of the hulls, then at those of ever smaller parts, first where the distance
/// may still be largest: it grows by no more than one walks. Ends when nothing farther is left or after kSamples.
double deviationOverSurface(const std::vector<ConvexHull>& hulls, const TriangleTree& mesh, double at_least) {
  constexpr int kSamples = 4000;
  struct Patch {
    Triangle corners;
    double bound;  // no point of it lies farther from the mesh
    bool operator<(const Patch& other) const { return bound < other.bound; }
  };
  double farthest = at_least;
  std::priority_queue<Patch> patches;
  const auto look = [&](const Triangle& t) {
    const Vector3d centre = (t[0] + t[1] + t[2]) / 3.0;
    const double distance = mesh.distance(centre);
    farthest = std::max(farthest, distance);
    const auto reach = [&](int i) { return (t[i] - centre).norm(); };
    patches.push({t, distance + std::max({reach(0), reach(1), reach(2)})});
  };
  for (const ConvexHull& hull : hulls) {
    for (const Triangle& triangle : trianglesOf(hull.vertices(), hull.triangles())) look(triangle);
  }
  for (int samples = 0; samples < kSamples && !patches.empty(); samples += 2) {
    if (patches.top().bound <= farthest + kRounding) break;
    const Triangle t = patches.top().corners;
    patches.pop();
    const auto edge = [&](int i) { return (t[(i + 1) % 3] - t[i]).squaredNorm(); };
    const int longest = edge(0) >= edge(1) ? (edge(0) >= edge(2) ? 0 : 2) : (edge(1) >= edge(2) ? 1 : 2);
    const Vector3d &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
    const Vector3d middle = 0.5 * (a + b);
    look({a, middle, c});
    look({middle, b, c});
  }
  return farthest;
}

}  // namespace

MeshPieces convexPieces(const TriangleMesh& mesh) {
  MeshPieces pieces;
  if (mesh.triangles.empty()) return pieces;
  std::vector<Component> components;
  for (std::vector<Vector3d>& vertices : connectedVertices(mesh)) components.emplace_back(std::move(vertices));

  const TriangleTree surface(trianglesOf(mesh.vertices, mesh.triangles));
  double over_vertices = 0.0;
  for (Component& component : outermost(std::move(components))) {
    over_vertices = std::max(over_vertices, deviationOverVertices(component, surface));
    pieces.hulls.push_back(std::move(component.hull));
  }
  pieces.deviation = deviationOverSurface(pieces.hulls, surface, over_vertices);
  if (pieces.deviation > kRounding) {
    pieces.representation = pieces.hulls.size() == 1 ? Representation::ConvexHull : Representation::Decomposed;
  }
  return pieces;
}

}  // namespace proximity_server
