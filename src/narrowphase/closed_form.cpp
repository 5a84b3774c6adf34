#include "closed_form.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server {
namespace {

using Eigen::Vector3d;
using Kind = Shape::Kind;

constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
constexpr double kMostTilt = 0.5;  // of a normal that rounding has turned so far, nothing is known

SignedDistance along(double distance, const Vector3d& normal, const Vector3d& point_a, const Vector3d& point_b) {
  SignedDistance result;
  result.distance = distance;
  result.normal = normal;
  result.point_a = point_a;
  result.point_b = point_b;
  return result;
}

/// Where the points coincide every direction across `free_axis` is right, and one is chosen.
SignedDistance between(const Vector3d& point_a, const Vector3d& point_b, const Vector3d& free_axis) {
  const Vector3d difference = point_b - point_a;
  const double distance = difference.norm();
  if (distance > 0.0) return along(distance, difference / distance, point_a, point_b);
  SignedDistance result = along(0.0, free_axis, point_a, point_b);
  result.unique = false;
  return result;
}

/// Any unit vector perpendicular to both segments; to one where the other is a point or parallel.
Vector3d across(const Vector3d& u, const Vector3d& v) {
  const Vector3d normal = u.cross(v);
  if (normal.squaredNorm() > 0.0) return normal.normalized();
  const Vector3d& longer = u.squaredNorm() >= v.squaredNorm() ? u : v;
  return longer.squaredNorm() > 0.0 ? Vector3d(longer.unitOrthogonal()) : Vector3d(Vector3d::UnitX());
}

/// A segment by its centre and half its length along each axis.
struct Segment {
  Vector3d centre, half;

  /// In units of half, within [-1, 1]: the place nearest to a point.
  double nearest(const Vector3d& point) const {
    const double length2 = half.squaredNorm();
    return length2 > 0.0 ? std::clamp(half.dot(point - centre) / length2, -1.0, 1.0) : 0.0;
  }
  Vector3d at(double s) const { return centre + s * half; }
};

/// The part of `normal` that points away from a segment at a place on it: across it, or beyond its end.
Vector3d awayFrom(const Segment& segment, double place, const Vector3d& normal) {
  const double length2 = segment.half.squaredNorm();
  const double along = segment.half.dot(normal);
  if (length2 == 0.0 || (place == 1.0 && along >= 0.0) || (place == -1.0 && along <= 0.0)) return normal;
  return normal - along / length2 * segment.half;
}

struct Places {
  double on_a, on_b;
};

/// The nearest places of two segments: the common perpendicular where it meets both, else an end of one of them. All
/// four ends are tried, which is as good for parallel segments as for any other.
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

/// The normal of segments that nearly touch: the difference of the points is then rounding along the segments, which
/// would tilt it. Twice away from both is what it may be, and where nothing is left, it is any across both.
SignedDistance nearlyTouching(const Segment& a, const Segment& b, const Places& places, SignedDistance result) {
  const bool coincide = result.distance <= kRounding * (a.half.lpNorm<1>() + b.half.lpNorm<1>());
  Vector3d normal = coincide ? Vector3d(Vector3d::Zero()) : result.normal;
  for (int i = 0; i < 2; ++i) normal = -awayFrom(b, places.on_b, -awayFrom(a, places.on_a, normal));
  const double left = normal.norm();
  result.unique = !coincide;
  result.normal = left > kMostTilt ? Vector3d(normal / left) : across(a.half, b.half);
  if (result.normal.dot(result.point_b - result.point_a) < 0.0) result.normal = -result.normal;
  return result;
}

SignedDistance segmentSegment(const Segment& a, const Segment& b) {
  const Places places = nearestPlaces(a, b);
  const SignedDistance result = between(a.at(places.on_a), b.at(places.on_b), Vector3d::UnitX());
  // At a tenth of the sizes rounding tilts the normal by no more than ten roundings.
  const bool near = result.distance < 0.1 * (a.half.lpNorm<1>() + b.half.lpNorm<1>());
  return near ? nearlyTouching(a, b, places, result) : result;
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

SignedDistance swapped(const SignedDistance& result) {
  SignedDistance other = result;
  other.normal = -result.normal;
  other.point_a = result.point_b;
  other.point_b = result.point_a;
  return other;
}

SignedDistance transformed(const SignedDistance& result, const Eigen::Isometry3d& pose) {
  SignedDistance other = result;
  other.normal = pose.linear() * result.normal;
  other.point_a = pose * result.point_a;
  other.point_b = pose * result.point_b;
  return other;
}

}  // namespace

SignedDistance closedForm(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  if (a.kind() == Kind::Point && b.kind() == Kind::Point)
    return between(Vector3d::Zero(), a_T_b.translation(), Vector3d::UnitX());
  if (a.kind() == Kind::Box) return boxPoint(a.halfExtents(), a_T_b.translation());
  if (b.kind() == Kind::Box) {
    const Vector3d a_in_b = a_T_b.linear().transpose() * -a_T_b.translation();
    return transformed(swapped(boxPoint(b.halfExtents(), a_in_b)), a_T_b);
  }
  return segmentSegment({Vector3d::Zero(), a.halfExtents()}, {a_T_b.translation(), a_T_b.linear() * b.halfExtents()});
}

}  // namespace proximity_server
