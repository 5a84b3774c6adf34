#include "proximity_server/scene/pieces/convex_pieces.h"

#include "scene/mesh/mesh_file.h"
#include "scene/mesh/stop_flag.h"
#include "scene/pieces/decomposition.h"
#include "scene/pieces/interior.h"
#include "scene/pieces/mesh_cache.h"
#include "scene/pieces/mesh_deviation.h"
#include "scene/pieces/mesh_parts.h"
#include "system/numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

/// A connected component of the mesh.
struct Component {
  int number;
  Cover cover;  // its hull
};

/// True if all of `inner` lies in `outer`, within the rounding of the test.
bool contains(const narrowphase::ConvexHull& outer, const narrowphase::ConvexHull& inner) {
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

/// A mesh and its connected components.
struct ConnectedMesh {
  explicit ConnectedMesh(const TriangleMesh& mesh)
      : welded(scene::welded(mesh)), components(componentNumbers(welded)), parts(partsOf(welded, components)) {}
  TriangleMesh welded;
  Partition components;             // for each triangle its component
  std::vector<TriangleMesh> parts;  // index: the number of the component
};

/// A mesh while it is divided into pieces.
struct Job {
  const ConnectedMesh& mesh;
  const MeshOptions& options;
  Effort& effort;
  double tolerance;  // [m]
};

/// A mesh that half of the budget does not bring to so many pieces gets a coarser tolerance, up to so many times its own.
constexpr int kFewPieces = 300;
constexpr double kCoarsest = 8.0;

std::vector<Component> componentsOf(const Job& job) {
  std::vector<Component> components;
  for (const TriangleMesh& part : job.mesh.parts)
    components.push_back({static_cast<int>(components.size()), coverOf(part.vertices, job.effort)});
  return components;
}

std::vector<TriangleMesh> closedParts(const std::vector<TriangleMesh>& components) {
  std::vector<TriangleMesh> closed;
  std::copy_if(components.begin(), components.end(), std::back_inserter(closed), isClosed);
  return closed;
}

std::vector<Triangle> allTriangles(const std::vector<TriangleMesh>& parts) {
  std::vector<Triangle> all;
  for (const TriangleMesh& part : parts)
    for (const Triangle& triangle : trianglesOf(part.vertices, part.triangles)) all.push_back(triangle);
  return all;
}

/// The volume of the hulls of all components divided by the volume that they enclose. NaN if one of them is open.
double volumeRatio(const std::vector<TriangleMesh>& components) {
  double hulls = 0.0, meshes = 0.0;
  if (!std::all_of(components.begin(), components.end(), isClosed)) return std::numeric_limits<double>::quiet_NaN();
  for (const TriangleMesh& component : components) {
    hulls += narrowphase::ConvexHull(component.vertices).volume();
    meshes += std::abs(enclosedVolume(component));
  }
  return meshes > 0.0 ? hulls / meshes : std::numeric_limits<double>::quiet_NaN();
}

/// Hulls after the search for their points that lie farthest outside of the mesh.
struct Measured {
  double deviation;                  // [m] an upper bound for the hulls that are not too far
  std::vector<std::size_t> too_far;  // the indices of the hulls that are not proven to lie within tolerance
  std::vector<Vector3d> rooms;       // points of the rooms that these fill
};

/// Measures hulls. A room that is not excluded when the effort is spent counts as filled, which is the safe side: it makes
/// the deviation larger, and the hull stays. Surfaces have no limit, because most of them are known to be within tolerance.
Measured measure(const Job& job, const MeshSolid& solid, const std::vector<Cover>& covers) {
  const Effort for_rooms = std::exchange(job.effort, Effort(kInfinity, job.options.stop));
  Measured result{covers.empty() ? 0.0 : solid.deviationOf(covers), {}, {}};
  std::vector<std::size_t> within(covers.size());
  std::iota(within.begin(), within.end(), 0);
  if (result.deviation > job.tolerance) {
    const auto far = std::stable_partition(
        within.begin(), within.end(), [&](std::size_t i) { return solid.isSurfaceWithin(job.tolerance, covers[i]); });
    result.too_far.assign(far, within.end());
    within.erase(far, within.end());
    result.deviation = job.tolerance;
  }
  job.effort = for_rooms;
  for (const std::size_t i : within) {
    const double known = std::min(result.deviation, job.tolerance);
    const Rooms::Largest room = solid.roomIn(covers[i].hull, known, job.tolerance);
    if (!(room.at_most > result.deviation + kMeshRounding)) continue;
    if (room.at_most > job.tolerance && !job.effort.isSpent()) {
      result.too_far.push_back(i);
      result.rooms.push_back(room.centre);
    } else {
      result.deviation = room.at_most;
    }
  }
  return result;
}

/// Returns clusters of whole components if their hulls are within tolerance.
std::optional<Clustering> ifWithin(const Job& job, const MeshSolid& solid, Partition partition,
                                   Representation representation) {
  std::vector<Cover> covers;
  for (std::vector<Vector3d>& points : clusterPoints(job.mesh.welded, partition)) {
    covers.push_back(coverOf(std::move(points), job.effort));
    if (!solid.isSurfaceWithin(job.tolerance, covers.back())) return std::nullopt;
  }
  const Measured found = measure(job, solid, covers);
  if (job.effort.isSpent()) throw Effort::Exceeded();
  if (!found.too_far.empty()) return std::nullopt;
  Clustering clustering;
  clustering.partition = std::move(partition);
  clustering.representation = representation;
  clustering.deviation = found.deviation;
  return clustering;
}

/// Assigns each component to a cluster of its own, or to the cluster of another component whose hull contains its hull:
/// the union of the hulls stays the same.
Partition hullsOfComponents(const Job& job) {
  std::vector<Component> components = componentsOf(job);
  std::stable_sort(components.begin(), components.end(), [](const Component& a, const Component& b) {
    return a.cover.hull.volume() > b.cover.hull.volume();
  });
  std::vector<const Component*> outermost;
  std::vector<int> hider(components.size());
  for (const Component& component : components) {
    const auto hides = [&](const Component* other) {
      const narrowphase::ConvexHull &outer = other->cover.hull, &inner = component.cover.hull;
      job.effort.spend(1 + outer.triangles().size() * inner.vertices().size());
      return contains(outer, inner);
    };
    const auto found = std::find_if(outermost.begin(), outermost.end(), hides);
    const bool is_hidden = found != outermost.end();
    hider[component.number] = is_hidden ? (*found)->number : component.number;
    if (!is_hidden) outermost.push_back(&component);
  }
  Partition partition;
  for (const int component : job.mesh.components) partition.push_back(hider[component]);
  return partition;
}

Clustering trianglesThemselves(std::size_t count) {
  Clustering clustering;
  clustering.partition.resize(count);
  std::iota(clustering.partition.begin(), clustering.partition.end(), 0);
  clustering.representation = Representation::Triangles;
  return clustering;
}

bool isOneByOne(const Partition& partition) {
  return *std::max_element(partition.begin(), partition.end()) == static_cast<int>(partition.size()) - 1;
}

std::vector<narrowphase::ConvexHull> hullsOf(const TriangleMesh& mesh, const Partition& partition) {
  const std::vector<std::vector<Vector3d>> clusters = clusterPoints(mesh, partition);
  std::vector<narrowphase::ConvexHull> hulls;
  hulls.reserve(clusters.size());
  for (const std::vector<Vector3d>& points : clusters) hulls.emplace_back(points);
  return hulls;
}

/// For each triangle the number of its hull, see hullsOf().
Partition hullNumbers(const Partition& partition) {
  // index: the number of the cluster
  std::vector<int> numbers(static_cast<std::size_t>(*std::max_element(partition.begin(), partition.end())) + 1, 0);
  for (const int cluster : partition) numbers[cluster] = 1;
  std::exclusive_scan(numbers.begin(), numbers.end(), numbers.begin(), 0);
  Partition result;
  for (const int cluster : partition) result.push_back(numbers[cluster]);
  return result;
}

/// Measures the hulls of clusters, and divides anew those that are too far until none is. This has the time budget once
/// more; when it is spent, the rooms that are left count as filled.
void settle(const Job& job, const MeshSolid& solid, Clustering& clustering) {
  const TriangleMesh& mesh = job.mesh.welded;
  std::vector<Vector3d> rooms;
  job.effort = Effort(job.options.time_budget, job.options.stop);
  for (std::size_t first = 0;;) {  // the first cluster that is not measured
    const std::vector<std::vector<int>> clusters = byNumber(clustering.partition);
    std::vector<std::size_t> numbers;  // of the clusters of covers
    std::vector<Cover> covers;
    for (std::size_t i = first; i < clusters.size(); ++i) {
      if (clusters[i].size() < 2) continue;
      std::vector<Vector3d> points = pointsOf(mesh, clusters[i]);
      numbers.push_back(i);
      covers.push_back({narrowphase::ConvexHull(points), std::move(points)});
    }
    const Measured found = measure(job, solid, covers);
    clustering.deviation = std::max(clustering.deviation, found.deviation);
    clustering.is_complete &= !job.effort.isSpent();
    if (found.too_far.empty()) break;

    rooms.insert(rooms.end(), found.rooms.begin(), found.rooms.end());
    TriangleMesh filling{mesh.vertices, {}};
    Partition parts;
    std::vector<int> origins;
    for (const std::size_t i : found.too_far) {
      for (const int t : clusters[numbers[i]]) {
        filling.triangles.push_back(mesh.triangles[t]);
        parts.push_back(static_cast<int>(i));
        origins.push_back(t);
      }
    }
    first = clusters.size();
    const Decomposition anew = decompose(filling, parts, solid, job.tolerance, PartsOfHulls::AreTested, rooms);
    for (std::size_t i = 0; i < origins.size(); ++i)
      clustering.partition[origins[i]] = static_cast<int>(first) + anew.partition[i];
    clustering.is_complete &= anew.is_complete;
  }
  clustering.partition = hullNumbers(clustering.partition);
}

/// Decomposes a mesh within its tolerance. While half of the budget leaves too many pieces, the tolerance is doubled, with as
/// much effort.
Clustering decomposed(Job job, const MeshSolid& solid) {
  const double coarsest = kCoarsest * job.tolerance;
  Clustering clustering;
  while (true) {
    job.effort = Effort(0.5 * job.options.time_budget, job.options.stop);
    // All components take part, not only the outermost ones: the hull of a component can contain another component that
    // lies in a hollow of it, but the hulls of its clusters need not contain that one.
    Decomposition found = decompose(job.mesh.welded, job.mesh.components, solid, job.tolerance);
    const int pieces = *std::max_element(found.partition.begin(), found.partition.end()) + 1;
    clustering.partition = std::move(found.partition);
    clustering.is_complete &= found.is_complete;
    if (found.is_complete || pieces <= kFewPieces || job.tolerance >= coarsest) break;
    job.tolerance *= 2.0;
  }
  clustering.tolerance = job.tolerance;
  settle(job, solid, clustering);
  clustering.representation = isOneByOne(clustering.partition) ? Representation::Triangles : Representation::Decomposed;
  return clustering;
}

/// Returns the clusters of the first representation that is within tolerance. Representations with fewer pieces are
/// tried first.
Clustering nearestEnough(const Job& job, const MeshSolid& solid) {
  const std::size_t triangles = job.mesh.components.size();
  job.effort = Effort(0.5 * job.options.time_budget, job.options.stop);
  bool is_complete = true;
  try {
    if (auto hull = ifWithin(job, solid, Partition(triangles, 0), Representation::ConvexHull)) return *hull;
    if (auto hulls = ifWithin(job, solid, hullsOfComponents(job), Representation::Decomposed)) return *hulls;
  } catch (const Effort::Exceeded&) {
    is_complete = false;
  }
  const bool needs_triangles = job.options.tolerance <= kMeshRounding;
  if (!needs_triangles && job.options.progress)
    job.options.progress("decomposing " + std::to_string(triangles) + " triangles");
  Clustering clustering = needs_triangles ? trianglesThemselves(triangles) : decomposed(job, solid);
  clustering.is_complete &= is_complete;
  return clustering;
}

/// [m] The largest distance of a point of the mesh outside of the hull that covers it.
double uncoveredBy(const TriangleMesh& mesh, const Partition& partition, const std::atomic<bool>* stop) {
  Effort unlimited(kInfinity, stop);
  double farthest = 0.0;
  for (std::vector<Vector3d>& points : clusterPoints(mesh, partition))
    farthest = std::max(farthest, farthestOutside(coverOf(std::move(points), unlimited), unlimited));
  return farthest;
}

Clustering compute(const TriangleMesh& mesh, const ConnectedMesh& connected, const MeshOptions& options,
                   const MeshCache& cache, std::vector<std::string>& warnings) {
  Effort effort(options.time_budget, options.stop);
  const std::vector<TriangleMesh> closed = closedParts(connected.parts);
  requireNoStop(options.stop);
  const Job job{connected, options, effort, std::max(options.tolerance, kMeshRounding)};
  const MeshSolid solid(trianglesOf(mesh.vertices, mesh.triangles), allTriangles(closed), effort,
                        Rooms(connected.parts, options.stop));
  Clustering clustering = nearestEnough(job, solid);
  clustering.tolerance = std::max(clustering.tolerance, options.tolerance);
  clustering.volume_ratio = volumeRatio(connected.parts);
  if (clustering.representation != Representation::Triangles) {
    clustering.uncovered = uncoveredBy(mesh, clustering.partition, options.stop);
    if (clustering.deviation <= kMeshRounding) clustering.representation = Representation::Exact;
  }
  const std::string trouble = cache.store(clustering);
  if (!trouble.empty()) warnings.push_back(trouble);
  return clustering;
}

std::string shortfallOf(const TriangleMesh& mesh, const MeshOptions& options, const MeshPieces& pieces) {
  std::ostringstream text;
  text << "its " << mesh.triangles.size() << " triangles would take more than the time budget of "
       << options.time_budget << " s to become as few convex pieces as possible; " << pieces.hulls.size()
       << " stand for it, within ";
  if (pieces.deviation <= options.tolerance)
    text << "the tolerance";
  else
    text << pieces.deviation << " m instead of the tolerance of " << options.tolerance << " m";
  return text.str();
}

/// True if a component is closed and encloses more than the rounding of its file.
bool isSolid(const TriangleMesh& component) {
  if (!isClosed(component)) return false;
  double area = 0.0;
  for (const auto& [a, b, c] : trianglesOf(component.vertices, component.triangles))
    area += 0.5 * (b - a).cross(c - a).norm();
  return std::abs(enclosedVolume(component)) > kMeshRounding * area;
}

/// How the text about open components ends: the first if a single hull stands for each of them, else the second, with
/// the third if a closed component is the wall of a room. Without a closed wall around it, nothing tells that room from
/// a solid that is inside out.
constexpr char kIsSolidAsHull[] = "; a convex hull stands for each such part, and is solid";
constexpr char kHoldsNothing[] = "; what lies inside and touches none of its convex pieces counts as apart";
constexpr char kFillsRooms[] = ", but a room is solid if the wall around it is not closed";
std::string opennessOf(std::size_t open, std::size_t parts) {
  if (open < parts) return std::to_string(open) + " of its " + std::to_string(parts) + " parts are not closed";
  if (parts == 1) return "it is not a closed surface";
  return "it is not closed in any of its " + std::to_string(parts) + " parts";
}

/// Adds to the pieces what describes the solid: the representatives, the interior and the text about open components.
void addSolid(const ConnectedMesh& mesh, const Partition& partition, MeshPieces& pieces) {
  const Partition hulls = hullNumbers(partition);
  std::vector<int> first_hull(mesh.parts.size(), -1);
  std::vector<bool> is_split(mesh.parts.size(), false);
  for (std::size_t t = 0; t < hulls.size(); ++t) {
    int& first = first_hull[mesh.components[t]];
    if (first < 0) first = hulls[t];
    if (first != hulls[t]) is_split[mesh.components[t]] = true;
  }
  pieces.is_representative.assign(pieces.hulls.size(), false);
  std::vector<TriangleMesh> solids;
  bool leaves_space = false, open_in_single_hulls = true, has_room = false;
  for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
    const TriangleMesh& part = mesh.parts[i];
    pieces.is_representative[first_hull[i]] = true;
    if (isSolid(part)) {
      leaves_space |= is_split[i];
      has_room |= enclosedVolume(part) < 0.0;
      solids.push_back(part);
    } else {
      open_in_single_hulls &= !is_split[i];
    }
  }
  if (leaves_space) pieces.interior = std::make_shared<const Interior>(allTriangles(solids));
  const std::size_t open = mesh.parts.size() - solids.size();
  if (open > 0)
    pieces.openness = opennessOf(open, mesh.parts.size()) + (open_in_single_hulls ? kIsSolidAsHull : kHoldsNothing) +
                      (has_room && !open_in_single_hulls ? kFillsRooms : "");
}

}  // namespace

