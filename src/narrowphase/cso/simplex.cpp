#include "narrowphase/cso/simplex.h"

#include "narrowphase/shape/triangle.h"
#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// The nearest point of one face of the simplex (a vertex, an edge or a triangle), before any square root is taken.
struct Candidate {
  Vector3d normal;   ///< from the face to the origin, of any length
  double normal2;    ///< its squared norm
  double height;     ///< [m] of the origin over the face, times the length of the normal
  unsigned members;  ///< vertices of the face, one bit each
};

// The quotient first: the square of the height underflows where lengths are 1e-30 m.
double distance2(const Candidate& c) { return c.height / c.normal2 * c.height; }
const Candidate& nearer(const Candidate& a, const Candidate& b) { return distance2(a) <= distance2(b) ? a : b; }

/// An edge of 1e-48 m is shorter than the rounding of lengths from 1e-30 m on: its ends are as near as any of its
/// points. The squares of shorter edges, and of smaller triangles, would lose digits.
constexpr double kShortestEdge2 = 1e-96;                            // [m^2]
constexpr double kSmallestArea2 = kShortestEdge2 * kShortestEdge2;  // [m^4]

unsigned bit(int place) { return 1u << place; }

Candidate nearestOfVertex(const Simplex& simplex, int w) {
  const Vector3d& p = simplex[w].point;
  const double norm2 = p.squaredNorm();
  return {-p, norm2, norm2, bit(w)};
}

/// The line through w and a has the points p = l_w w + l_a a with l_w + l_a = 1. In the nearest one, p is perpendicular
/// to the edge e = a - w:
///
///   [ 1      1     ] [ l_w ]   [ 1 ]
///   [ w . e  a . e ] [ l_a ] = [ 0 ]
///
/// The determinant is e . e, and so l_a = -(w . e) / (e . e) and l_w = (a . e) / (e . e) = 1 - l_a. The signs of both
/// tell the region in which the origin lies:
///
///   region w:  l_a <= 0
///   region a:  l_w <= 0
///   region wa: both are positive; p lies inside of the edge
///
/// In region wa the normal is (w x e) x e = (w . e) e - (e . e) w = -(e . e) p, which leads from p to the origin. As
/// |w x e|^2 = (e . e) (p . p), this is the height |p| times the length of the normal.
Candidate nearestOfEdge(const Simplex& simplex, int w, int a) {
  const Vector3d& pw = simplex[w].point;
  const Vector3d edge = simplex[a].point - pw;
  const double of_a = -pw.dot(edge);                      // l_a, times the square of the edge
  if (!(of_a > 0.0)) return nearestOfVertex(simplex, w);  // region w
  const double edge2 = edge.squaredNorm();
  if (!(of_a < edge2)) return nearestOfVertex(simplex, a);         // region a
  if (edge2 < kShortestEdge2) return nearestOfVertex(simplex, w);  // the edge has no direction
  // Region wa. By products, as a projection would wait for a division, and leave the rounding error of a long vector in
  // a short one.
  const Vector3d moment = pw.cross(edge), normal = moment.cross(edge);
  return {normal, normal.squaredNorm(), moment.squaredNorm(), bit(w) | bit(a)};
}

/// Area vector of a triangle, and the barycentric weights of the point of its plane nearest to the origin, times the
/// squared area.
///
/// The plane has the points p = l_w w + l_a a + l_b b with l_w + l_a + l_b = 1. In the nearest one, p is perpendicular
/// to two edges, and so parallel to their product, the area vector n = (a - w) x (b - w):
///
///   [ 1            1            1           ] [ l_w ]   [ 1 ]
///   [ w . (a - w)  a . (a - w)  b . (a - w) ] [ l_a ] = [ 0 ]
///   [ w . (b - w)  a . (b - w)  b . (b - w) ] [ l_b ]   [ 0 ]
///
/// The determinant is n . n. A weight is the part of the area that p spans with the opposite edge, the weight of w
/// n . ((a - p) x (b - p)) / (n . n); the terms with p vanish, as p is parallel to n:
///
///   l_w (n . n) = n . (a x b),   l_a (n . n) = n . (b x w),   l_b (n . n) = n . (w x a)
///
/// Their sum is n . n. Each product is taken with an edge in place of one of its vertices, a x b = a x (b - a), so that
/// it does not cancel far from the origin.
struct Areas {
  Vector3d area;
  double of_w, of_a, of_b;  ///< l_w, l_a and l_b, times n . n

