#include "narrowphase/closed_form/points_segments.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;
using Kind = Shape::Kind;

constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();

SignedDistance along(double distance, const Vector3d& normal, const Vector3d& point_a, const Vector3d& point_b) {
  SignedDistance result;
  result.distance = distance;
  result.normal = normal;
  result.point_a = point_a;
  result.point_b = point_b;
  return result;
}

/// Signed distance between two points. If they coincide, every normal is right, and `free_axis` is taken.
SignedDistance between(const Vector3d& point_a, const Vector3d& point_b, const Vector3d& free_axis) {
  const Vector3d difference = point_b - point_a;
  const double distance = difference.norm();
  if (distance > 0.0) return along(distance, difference / distance, point_a, point_b);
  SignedDistance result = along(0.0, free_axis, point_a, point_b);
  result.unique = false;
  return result;
}

Vector3d without(const Vector3d& unit, const Vector3d& v) { return v - unit.dot(v) * unit; }

/// The unit vector perpendicular to `unit` in the plane of `unit` and the unit vector v. It is accurate for nearly
/// parallel vectors, too, and zero for parallel ones.
Vector3d acrossInPlane(const Vector3d& unit, const Vector3d& v) {
  const Vector3d once = without(unit, v);
  const double sine = once.norm();
  return sine > kRounding ? Vector3d(without(unit, once / sine).normalized()) : Vector3d(Vector3d::Zero());
}

/// A unit vector perpendicular to both segments, or perpendicular to the longer one if the other is a point or
/// parallel.
Vector3d across(const Vector3d& u, const Vector3d& v) {
  const bool u_is_longer = u.squaredNorm() >= v.squaredNorm();
  const Vector3d along = (u_is_longer ? u : v).normalized(), other = (u_is_longer ? v : u).normalized();
  if (along.isZero()) return Vector3d::UnitX();
  const Vector3d in_plane = acrossInPlane(along, other);
  return in_plane.isZero() ? Vector3d(along.unitOrthogonal()) : Vector3d(along.cross(in_plane).normalized());
}

/// A segment, stored by its centre and the vector from there to one end.
struct Segment {
  Vector3d centre, half;

  /// The place nearest to a point, from -1 (one end) to 1 (the other end).
  double nearest(const Vector3d& point) const {
    const double length2 = half.squaredNorm();
    return length2 > 0.0 ? std::clamp(half.dot(point - centre) / length2, -1.0, 1.0) : 0.0;
  }
  Vector3d at(double s) const { return centre + s * half; }
};

struct Places {
  double on_a, on_b;
};

/// The nearest places of two segments. They lie on the common perpendicular if it meets both segments; otherwise one of
/// them is an end. All four ends are tried, which is correct for parallel segments, too.
Places nearestPlaces(const Segment& a, const Segment& b) {
  Places best{};
  double best_distance2 = std::numeric_limits<double>::infinity();
  const auto offer = [&](double on_a, double on_b) {
    const double distance2 = (b.at(on_b) - a.at(on_a)).squaredNorm();
    if (distance2 < best_distance2) {
      best_distance2 = distance2;
      best = {on_a, on_b};
    }
  };
  const Vector3d normal = a.half.cross(b.half);
  const double normal2 = normal.squaredNorm();
  if (normal2 > 0.0) {
    const Vector3d offset = b.centre - a.centre;
    const double on_a = offset.cross(b.half).dot(normal) / normal2, on_b = offset.cross(a.half).dot(normal) / normal2;
    if (std::abs(on_a) <= 1.0 && std::abs(on_b) <= 1.0) offer(on_a, on_b);
  }
  for (const double end : {-1.0, 1.0}) {
    offer(end, b.nearest(a.at(end)));
    offer(a.nearest(b.at(end)), end);
  }
  return best;
}

/// [m] Gap between the support planes of two segments along a unit normal.
double gapAlong(const Segment& a, const Segment& b, const Vector3d& normal) {
  return normal.dot(b.centre - a.centre) - std::abs(normal.dot(a.half)) - std::abs(normal.dot(b.half));
}

