#include "scene/pieces/decomposition.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;
using Cluster = std::vector<int>;  // the indices of its triangles

/// Splits a cluster in the middle of the longest side of its box. Returns the upper half.
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

std::vector<Vector3d> sorted(std::vector<Vector3d> points) {
  std::sort(points.begin(), points.end(), isBefore);
  return points;
}

bool isOneOf(const std::vector<Vector3d>& sorted_points, const Vector3d& point) {
  return std::binary_search(sorted_points.begin(), sorted_points.end(), point, isBefore);
}

/// The conditions that the hull of every cluster must meet.
struct Demand {
  const MeshSolid& solid;
  double tolerance;  // [m]
  const std::vector<Vector3d>& rooms;
  PartsOfHulls parts_of_hulls;

  /// `surface`: the triangles of the hull that are not yet known to be within tolerance.
  bool isMetBy(const Cover& cover, const std::vector<Triangle>& surface) const {
    solid.effort().spend(rooms.size() * cover.hull.triangles().size());
    const auto isFilled = [&](const Vector3d& p) { return cover.hull.dimension() == 3 && isInHull(cover.hull, p); };
    return std::none_of(rooms.begin(), rooms.end(), isFilled) && solid.isSurfaceWithin(tolerance, cover, surface);
  }
};

/// Returns the sorted vertices of the hull of all points, or no vertices if the hull is not within tolerance.
std::vector<Vector3d> hullWithin(const Demand& demand, const std::vector<Vector3d>& points) {
  const Cover cover = coverOf(points, demand.solid.effort());
  if (!demand.isMetBy(cover, surfaceOf(cover.hull))) return {};
  return sorted(cover.hull.vertices());
}

/// Returns the sorted vertices of the common hull of two hulls that lie within tolerance, or no vertices if the common
/// hull is not within tolerance. A triangle of the common hull whose corners all belong to one of the two lies in that
/// one, and so within tolerance.
std::vector<Vector3d> commonHullWithin(const Demand& demand, const std::vector<Vector3d>& a,
                                       const std::vector<Vector3d>& b) {
  std::vector<Vector3d> points = a;
  points.insert(points.end(), b.begin(), b.end());
  const Cover cover = coverOf(std::move(points), demand.solid.effort());
  const std::vector<Triangle> surface = surfaceOf(cover.hull);
  std::vector<Triangle> bridges;
  std::copy_if(surface.begin(), surface.end(), std::back_inserter(bridges), [&](const Triangle& triangle) {
    const auto isOf = [&](const std::vector<Vector3d>& corners) {
      return std::all_of(triangle.begin(), triangle.end(), [&](const Vector3d& p) { return isOneOf(corners, p); });
    };
    return !isOf(a) && !isOf(b);
  });
  if (!demand.isMetBy(cover, bridges)) return {};
  return sorted(cover.hull.vertices());
}

const Vector3d& farthestAlong(const Vector3d& direction, const std::vector<Vector3d>& points) {
  const auto isBelow = [&](const Vector3d& p, const Vector3d& q) { return direction.dot(p) < direction.dot(q); };
  return *std::max_element(points.begin(), points.end(), isBelow);
}

/// Returns some of the sorted vertices of a hull. None of the others lies farther than `slack` [m] above a face of the hull
/// of these.
std::vector<Vector3d> outermost(const narrowphase::ConvexHull& whole, double slack, Effort& effort) {
  constexpr int kFew = 20;  // with so few, nothing is gained
  const std::vector<Vector3d>& all = whole.vertices();
  if (whole.dimension() < 3 || whole.size() <= kFew) return sorted(all);
  std::vector<Vector3d> kept;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) kept.push_back(farthestAlong(side * Vector3d::Unit(axis), all));
  for (std::size_t known = 0; known != kept.size();) {
    known = kept.size();
    const Cover cover = coverOf(kept, effort);
    if (cover.hull.dimension() < 3) return sorted(all);
    effort.spend(cover.hull.triangles().size() * all.size());
    for (const auto& [a, b, c] : surfaceOf(cover.hull)) {
      const Vector3d normal = (b - a).cross(c - a).stableNormalized();
      const Vector3d& farthest = farthestAlong(normal, all);
      if (normal.dot(farthest - a) > slack) kept.push_back(farthest);
    }
    kept = sorted(std::move(kept));
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  }
  return kept;
}

