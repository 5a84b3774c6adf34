#include "scene/pieces/mesh_deviation.h"

#include "scene/pieces/mesh_parts.h"
#include "system/numbers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

// Without this gap to the tolerance, a hull at exactly the tolerance would never be decided.
constexpr double kTooClose = 0.98;

constexpr std::size_t kStepsPerTreeTriangle = 20;  // to build a tree

/// A tree of the triangles of a hull's surface.
TriangleTree treeOf(const std::vector<Triangle>& surface, Effort& effort) {
  effort.spend(kStepsPerTreeTriangle * surface.size());
  return TriangleTree(surface);
}

/// The search ends when the deviation is proven to be at most `below` [m], or found to exceed `above` [m].
struct DecisionThresholds {
  double below = -kInfinity, above = kInfinity;
};

}  // namespace

bool isInHull(const narrowphase::ConvexHull& hull, const Vector3d& p) {
  const std::vector<Vector3d>& v = hull.vertices();
  return std::none_of(hull.triangles().begin(), hull.triangles().end(), [&](const std::array<int, 3>& t) {
    return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).dot(p - v[t[0]]) > 0.0;
  });
}

std::vector<Triangle> surfaceOf(const narrowphase::ConvexHull& hull) {
  if (hull.triangles().empty()) return {{hull.vertices().front(), hull.vertices().back(), hull.vertices().back()}};
  return trianglesOf(hull.vertices(), hull.triangles());
}

std::vector<Vector3d> pointsBelow(const narrowphase::ConvexHull& hull, const std::vector<Vector3d>& points) {
  std::vector<Vector3d> corners = hull.vertices(), below;
  std::sort(corners.begin(), corners.end(), isBefore);
  for (const Vector3d& point : points) {
    if (!std::binary_search(corners.begin(), corners.end(), point, isBefore)) below.push_back(point);
  }
  return below;
}

/// Looks for the point of some triangles that lies farthest outside of a mesh.
class DeviationSearch {
 public:
  DeviationSearch(const MeshSolid& mesh, const DecisionThresholds& thresholds) : mesh_(mesh), thresholds_(thresholds) {}

  double farthest() const { return farthest_; }

  /// [m] No part lies farther outside than this, except for kMeshRounding.
  double proven() const {
    return patches_.empty() || patches_.top().bound <= negligible() ? farthest_ : patches_.top().bound;
  }

  bool isExceeded() const { return farthest_ > thresholds_.above; }

  /// True if no part is left that may lie farther outside than the farthest point found, or than the threshold `below`.
  bool isProven() const { return !isExceeded() && (patches_.empty() || patches_.top().bound <= negligible()); }

