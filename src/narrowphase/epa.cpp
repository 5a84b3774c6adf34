#include "proximity_server/narrowphase/epa.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polytope.h"
#include "triangle.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

void add(Simplex& simplex, const CsoVertex& w) { simplex.vertices[static_cast<std::size_t>(simplex.size++)] = w; }

/// Adds the first vertex that the CSO has more than rounding away from the span of the simplex, if there is one.
template <typename Directions, typename Height>
bool growBy(Cso& cso, Simplex& simplex, const Directions& directions, Height height) {
  for (const Vector3d& direction : directions) {
    const CsoVertex w = cso.vertex(direction);
    if (height(w.point) <= cso.rounding()) continue;
    add(simplex, w);
    return true;
  }
  return false;
}

bool growPoint(Cso& cso, Simplex& simplex) {
  const Vector3d o = simplex.vertices[0].point;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  return growBy(cso, simplex, std::array<Vector3d, 6>{x, -x, y, -y, z, -z},
                [&](const Vector3d& p) { return (p - o).norm(); });
}

bool growSegment(Cso& cso, Simplex& simplex) {
  const Vector3d o = simplex.vertices[0].point;
  const Vector3d along = (simplex.vertices[1].point - o).normalized();
  const Vector3d u = along.unitOrthogonal(), v = along.cross(u);
  return growBy(cso, simplex, std::array<Vector3d, 4>{u, -u, v, -v},
                [&](const Vector3d& p) { return along.cross(p - o).norm(); });
}

Vector3d areaOf(const Simplex& triangle) {
  const Vector3d &a = triangle.vertices[0].point, &b = triangle.vertices[1].point, &c = triangle.vertices[2].point;
  return areaVector(b - a, c - b, a - c);
}

/// A triangle without area within rounding becomes the longest of its edges.
void dropFromSliver(const Cso& cso, Simplex& triangle) {
  auto& v = triangle.vertices;
  const auto length = [&](std::size_t i, std::size_t j) { return (v[i].point - v[j].point).norm(); };
  const double ab = length(0, 1), bc = length(1, 2), ca = length(2, 0);
  const double longest = std::max({ab, bc, ca});
  if (areaOf(triangle).norm() > cso.rounding() * longest) return;
  if (longest == bc) v[0] = v[2];
  if (longest == ca && longest != bc) v[1] = v[2];
  triangle.size = 2;
}

/// Where the origin lies on the surface of the CSO, or the CSO has no volume: the answer is the plane of the triangle.
struct SurfacePlane {
  bool found = false;
  Vector3d normal;
  double depth;
  bool two_sided;
};

SurfacePlane growTriangle(Cso& cso, Simplex& simplex) {
  const Vector3d normal = areaOf(simplex).normalized();
  const Vector3d o = simplex.vertices[0].point;
  const CsoVertex above = cso.vertex(normal), below = cso.vertex(-normal);
  const double up = normal.dot(above.point), down = -normal.dot(below.point);  // depths in both directions
  const double rounding = cso.rounding();
  if (std::min(up, down) <= rounding) {
    const bool upwards = up <= down;
    return {true, upwards ? normal : Vector3d(-normal), std::min(up, down), std::max(up, down) <= rounding};
  }
  add(simplex, normal.dot(above.point - o) >= normal.dot(o - below.point) ? above : below);
  return {};
}

EpaResult onSurface(const Cso& cso, const Simplex& witnesses, const SurfacePlane& plane) {
  EpaResult result;
  result.status = Status::Converged;
  result.depth = plane.depth;
  result.lower_bound = std::min(plane.depth, 0.0) - cso.rounding();
  result.normal = plane.normal;
  result.point_a = witnesses.pointOnA();
  result.point_b = witnesses.pointOnB();
  result.unique = !plane.two_sided;
  result.iterations = 0;
  return result;
}

