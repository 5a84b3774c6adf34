#include "narrowphase/closed_form/parallel_axes.h"

#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = Shape::Kind;

// In vectors of the half plane, x is the radius and y the height.

/// The unit vector of any vector that is not zero, even if its square underflows.
Vector2d unitOf(const Vector2d& v) { return (v / v.cwiseAbs().maxCoeff()).normalized(); }

/// Half of the section of a core through its axis. The radius of a segment or a point is 0.
struct Profile {
  double radius, half;
  double apex;  ///< +1 or -1: the apex of a cone points up or down; 0: not a cone

  Profile(const Shape& shape, double up)
      : radius(shape.halfExtents().x()), half(shape.halfExtents().z()), apex(shape.kind() == Kind::Cone ? up : 0.0) {}

  Vector2d support(const Vector2d& n) const {
    if (apex == 0.0) return {radius, std::copysign(half, n.y())};
    const bool at_apex = 2.0 * half * apex * n.y() >= radius * n.x();
    return at_apex ? Vector2d(0.0, apex * half) : Vector2d(radius, -apex * half);
  }
  Vector2d slantNormal() const { return unitOf({2.0 * half, apex * radius}); }
};

/// The boundary of the sum of two profiles, from the lower end of the axis to the upper one. Edge i has the normal i,
/// and runs from corner i to corner i + 1. Each corner is stored as the sum of a corner of a and one of b.
class Boundary {
 public:
  Boundary(const Profile& a, const Profile& b) {
    normals_[0] = {0.0, -1.0};
    normals_[1] = {1.0, 0.0};
    if (a.apex != 0.0) normals_[++edges_] = a.slantNormal();
    if (b.apex != 0.0) normals_[++edges_] = b.slantNormal();
    normals_[++edges_] = {0.0, 1.0};
    ++edges_;
    // The slant of a cone that is nearly flat has the same y as an end; its x tells on which side of it.
    std::sort(normals_.begin(), normals_.begin() + edges_, [](const Vector2d& m, const Vector2d& n) {
      if (m.y() != n.y()) return m.y() < n.y();
      return m.y() < 0.0 ? m.x() < n.x() : m.x() > n.x();
    });
    addCorner({0.0, a.support(normals_.front()).y()}, {0.0, b.support(normals_.front()).y()});
    for (std::size_t i = 0; i + 1 < size(); ++i) {
      const Vector2d between = normals_[i] + normals_[i + 1];
      addCorner(a.support(between), b.support(between));
    }
    const Vector2d up = normals_[size() - 1];
    addCorner({0.0, a.support(up).y()}, {0.0, b.support(up).y()});
  }

  std::size_t size() const { return static_cast<std::size_t>(edges_); }
  const Vector2d& normal(std::size_t edge) const { return normals_[edge]; }
  Vector2d corner(std::size_t i) const { return of_a_[i] + of_b_[i]; }
  Vector2d cornerOfA(std::size_t i) const { return of_a_[i]; }
  double height(std::size_t edge, const Vector2d& p) const { return normals_[edge].dot(p - corner(edge)); }

  /// [m] Distance, along an edge, of p from the nearest point of the edge.
  double lateralDistance(std::size_t edge, const Vector2d& p) const {
    const Vector2d along = corner(edge + 1) - corner(edge);
    const Vector2d nearest = corner(edge) + place(edge, p) * along;
    return std::abs(normals_[edge].x() * (p - nearest).y() - normals_[edge].y() * (p - nearest).x());
  }

  /// The place on an edge, from 0 to 1, of the point nearest to p.
  double place(std::size_t edge, const Vector2d& p) const {
    const Vector2d along = corner(edge + 1) - corner(edge);
    const double size = along.cwiseAbs().maxCoeff();
    if (size == 0.0) return 0.0;
    const Vector2d scaled = along / size;  // its square does not underflow
    return std::clamp(scaled.dot(p - corner(edge)) / scaled.squaredNorm() / size, 0.0, 1.0);
  }

 private:
  void addCorner(const Vector2d& of_a, const Vector2d& of_b) {
    of_a_[corners_] = of_a;
    of_b_[corners_++] = of_b;
  }

  static constexpr std::size_t kMaxEdges = 5;  // two ends, the lateral surface, and the slants of two cones
  int edges_ = 1;
  int corners_ = 0;
  std::array<Vector2d, kMaxEdges> normals_;
  std::array<Vector2d, kMaxEdges + 1> of_a_, of_b_;
};

