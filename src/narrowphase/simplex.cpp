#include "proximity_server/narrowphase/simplex.h"

#include <cmath>
#include <limits>

#include "triangle.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// A subset of the simplex by indices, with the weights of its nearest point.
struct Candidate {
  int size;
  std::array<int, 3> index;
  std::array<double, 3> weight;
  double distance;
  Vector3d normal;
};

const Candidate& nearer(const Candidate& a, const Candidate& b) { return a.distance <= b.distance ? a : b; }

Vector3d point(const Simplex& simplex, int index) { return simplex.vertices[static_cast<std::size_t>(index)].point; }

/// A point at the origin has no normal of its own; the caller sees the distance and does not use it.
Vector3d normalOf(const Vector3d& nearest, double distance) {
  return distance > 0.0 ? Vector3d(nearest / -distance) : Vector3d(Vector3d::UnitX());
}

Candidate nearestOfVertex(const Simplex& simplex, int w) {
  const Vector3d p = point(simplex, w);
  const double distance = p.norm();
  return {1, {w, 0, 0}, {1.0, 0.0, 0.0}, distance, normalOf(p, distance)};
}

Candidate nearestOfEdge(const Simplex& simplex, int w, int a) {
  const Vector3d pw = point(simplex, w);
  const Vector3d edge = point(simplex, a) - pw;
  const double along = -pw.dot(edge);
  const double length2 = edge.squaredNorm();
  if (!(along > 0.0)) return nearestOfVertex(simplex, w);
  if (!(along < length2)) return nearestOfVertex(simplex, a);
  const double t = along / length2;
  const Vector3d p = pw + t * edge;
  const double distance = p.norm();
  return {2, {w, a, 0}, {1.0 - t, t, 0.0}, distance, normalOf(p, distance)};
}

Candidate nearestOfTriangle(const Simplex& simplex, int w, int a, int b) {
  const Vector3d pw = point(simplex, w), pa = point(simplex, a), pb = point(simplex, b);
  const Vector3d wa = pa - pw, ab = pb - pa, bw = pw - pb;
  const Vector3d area = areaVector(wa, ab, bw);
  // Areas that the projected origin spans with the edges opposite to w, a and b.
  const double of_w = area.dot(pa.cross(ab));
  const double of_a = area.dot(pb.cross(bw));
  const double of_b = area.dot(pw.cross(wa));
  if (of_w > 0.0 && of_a > 0.0 && of_b > 0.0) {
    const double sum = of_w + of_a + of_b;
    const Vector3d normal = area.normalized();
    const double height = normal.dot(pw);
    return {3,
            {w, a, b},
            {of_w / sum, of_a / sum, of_b / sum},
            std::abs(height),
            height > 0.0 ? Vector3d(-normal) : normal};
  }
  if (of_a > 0.0 && of_w > 0.0) return nearestOfEdge(simplex, w, a);
  if (of_b > 0.0 && of_w > 0.0) return nearestOfEdge(simplex, w, b);
  return nearer(nearestOfEdge(simplex, w, a), nearestOfEdge(simplex, w, b));
}

/// The faces at the newest vertex that do not surely have the origin on their inner side.
std::array<bool, 3> facesTowardsOrigin(const Simplex& simplex) {
  const Vector3d w = point(simplex, 3);
  const Vector3d a = point(simplex, 0) - w, b = point(simplex, 1) - w, c = point(simplex, 2) - w;
  const Vector3d ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
  // A triple product of x, y, z is off by at most 6 eps |x| |y| |z|, to first order in eps.
  constexpr double k = 6.0 * std::numeric_limits<double>::epsilon();
  const double na = a.norm(), nb = b.norm(), nc = c.norm(), nw = w.norm();
  const double volume = ab.dot(c);
  if (std::abs(volume) <= k * na * nb * nc) return {true, true, true};
  const double side = volume > 0.0 ? 1.0 : -1.0;
  return {!(side * ab.dot(w) < -k * na * nb * nw), !(side * bc.dot(w) < -k * nb * nc * nw),
          !(side * ca.dot(w) < -k * nc * na * nw)};
}

Candidate nearestOfFaces(const Simplex& simplex, const std::array<bool, 3>& towards_origin) {
  Candidate best;
  best.distance = std::numeric_limits<double>::infinity();
  if (towards_origin[0]) best = nearer(best, nearestOfTriangle(simplex, 3, 0, 1));
  if (towards_origin[1]) best = nearer(best, nearestOfTriangle(simplex, 3, 1, 2));
  if (towards_origin[2]) best = nearer(best, nearestOfTriangle(simplex, 3, 2, 0));
  return best;
}

Nearest keep(Simplex& simplex, const Candidate& candidate) {
  const Simplex whole = simplex;
  simplex.size = candidate.size;
  for (std::size_t i = 0; i < static_cast<std::size_t>(candidate.size); ++i) {
    simplex.vertices[i] = whole.vertices[static_cast<std::size_t>(candidate.index[i])];
    simplex.weights[i] = candidate.weight[i];
  }
  return {candidate.distance, candidate.normal, false};
}

}  // namespace

bool Simplex::contains(const CsoVertex& w) const {
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i)
    if (vertices[i].point == w.point) return true;
  return false;
}

Vector3d Simplex::pointOnA() const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += weights[i] * vertices[i].on_a;
  return sum;
}

Vector3d Simplex::pointOnB() const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += weights[i] * vertices[i].on_b;
  return sum;
}

Nearest reduceToNearest(Simplex& simplex) {
  switch (simplex.size) {
    case 1:
      return keep(simplex, nearestOfVertex(simplex, 0));
    case 2:
      return keep(simplex, nearestOfEdge(simplex, 1, 0));
    case 3:
      return keep(simplex, nearestOfTriangle(simplex, 2, 0, 1));
    default:
      break;
  }
  const std::array<bool, 3> towards_origin = facesTowardsOrigin(simplex);
  if (!towards_origin[0] && !towards_origin[1] && !towards_origin[2]) return {0.0, Vector3d::Zero(), true};
  return keep(simplex, nearestOfFaces(simplex, towards_origin));
}

}  // namespace proximity_server
