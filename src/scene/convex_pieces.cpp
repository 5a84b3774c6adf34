#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "decomposition.h"
#include "mesh_cache.h"
#include "mesh_deviation.h"
#include "mesh_parts.h"
#include "proximity_server/scene/mesh.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// A connected component of the mesh and its hull.
struct Component {
  explicit Component(TriangleMesh part) : mesh(std::move(part)), hull(mesh.vertices) {}
  TriangleMesh mesh;
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
std::vector<Component> outermost(std::vector<Component> components, Effort& effort) {
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.hull.volume() > b.hull.volume(); });
  std::vector<Component> kept;
  for (Component& component : components) {
    const bool hidden = std::any_of(kept.begin(), kept.end(), [&](const Component& other) {
      effort.spend(1 + other.hull.triangles().size() * component.hull.vertices().size());
      return contains(other.hull, component.hull);
    });
    if (!hidden) kept.push_back(std::move(component));
  }
  return kept;
}

std::vector<Component> componentsOf(const TriangleMesh& mesh) {
  std::vector<Component> components;
  for (TriangleMesh& part : connectedComponents(mesh)) components.emplace_back(std::move(part));
  return components;
}

std::vector<Triangle> closedTriangles(const std::vector<Component>& components) {
  std::vector<Triangle> closed;
  for (const Component& component : components) {
    if (!isClosed(component.mesh)) continue;
    for (const Triangle& triangle : trianglesOf(component.mesh.vertices, component.mesh.triangles)) {
      closed.push_back(triangle);
    }
  }
  return closed;
}

/// Hull over mesh, of the components together; NaN where one of them is open.
double volumeRatio(const std::vector<Component>& components) {
  double hulls = 0.0, meshes = 0.0;
  for (const Component& component : components) {
    if (!isClosed(component.mesh)) return std::numeric_limits<double>::quiet_NaN();
    hulls += component.hull.volume();
    meshes += std::abs(enclosedVolume(component.mesh));
  }
  return meshes > 0.0 ? hulls / meshes : std::numeric_limits<double>::quiet_NaN();
}

MeshPieces hullOfAll(const TriangleMesh& mesh, const MeshSolid& solid) {
  MeshPieces pieces;
  std::vector<Vector3d> corners;
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) corners.push_back(mesh.vertices[corner]);
  }
  pieces.hulls.emplace_back(corners);
  pieces.deviation = solid.deviationOf(pieces.hulls.front(), corners);
  pieces.representation = Representation::ConvexHull;
  return pieces;
}

MeshPieces hullsOfComponents(const std::vector<Component>& components, const MeshSolid& solid) {
  MeshPieces pieces;
  for (const Component& component : components) {
    pieces.deviation = std::max(pieces.deviation, solid.deviationOf(component.hull, component.mesh.vertices));
    pieces.hulls.push_back(component.hull);
  }
  pieces.representation = Representation::Decomposed;
  return pieces;
}

/// From the cache, or computed and stored there.
Partition partitionOf(const TriangleMesh& component, const MeshSolid& solid, const MeshOptions& options,
                      MeshPieces& pieces) {
  const MeshCache cache(options.cache);
  if (const auto known = cache.find(component, options.tolerance)) return *known;
  if (options.progress) {
    options.progress("decomposing a part of " + std::to_string(component.triangles.size()) + " triangles");
  }
  Partition partition = decompose(component, solid, options.tolerance);
  const std::string trouble = cache.store(component, options.tolerance, partition);
  if (!trouble.empty() && (pieces.warnings.empty() || pieces.warnings.back() != trouble)) {
    pieces.warnings.push_back(trouble);
  }
  return partition;
}