/// The point of the boundary nearest to p; p lies at this point plus distance * normal.
struct Nearest2d {
  double distance;
  Vector2d normal;
  Vector2d of_a;
  bool unique;
};

Nearest2d onEdge(const Boundary& boundary, std::size_t edge, const Vector2d& p, double tolerance) {
  PROXIMITY_ASSERT(edge < boundary.size(),
                   "The boundary has no such edge: edges have the numbers of their first corners.");
  const double distance = boundary.height(edge, p);
  const double place = boundary.place(edge, p);
  bool unique = true;
  for (std::size_t other = 0; other < boundary.size(); ++other)
    unique =
        unique && (boundary.normal(other) == boundary.normal(edge) || boundary.height(other, p) < distance - tolerance);
  return {distance, boundary.normal(edge),
          boundary.cornerOfA(edge) + place * (boundary.cornerOfA(edge + 1) - boundary.cornerOfA(edge)), unique};
}

double cross(const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

/// The direction of `difference`, limited to the range between the normals of the edges that meet in the corner: if p
/// is near the corner, rounding may turn the difference out of this range. Edges of length 0 are skipped.
Vector2d cornerNormal(const Boundary& boundary, std::size_t corner, const Vector2d& difference) {
  std::size_t before = corner, after = corner;
  while (before > 0 && boundary.corner(before - 1) == boundary.corner(corner)) --before;
  while (after < boundary.size() && boundary.corner(after + 1) == boundary.corner(corner)) ++after;
  const Vector2d n = unitOf(difference);
  if (before > 0 && !(cross(boundary.normal(before - 1), n) > 0.0)) return boundary.normal(before - 1);
  if (after < boundary.size() && !(cross(n, boundary.normal(after)) > 0.0)) return boundary.normal(after);
  return n;
}

/// [m] A bound of the rounding of the height of p over an edge.
double roundingOf(const Boundary& boundary, const Vector2d& p) {
  double reach = p.lpNorm<1>();
  for (std::size_t edge = 0; edge < boundary.size(); ++edge) reach = std::max(reach, boundary.corner(edge).lpNorm<1>());
  return 8.0 * std::numeric_limits<double>::epsilon() * reach;
}

/// True if p lies over the nearest point of an edge, within rounding. False if the length of the edge is lost in
/// rounding; then its corners are equally near.
bool isOver(const Boundary& boundary, std::size_t edge, const Vector2d& p, double height) {
  return std::hypot(height, boundary.lateralDistance(edge, p)) - height <= roundingOf(boundary, p);
}

/// Takes the corner over which p lies along the normal: other corners may be equally near, within rounding.
Nearest2d nearestOutside(const Boundary& boundary, const Vector2d& p) {
  Nearest2d nearest{std::numeric_limits<double>::infinity(), {}, {}, true};
  double smallest_lateral = std::numeric_limits<double>::infinity();
  for (std::size_t edge = 0; edge < boundary.size(); ++edge) {
    const double height = boundary.height(edge, p);
    if (!(height > 0.0)) continue;  // p lies on the inner side of this edge
    const double place = boundary.place(edge, p);
    const Vector2d of_a = boundary.cornerOfA(edge) + place * (boundary.cornerOfA(edge + 1) - boundary.cornerOfA(edge));
    // A nearest point inside of an edge is the nearest of all; rounding may make a corner seem nearer.
    if (place > 0.0 && place < 1.0 && isOver(boundary, edge, p, height))
      return {height, boundary.normal(edge), of_a, true};
    const std::size_t corner = edge + (place > 0.0 ? 1 : 0);
    const Vector2d difference = p - boundary.corner(corner);
    const Vector2d normal = cornerNormal(boundary, corner, difference);
    const double distance = difference.norm(), lateral = (difference - distance * normal).norm();
    if (!(lateral < smallest_lateral)) continue;
    smallest_lateral = lateral;
    nearest = {distance, normal, of_a, true};
  }
  return nearest;
}

/// The edge with the greatest height of p over it. Among edges with the same height within rounding, it is the one
/// whose nearest point is closest to the foot of p.
std::size_t edgeUnder(const Boundary& boundary, const Vector2d& p) {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t edge = 0; edge < boundary.size(); ++edge) highest = std::max(highest, boundary.height(edge, p));
  const double rounding = roundingOf(boundary, p);
  std::size_t best = 0;
  double smallest_lateral = std::numeric_limits<double>::infinity();
  for (std::size_t edge = 0; edge < boundary.size(); ++edge) {
    if (boundary.height(edge, p) < highest - rounding) continue;
    const double lateral = boundary.lateralDistance(edge, p);
    if (!(lateral < smallest_lateral)) continue;
    smallest_lateral = lateral;
    best = edge;
  }
  return best;
}

