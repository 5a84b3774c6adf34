#include "proximity_server/narrowphase/simplex.h"

#include <cmath>
#include <limits>

#include "triangle.h"

namespace proximity_server {
namespace {

using Eigen::Vector3d;

/// A subset with its nearest point, before any square root: the normal is perpendicular to the subset but of any
/// length.
struct Candidate {
  Subset subset;
  double distance2;  ///< [m^2]
  Vector3d normal;   ///< towards the origin
  double normal2;    ///< its squared norm
};

const Candidate& nearer(const Candidate& a, const Candidate& b) { return a.distance2 <= b.distance2 ? a : b; }

const Vector3d& point(const Places& places, int place) { return places[static_cast<std::size_t>(place)].point; }

Candidate nearestOfVertex(const Places& places, int w) {
  const Vector3d& p = point(places, w);
  const double distance2 = p.squaredNorm();
  return {{1, {w}, {1.0}}, distance2, -p, distance2};
}

Candidate nearestOfEdge(const Places& places, int w, int a) {
  const Vector3d& pw = point(places, w);
  const Vector3d edge = point(places, a) - pw;
  const double of_a = -pw.dot(edge);
  const double length2 = edge.squaredNorm();
  if (!(of_a > 0.0)) return nearestOfVertex(places, w);
  if (!(of_a < length2)) return nearestOfVertex(places, a);
  // Twice across the edge, as the first time leaves the rounding of a long vector in a short one.
  const Vector3d near = pw + of_a / length2 * edge;
  const Vector3d p = near - near.dot(edge) / length2 * edge;
  const double distance2 = p.squaredNorm();
  return {{2, {a, w}, {of_a, length2 - of_a}}, distance2, -p, distance2};
}

Candidate nearestOfTriangle(const Places& places, int w, int a, int b) {
  const Vector3d &pw = point(places, w), &pa = point(places, a), &pb = point(places, b);
  const Vector3d wa = pa - pw, ab = pb - pa, bw = pw - pb;
  const Vector3d area = areaVector(wa, ab, bw);
  // Areas that the projected origin spans with the edges opposite to w, a and b.
  const double of_w = area.dot(pa.cross(ab));
  const double of_a = area.dot(pb.cross(bw));
  const double of_b = area.dot(pw.cross(wa));
  if (of_w > 0.0 && of_a > 0.0 && of_b > 0.0) {
    const double area2 = area.squaredNorm();
    const double height = area.dot(pw);  // times |area|
    return {{3, {a, b, w}, {of_a, of_b, of_w}}, height * height / area2, height > 0.0 ? Vector3d(-area) : area, area2};
  }
  if (of_a > 0.0 && of_w > 0.0) return nearestOfEdge(places, w, a);
  if (of_b > 0.0 && of_w > 0.0) return nearestOfEdge(places, w, b);
  return nearer(nearestOfEdge(places, w, a), nearestOfEdge(places, w, b));
}

/// The faces w a b, w b c, w c a that do not surely have the origin on their inner side.
std::array<bool, 3> facesTowardsOrigin(const Places& places, int w, const std::array<int, 4>& others) {
  const Vector3d& pw = point(places, w);
  const Vector3d a = point(places, others[0]) - pw, b = point(places, others[1]) - pw,
                 c = point(places, others[2]) - pw;
  const Vector3d ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
  // A triple product of x, y, z is off by at most 6 eps |x| |y| |z|, to first order in eps; |x|_1 is never less than
  // |x|.
  constexpr double k = 6.0 * std::numeric_limits<double>::epsilon();
  const double na = a.lpNorm<1>(), nb = b.lpNorm<1>(), nc = c.lpNorm<1>(), nw = pw.lpNorm<1>();
  const double volume = ab.dot(c);
  if (std::abs(volume) <= k * na * nb * nc) return {true, true, true};
  const double side = volume > 0.0 ? 1.0 : -1.0;
  return {!(side * ab.dot(pw) < -k * na * nb * nw), !(side * bc.dot(pw) < -k * nb * nc * nw),
          !(side * ca.dot(pw) < -k * nc * na * nw)};
}

Candidate nearestOfTetrahedron(const Places& places, int w, const std::array<int, 4>& others,
                               const std::array<bool, 3>& towards_origin) {
  Candidate best;
  best.distance2 = std::numeric_limits<double>::infinity();
  for (std::size_t face = 0; face < 3; ++face)
    if (towards_origin[face])
      best = nearer(best, nearestOfTriangle(places, w, others[face], others[face == 2 ? 0 : face + 1]));
  return best;
}

Nearest chosen(const Candidate& candidate) {
  // A point at the origin has no normal of its own; the caller sees the distance and does not use it.
  const Vector3d normal =
      candidate.normal2 > 0.0 ? Vector3d(candidate.normal / std::sqrt(candidate.normal2)) : Vector3d(Vector3d::UnitX());
  return {std::sqrt(candidate.distance2), normal, candidate.subset, false};
}

}  // namespace

int Subset::freePlace() const {
  unsigned used = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) used |= 1u << places[i];
  int place = 0;
  while (used & (1u << place)) ++place;
  return place;
}

Simplex::Simplex(const Places& places, const Subset& subset) : size(subset.size) {
  double sum = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += subset.weights[i];
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) {
    vertices[i] = places[static_cast<std::size_t>(subset.places[i])];
    weights[i] = subset.weights[i] / sum;
  }
}

Vector3d Simplex::pointOnA() const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += weights[i] * vertices[i].on_a;
  return sum;
}

Vector3d Simplex::pointOnB() const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += weights[i] * vertices[i].onB();
  return sum;
}

Nearest nearestToOrigin(const Places& places, const Subset& subset, int newest) {
  const std::array<int, 4>& others = subset.places;
  switch (subset.size) {
    case 0:
      return chosen(nearestOfVertex(places, newest));
    case 1:
      return chosen(nearestOfEdge(places, newest, others[0]));
    case 2:
      return chosen(nearestOfTriangle(places, newest, others[0], others[1]));
    default:
      break;
  }
  const std::array<bool, 3> towards_origin = facesTowardsOrigin(places, newest, others);
  if (towards_origin[0] || towards_origin[1] || towards_origin[2])
    return chosen(nearestOfTetrahedron(places, newest, others, towards_origin));
  return {0.0, Vector3d::Zero(), {4, {others[0], others[1], others[2], newest}, {1.0, 1.0, 1.0, 1.0}}, true};
}

}  // namespace proximity_server
