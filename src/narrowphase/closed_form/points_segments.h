#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/narrowphase/shape/support.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

/// True if closedForm() answers this pair: points and segments in any combination, and a point with a box.
inline bool hasClosedForm(Shape::Kind a, Shape::Kind b) {
  const auto is_line = [](Shape::Kind kind) { return kind == Shape::Kind::Point || kind == Shape::Kind::Segment; };
  return (is_line(a) && is_line(b)) || (a == Shape::Kind::Box && b == Shape::Kind::Point) ||
         (a == Shape::Kind::Point && b == Shape::Kind::Box);
}

// The formulas are inline: where they are calls, results are stored and loaded again several times in a query, and that
// takes as long as the formulas.
namespace closed_form {

inline SignedDistance along(double distance, const Eigen::Vector3d& normal, const Eigen::Vector3d& point_a,
                            const Eigen::Vector3d& point_b) {
  SignedDistance result;
  result.distance = distance;
  result.normal = normal;
  result.point_a = point_a;
  result.point_b = point_b;
  return result;
}

/// Signed distance between two points. If they coincide, every normal is right, and x is taken.
inline SignedDistance between(const Eigen::Vector3d& point_a, const Eigen::Vector3d& point_b) {
  const Eigen::Vector3d difference = point_b - point_a;
  const double distance = difference.norm();
  // Otherwise the normal would not be a unit vector.
  if (distance > support::kShortest) return along(distance, difference / distance, point_a, point_b);
  const double size = difference.cwiseAbs().maxCoeff();
  const Eigen::Vector3d normal = size > 0.0 ? (difference / size).normalized() : Eigen::Vector3d::UnitX();
  SignedDistance result = along(0.0, normal, point_a, point_b);
  result.unique = false;
  return result;
}

/// A segment, stored by its centre and the vector from there to one end.
struct Segment {
  Eigen::Vector3d centre, half;

  Eigen::Vector3d at(double place) const { return centre + place * half; }
};

/// [m] Gap between the support planes of two segments along a unit normal.
inline double gapAlong(const Segment& a, const Segment& b, const Eigen::Vector3d& normal) {
  return normal.dot(b.centre - a.centre) - std::abs(normal.dot(a.half)) - std::abs(normal.dot(b.half));
}

/// Corrects the normal of segments that nearly touch. The difference of their points is then mostly rounding, which
/// tilts the normal along the segments. The candidates are the normal made perpendicular to one or both segments, and
/// the common perpendicular; the one with the widest gap is taken, and its gap is the lower bound.
SignedDistance nearlyTouching(const Segment& a, const Segment& b, SignedDistance result);

/// The nearest places of two segments, a along z and centred at the origin.
struct NearestPlaces {
  double height;  ///< [m] of the point of a
  double on_b;    ///< from -1 (one end of b) to 1 (the other end)
  bool cross;     ///< both lie inside of their segments, which are not parallel
};

inline NearestPlaces nearestPlaces(double half_length, const Segment& b) {
  const Eigen::Vector3d &t = b.centre, &v = b.half;
  const double length2 = v.squaredNorm(), across2 = v.x() * v.x() + v.y() * v.y();
  const double approach = -(v.x() * t.x() + v.y() * t.y());
  // At a smaller angle all places of b are equally far from the line of a, within rounding.
  constexpr double kParallel = std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon();
  constexpr double kShortest2 = support::kShortest * support::kShortest;
  const bool is_parallel = !(across2 > std::max(kParallel * length2, kShortest2));
  const double level = v.z() != 0.0 ? -t.z() / v.z() : 0.0;
  const double free_place = is_parallel ? level : approach / across2;
  const double place = std::clamp(free_place, -1.0, 1.0), height = t.z() + place * v.z();
  const double end = std::clamp(height, -half_length, half_length);
  if (height == end) return {height, place, !is_parallel && place == free_place};
  const double place_at_end = length2 > 0.0 ? (approach + (end - t.z()) * v.z()) / length2 : 0.0;
  return {end, std::clamp(place_at_end, -1.0, 1.0), false};
}

/// Signed distance of two segments; the first is centred at the origin, along z, with `half_length` on either side.
///
/// 1. Find the place of b nearest to the line of a. In the plane across a this is the place nearest to the origin.
/// 2. If its height is on a, both are the nearest places. Otherwise the nearest place of a is the end on this side, and
///    the nearest place of b is the one nearest to this end. The squared distance is convex in both places, so this is
///    the minimum.
/// 3. If the segments cross, the normal is their common perpendicular (-v_y, v_x, 0). Its products with both segments
///    are zero even in floating point, so rounding does not tilt it, however near they are.
/// 4. Otherwise it leads from point to point. If that is tilted by more than rounding, it is corrected.
///
/// As a lies along z, the part of b across a is read from the pose, and not found as a difference: the distance has an
/// error of a few eps of the sizes and the offset at any angle.
inline SignedDistance segmentSegment(double half_length, const Segment& b) {
  const Eigen::Vector3d &t = b.centre, &v = b.half;
  const double small = 8.0 * std::numeric_limits<double>::epsilon() * (half_length + v.lpNorm<1>());
  const NearestPlaces places = nearestPlaces(half_length, b);
  const Eigen::Vector3d on_a(0.0, 0.0, places.height), on_b = b.at(places.on_b);
  if (places.cross) {
    const double across = std::sqrt(v.x() * v.x() + v.y() * v.y()), gap = (v.x() * t.y() - v.y() * t.x()) / across;
    const double scale = std::copysign(1.0 / across, gap);
    SignedDistance result = along(std::abs(gap), {-scale * v.y(), scale * v.x(), 0.0}, on_a, on_b);
    result.lower_bound = result.distance;
    result.unique = result.distance > small;
    return result;
  }
  const Segment a{Eigen::Vector3d::Zero(), {0.0, 0.0, half_length}};
  SignedDistance result = between(on_a, on_b);
  result.lower_bound = gapAlong(a, b, result.normal);
  const double rounded = 4.0 * std::numeric_limits<double>::epsilon() * result.distance;
  const bool is_tilted = result.distance - result.lower_bound > 2.0 * small + rounded;
  return is_tilted || result.distance <= small ? nearlyTouching(a, b, result) : result;
}

/// Signed distance of a box (a, centred at the origin) and a point inside of it.
inline SignedDistance pointInside(const Eigen::Vector3d& half, const Eigen::Vector3d& point) {
  Eigen::Index axis;
  const double depth = (half - point.cwiseAbs()).minCoeff(&axis);
  const double side = std::copysign(1.0, point[axis]);
  Eigen::Vector3d surface = point;
  surface[axis] = side * half[axis];
  SignedDistance result = along(-depth, side * Eigen::Vector3d::Unit(axis), surface, point);
  int as_near = 0;
  for (int k = 0; k < 3; ++k)
    for (const double s : {-1.0, 1.0}) as_near += half[k] - s * point[k] == depth;
  result.unique = as_near == 1;
  return result;
}

/// Signed distance of a box (a, centred at the origin) and a point.
inline SignedDistance boxPoint(const Eigen::Vector3d& half, const Eigen::Vector3d& point) {
  const Eigen::Vector3d nearest = point.cwiseMax(-half).cwiseMin(half);
  return nearest == point ? pointInside(half, point) : between(nearest, point);
}

/// Signed distance of a point (a, at the origin) and a box. The transpose of a rotation matrix is its inverse only up
/// to rounding: the nearest point of the box is found in the frame of the box, and the distance to it in the frame of
/// a.
inline SignedDistance pointBox(const Eigen::Vector3d& half, const Eigen::Isometry3d& a_T_b) {
  const Eigen::Vector3d point = a_T_b.linear().transpose() * -a_T_b.translation();
  Eigen::Vector3d nearest = point.cwiseMax(-half).cwiseMin(half), towards_box = nearest - point;
  const bool is_outside = nearest != point;
  bool is_unique = true;
  if (!is_outside) {
    const SignedDistance in_b = pointInside(half, point);
    nearest = in_b.point_a;
    towards_box = -in_b.normal;
    is_unique = in_b.unique;
  }
  const Eigen::Vector3d point_b = a_T_b.linear() * nearest + a_T_b.translation();
  // If the point is near the box, rounding would tilt the difference of the points; the direction is taken from the
  // box.
  const double distance2 = towards_box.squaredNorm();
  const bool is_short = !(distance2 > support::kShortest * support::kShortest);
  if (is_short) towards_box /= towards_box.cwiseAbs().maxCoeff();  // the square of its normal would underflow
  const bool is_far = is_outside && !is_short && distance2 > half.squaredNorm();
  const Eigen::Vector3d normal = (is_far ? point_b : Eigen::Vector3d(a_T_b.linear() * towards_box)).normalized();
  SignedDistance result = along(normal.dot(point_b), normal, Eigen::Vector3d::Zero(), point_b);
  result.unique = is_unique;
  return result;
}

}  // namespace closed_form

