#include "proximity_server/narrowphase/epa.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "polytope.h"
#include "triangle.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// The vertices that EPA begins with.
struct Start {
  std::array<CsoVertex, 4> vertices;
  int size = 0;

  explicit Start(const Simplex& simplex) {
    for (int place = 0; place < 4; ++place)
      if (simplex.has(place)) add(simplex[place]);
  }
  void add(const CsoVertex& w) { vertices[static_cast<std::size_t>(size++)] = w; }
};

/// Adds the first vertex that the CSO has more than rounding away from the span of the simplex, if there is one.
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

/// A triangle without area within rounding becomes the longest of its edges.
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

/// Where the origin lies on the surface of the CSO, or the CSO has no volume, one plane is the answer.
struct SurfacePlane {
  bool found = false;
  Vector3d normal;
  double depth;
  bool two_sided;
};

/// The plane across a CSO that is no more than the segment or point of the simplex: away from the origin, if that can
/// be told from lying on it.
SurfacePlane planeAcross(const Cso& cso, const Start& start) {
  const Vector3d first = start.vertices[0].point, last = start.vertices[start.size == 2 ? 1 : 0].point;
  const Vector3d along = (last - first).normalized();
  const auto across = [&](const Vector3d& v) { return Vector3d(v - along.dot(v) * along); };
  const Vector3d towards_origin = across(-first);
  const bool apart = towards_origin.norm() > cso.rounding();
  // Twice, as the first time leaves the rounding of a long vector in a short one.
  const Vector3d any = start.size == 2 ? along.unitOrthogonal() : Vector3d::UnitX();
  const Vector3d normal = apart ? Vector3d(across(towards_origin.normalized()).normalized()) : any;
  return {true, normal, std::max(normal.dot(first), normal.dot(last)), !apart};
}

SurfacePlane growTriangle(Cso& cso, Start& start) {
  const Vector3d normal = areaOf(start).normalized();
  const Vector3d o = start.vertices[0].point;
  const CsoVertex above = cso.vertex(normal), below = cso.vertex(-normal);
  const double up = normal.dot(above.point), down = -normal.dot(below.point);  // depths in both directions
  const double rounding = cso.rounding();
  if (std::min(up, down) <= rounding) {
    const bool upwards = up <= down;
    return {true, upwards ? normal : Vector3d(-normal), std::min(up, down), std::max(up, down) <= rounding};
  }
  start.add(normal.dot(above.point - o) >= normal.dot(o - below.point) ? above : below);
  return {};
}

EpaResult onSurface(const Cso& cso, const WitnessPoints& witnesses, const SurfacePlane& plane, const Options& options) {
  EpaResult result;
  result.depth = plane.depth;
  result.lower_bound = std::min(plane.depth, 0.0) - cso.rounding();
  result.status = plane.depth + cso.rounding() - result.lower_bound <= options.distance_tolerance ? Status::Converged
                                                                                                  : Status::Degenerate;
  result.normal = plane.normal;
  result.has_normal = result.has_points = true;
  result.point_a = witnesses.on_a;
  result.point_b = witnesses.on_b;
  result.unique = !plane.two_sided;
  result.iterations = 0;
  return result;
}

/// A point of a face with what made it, and how far it lies from where the normal says it should.
struct FacePoint {
  Vector3d on_a, on_b;
  double beside;  ///< [m]
};

/// The point in which the ray along the normal passes a face, or what lies near it on the face where it passes beside.
FacePoint passage(const Polytope& polytope, const Polytope::Face& face, const EpaResult& result) {
  std::array<double, 3> weights = polytope.rayWeights(face, result.normal);
  double sum = 0.0;
  for (double& weight : weights) sum += weight = std::max(weight, 0.0);
  FacePoint point{Vector3d::Zero(), Vector3d::Zero(), 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const CsoVertex& vertex = polytope.vertex(face.vertices[i]);
    point.on_a += weights[i] / sum * vertex.on_a;
    point.on_b += weights[i] / sum * vertex.onB();
  }
  point.beside = (point.on_a - point.on_b - result.depth * result.normal).norm();
  return point;
}