Nearest2d nearestOnBoundary(const Boundary& boundary, const Vector2d& p, double tolerance) {
  PROXIMITY_ASSERT(boundary.size() > 0, "The boundary has no edge: the difference of two profiles has at least one.");
  const std::size_t edge = edgeUnder(boundary, p);
  if (boundary.height(edge, p) <= 0.0) return onEdge(boundary, edge, p, tolerance);
  return nearestOutside(boundary, p);
}

/// depthOfTiltedAxes() with a as the straight solid and b as the tilted one.
double depthOfTilted(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  const double up = std::copysign(1.0, a_T_b.linear()(2, 2));
  const Vector3d axis = up * a_T_b.linear().col(2), origin = -a_T_b.translation();
  const Boundary boundary(Profile(a, 1.0), Profile(b, -up));
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t corner = 1; corner < boundary.size(); ++corner) {
    const Vector2d of_a = boundary.cornerOfA(corner), of_b = boundary.corner(corner) - of_a;
    const Vector2d point(of_a.x() + axis.z() * of_b.x(), of_a.y() + axis.z() * of_b.y() + origin.z());
    const Vector2d from_radius = origin.head<2>() + of_b.y() * axis.head<2>(), from_height = of_b.x() * axis.head<2>();
    for (const std::size_t edge : {corner - 1, corner}) {
      const Vector2d& n = boundary.normal(edge);
      depth = std::min(depth, n.dot(point) - (n.x() * from_radius - n.y() * from_height).norm());
    }
  }
  return depth;
}

}  // namespace

double axesTilt(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  if (a.kind() == Kind::Point || b.kind() == Kind::Point) return 0.0;
  return a_T_b.linear().col(2).head<2>().norm();
}

SignedDistance parallelAxesDistance(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double tolerance) {
  const Vector3d axis_b = a_T_b.linear().col(2), t = a_T_b.translation();
  const Vector3d axis = a.kind() == Kind::Point ? Vector3d(axis_b.normalized()) : Vector3d(Vector3d::UnitZ());
  const auto acrossAxis = [&](const Vector3d& v) { return Vector3d(v - v.dot(axis) * axis); };
  const Vector3d across = acrossAxis(t);
  const double radius = across.norm();
  // Projected twice: the first projection leaves the rounding error of a long vector in a short one.
  const Vector3d kept = radius > 0.0 ? acrossAxis(across / radius) : Vector3d(Vector3d::Zero());
  const Vector3d outwards = kept.norm() > 0.5 ? Vector3d(kept.normalized()) : Vector3d(axis.unitOrthogonal());
  const auto inSpace = [&](const Vector2d& p) { return Vector3d(p.x() * outwards + p.y() * axis); };

  // The sum of the profiles is the profile of a + (-b) about the centre of a. In it, the origin of the CSO lies at b's
  // centre.
  const Boundary boundary(Profile(a, 1.0), Profile(b, -std::copysign(1.0, axis_b.dot(axis))));
  const Nearest2d nearest = nearestOnBoundary(boundary, {radius, t.dot(axis)}, tolerance);

  SignedDistance result;
  result.distance = nearest.distance;
  result.normal = inSpace(nearest.normal).normalized();
  result.point_a = inSpace(nearest.of_a);
  result.point_b = result.point_a + result.distance * result.normal;
  const bool ring = nearest.normal.x() * radius <= 0.5 * tolerance && nearest.normal.x() > 0.0;
  result.unique = nearest.unique && !(ring && nearest.distance <= tolerance);
  return result;
}

double depthOfTiltedAxes(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  return std::max(depthOfTilted(a, b, a_T_b), depthOfTilted(b, a, a_T_b.inverse()));
}

}  // namespace proximity_server::narrowphase