  Areas(const Vector3d& w, const Vector3d& a, const Vector3d& b) {
    const Vector3d wa = a - w, ab = b - a, bw = w - b;
    area = areaVector(wa, ab, bw);
    of_w = area.dot(a.cross(ab));
    of_a = area.dot(w.cross(bw));
    of_b = area.dot(w.cross(wa));
  }
};

/// The signs of the weights tell where p, the point of the plane nearest to the origin, lies:
///
///   region wab: all are positive; p is inside of the triangle, and nearest
///   region wa:  only l_b <= 0; p lies beyond the line w a only, so that the nearest point is on this edge
///   region wb:  only l_a <= 0; likewise
///   the others: p lies beyond two lines, or beyond a b. The edge a b was there before w was found, and cannot be
///               nearer than the nearest point was then; so it is the nearer point of the edges w a and w b.
///
/// In region wab the normal is the area vector, towards the origin, and the height times its length is |n . w|.
Candidate nearestOfTriangle(const Simplex& simplex, int w, int a, int b) {
  const Areas areas(simplex[w].point, simplex[a].point, simplex[b].point);
  const double area2 = areas.area.squaredNorm();
  // Region wab
  if (areas.of_w > 0.0 && areas.of_a > 0.0 && areas.of_b > 0.0 && area2 > kSmallestArea2) {
    const double height = -areas.area.dot(simplex[w].point);
    return {height < 0.0 ? Vector3d(-areas.area) : areas.area, area2, std::abs(height), bit(w) | bit(a) | bit(b)};
  }
  if (areas.of_a > 0.0 && areas.of_w > 0.0) return nearestOfEdge(simplex, w, a);  // region wa
  if (areas.of_b > 0.0 && areas.of_w > 0.0) return nearestOfEdge(simplex, w, b);  // region wb
  return nearer(nearestOfEdge(simplex, w, a), nearestOfEdge(simplex, w, b));
}

/// The rounding error of a triple product of x, y, z is at most this times |x| |y| |z|, to first order in eps. |x|_1
/// may be used for |x|, as it is never less.
constexpr double kTripleProduct = 6.0 * std::numeric_limits<double>::epsilon();

/// For each of the faces w a b, w b c, w c a: false only if the origin surely lies on the inner side of the face.
///
/// With a, b and c relative to w, the determinant (a x b) . c is the volume, times six. Its sign is the side of the
/// plane w a b on which c lies: the inner side. The origin is at -w, so it lies there too if (a x b) . -w has the same
/// sign. The planes w b c and w c a follow by turning the letters, which leaves the determinant as it is. A sign counts
/// if it exceeds the rounding error; if the sign of the volume does not, no side is known.
struct FacesTowardsOrigin {
  bool wab, wbc, wca;
};

FacesTowardsOrigin facesTowardsOrigin(const Simplex& simplex, int w, int pa, int pb, int pc) {
  const Vector3d& pw = simplex[w].point;
  const Vector3d a = simplex[pa].point - pw, b = simplex[pb].point - pw, c = simplex[pc].point - pw;
  const Vector3d ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
  constexpr double k = kTripleProduct;
  const double na = a.lpNorm<1>(), nb = b.lpNorm<1>(), nc = c.lpNorm<1>(), nw = pw.lpNorm<1>();
  const double volume = ab.dot(c);
  if (std::abs(volume) <= k * na * nb * nc) return {true, true, true};
  const double side = volume > 0.0 ? 1.0 : -1.0;
  return {!(side * ab.dot(pw) < -k * na * nb * nw), !(side * bc.dot(pw) < -k * nb * nc * nw),
          !(side * ca.dot(pw) < -k * nc * na * nw)};
}