  /// Measures at some triangles of the hull's surface.
  void look(const narrowphase::ConvexHull& hull, const std::vector<Triangle>& surface) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& vertex : hull.vertices()) middle += vertex / static_cast<double>(hull.vertices().size());
    for (const Triangle& triangle : surface) {
      if (isExceeded()) return;
      if (!isNearItsCorners(triangle)) look(triangle, middle);
    }
  }

  /// Measures at the points of the hull's surface that are nearest to the points `below` it.
  void lookAbove(const std::vector<Vector3d>& below, const std::vector<Triangle>& surface) {
    if (below.empty() || surface.empty() || isExceeded()) return;
    const TriangleTree tree = treeOf(surface, mesh_.effort());
    for (const Vector3d& point : below) {
      if (isExceeded()) return;
      // The point belongs to the mesh. So its distance from the surface point above it is an upper bound of the
      // distance of that surface point from the mesh.
      const TriangleTree::Nearest above = tree.nearest(point, mesh_.effort(), nullptr, {negligible()});
      if (above.distance > negligible()) farthest_ = std::max(farthest_, mesh_.distance(above.point));
    }
  }

  /// Divides the triangles and measures at the parts, until the search is decided or `looks` parts were measured.
  void refine(int looks) {
    for (; looks > 0 && !patches_.empty() && !isExceeded(); looks -= 2) {
      if (patches_.top().bound <= negligible()) break;
      const Patch whole = patches_.top();
      patches_.pop();
      const Triangle& t = whole.corners;
      const auto edge = [&](int i) { return (t[(i + 1) % 3] - t[i]).squaredNorm(); };
      const int longest = edge(0) >= edge(1) ? (edge(0) >= edge(2) ? 0 : 2) : (edge(1) >= edge(2) ? 1 : 2);
      const Vector3d &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
      const Vector3d middle = 0.5 * (a + b);
      look({a, middle, c}, whole.middle_of_hull, &whole.measured);
      look({middle, b, c}, whole.middle_of_hull, &whole.measured);
    }
  }

 private:
  struct Measured {
    Vector3d centre;
    const Triangle* near;  // the triangle of the mesh that is nearest to the centre
    double distance;       // [m] from that triangle
    bool is_inside;
  };
  struct Patch {
    Triangle corners;
    Measured measured;
    Vector3d middle_of_hull;
    double bound;  // [m] an upper bound of the distance outside of the mesh, for all points of the patch
    bool operator<(const Patch& other) const { return bound < other.bound; }
  };

  /// [m] A part that lies no farther outside than this changes nothing.
  double negligible() const { return std::max(farthest_ + kMeshRounding, thresholds_.below); }

  /// True if a triangle of a hull changes nothing, because its corners belong to the mesh and are near to each of its
  /// points. No point of a triangle is farther from all corners than the centre of an equilateral one of as long a side.
  bool isNearItsCorners(const Triangle& t) const {
    const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
    return longest <= std::sqrt(3.0) * std::min(negligible(), thresholds_.above);
  }

  /// True if a point is inside of the mesh. On the way from the centre of the whole there is no surface if that way is
  /// shorter than the distance of the centre from it.
  bool isInside(const Vector3d& p, const Measured* of_whole) const {
    constexpr double kClearly = 1.0 - 1e-9;
    const bool is_as_before = of_whole && (p - of_whole->centre).norm() < kClearly * of_whole->distance;
    return is_as_before ? of_whole->is_inside : mesh_.inside_.holds(p, mesh_.effort());
  }

  void look(const Triangle& t, const Vector3d& middle_of_hull, const Measured* of_whole = nullptr) {
    const Vector3d centre = (t[0] + t[1] + t[2]) / 3.0;
    double reach = 0.0, at_corners = 0.0;
    for (const Vector3d& corner : t) reach = std::max(reach, (corner - centre).norm());
    // A triangle so near proves that the patch changes nothing. Without one within reach, it is wholly inside or outside.
    const double harmless =
        std::min(negligible() - reach, thresholds_.above < kInfinity ? thresholds_.above : farthest_);
    const double far = std::max(harmless, reach) + kMeshRounding;
    const Triangle* near = of_whole ? of_whole->near : nullptr;
    TriangleTree::Nearest nearest = mesh_.surface_.nearest(centre, mesh_.effort(), near, {harmless, far});
    if (nearest.distance <= harmless) return;
    if (!nearest.triangle) {
      if (isInside(centre, of_whole)) return;
      nearest = mesh_.surface_.nearest(centre, mesh_.effort(), near, {});
    }
    for (const Vector3d& corner : t) {
      at_corners = std::max(at_corners, (nearestPoint(*nearest.triangle, corner) - corner).norm());
    }
    const double bound = std::min(nearest.distance + reach, at_corners);
    if (nearest.distance <= farthest_ && bound <= negligible()) return;
    const bool inside = nearest.distance > 0.0 && isInside(centre, of_whole);
    if (!inside) farthest_ = std::max(farthest_, nearest.distance);
    const double signed_bound = inside ? std::min(bound, reach - nearest.distance) : bound;
    if (signed_bound <= negligible()) return;
    const bool may_be_covered = inside || nearest.distance <= kMeshRounding;
    if (may_be_covered && isCovered(t, centre, middle_of_hull)) return;
    patches_.push({t, {centre, nearest.triangle, nearest.distance, inside}, middle_of_hull, signed_bound});
  }

  /// True if a part of a hull is proven to lie outside by kMeshRounding at most, because it is inside after each of its
  /// points has moved by so little towards the middle of the hull. This settles triangles that cut through the solid
  /// from edge to edge, or that lie in the plane of several triangles of the mesh.
  bool isCovered(const Triangle& t, const Vector3d& centre, const Vector3d& middle_of_hull) const {
    double length = kMeshRounding;
    for (const Vector3d& corner : t) length = std::max(length, (middle_of_hull - corner).norm());
    const auto moved = [&](const Vector3d& p) -> Vector3d { return p + kMeshRounding / length * (middle_of_hull - p); };
    return mesh_.inside_.holds(moved(centre), mesh_.effort()) &&
           !mesh_.surface_.mayMeet({moved(t[0]), moved(t[1]), moved(t[2])}, mesh_.effort());
  }

  const MeshSolid& mesh_;
  const DecisionThresholds thresholds_;
  double farthest_ = 0.0;
  std::priority_queue<Patch> patches_;
};