MeshPieces convexPieces(const TriangleMesh& mesh, const MeshOptions& options) {
  if (!(options.tolerance >= 0.0) || std::isinf(options.tolerance)) {
    throw std::invalid_argument("a mesh tolerance must be a finite length, at least 0");
  }
  if (!(options.time_budget > 0.0)) throw std::invalid_argument("a mesh's time budget must be above 0");
  requireNoStop(options.stop);
  if (mesh.triangles.empty()) return {};
  checkMesh(mesh);
  const MeshCache cache(options.cache, mesh, options.tolerance, options.time_budget);
  MeshPieces pieces;
  std::optional<Clustering> clustering = cache.find();
  const ConnectedMesh connected(mesh);
  requireNoStop(options.stop);
  if (!clustering) clustering = compute(mesh, connected, options, cache, pieces.warnings);
  pieces.hulls = hullsOf(mesh, clustering->partition);
  addSolid(connected, clustering->partition, pieces);
  pieces.representation = clustering->representation;
  pieces.tolerance = clustering->tolerance;
  pieces.deviation = clustering->deviation;
  pieces.uncovered = clustering->uncovered;
  pieces.volume_ratio = clustering->volume_ratio;
  if (!clustering->is_complete) pieces.shortfall = shortfallOf(mesh, options, pieces);
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
  // The XDG specification says that a relative path is to be ignored.
  if (const std::string cache = folder("XDG_CACHE_HOME"); !cache.empty() && cache.front() == '/') {
    return cache + "/proximity_server";
  }
  const std::string home = folder("HOME");
  return home.empty() ? "" : home + "/.cache/proximity_server";
}

}  // namespace proximity_server::scene
