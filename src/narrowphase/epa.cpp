#include "proximity_server/narrowphase/epa.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polytope.h"
#include "refinement.h"
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

/// What Newton's method makes of a direction, with the depth along it; nothing where it misses a piece.
struct Refined {
  Stationary stationary;
  double depth;
};
std::optional<Refined> refined(Cso& cso, const Simplex& simplex, const Vector3d& normal) {
  const std::optional<Stationary> stationary = refine(cso, simplex, normal);
  if (!stationary) return std::nullopt;
  const double depth = stationary->normal.dot(cso.vertex(stationary->normal).point);
  if (depth - stationary->height > cso.rounding()) return std::nullopt;
  return Refined{*stationary, depth};
}

void setDirection(const Refined& direction, EpaResult& result) {
  result.depth = direction.depth;
  result.normal = direction.stationary.normal;
  result.has_normal = result.has_points = true;
  result.point_a = direction.stationary.points.on_a;
  result.point_b = direction.stationary.points.on_b;
}

EpaResult onSurface(Cso& cso, const Simplex& simplex, const SurfacePlane& plane, const Options& options) {
  const WitnessPoints witnesses = witnessPoints(simplex);
  EpaResult result;
  result.depth = plane.depth;
  result.normal = plane.normal;
  result.has_normal = result.has_points = true;
  result.point_a = witnesses.on_a;
  result.point_b = witnesses.on_b;
  if (!cso.isPolytope()) {
    const std::optional<Refined> direction = refined(cso, simplex, plane.normal);
    if (direction && direction->depth <= plane.depth + cso.rounding()) setDirection(*direction, result);
  }
  result.lower_bound = std::min(result.depth, 0.0) - cso.rounding();
  const bool converged = result.depth + cso.rounding() - result.lower_bound <= options.distance_tolerance;
  result.status = converged ? Status::Converged : Status::Degenerate;
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
      if (!(face.area.dot(result.normal) > 0.0)) return;
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
    const bool is_as_close = face.isCloserThan(result.depth + options.distance_tolerance) &&
                             !face.isCloserThan(result.depth - options.distance_tolerance);
    if (is_as_close && (face.normal() - result.normal).squaredNorm() > kSameDirection * kSameDirection) unique = false;
  });
  return unique;
}

/// The shallowest direction known so far, and the caps of directions that are proven to be no shallower than some depth
/// that was known when they were found.
class Shallowest {
 public:
  explicit Shallowest(EpaResult& result) : result_(result) {}

  /// Newton's method from a face of a curved CSO that reaches no deeper than what is known.
  void refineFrom(Cso& cso, const Polytope& polytope, const Polytope::Face& face) {
    Simplex simplex;
    for (int i = 0; i < 3; ++i) simplex[i] = polytope.vertex(face.vertices[static_cast<std::size_t>(i)]);
    simplex.members = 0b111;
    const std::optional<Refined> direction = refined(cso, simplex, face.normal());
    if (!direction) return;
    const Stationary& stationary = direction->stationary;
    if (stationary.cos_proven < 1.0 && caps_ < kMostCaps)
      proven_[static_cast<std::size_t>(caps_++)] = {stationary.normal, stationary.cos_proven};
    // Of two directions as good as each other, the one that has points.
    const double limit = result_.depth + (result_.has_points ? 0.0 : cso.rounding());
    if (direction->depth < limit) setDirection(*direction, result_);
  }

  /// Whether what the polytope leaves open about a face lies in one proven cap.
  ///
  /// Open are the directions in which no vertex of the polytope reaches as far as the depth. They surround the normals
  /// of the faces closer than that, and end on the way to the normal of any neighbour that is not. All of that in one
  /// cap, which is convex, leaves nothing open.
  bool isProven(const Polytope& polytope, const Polytope::Face& face) const {
    return std::any_of(proven_.begin(), proven_.begin() + caps_,
                       [&](const Cap& cap) { return holds(cap, polytope, face); });
  }

 private:
  static constexpr int kMostCaps = 8;
  struct Cap {
    Vector3d normal;
    double cosine;
  };