struct ClusterWithHull {
  Cluster triangles;
  std::vector<Vector3d> corners;  // sorted vertices of its hull, all or the outermost
};

/// Cuts clusters into parts that are within tolerance.
class Halving {
 public:
  Halving(const TriangleMesh& mesh, const Demand& demand) : mesh_(mesh), demand_(demand) {}

  /// Returns the whole component if its hull is within tolerance. Otherwise returns its parts, each cut twice more than
  /// necessary, so that its triangles can join neighbouring parts.
  std::vector<ClusterWithHull> partsOf(Cluster component) {
    std::vector<ClusterWithHull> parts = halved({std::move(component)});
    if (parts.size() <= 1) return parts;
    if (demand_.parts_of_hulls == PartsOfHulls::AreTrusted) return quartered(std::move(parts));
    for (int level = 0; level < 2; ++level) parts = cutOnce(std::move(parts));
    return parts;
  }

  /// True if the effort was enough for all calls so far.
  bool isComplete() const { return is_complete_; }

 private:
  /// Halves clusters until the hull of each is within tolerance; a single triangle always is.
  std::vector<ClusterWithHull> halved(std::vector<Cluster> pending) {
    std::vector<ClusterWithHull> parts;
    while (!pending.empty()) {
      Cluster cluster = std::move(pending.back());
      pending.pop_back();
      std::vector<Vector3d> corners = cornersOf(cluster);
      if (corners.empty()) {
        pending.push_back(takeHalf(mesh_, cluster));
        pending.push_back(std::move(cluster));
      } else {
        parts.push_back({std::move(cluster), std::move(corners)});
      }
    }
    return parts;
  }

  std::vector<ClusterWithHull> cutOnce(std::vector<ClusterWithHull> parts) {
    std::vector<ClusterWithHull> result;
    for (ClusterWithHull& part : parts) {
      std::vector<ClusterWithHull> halves;
      if (part.triangles.size() > 1 && is_complete_) {
        Cluster lower = part.triangles, upper = takeHalf(mesh_, lower);
        halves = halved({std::move(upper), std::move(lower)});
      }
      if (halves.empty() || !is_complete_) {
        result.push_back(std::move(part));
      } else {
        std::move(halves.begin(), halves.end(), std::back_inserter(result));
      }
    }
    return result;
  }

  /// Cuts parts twice. The hulls of what is cut are trusted, and the merging uses only their outermost vertices. The others
  /// rise above a face by less than the 2 % that isSurfaceWithin() keeps from the tolerance. At a sharp edge they may be
  /// farther away; the deviation of the result is measured with all triangles.
  std::vector<ClusterWithHull> quartered(std::vector<ClusterWithHull> parts) {
    std::vector<ClusterWithHull> result;
    for (ClusterWithHull& part : parts) {
      std::vector<Cluster> cut{part.triangles};
      for (int level = 0; level < 2; ++level) {
        for (std::size_t i = 0, count = cut.size(); i < count; ++i)
          if (cut[i].size() > 1) cut.push_back(takeHalf(mesh_, cut[i]));
      }
      std::vector<ClusterWithHull> cut_parts = withHulls(std::move(cut));
      if (cut_parts.empty()) cut_parts.push_back(std::move(part));
      std::move(cut_parts.begin(), cut_parts.end(), std::back_inserter(result));
    }
    return result;
  }

  /// Returns nothing if the effort is spent.
  std::vector<ClusterWithHull> withHulls(std::vector<Cluster> clusters) try {
    std::vector<ClusterWithHull> parts;
    if (!is_complete_) return parts;
    for (Cluster& cluster : clusters) {
      const Cover cover = coverOf(pointsOf(mesh_, cluster), demand_.solid.effort());
      parts.push_back({std::move(cluster), outermost(cover.hull, kSlack * demand_.tolerance, demand_.solid.effort())});
    }
    return parts;
  } catch (const Effort::Exceeded&) {
    is_complete_ = false;
    return {};
  }

