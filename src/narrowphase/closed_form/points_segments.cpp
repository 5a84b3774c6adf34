#include "narrowphase/closed_form/points_segments.h"

#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();

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

}  // namespace

namespace closed_form {

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

}  // namespace closed_form
}  // namespace proximity_server::narrowphase