MeshSolid::MeshSolid(std::vector<Triangle> surface, const std::vector<Triangle>& closed, Effort& effort, Rooms rooms)
    : surface_(std::move(surface)), inside_(TriangleBoxes(closed)), rooms_(std::move(rooms)), effort_(effort) {}

double MeshSolid::distance(const Vector3d& p) const {
  const double to_surface = surface_.nearest(p, effort_).distance;
  return to_surface > 0.0 && inside_.holds(p, effort_) ? -to_surface : to_surface;
}

double MeshSolid::deviationOf(const std::vector<Cover>& covers) const {
  constexpr int kLooks = 1000000;
  DeviationSearch search(*this, DecisionThresholds());
  for (const Cover& cover : covers) search.lookAbove(pointsBelow(cover.hull, cover.points), surfaceOf(cover.hull));
  for (const Cover& cover : covers) search.look(cover.hull, surfaceOf(cover.hull));
  search.refine(kLooks);
  return search.proven();
}

bool MeshSolid::isSurfaceWithin(double tolerance, const Cover& cover, std::vector<Triangle> surface) const {
  constexpr int kLooks = 100000;
  // Most hulls that are too far are so at a large triangle.
  const auto size = [](const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).squaredNorm(); };
  std::stable_sort(surface.begin(), surface.end(),
                   [&](const Triangle& a, const Triangle& b) { return size(a) > size(b); });
  DeviationSearch search(*this, {tolerance, kTooClose * tolerance});
  search.look(cover.hull, surface);
  search.lookAbove(pointsBelow(cover.hull, cover.points), surface);
  search.refine(kLooks);
  return search.isProven();
}

Rooms::Largest MeshSolid::roomIn(const narrowphase::ConvexHull& hull, double deviation, double tolerance) const {
  constexpr int kLooks = 100000;
  return rooms_.largestIn(hull, {deviation, std::max(kTooClose * tolerance, deviation), 0.0, kLooks}, effort_);
}

double farthestOutside(const Cover& cover, Effort& effort) {
  const std::vector<Vector3d> below = pointsBelow(cover.hull, cover.points);
  if (below.empty()) return 0.0;
  const std::vector<Triangle> surface = surfaceOf(cover.hull);
  const TriangleTree tree = treeOf(surface, effort);
  std::optional<EnclosedSpace> inside;
  if (cover.hull.dimension() == 3) inside.emplace(tree.boxes());
  double farthest = 0.0;
  for (const Vector3d& point : below) {
    // A ray that grazes an edge counts too few crossings, so the point may be inside all the same.
    if (inside && (inside->holds(point, effort) || isInHull(cover.hull, point))) continue;
    farthest = std::max(farthest, tree.nearest(point, effort).distance);
  }
  return farthest;
}

}  // namespace proximity_server::scene
