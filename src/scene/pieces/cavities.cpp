#include "scene/pieces/cavities.h"

#include <algorithm>
#include <limits>

#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/mesh_parts.h"

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

bool faceDifferentWays(const std::vector<TriangleMesh>& parts) {
  const auto facesInwards = [](const TriangleMesh& part) { return enclosedVolume(part) < 0.0; };
  const auto count = std::count_if(parts.begin(), parts.end(), facesInwards);
  return count > 0 && count < static_cast<std::ptrdiff_t>(parts.size());
}

/// Whether a point is inside of the hull.
bool holds(const narrowphase::ConvexHull& hull, const Vector3d& p) {
  const auto triangles = trianglesOf(hull.vertices(), hull.triangles());
  return hull.dimension() == 3 && std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& triangle) {
           const auto& [a, b, c] = triangle;
           return (b - a).cross(c - a).dot(p - a) < 0.0;
         });
}

}  // namespace

Cavities::Cavities(const std::vector<TriangleMesh>& closed_parts, double tolerance) {
  if (!faceDifferentWays(closed_parts)) return;
  std::vector<Triangle> all;
  std::vector<EnclosedSpace> of_parts;
  for (const TriangleMesh& part : closed_parts) {
    const std::vector<Triangle> triangles = trianglesOf(part.vertices, part.triangles);
    of_parts.emplace_back(triangles);
    all.insert(all.end(), triangles.begin(), triangles.end());
  }
  Effort unlimited(std::numeric_limits<double>::infinity());
  const EnclosedSpace solid(all);
  const TriangleTree surface(all);
  const auto isInCavity = [&](const Vector3d& p) {
    return !solid.holds(p, unlimited) && surface.nearest(p, unlimited).distance > tolerance &&
           std::any_of(of_parts.begin(), of_parts.end(),
                       [&](const EnclosedSpace& part) { return part.holds(p, unlimited); });
  };
  for (const auto& [a, b, c] : all) {
    const Vector3d step = 1.5 * tolerance * (b - a).cross(c - a).stableNormalized();
    for (const Vector3d& p : {Vector3d((a + b + c) / 3.0 + step), Vector3d((a + b + c) / 3.0 - step)})
      if (isInCavity(p)) points_.push_back(p);
  }
}

bool Cavities::areFilledBy(const narrowphase::ConvexHull& hull, Effort& effort) const {
  effort.spend(points_.size() * hull.triangles().size());
  return std::any_of(points_.begin(), points_.end(), [&](const Vector3d& p) { return holds(hull, p); });
}

}  // namespace proximity_server::scene
