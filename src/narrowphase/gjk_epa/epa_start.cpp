#include "narrowphase/gjk_epa/epa_start.h"

#include "narrowphase/shape/triangle.h"
#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// The vertices found so far.
struct Start {
  std::array<CsoVertex, 4> vertices;
  int size = 0;

  explicit Start(const Simplex& simplex) {
    for (int place = 0; place < 4; ++place)
      if (simplex.has(place)) add(simplex[place]);
  }
  void add(const CsoVertex& w) { vertices[size++] = w; }
};

/// Adds the first of the support vertices along `directions` that lies more than rounding outside of the span of the
/// simplex. Returns false if none does.
template <typename Directions, typename Height>
bool growBy(Cso& cso, Start& start, const Directions& directions, Height height) {
  for (const Vector3d& direction : directions) {
    const CsoVertex w = cso.vertex(direction);
    if (height(w.point) <= cso.rounding()) continue;
    start.add(w);
    return true;
  }
  return false;
}

bool growPoint(Cso& cso, Start& start) {
  const Vector3d o = start.vertices[0].point;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  return growBy(cso, start, std::array<Vector3d, 6>{x, -x, y, -y, z, -z},
                [&](const Vector3d& p) { return (p - o).norm(); });
}

bool growSegment(Cso& cso, Start& start) {
  const Vector3d o = start.vertices[0].point;
  const Vector3d along = (start.vertices[1].point - o).normalized();
  const Vector3d u = along.unitOrthogonal(), v = along.cross(u);
  return growBy(cso, start, std::array<Vector3d, 4>{u, -u, v, -v},
                [&](const Vector3d& p) { return along.cross(p - o).norm(); });
}

Vector3d areaOf(const Start& triangle) {
  const Vector3d &a = triangle.vertices[0].point, &b = triangle.vertices[1].point, &c = triangle.vertices[2].point;
  return areaVector(b - a, c - b, a - c);
}

/// Replaces a triangle whose area is rounding by the longest of its edges.
void dropFromSliver(const Cso& cso, Start& triangle) {
  auto& v = triangle.vertices;
  const auto length = [&](std::size_t i, std::size_t j) { return (v[i].point - v[j].point).norm(); };
  const double ab = length(0, 1), bc = length(1, 2), ca = length(2, 0);
  const double longest = std::max({ab, bc, ca});
  if (areaOf(triangle).norm() > cso.rounding() * longest) return;
  if (longest == bc) v[0] = v[2];
  if (longest == ca && longest != bc) v[1] = v[2];
  triangle.size = 2;
}

/// Support plane of a CSO that is a segment or a point. Its normal points from the CSO to the origin; if the origin
/// lies on the CSO within rounding, any normal perpendicular to the segment is taken.
SurfacePlane planeAcross(const Cso& cso, const Start& start) {
  const Vector3d first = start.vertices[0].point, last = start.vertices[start.size == 2 ? 1 : 0].point;
  const Vector3d along = (last - first).normalized();
  const auto across = [&](const Vector3d& v) { return Vector3d(v - along.dot(v) * along); };
  const Vector3d towards_origin = across(-first);
  const bool apart = towards_origin.norm() > cso.rounding();
  // Projected twice: the first projection leaves the rounding error of a long vector in a short one.
  const Vector3d any = start.size == 2 ? along.unitOrthogonal() : Vector3d::UnitX();
  const Vector3d normal = apart ? Vector3d(across(towards_origin.normalized()).normalized()) : any;
  return {normal, std::max(normal.dot(first), normal.dot(last)), !apart};
}

/// Adds the vertex of the CSO farthest from the plane of the triangle. If the origin lies on the surface of the CSO,
/// returns its support plane instead.
std::optional<SurfacePlane> growTriangle(Cso& cso, Start& start) {
  const Vector3d normal = areaOf(start).normalized();
  const Vector3d o = start.vertices[0].point;
  const CsoVertex above = cso.vertex(normal), below = cso.vertex(-normal);
  const double up = normal.dot(above.point), down = -normal.dot(below.point);  // depths along both directions
  const double rounding = cso.rounding();
  if (std::min(up, down) <= rounding) {
    const bool upwards = up <= down;
    return SurfacePlane{upwards ? normal : Vector3d(-normal), std::min(up, down), std::max(up, down) <= rounding};
  }
  start.add(normal.dot(above.point - o) >= normal.dot(o - below.point) ? above : below);
  return std::nullopt;
}

}  // namespace

EpaStart epaStart(Cso& cso, const Simplex& simplex) {
  PROXIMITY_ASSERT(simplex.members != 0, "The simplex is empty: the tetrahedron grows from at least one vertex of it.");
  Start start(simplex);
  if (start.size == 3) dropFromSliver(cso, start);
  if (start.size == 1 && !growPoint(cso, start)) return {start.vertices, planeAcross(cso, start)};
  if (start.size == 2 && !growSegment(cso, start)) return {start.vertices, planeAcross(cso, start)};
  const std::optional<SurfacePlane> plane = start.size == 3 ? growTriangle(cso, start) : std::nullopt;
  return {start.vertices, plane};
}

}  // namespace proximity_server::narrowphase