/// The nearest point of the faces that may have the origin on their outer side. It has no members if there are none:
/// region wabc, inside of the tetrahedron. The face a b c was there before w was found, with the origin on the side of
/// w.
Candidate nearestOfTetrahedron(const Simplex& simplex, int w, int a, int b, int c) {
  const FacesTowardsOrigin faces = facesTowardsOrigin(simplex, w, a, b, c);
  Candidate best{Vector3d::Zero(), 1.0, std::numeric_limits<double>::infinity(), 0};
  if (faces.wab) best = nearestOfTriangle(simplex, w, a, b);
  if (faces.wbc) best = nearer(best, nearestOfTriangle(simplex, w, b, c));
  if (faces.wca) best = nearer(best, nearestOfTriangle(simplex, w, c, a));
  return best;
}

/// The places of the members of a simplex, lowest first. The table is indexed by the bits of Simplex::members.
struct Members {
  int count;
  std::array<int, 4> places;
};
constexpr std::array<Members, 16> kMembers{{{0, {}},
                                            {1, {0}},
                                            {1, {1}},
                                            {2, {0, 1}},
                                            {1, {2}},
                                            {2, {0, 2}},
                                            {2, {1, 2}},
                                            {3, {0, 1, 2}},
                                            {1, {3}},
                                            {2, {0, 3}},
                                            {2, {1, 3}},
                                            {3, {0, 1, 3}},
                                            {2, {2, 3}},
                                            {3, {0, 2, 3}},
                                            {3, {1, 2, 3}},
                                            {4, {0, 1, 2, 3}}}};

Candidate nearestOf(const Simplex& simplex, int newest) {
  const auto& [count, others] = kMembers[simplex.members];
  switch (count) {
    case 0:
      return nearestOfVertex(simplex, newest);
    case 1:
      return nearestOfEdge(simplex, newest, others[0]);
    case 2:
      return nearestOfTriangle(simplex, newest, others[0], others[1]);
    default:
      return nearestOfTetrahedron(simplex, newest, others[0], others[1], others[2]);
  }
}

double longestEdge2(const CsoVertex& w, const CsoVertex& a, const CsoVertex& b) {
  return std::max(
      {(a.point - w.point).squaredNorm(), (b.point - a.point).squaredNorm(), (w.point - b.point).squaredNorm()});
}

/// The weight of a is l_a of nearestOfEdge().
WitnessPoints pointsOfEdge(const CsoVertex& w, const CsoVertex& a) {
  const Vector3d edge = a.point - w.point;
  const double of_a = std::clamp(-w.point.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  return {w.on_a + of_a * (a.on_a - w.on_a), w.onB() + of_a * (a.onB() - w.onB())};
}

/// The point of a triangle nearest to the origin, if its plane has it inside of the triangle; otherwise a point of the
/// triangle.
///
/// With e = q - p, s = r - p and the foot f = (s . e) / (e . e) of r on the edge, the height h = s - f e is
/// perpendicular to e. A point p + l_q e + l_r s = p + (l_q + l_r f) e + l_r h is nearest to the origin if its parts
/// along e and h are the parts of -p:
///
///   l_r = -(p . h) / (h . h),   l_q = -(p . e) / (e . e) - l_r f
///
/// So the places are in units of the edge and the height: the error of the point is a few eps of the edge, however
/// small the height is.
WitnessPoints pointsAcrossEdge(const CsoVertex& p, const CsoVertex& q, const CsoVertex& r) {
  const Vector3d edge = q.point - p.point, side = r.point - p.point;
  const double edge2 = edge.squaredNorm();
  const double foot_of_r = side.dot(edge) / edge2, foot_of_origin = -p.point.dot(edge) / edge2;
  const Vector3d height = side - foot_of_r * edge, of_origin = -p.point - foot_of_origin * edge;
  const double of_r = std::clamp(of_origin.dot(height) / height.squaredNorm(), 0.0, 1.0);
  const double of_q = std::clamp(foot_of_origin - of_r * foot_of_r, 0.0, 1.0 - of_r);
  return {p.on_a + of_q * (q.on_a - p.on_a) + of_r * (r.on_a - p.on_a),
          p.onB() + of_q * (q.onB() - p.onB()) + of_r * (r.onB() - p.onB())};
}

}  // namespace