/// Corrects the normal of segments that nearly touch. The difference of their points is then mostly rounding, which
/// tilts the normal along the segments. The candidates are the normal made perpendicular to one or both segments, and
/// the common perpendicular; the one with the widest gap is taken, and its gap is the lower bound.
SignedDistance nearlyTouching(const Segment& a, const Segment& b, SignedDistance result) {
  const Vector3d along_a = a.half.normalized(), along_b = b.half.normalized(), free = across(a.half, b.half);
  const Vector3d across_a = without(along_a, result.normal), across_b = without(along_b, result.normal);
  const Vector3d across_both = without(acrossInPlane(along_a, along_b), across_a);
  result.lower_bound = gapAlong(a, b, result.normal);
  for (const Vector3d& candidate : {free, Vector3d(-free), across_a, across_b, across_both}) {
    const double length = candidate.norm();
    if (!(length > kRounding)) continue;
    const Vector3d once = candidate / length;
    const double gap = gapAlong(a, b, once);
    if (!(gap > result.lower_bound)) continue;
    result.lower_bound = gap;
    result.normal = once;
  }
  result.unique = result.distance > kRounding * (a.half.lpNorm<1>() + b.half.lpNorm<1>());
  return result;
}

SignedDistance segmentSegment(const Segment& a, const Segment& b) {
  const Places places = nearestPlaces(a, b);
  SignedDistance result = between(a.at(places.on_a), b.at(places.on_b), Vector3d::UnitX());
  // Beyond a tenth of the sizes the rounding of the points does not tilt the normal noticeably.
  const bool near = result.distance < 0.1 * (a.half.lpNorm<1>() + b.half.lpNorm<1>());
  if (near) return nearlyTouching(a, b, result);
  result.lower_bound = gapAlong(a, b, result.normal);
  return result;
}

/// Signed distance of a box (a, centred at the origin) and a point.
SignedDistance boxPoint(const Vector3d& half, const Vector3d& point) {
  const Vector3d inside = point.cwiseMax(-half).cwiseMin(half);
  if (inside != point) return between(inside, point, Vector3d::UnitX());
  Eigen::Index axis;
  const double depth = (half - point.cwiseAbs()).minCoeff(&axis);
  const double side = std::copysign(1.0, point[axis]);
  Vector3d surface = point;
  surface[axis] = side * half[axis];
  SignedDistance result = along(-depth, side * Vector3d::Unit(axis), surface, point);
  int as_near = 0;
  for (int k = 0; k < 3; ++k)
    for (const double s : {-1.0, 1.0}) as_near += half[k] - s * point[k] == depth;
  result.unique = as_near == 1;
  return result;
}

/// Signed distance of a point (a, at the origin) and a box. The transpose of a rotation matrix is its inverse only up
/// to rounding: the nearest point of the box is found in the frame of the box, and the distance to it in the frame of
/// a.
SignedDistance pointBox(const Vector3d& half, const Eigen::Isometry3d& a_T_b) {
  const SignedDistance in_b = boxPoint(half, a_T_b.linear().transpose() * -a_T_b.translation());
  const Vector3d point_b = a_T_b * in_b.point_a;
  if (in_b.distance > half.sum()) return between(Vector3d::Zero(), point_b, Vector3d::UnitX());
  // If the point is near the box, rounding would tilt the difference of the points; the normal of the box is taken.
  const Vector3d normal = (a_T_b.linear() * -in_b.normal).normalized();
  SignedDistance result = along(normal.dot(point_b), normal, Vector3d::Zero(), point_b);
  result.unique = in_b.unique;
  return result;
}

}  // namespace

SignedDistance closedForm(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  if (a.kind() == Kind::Point && b.kind() == Kind::Point)
    return between(Vector3d::Zero(), a_T_b.translation(), Vector3d::UnitX());
  if (a.kind() == Kind::Box) return boxPoint(a.halfExtents(), a_T_b.translation());
  if (b.kind() == Kind::Box) return pointBox(b.halfExtents(), a_T_b);
  return segmentSegment({Vector3d::Zero(), a.halfExtents()}, {a_T_b.translation(), a_T_b.linear() * b.halfExtents()});
}

}  // namespace proximity_server::narrowphase
