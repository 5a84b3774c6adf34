#include "narrowphase/curved/stationary_rims.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = Shape::Kind;

constexpr int kMaxSteps = 12;
constexpr int kMaxCases = 4;
constexpr double kMaxTurn = 0.7;  // [rad] in longer steps Newton's method seldom converges

RimEnds endsOf(const Cso& cso, const Simplex& simplex) {
  const Vector3d axis_b = cso.bAxes().col(2);
  const double origin_b = axis_b.dot(cso.bOrigin());
  int of_a = 0, of_b = 0, count = 0;
  for (int place = 0; place < 4; ++place) {
    if (!simplex.has(place)) continue;
    ++count;
    of_a += simplex[place].on_a.z() < 0.0 ? -1 : 1;
    of_b += axis_b.dot(simplex[place].onB()) < origin_b ? -1 : 1;
  }
  const auto end = [count](int sum) { return sum == count ? 1.0 : sum == -count ? -1.0 : 0.0; };
  return {end(of_a), end(of_b)};
}

/// A point (cosine, sine) of the unit circle, turned by 2 atan(angle / 2): the angle, up to its cube.
Vector2d turned(const Vector2d& at, double angle) {
  const double half = 0.5 * angle, scale = 1.0 / (1.0 + half * half);
  const double cosine = (1.0 - half * half) * scale, sine = angle * scale;
  return {cosine * at.x() - sine * at.y(), sine * at.x() + cosine * at.y()};
}

/// The point of a rim in the frame of its core, rounded as a support point.
Vector3d onRim(const Shape& shape, double end, const Vector2d& at) {
  return support::rimPoint(shape.halfExtents().x(), end * shape.halfExtents().z(), {at.x(), at.y(), 0.0}, at.norm());
}

/// The direction through points on both cores, in the frame of a, of which `normal` is a guess.
std::optional<StationaryDirection> through(const Vector3d& on_a, const Vector3d& on_b, const Vector3d& normal) {
  const Vector3d between = on_b - on_a;
  const double side = std::copysign(1.0, between.dot(normal)), distance = side * between.norm();
  if (!(std::abs(distance) > support::kShortest)) return std::nullopt;
  return StationaryDirection{between / distance, -distance, {on_a, on_b}, 1.0};
}

/// The place (cosine, sine) on a rim in this direction.
Vector2d towardsOnRim(const Shape& shape, const Vector2d& direction) {
  return shape.halfExtents().x() > 0.0 ? direction.normalized() : Vector2d::UnitX();
}

std::optional<StationaryDirection> betweenRims(const Cso& cso, const RimEnds& ends, const Vector3d& normal) {
  const double radius_a = cso.a().halfExtents().x(), radius_b = cso.b().halfExtents().x();
  const auto axes = cso.bAxes();
  const Vector3d centres(axes.col(2) * (ends.of_b * cso.b().halfExtents().z()) + cso.bOrigin() -
                         ends.of_a * cso.a().halfExtents().z() * Vector3d::UnitZ());
  Vector2d at_a = towardsOnRim(cso.a(), normal.head<2>());
  Vector2d at_b = towardsOnRim(cso.b(), -(axes.leftCols<2>().transpose() * normal));
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vector2d out_a = radius_a * at_a, along_a(-out_a.y(), out_a.x());
    const Vector3d out_b = radius_b * (axes.leftCols<2>() * at_b);
    const Vector3d along_b = radius_b * (axes.col(1) * at_b.x() - axes.col(0) * at_b.y());
    Vector3d between = centres + out_b;  // from a to b
    between.head<2>() -= out_a;
    // Derivatives of half the squared distance. A rim of radius 0 does not move.
    const double slope_a = -along_a.dot(between.head<2>()), slope_b = along_b.dot(between);
    const double aa = radius_a > 0.0 ? radius_a * radius_a + out_a.dot(between.head<2>()) : 1.0;
    const double bb = radius_b > 0.0 ? radius_b * radius_b - out_b.dot(between) : 1.0;
    const double ab = -along_a.dot(along_b.head<2>());
    const double determinant = aa * bb - ab * ab;
    if (!(aa > 0.0 && determinant > kRing * aa * bb)) return std::nullopt;
    const double turn_a = (ab * slope_b - bb * slope_a) / determinant;
    const double turn_b = (ab * slope_a - aa * slope_b) / determinant;
    const double turn = std::max(std::abs(turn_a), std::abs(turn_b));
    if (!(turn < kMaxTurn)) return std::nullopt;
    at_a = turned(at_a, turn_a);
    at_b = turned(at_b, turn_b);
    if (turn < kLastTurn)
      return through(onRim(cso.a(), ends.of_a, at_a), axes * onRim(cso.b(), ends.of_b, at_b) + cso.bOrigin(), normal);
  }
  return std::nullopt;
}

/// A circle beside the axis of a mantle, seen along this axis: an ellipse.
struct Ellipse {
  Vector2d centre, x, y;  ///< the point at the angle t is centre + cos(t) x + sin(t) y
};

/// The place on a rim that is nearest to the axis, from a direction near to it.
std::optional<Vector2d> nearestOnRim(const Shape& shape, const Ellipse& seen, const Vector2d& direction) {
  Vector2d at = towardsOnRim(shape, direction);
  if (!(shape.halfExtents().x() > 0.0)) return at;
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vector2d out = at.x() * seen.x + at.y() * seen.y, along = at.x() * seen.y - at.y() * seen.x;
    const Vector2d point = seen.centre + out;
    const double curvature = along.squaredNorm() - point.dot(out);
    const double turn = -point.dot(along) / curvature;
    if (!(curvature > kRing * along.squaredNorm() && std::abs(turn) < kMaxTurn)) return std::nullopt;
    at = turned(at, turn);
    if (std::abs(turn) < kLastTurn) return at;
  }
  return std::nullopt;
}