  bool holds(const Cap& cap, const Polytope& polytope, const Polytope::Face& face) const {
    constexpr std::size_t kMostFaces = 16;
    std::array<const Polytope::Face*, kMostFaces> closer{&face};
    std::size_t count = 1;
    for (std::size_t i = 0; i < count; ++i) {
      const double distance = closer[i]->distance(), inside = closer[i]->normal().dot(cap.normal);
      if (!(inside > cap.cosine)) return false;
      for (std::size_t edge = 0; edge < 3; ++edge) {
        const Polytope::Face& next = polytope.neighbour(*closer[i], edge);
        if (next.isCloserThan(result_.depth)) {
          if (std::find(closer.begin(), closer.begin() + count, &next) != closer.begin() + count) continue;
          if (count == kMostFaces) return false;
          closer[count++] = &next;
          continue;
        }
        // The edge reaches as far as the depth before the direction that divides the normals like the distances.
        const double part = (result_.depth - distance) / (next.distance() - distance);
        if (!next.hasNormal() || !((1.0 - part) * inside + part * next.normal().dot(cap.normal) > cap.cosine))
          return false;
      }
    }
    return true;
  }

  EpaResult& result_;
  int caps_ = 0;
  std::array<Cap, kMostCaps> proven_;
};

/// Of the depth: a face that does not reach as far knows too little of the smooth pieces.
constexpr double kWorthRefining = 0.6;

EpaResult expandPolytope(Cso& cso, const Start& tetrahedron, const Options& options) {
  Polytope polytope(tetrahedron.vertices, cso.rounding());
  EpaResult result;
  result.has_normal = result.has_points = false;
  result.depth = std::numeric_limits<double>::infinity();
  Shallowest shallowest(result);
  // The polytope, the support plane and a proven cap are each within rounding of what they stand for.
  const auto gap = [&] { return result.depth + cso.rounding() - result.lower_bound; };
  // The depth that Newton's method found is better than what is left to prove of it.
  const auto isFinal = [&, final_gap = cso.finalGap(options.distance_tolerance)] {
    return gap() <= (result.has_points ? options.distance_tolerance : final_gap);
  };
  const auto end = [&](Status status, const Polytope::Face* face) {
    const bool converged = status != Status::Threshold && gap() <= options.distance_tolerance;
    result.status = converged ? Status::Converged : status;
    if (!result.has_normal) return result;
    if (!result.has_points) setWitnesses(polytope, face, options, result);
    result.unique = isUnique(polytope, result, options);
    return result;
  };

  for (result.iterations = 1;; ++result.iterations) {
    const Polytope::Face* face = polytope.closest();
    while (face != nullptr && shallowest.isProven(polytope, *face)) {
      polytope.setClosestAside();
      face = polytope.closest();
    }
    const double reach = face != nullptr ? face->distance() : result.depth;
    result.lower_bound = std::min(reach, result.depth) - cso.rounding();
    if (-result.lower_bound <= options.stop_below) return end(Status::Threshold, nullptr);
    if (isFinal()) return end(Status::Converged, nullptr);
    if (face == nullptr) return end(Status::Degenerate, nullptr);

    const Vector3d normal = face->normal();
    const CsoVertex w = cso.vertex(normal);
    const double depth = normal.dot(w.point);
    // What Newton's method found, with its points, is not given up for less than rounding.
    if (depth < result.depth - (result.has_points ? cso.rounding() : 0.0)) {
      result.depth = depth;
      result.normal = normal;
      result.has_normal = true;
      result.has_points = false;
      if (isFinal()) return end(Status::Converged, face);
    }
    if (-(result.depth + cso.rounding()) > options.stop_above) return end(Status::Threshold, nullptr);
    if (result.iterations >= options.max_iterations || polytope.full()) return end(Status::IterationLimit, nullptr);
    const bool is_near = reach > kWorthRefining * depth;
    if (!cso.isPolytope() && is_near && !(depth > result.depth)) shallowest.refineFrom(cso, polytope, *face);
    if (polytope.hasCorner(*face, w)) return end(Status::Degenerate, nullptr);
    if (!polytope.expand(*face, w, result.depth)) return end(Status::Degenerate, nullptr);
  }
}

/// The depth is at least `lower_bound`, and nobody asks for more.
EpaResult decidedBy(double lower_bound) {
  EpaResult result;
  result.status = Status::Threshold;
  result.lower_bound = lower_bound;
  result.has_normal = result.has_points = false;
  result.iterations = 0;
  return result;
}

}  // namespace

EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options) {
  if (simplex.members == 0b1111 && std::isfinite(options.stop_below)) {
    const double enclosed = enclosedRadius(simplex) - cso.rounding();
    if (-enclosed <= options.stop_below) return decidedBy(enclosed);
  }
  Start start(simplex);
  const auto onPlane = [&](const SurfacePlane& plane) { return onSurface(cso, simplex, plane, options); };
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