/// Each component within tolerance of its hull as that hull, the others as the hulls of clusters of their triangles.
MeshPieces decomposed(const std::vector<Component>& components, const MeshSolid& solid, const MeshOptions& options) {
  MeshPieces pieces;
  pieces.representation = Representation::Decomposed;
  const auto add = [&](ConvexHull hull, double deviation) {
    pieces.hulls.push_back(std::move(hull));
    pieces.deviation = std::max(pieces.deviation, deviation);
  };
  for (const Component& component : components) {
    const double deviation = solid.deviationOf(component.hull, component.mesh.vertices);
    if (deviation <= options.tolerance) {
      add(component.hull, deviation);
      continue;
    }
    const Partition partition = partitionOf(component.mesh, solid, options, pieces);
    for (const std::vector<Vector3d>& vertices : clusterVertices(component.mesh, partition)) {
      ConvexHull hull(vertices);
      // Measured anew, also where the partition is an old one.
      const double measured = solid.deviationOf(hull, vertices);
      add(std::move(hull), measured);
    }
  }
  return pieces;
}

MeshPieces trianglesThemselves(const TriangleMesh& mesh) {
  MeshPieces pieces;
  pieces.representation = Representation::Triangles;
  for (const Triangle& t : trianglesOf(mesh.vertices, mesh.triangles)) {
    pieces.hulls.emplace_back(std::vector<Vector3d>{t[0], t[1], t[2]});
  }
  return pieces;
}

/// The first representation that is near enough, fewest pieces first.
MeshPieces nearestEnough(const TriangleMesh& mesh, const std::vector<Component>& all, const MeshOptions& options,
                         Effort& effort) {
  const double tolerance = std::max(options.tolerance, kMeshRounding);
  const MeshSolid solid(trianglesOf(mesh.vertices, mesh.triangles), closedTriangles(all), effort);
  MeshPieces pieces = hullOfAll(mesh, solid);
  if (pieces.deviation <= tolerance) return pieces;
  pieces = hullsOfComponents(outermost(all, effort), solid);
  if (pieces.deviation <= tolerance) return pieces;
  // Not the outermost only: what lies in a hollow is hidden by a hull, not by its clusters.
  if (options.tolerance > kMeshRounding) pieces = decomposed(all, solid, options);
  if (pieces.deviation <= tolerance) return pieces;
  return trianglesThemselves(mesh);
}

/// With what they leave uncovered; the triangles where all of that would take too long.
MeshPieces measuredPieces(const TriangleMesh& mesh, const std::vector<Component>& components,
                          const MeshOptions& options) try {
  Effort effort;
  MeshPieces pieces = nearestEnough(mesh, components, options, effort);
  if (pieces.representation == Representation::Triangles) return pieces;
  pieces.uncovered = uncovered(trianglesOf(mesh.vertices, mesh.triangles), pieces.hulls, effort);
  if (pieces.deviation <= kMeshRounding) pieces.representation = Representation::Exact;
  return pieces;
} catch (const Effort::Exceeded&) {
  MeshPieces pieces = trianglesThemselves(mesh);
  pieces.warnings.push_back("a mesh of " + std::to_string(mesh.triangles.size()) +
                            " triangles would take too long to become fewer convex pieces; its triangles stand for it");
  return pieces;
}

}  // namespace

MeshPieces convexPieces(const TriangleMesh& mesh, const MeshOptions& options) {
  if (!(options.tolerance >= 0.0) || std::isinf(options.tolerance)) {
    throw std::invalid_argument("a mesh tolerance must be a finite length, at least 0");
  }
  if (mesh.triangles.empty()) return {};
  const std::vector<Component> components = componentsOf(mesh);
  MeshPieces pieces = measuredPieces(mesh, components, options);
  pieces.volume_ratio = volumeRatio(components);
  return pieces;
}

const char* toString(Representation representation) {
  switch (representation) {
    case Representation::Exact:
      return "exact";
    case Representation::ConvexHull:
      return "convex_hull";
    case Representation::Decomposed:
      return "decomposed";
    case Representation::Triangles:
      return "triangles";
  }
  return "unknown";
}

std::string userMeshCache() {
  const auto folder = [](const char* variable) {
    const char* value = std::getenv(variable);
    return std::string(value ? value : "");
  };
  // The XDG specification: a relative path is to be ignored.
  if (const std::string cache = folder("XDG_CACHE_HOME"); !cache.empty() && cache.front() == '/') {
    return cache + "/proximity_server";
  }
  const std::string home = folder("HOME");
  return home.empty() ? "" : home + "/.cache/proximity_server";
}

}  // namespace proximity_server