/// The normal of a mantle, in the frame of its core, where the line from the axis through `point` meets it on the side
/// of `outwards`. Returns nullopt if the point lies on the axis.
std::optional<Vector3d> mantleNormal(const Vector3d& point, const Vector2d& outwards) {
  const double radial = std::copysign(point.head<2>().norm(), point.head<2>().dot(outwards));
  if (!(std::abs(radial) > support::kShortest)) return std::nullopt;
  return Vector3d(point.x() / radial, point.y() / radial, 0.0);
}

std::optional<StationaryDirection> betweenMantleAndRim(const Cso& cso, const RimEnds& ends, const Vector3d& normal) {
  const auto axes = cso.bAxes();
  const Vector3d& half = cso.b().halfExtents();
  const Vector2d centre = axes.col(2).head<2>() * (ends.of_b * half.z()) + cso.bOrigin().head<2>();
  const Ellipse ellipse{centre, half.x() * axes.col(0).head<2>(), half.x() * axes.col(1).head<2>()};
  const auto at = nearestOnRim(cso.b(), ellipse, -(axes.leftCols<2>().transpose() * normal));
  if (!at) return std::nullopt;
  const Vector3d on_b = axes * onRim(cso.b(), ends.of_b, *at) + cso.bOrigin();
  const auto out = mantleNormal(on_b, normal.head<2>());
  if (!out) return std::nullopt;
  const Vector3d on_a = cso.a().halfExtents().x() * *out + on_b.z() * Vector3d::UnitZ();
  return StationaryDirection{*out, out->dot(on_a - on_b), {on_a, on_b}, 1.0};
}

std::optional<StationaryDirection> betweenRimAndMantle(const Cso& cso, const RimEnds& ends, const Vector3d& normal) {
  const auto axes = cso.bAxes();
  const Vector3d& half = cso.a().halfExtents();
  const Vector3d from_b = ends.of_a * half.z() * Vector3d::UnitZ() - cso.bOrigin();
  const Ellipse ellipse{axes.leftCols<2>().transpose() * from_b, half.x() * axes.row(0).head<2>().transpose(),
                        half.x() * axes.row(1).head<2>().transpose()};
  const auto at = nearestOnRim(cso.a(), ellipse, normal.head<2>());
  if (!at) return std::nullopt;
  const Vector3d on_a = onRim(cso.a(), ends.of_a, *at);
  const Vector3d in_b = axes.transpose() * (on_a - cso.bOrigin());
  const auto out = mantleNormal(in_b, -(axes.leftCols<2>().transpose() * normal));
  if (!out) return std::nullopt;
  const Vector3d on_b = axes * (cso.b().halfExtents().x() * *out + in_b.z() * Vector3d::UnitZ()) + cso.bOrigin();
  const Vector3d towards_b = -(axes * *out).normalized();  // the axes of b need not be unit vectors to the last digit
  return StationaryDirection{towards_b, towards_b.dot(on_a - on_b), {on_a, on_b}, 1.0};
}

/// The end that corrects a wrong case. For a rim whose normal points away from the end, it is the mantle; for a mantle
/// whose point lies beyond an end, it is this end.
double corrected(double end, double height, double half, double towards_end) {
  if (end != 0.0) return end * towards_end < 0.0 ? 0.0 : end;
  return std::abs(height) > half ? std::copysign(1.0, height) : 0.0;
}

RimEnds corrected(const Cso& cso, const RimEnds& ends, const StationaryDirection& found) {
  const Vector3d axis_b = cso.bAxes().col(2);
  const Vector3d& normal = found.normal;
  return {corrected(ends.of_a, found.points.on_a.z(), cso.a().halfExtents().z(), normal.z()),
          corrected(ends.of_b, axis_b.dot(found.points.on_b - cso.bOrigin()), cso.b().halfExtents().z(),
                    -axis_b.dot(normal))};
}

bool hasMantle(const Shape& shape) { return shape.kind() == Kind::Cylinder || shape.kind() == Kind::Segment; }

}  // namespace

bool haveMantles(const Cso& cso) { return hasMantle(cso.a()) && hasMantle(cso.b()); }

std::optional<StationaryRims> stationaryRims(const Cso& cso, const Simplex& simplex, const Vector3d& normal) {
  if (!haveMantles(cso)) return std::nullopt;
  RimEnds ends = endsOf(cso, simplex);
  Vector3d towards = normal;
  for (int i = 0; i < kMaxCases; ++i) {
    if (ends.of_a == 0.0 && ends.of_b == 0.0) return std::nullopt;
    const auto found = ends.of_a == 0.0   ? betweenMantleAndRim(cso, ends, towards)
                       : ends.of_b == 0.0 ? betweenRimAndMantle(cso, ends, towards)
                                          : betweenRims(cso, ends, towards);
    if (!found) return std::nullopt;
    const RimEnds next = corrected(cso, ends, *found);
    if (next.of_a == ends.of_a && next.of_b == ends.of_b) return StationaryRims{*found, ends};
    ends = next;
    towards = found->normal;
  }
  return std::nullopt;
}

}  // namespace proximity_server::narrowphase