  /// Returns no corners if the hull is not within tolerance, or if the effort is spent.
  std::vector<Vector3d> cornersOf(const Cluster& cluster) try {
    if (cluster.size() == 1) return sorted(narrowphase::ConvexHull(pointsOf(mesh_, cluster)).vertices());
    if (!is_complete_) return {};
    return hullWithin(demand_, pointsOf(mesh_, cluster));
  } catch (const Effort::Exceeded&) {
    is_complete_ = false;
    return {};
  }

  static constexpr double kSlack = 0.01;  // of the tolerance
  const TriangleMesh& mesh_;
  const Demand demand_;
  bool is_complete_ = true;
};

/// Merges clusters, two at a time.
class Fusion {
 public:
  Fusion(const TriangleMesh& mesh, const Demand& demand)
      : mesh_(mesh), solid_(demand.solid), tolerance_(demand.tolerance), demand_(demand) {}

  void add(ClusterWithHull part) {
    Node node;
    node.corners = std::move(part.corners);
    for (const Vector3d& corner : node.corners) node.box.extend(corner);
    nodes_.push_back(std::move(node));
    triangles_.push_back(std::move(part.triangles));
  }

  /// Makes neighbours of nodes that share a vertex of the mesh. If very many share a vertex, only nodes that share an
  /// edge become neighbours.
  void joinAtVertices() {
    constexpr std::size_t kMany = 16;
    std::vector<std::vector<int>> at_vertex(mesh_.vertices.size());
    for (int i = 0; i < static_cast<int>(triangles_.size()); ++i) {
      for (const int t : triangles_[i]) {
        for (const int v : mesh_.triangles[t]) {
          if (at_vertex[v].empty() || at_vertex[v].back() != i) at_vertex[v].push_back(i);
        }
      }
    }
    std::vector<NodePair> pairs = pairsAtEdges();
    for (const std::vector<int>& around : at_vertex) {
      if (around.size() > kMany) continue;
      for (std::size_t i = 1; i < around.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) pairs.emplace_back(around[j], around[i]);
    }
    join(std::move(pairs));
  }

  /// Makes neighbours of nodes whose boxes are no farther apart than twice the tolerance.
  void joinNearBoxes() {
    const double farthest = 2.0 * tolerance_;
    std::vector<int> alive;
    for (int i = 0; i < static_cast<int>(nodes_.size()); ++i)
      if (nodes_[i].whole < 0) alive.push_back(i);
    std::stable_sort(alive.begin(), alive.end(),
                     [&](int a, int b) { return nodes_[a].box.min().x() < nodes_[b].box.min().x(); });
    std::vector<NodePair> pairs;
    for (std::size_t i = 0; i < alive.size() && pairs.size() < kMaxPairs; ++i) {
      const Eigen::AlignedBox3d& box = nodes_[alive[i]].box;
      for (std::size_t j = i + 1; j < alive.size(); ++j) {
        const Eigen::AlignedBox3d& other = nodes_[alive[j]].box;
        solid_.effort().spend(2);
        if (other.min().x() > box.max().x() + farthest) break;
        if (box.squaredExteriorDistance(other) > farthest * farthest) continue;
        solid_.effort().spend(100);
        pairs.emplace_back(std::minmax(alive[i], alive[j]));
      }
    }
    join(std::move(pairs));
  }

  /// Merges neighbours until no two of them can be merged.
  void fuse() {
    while (!pairs_.empty()) {
      const Pair pair = pairs_.top();
      pairs_.pop();
      solid_.effort().spend(20);
      if (nodes_[pair.a].whole >= 0 || nodes_[pair.b].whole >= 0) continue;
      std::vector<Vector3d> corners = commonHullWithin(demand_, nodes_[pair.a].corners, nodes_[pair.b].corners);
      if (corners.empty()) {
        nodes_[pair.a].neighbours.push_back({pair.b, Relation::Apart});
        nodes_[pair.b].neighbours.push_back({pair.a, Relation::Apart});
      } else {
        unite(pair.a, pair.b, std::move(corners));
      }
    }
  }