/// Signed distance of two cores that have a closed form, without margins.
///
/// Frame, sign, invariant: as signedDistance().
/// Error:   a few eps of the sizes and the offset.
/// Source:  Ericson, Real-Time Collision Detection, 2005, 5.1.
inline SignedDistance closedForm(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  using Kind = Shape::Kind;
  if (a.kind() == Kind::Box) return closed_form::boxPoint(a.halfExtents(), a_T_b.translation());
  if (b.kind() == Kind::Box) return closed_form::pointBox(b.halfExtents(), a_T_b);
  if (a.kind() == Kind::Point && b.kind() == Kind::Point)
    return closed_form::between(Eigen::Vector3d::Zero(), a_T_b.translation());
  return closed_form::segmentSegment(a.halfExtents().z(),
                                     {a_T_b.translation(), b.halfExtents().z() * a_T_b.linear().col(2)});
}

/// True if, within the tolerance, only one pair of points of two cores with a closed form has this distance, given that
/// only one direction does: the cores are not two segments perpendicular to the normal and parallel to each other.
inline bool meetInOnePoint(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b,
                           const Eigen::Vector3d& normal, double tolerance) {
  if (a.kind() != Shape::Kind::Segment || b.kind() != Shape::Kind::Segment) return true;
  const double length_a = 2.0 * a.halfExtents().z(), length_b = 2.0 * b.halfExtents().z();
  const Eigen::Vector3d along_b = a_T_b.linear().col(2);
  const bool are_points = length_a <= tolerance || length_b <= tolerance;
  if (are_points || length_a * std::abs(normal.z()) > tolerance || length_b * std::abs(along_b.dot(normal)) > tolerance)
    return true;
  const double sine = std::sqrt(along_b.x() * along_b.x() + along_b.y() * along_b.y());
  return std::min(length_a, length_b) * sine > tolerance;
}

}  // namespace proximity_server::narrowphase
