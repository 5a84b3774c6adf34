#include "mesh_deviation.h"

#include <algorithm>
#include <limits>
#include <queue>

#include "mesh_parts.h"

namespace proximity_server {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// To build a hull and its tree.
constexpr std::size_t kStepsPerCorner = 1000;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The largest value over the triangles of a distance that changes by no more than one walks, or `at_least`.
/// Ends when nothing larger is left, when enough is known, or after kSamples parts.
template <typename Distance>
double farthestOver(const std::vector<Triangle>& triangles, double at_least, const Distance& distance,
                    const Enough& enough = {}) {
  constexpr int kSamples = 4000;
  struct Patch {
    Triangle corners;
    double bound;  // no point of it lies farther
    bool operator<(const Patch& other) const { return bound < other.bound; }
  };
  double farthest = at_least;
  std::priority_queue<Patch> patches;
  const auto look = [&](const Triangle& t) {
    const Vector3d centre = (t[0] + t[1] + t[2]) / 3.0;
    const double here = distance(centre);
    farthest = std::max(farthest, here);
    const auto reach = [&](int i) { return (t[i] - centre).norm(); };
    patches.push({t, here + std::max({reach(0), reach(1), reach(2)})});
  };
  for (const Triangle& triangle : triangles) look(triangle);
  for (int samples = 0; samples < kSamples && !patches.empty(); samples += 2) {
    if (patches.top().bound <= std::max(farthest + kMeshRounding, enough.below) || farthest > enough.above) break;
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

/// A hull's surface; a segment or a point as a triangle without area.
std::vector<Triangle> surfaceOf(const ConvexHull& hull) {
  if (hull.triangles().empty()) return {{hull.vertices().front(), hull.vertices().back(), hull.vertices().back()}};
  return trianglesOf(hull.vertices(), hull.triangles());
}

/// A hull as the planes of its faces, so that most points are settled by few of them.
class HullInterior {
 public:
  explicit HullInterior(const ConvexHull& hull) {
    for (const Vector3d& vertex : hull.vertices()) box_.extend(vertex);
    if (hull.dimension() < 3) return;
    for (const auto& [a, b, c] : surfaceOf(hull)) {
      const Vector3d normal = (b - a).cross(c - a).stableNormalized();
      planes_.push_back({normal, normal.dot(a)});
    }
  }
  bool holds(const Vector3d& p) const {
    if (planes_.empty() || !box_.contains(p)) return false;
    return std::all_of(planes_.begin(), planes_.end(), [&](const Plane& q) { return q.normal.dot(p) <= q.offset; });
  }

 private:
  struct Plane {
    Vector3d normal;
    double offset;
  };
  Eigen::AlignedBox3d box_;
  std::vector<Plane> planes_;
};

}  // namespace

EnclosedSpace::EnclosedSpace(const std::vector<Triangle>& closed) {
  turns_ = {Eigen::AngleAxisd(0.7391, Vector3d(0.317, 0.911, -0.263).normalized()).toRotationMatrix(),
            Eigen::AngleAxisd(2.1731, Vector3d(-0.571, 0.337, 0.749).normalized()).toRotationMatrix()};
  for (std::size_t ray = 0; ray < kRays; ++ray) {
    for (const Triangle& t : closed) {
      Seen seen{{turns_[ray] * t[0], turns_[ray] * t[1], turns_[ray] * t[2]}, {}};
      for (const Vector3d& corner : seen.corners) seen.box.extend(corner);
      seen_[ray].push_back(seen);
    }
  }
}

bool EnclosedSpace::holds(const Vector3d& p) const {
  return winding(0, turns_[0] * p) != 0 && winding(1, turns_[1] * p) != 0;
}

int EnclosedSpace::winding(std::size_t ray, const Vector3d& p) const {
  int crossings = 0;
  for (const Seen& seen : seen_[ray]) {
    const Vector3d &low = seen.box.min(), &high = seen.box.max();
    if (high.x() < p.x() || low.x() > p.x() || high.y() < p.y() || low.y() > p.y() || high.z() < p.z()) continue;
    const auto flat = [&](std::size_t i) { return Vector2d((seen.corners[i] - p).head<2>()); };
    const Vector2d a = flat(0), b = flat(1), c = flat(2);
    const double u = cross(b, c), v = cross(c, a), w = cross(a, b);
    const bool counter_clockwise = u > 0 && v > 0 && w > 0;
    if (!counter_clockwise && !(u < 0 && v < 0 && w < 0)) continue;
    const double z = (u * seen.corners[0].z() + v * seen.corners[1].z() + w * seen.corners[2].z()) / (u + v + w);
    if (z > p.z()) crossings += counter_clockwise ? 1 : -1;
  }
  return crossings;
}

MeshSolid::MeshSolid(std::vector<Triangle> surface, const std::vector<Triangle>& closed, Effort& effort)
    : surface_(std::move(surface)), inside_(closed), effort_(effort) {}

double MeshSolid::distance(const Vector3d& p) const {
  effort_.spend(inside_.size());
  const double to_surface = surface_.distance(p, effort_);
  return to_surface > 0.0 && inside_.holds(p) ? -to_surface : to_surface;
}

double MeshSolid::deviationOf(const ConvexHull& hull, const std::vector<Vector3d>& vertices) const {
  return deviationOf(hull, vertices, Enough());
}

bool MeshSolid::isWithin(double tolerance, const ConvexHull& hull, const std::vector<Vector3d>& vertices) const {
  return deviationOf(hull, vertices, {tolerance, tolerance}) <= tolerance;
}

double MeshSolid::deviationOf(const ConvexHull& hull, const std::vector<Vector3d>& vertices,
                              const Enough& enough) const {
  const std::vector<Triangle> triangles = surfaceOf(hull);
  const TriangleTree hull_surface(triangles);
  double farthest = 0.0;
  effort_.spend(kStepsPerCorner * (triangles.size() + vertices.size()));
  for (const Vector3d& vertex : vertices) {
    const Vector3d above = hull_surface.nearest(vertex, effort_);
    if ((above - vertex).norm() > farthest) farthest = std::max(farthest, distance(above));
    if (farthest > enough.above) return farthest;
  }
  return farthestOver(
      triangles, farthest, [this](const Vector3d& p) { return distance(p); }, enough);
}

double uncovered(const std::vector<Triangle>& triangles, const std::vector<ConvexHull>& hulls, Effort& effort) {
  std::vector<Triangle> surfaces;
  std::vector<HullInterior> interiors;
  for (const ConvexHull& hull : hulls) {
    for (const Triangle& triangle : surfaceOf(hull)) surfaces.push_back(triangle);
    interiors.emplace_back(hull);
  }
  const TriangleTree surface(std::move(surfaces));
  return farthestOver(triangles, 0.0, [&](const Vector3d& p) {
    effort.spend(hulls.size());
    const double outside = surface.distance(p, effort);
    const bool held = std::any_of(interiors.begin(), interiors.end(), [&](const auto& hull) { return hull.holds(p); });
    return held ? 0.0 : outside;
  });
}

}  // namespace proximity_server