/// Witnesses where the ray from the origin along the normal leaves the polytope: through `guess`, or through the face
/// that fits best. There are none where that is farther from the depth than the bounds and the tolerance explain.
void setWitnesses(const Polytope& polytope, const Polytope::Face* guess, const Options& options, EpaResult& result) {
  const double accepted = result.depth - result.lower_bound + options.distance_tolerance;
  FacePoint best{Vector3d::Zero(), Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  if (guess != nullptr) best = passage(polytope, *guess, result);
  // Beyond an edge of the guess lies another face in the same plane. Written as !(<=) for NaN.
  if (!(best.beside <= result.depth - result.lower_bound)) {
    best.beside = std::numeric_limits<double>::infinity();
    polytope.forEachFace([&](const Polytope::Face& face) {
      if (!(face.normal.dot(result.normal) > 0.0)) return;
      const FacePoint candidate = passage(polytope, face, result);
      if (candidate.beside < best.beside) best = candidate;
    });
  }
  result.has_points = best.beside <= accepted;
  result.point_a = best.on_a;
  result.point_b = best.on_b;
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

/// Slides the normal down to where the depth has no slope, and there its support points are the witnesses. For the
/// curved parts of a CSO that the polytope was too coarse for; a corner or an edge of the depth stays as it is.
///
/// Newton's method on the sphere: the slope of the depth at n is the tangential part of the support point, so that
/// differences of support points give its curvature.
void slideToMinimum(Cso& cso, EpaResult& result) {
  constexpr double kStep = 1e-5;  // [rad] the cube root of eps: as small as differences allow
  constexpr double kFlat = 1e-4;  // curvatures below this part of the depth are a ring of equal depths
  constexpr int kMostSteps = 12;
  for (int i = 0; i < kMostSteps; ++i) {
    const Vector3d n = result.normal, u = n.unitOrthogonal(), v = n.cross(u);
    const auto slope = [&](const Vector3d& direction) {
      const Vector3d w = cso.vertex(direction.normalized()).point;
      return Eigen::Vector2d(u.dot(w), v.dot(w));
    };
    const Eigen::Vector2d here = slope(n);
    Eigen::Matrix2d curvature;
    curvature << (slope(n + kStep * u) - slope(n - kStep * u)) / (2.0 * kStep),
        (slope(n + kStep * v) - slope(n - kStep * v)) / (2.0 * kStep);
    curvature -= result.depth * Eigen::Matrix2d::Identity();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(0.5 * (curvature + curvature.transpose()));
    Vector3d next = n;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d axis = axes.eigenvectors().col(k);
      if (axes.eigenvalues()[k] <= kFlat * result.depth) continue;
      next -= axis.dot(here) / axes.eigenvalues()[k] * (axis.x() * u + axis.y() * v);
    }
    next.normalize();
    const CsoVertex w = cso.vertex(next);
    const double depth = next.dot(w.point);
    if (!(depth < result.depth)) return;
    result.depth = depth;
    result.normal = next;
    const double beside = (w.point - depth * next).norm();
    result.has_points = beside <= depth - result.lower_bound;
    result.point_a = w.on_a;
    result.point_b = w.onB();
  }
}

EpaResult expandPolytope(Cso& cso, const Start& tetrahedron, const Options& options) {
  Polytope polytope(tetrahedron.vertices, cso.rounding());
  EpaResult result;
  result.has_normal = result.has_points = false;
  result.depth = std::numeric_limits<double>::infinity();
  const auto gap = [&] { return result.depth + cso.rounding() - result.lower_bound; };
  const double final_gap = cso.finalGap(options.distance_tolerance);
  const auto end = [&](Status status, const Polytope::Face* face) {
    const bool converged = status != Status::Threshold && gap() <= options.distance_tolerance;
    result.status = converged ? Status::Converged : status;
    if (!result.has_normal) return result;
    setWitnesses(polytope, face, options, result);
    if (result.status == Status::IterationLimit) slideToMinimum(cso, result);
    result.unique = isUnique(polytope, result, options);
    return result;
  };

  for (result.iterations = 1;; ++result.iterations) {
    const Polytope::Face* face = polytope.closest();
    const double reach = face != nullptr ? face->distance : result.depth;
    result.lower_bound = std::min(reach, result.depth) - cso.rounding();
    if (-result.lower_bound <= options.stop_below) return end(Status::Threshold, nullptr);
    if (gap() <= final_gap) return end(Status::Converged, nullptr);
    if (face == nullptr) return end(Status::Degenerate, nullptr);

    const CsoVertex w = cso.vertex(face->normal);
    const double depth = face->normal.dot(w.point);
    if (depth < result.depth) {
      result.depth = depth;
      result.normal = face->normal;
      result.has_normal = true;
      if (gap() <= final_gap) return end(Status::Converged, face);
    }
    if (-(result.depth + cso.rounding()) > options.stop_above) return end(Status::Threshold, nullptr);
    if (result.iterations >= options.max_iterations || polytope.full()) return end(Status::IterationLimit, nullptr);
    if (polytope.hasCorner(*face, w)) return end(Status::Degenerate, nullptr);
    if (!polytope.expand(*face, w, result.depth)) return end(Status::Degenerate, nullptr);
  }
}

}  // namespace

EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options) {
  Start start(simplex);
  const auto onPlane = [&](const SurfacePlane& plane) {
    return onSurface(cso, witnessPoints(simplex), plane, options);
  };
  if (start.size == 3) dropFromSliver(cso, start);
  if (start.size == 1 && !growPoint(cso, start)) return onPlane(planeAcross(cso, start));
  if (start.size == 2 && !growSegment(cso, start)) return onPlane(planeAcross(cso, start));
  if (start.size == 3) {
    const SurfacePlane plane = growTriangle(cso, start);
    if (plane.found) return onPlane(plane);
  }
  return expandPolytope(cso, start, options);
}

}  // namespace proximity_server