/// Where the ray from the origin along the normal leaves the polytope, on both shapes.
void setWitnesses(const Polytope& polytope, const Polytope::Face& face, EpaResult& result) {
  const auto smallest = [](const std::array<double, 3>& w) { return std::min({w[0], w[1], w[2]}); };
  std::array<double, 3> weights = polytope.rayWeights(face, result.normal);
  std::array<int, 3> vertices = face.vertices;
  // Beyond an edge of this face lies another one in the same plane (or, unfinished, nearly so).
  if (!(smallest(weights) >= 0.0)) {
    polytope.forEachFace([&](const Polytope::Face& other) {
      if (!(other.normal.dot(result.normal) > 0.0)) return;
      const std::array<double, 3> candidate = polytope.rayWeights(other, result.normal);
      if (!(smallest(candidate) > smallest(weights))) return;
      weights = candidate;
      vertices = other.vertices;
    });
  }
  double sum = 0.0;
  for (double& weight : weights) sum += weight = std::max(weight, 0.0);
  result.point_a = result.point_b = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    result.point_a += weights[i] / sum * polytope.vertex(vertices[i]).on_a;
    result.point_b += weights[i] / sum * polytope.vertex(vertices[i]).onB();
  }
}

/// Whether no direction but those near the normal is as short. Within 1e-2 rad it counts as the same direction: a face
/// of a curved CSO differs in depth by half the squared angle times its radius, and 1e-9 m should not tell faces apart.
bool isUnique(const Polytope& polytope, const EpaResult& result, const Options& options) {
  constexpr double kSameDirection = 1e-2;
  bool unique = true;
  polytope.forEachFace([&](const Polytope::Face& face) {
    if (face.distance <= result.depth + options.distance_tolerance &&
        (face.normal - result.normal).squaredNorm() > kSameDirection * kSameDirection)
      unique = false;
  });
  return unique;
}

EpaResult expandPolytope(Cso& cso, const Simplex& tetrahedron, const Options& options) {
  Polytope polytope(tetrahedron.vertices, cso.rounding());
  EpaResult result;
  result.depth = std::numeric_limits<double>::infinity();
  Polytope::Face best;
  const auto end = [&](Status status) {
    result.status = status;
    setWitnesses(polytope, best, result);
    result.unique = isUnique(polytope, result, options);
    return result;
  };

  for (result.iterations = 1;; ++result.iterations) {
    const Polytope::Face* closest = polytope.closest();
    if (closest == nullptr) {  // every face is as far as the best direction is deep
      result.lower_bound = result.depth - cso.rounding();
      return end(Status::Converged);
    }
    const Polytope::Face face = *closest;
    result.lower_bound = face.distance - cso.rounding();

    const CsoVertex w = cso.vertex(face.normal);
    const double depth = face.normal.dot(w.point);
    const bool settled = depth + cso.rounding() - result.lower_bound <= options.distance_tolerance;
    if (depth < result.depth || settled) {
      result.depth = depth;
      result.normal = face.normal;
      best = face;
    }
    if (settled) return end(Status::Converged);
    if (-(result.depth + cso.rounding()) > options.stop_above || -result.lower_bound <= options.stop_below)
      return end(Status::Threshold);
    if (result.iterations >= options.max_iterations || polytope.full()) return end(Status::IterationLimit);
    if (!polytope.expand(*closest, w, result.depth)) return end(Status::Degenerate);
  }
}

}  // namespace

EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options) {
  Simplex start = simplex;
  if (start.size == 3) dropFromSliver(cso, start);
  if (start.size == 1 && !growPoint(cso, start)) return onSurface(cso, simplex, {true, Vector3d::UnitX(), 0.0, true});
  if (start.size == 2 && !growSegment(cso, start)) {
    const Vector3d along = start.vertices[1].point - start.vertices[0].point;
    return onSurface(cso, simplex, {true, along.unitOrthogonal(), 0.0, true});
  }
  if (start.size == 3) {
    const SurfacePlane plane = growTriangle(cso, start);
    if (plane.found) return onSurface(cso, simplex, plane);
  }
  return expandPolytope(cso, start, options);
}

}  // namespace proximity_server