Nearest nearestToOrigin(const Simplex& simplex, int newest) {
  PROXIMITY_ASSERT(!simplex.has(newest), "The newest place is a member already: take it from freePlace().");
  const Candidate nearest = nearestOf(simplex, newest);
  if (nearest.members == 0) return {0.0, Vector3d::Zero(), 0.0, simplex.members | bit(newest), true};
  // A nearest point at the origin has no direction; the caller sees the distance 0 and does not use the direction.
  if (!(nearest.normal2 > 0.0)) return {0.0, Vector3d::UnitX(), 1.0, nearest.members, false};
  const double scale = 1.0 / std::sqrt(nearest.normal2);
  return {nearest.height * scale, nearest.normal, scale, nearest.members, false};
}

double enclosedRadius(const Simplex& tetrahedron) {
  PROXIMITY_ASSERT(
      tetrahedron.members == 0b1111,
      "The simplex is no tetrahedron: ask only after nearestToOrigin() has found that it encloses the origin.");
  const Vector3d &o = tetrahedron[3].point, &p = tetrahedron[0].point;
  const Vector3d a = p - o, b = tetrahedron[1].point - o, c = tetrahedron[2].point - o;
  const double na = a.norm(), nb = b.norm(), nc = c.norm();
  const double outwards = std::copysign(1.0, a.dot(b.cross(c)));
  const auto distance = [outwards](const Vector3d& area, const Vector3d& point, double sizes) {
    return (outwards * area.dot(point) - kTripleProduct * sizes * point.norm()) / area.norm();
  };
  return std::min({distance(b.cross(a), o, na * nb), distance(c.cross(b), o, nb * nc), distance(a.cross(c), o, nc * na),
                   distance((b - a).cross(c - a), p, (na + nb) * (na + nc))});
}

WitnessPoints pointsOfTriangle(const CsoVertex& w, const CsoVertex& a, const CsoVertex& b) {
  const WitnessPoints candidates[] = {pointsAcrossEdge(w, a, b), pointsAcrossEdge(a, b, w), pointsAcrossEdge(b, w, a),
                                      pointsOfEdge(w, a),        pointsOfEdge(a, b),        pointsOfEdge(b, w)};
  WitnessPoints best{w.on_a, w.onB()};
  // Written so that NaN, of an edge or a height without length, is not taken.
  for (const WitnessPoints& points : candidates)
    if ((points.on_a - points.on_b).squaredNorm() < (best.on_a - best.on_b).squaredNorm()) best = points;
  return best;
}

WitnessPoints witnessPoints(const Simplex& simplex) {
  PROXIMITY_ASSERT(simplex.members != 0 && simplex.members != 0b1111,
                   "The simplex is empty or a tetrahedron: reduce it by nearestToOrigin() first.");
  const auto& [count, places] = kMembers[simplex.members];
  const CsoVertex &w = simplex[places[0]], &a = simplex[places[1]], &b = simplex[places[2]];
  if (count == 1) return {w.on_a, w.onB()};
  if (count == 2) return pointsOfEdge(w, a);
  // The corners are in another order than in nearestToOrigin(), so that rounding may change the sign of a weight.
  const Areas areas(w.point, a.point, b.point);
  if (isNeedle(areas.area, longestEdge2(w, a, b))) return pointsOfTriangle(w, a, b);
  const Vector3d weights = Vector3d(areas.of_w, areas.of_a, areas.of_b).cwiseMax(0.0);
  const Vector3d parts = weights / weights.sum();
  const double of_w = parts.x(), of_a = parts.y(), of_b = parts.z();
  return {of_w * w.on_a + of_a * a.on_a + of_b * b.on_a, of_w * w.onB() + of_a * a.onB() + of_b * b.onB()};
}

}  // namespace proximity_server::narrowphase