  Partition partition() const {
    Partition result(mesh_.triangles.size(), -1);
    std::vector<int> number(nodes_.size(), -1);
    int count = 0;
    for (int i = 0; i < static_cast<int>(triangles_.size()); ++i) {
      const int whole = wholeOf(i);
      if (number[whole] < 0) number[whole] = count++;
      for (const int t : triangles_[i]) result[t] = number[whole];
    }
    return result;
  }

 private:
  using NodePair = std::pair<int, int>;              // the smaller number first
  static constexpr std::size_t kMaxPairs = 2000000;  // this many need 100 MB
  enum class Relation : unsigned char { Untried, Apart };
  struct Neighbour {
    int node;  // a node, or one that has become a part of it
    Relation relation;
    bool operator<(const Neighbour& other) const {
      return std::tie(node, relation) < std::tie(other.node, other.relation);
    }
  };
  struct Node {
    std::vector<Vector3d> corners;  // sorted
    Eigen::AlignedBox3d box;
    std::vector<Neighbour> neighbours;  // may hold the same node several times
    int whole = -1;                     // the node that it has become a part of; -1: none
  };
  struct Pair {
    double growth;  // [m^2]
    int a, b;
    bool operator<(const Pair& other) const {  // the smallest is on top
      return std::tie(growth, a, b) > std::tie(other.growth, other.a, other.b);
    }
  };

  std::vector<NodePair> pairsAtEdges() const {
    std::vector<std::tuple<int, int, int>> edges;
    for (int i = 0; i < static_cast<int>(triangles_.size()); ++i) {
      for (const int t : triangles_[i]) {
        const auto& corners = mesh_.triangles[t];
        for (std::size_t k = 0; k < 3; ++k) {
          const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 3]);
          edges.emplace_back(low, high, i);
        }
      }
    }
    std::sort(edges.begin(), edges.end());
    std::vector<NodePair> pairs;
    for (std::size_t i = 1; i < edges.size(); ++i) {
      const auto& [low, high, one] = edges[i - 1];
      const auto& [next_low, next_high, other] = edges[i];
      if (next_low == low && next_high == high && one != other) pairs.emplace_back(std::minmax(one, other));
    }
    return pairs;
  }

  int wholeOf(int node) const {
    while (nodes_[node].whole >= 0) node = nodes_[node].whole;
    return node;
  }

  /// Makes neighbours of the pairs that are not neighbours yet.
  void join(std::vector<NodePair> pairs) {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    if (pairs.size() > kMaxPairs) pairs.resize(kMaxPairs);
    for (Node& node : nodes_) node.neighbours = resolved(std::move(node.neighbours));
    const auto isKnown = [&](const NodePair& pair) {
      const auto& known = nodes_[pair.first].neighbours;
      const Neighbour neighbour{pair.second, Relation::Untried};
      const auto place = std::lower_bound(known.begin(), known.end(), neighbour);
      return place != known.end() && place->node == pair.second;
    };
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), isKnown), pairs.end());
    for (const auto& [a, b] : pairs) {
      nodes_[a].neighbours.push_back({b, Relation::Untried});
      nodes_[b].neighbours.push_back({a, Relation::Untried});
      push(a, b);
    }
  }

  /// Puts a pair into the queue. The pair whose common box has the smallest growth of surface comes first.
  void push(int a, int b) {
    const auto surface = [](const Eigen::AlignedBox3d& box) {
      const Vector3d size = box.sizes();
      return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
    };
    const Eigen::AlignedBox3d &box_a = nodes_[a].box, &box_b = nodes_[b].box;
    pairs_.push({surface(box_a.merged(box_b)) - surface(box_a) - surface(box_b), std::min(a, b), std::max(a, b)});
  }

  /// Replaces each neighbour by the node that it is a part of now, and keeps each of these once: as Apart if it was
  /// ever found so.
  std::vector<Neighbour> resolved(std::vector<Neighbour> neighbours) const {
    for (Neighbour& neighbour : neighbours) neighbour.node = wholeOf(neighbour.node);
    std::sort(neighbours.begin(), neighbours.end());
    std::vector<Neighbour> result;
    for (const Neighbour& neighbour : neighbours) {
      if (result.empty() || result.back().node != neighbour.node)
        result.push_back(neighbour);
      else
        result.back() = neighbour;
    }
    return result;
  }

  /// Merges two nodes. The neighbours of both become neighbours of the whole. A node that cannot be merged with a part
  /// cannot be merged with the whole.
  void unite(int a, int b, std::vector<Vector3d> corners) {
    const int whole = static_cast<int>(nodes_.size());
    Node node;
    node.corners = std::move(corners);
    node.box = nodes_[a].box.merged(nodes_[b].box);
    for (const int part : {a, b}) {
      std::vector<Neighbour>& neighbours = nodes_[part].neighbours;
      solid_.effort().spend(10 * neighbours.size());
      node.neighbours.insert(node.neighbours.end(), neighbours.begin(), neighbours.end());
      neighbours = {};
      nodes_[part].corners = {};
    }
    nodes_[a].whole = nodes_[b].whole = whole;
    nodes_.push_back(std::move(node));
    std::vector<Neighbour> neighbours = resolved(std::move(nodes_[whole].neighbours));
    neighbours.erase(std::remove_if(neighbours.begin(), neighbours.end(),
                                    [&](const Neighbour& neighbour) { return neighbour.node == whole; }),
                     neighbours.end());
    for (const auto& [other, relation] : neighbours) {
      nodes_[other].neighbours.push_back({whole, relation});
      if (relation == Relation::Untried) push(other, whole);
    }
    nodes_[whole].neighbours = std::move(neighbours);
  }

  const TriangleMesh& mesh_;
  const MeshSolid& solid_;
  const double tolerance_;
  const Demand demand_;
  std::vector<Cluster> triangles_;  // of the nodes that were added
  std::vector<Node> nodes_;
  std::priority_queue<Pair> pairs_;
};

}  // namespace

std::vector<Vector3d> pointsOf(const TriangleMesh& mesh, const Cluster& cluster) {
  std::vector<int> indices;
  for (const int t : cluster) indices.insert(indices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  std::vector<Vector3d> points;
  points.reserve(indices.size());
  for (const int i : indices) points.push_back(mesh.vertices[i]);
  return points;
}

Cover coverOf(std::vector<Vector3d> points, Effort& effort) {
  effort.spend(5000 + 1000 * points.size());
  narrowphase::ConvexHull hull(points);
  return {std::move(hull), std::move(points)};
}

Decomposition decompose(const TriangleMesh& mesh, const Partition& components, const MeshSolid& solid, double tolerance,
                        PartsOfHulls parts_of_hulls, const std::vector<Vector3d>& rooms) {
  // Halving can leave many parts, so it may use only half of the effort.
  Effort& effort = solid.effort();
  const Effort for_fusion = effort.half();
  const Demand demand{solid, tolerance, rooms, parts_of_hulls};
  Halving halving(mesh, demand);
  Fusion fusion(mesh, demand);
  for (Cluster& whole : byNumber(components)) {
    if (whole.empty()) continue;
    for (ClusterWithHull& part : halving.partsOf(std::move(whole))) fusion.add(std::move(part));
  }
  effort.add(for_fusion);
  bool is_complete = halving.isComplete();
  try {
    fusion.joinAtVertices();
    fusion.fuse();
    fusion.joinNearBoxes();
    fusion.fuse();
  } catch (const Effort::Exceeded&) {
    is_complete = false;
  }
  return {fusion.partition(), is_complete};
}

std::vector<std::vector<Vector3d>> clusterPoints(const TriangleMesh& mesh, const Partition& partition) {
  std::vector<std::vector<Vector3d>> points;
  for (const Cluster& cluster : byNumber(partition)) {
    if (!cluster.empty()) points.push_back(pointsOf(mesh, cluster));
  }
  return points;
}

}  // namespace proximity_server::scene
