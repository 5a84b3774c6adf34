#include "narrowphase/curved/inner_ellipsoid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Kind = Shape::Kind;

constexpr double kNothing = -std::numeric_limits<double>::infinity();

/// A spheroid inside of a cone, in its frame: it touches the base, and the slant in a circle.
struct Spheroid {
  double radial, axial;  ///< [m] half axes
  double height;         ///< [m] of its centre
};

/// The spheroid that touches the slant in the circle of this radius. With the normal (cos b, sin b) of the slant, its
/// support function s along the normal is the free parameter: radial^2 = s radius / cos b, and axial^2 = s (s - radius
/// cos b) / sin^2 b. It touches the base if s (2 k - radius cos b) = k^2, k = length sin b. Then axial = (k - s) / sin
/// b, which does not cancel at the rim.
Spheroid insideCone(const Vector3d& half, double radius) {
  const double length = 2.0 * half.z(), slant = std::hypot(length, half.x());
  const double cosine = length / slant, sine = half.x() / slant;
  const double k = length * sine, part = std::clamp(radius * cosine, 0.0, k);
  const double s = k * k / (2.0 * k - part), rest = k * (k - part) / (2.0 * k - part);  // rest is k - s
  return {std::sqrt(s * part) / cosine, rest / sine, half.z() - s / sine};
}

/// The part of a segment inclined to the normal that becomes a part of the ellipsoid: the whole segment, or only the
/// end that is farthest along the normal, so that the ellipsoid stays one of revolution about the other axis.
enum class Segments { Whole, Ends };

/// The ellipsoid inside of the CSO that touches it in the direction `normal`, see steps 1 to 3.
class InnerEllipsoid {
 public:
  InnerEllipsoid(const Cso& cso, const StationaryDirection& direction, double depth, Segments segments)
      : normal_(direction.normal), touching_(16.0 * cso.rounding()) {
    add({cso.a(), Matrix3d::Identity(), Vector3d::Zero(), direction.points.on_a, 1.0, 1.0});
    add({cso.b(), cso.bAxes(), cso.bOrigin(), direction.points.on_b, -1.0, shrunkBy(cso.bAxes())});
    if (segments == Segments::Whole) addSegments(depth);
    if (segments == Segments::Ends) addEnds();
    sumUp();
  }

  /// [m] Radius of a ball about the origin that lies inside, for the ball that would touch in the direction of the
  /// normal at the distance `depth`.
  double radius(double depth) const {
    // Entries of M are sums of nine products of sums; rounding of M and of the solution counts as a smaller M.
    const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * m_.trace();
    const double s = depth * (q_ * normal_).norm() - 2.0 * rounding;
    if (!(s > 0.0)) return kNothing;
    const Matrix3d n = m_ - (s + rounding) * Matrix3d::Identity();
    // Cholesky's decomposition; a pivot that is not positive says that M has an eigenvalue below s.
    const double d0 = n(0, 0), l10 = n(1, 0) / d0, l20 = n(2, 0) / d0;
    const double d1 = n(1, 1) - l10 * n(1, 0), l21 = (n(2, 1) - l20 * n(1, 0)) / d1;
    const double d2 = n(2, 2) - l20 * n(2, 0) - l21 * l21 * d1;
    if (!(d0 > 0.0 && d1 > 0.0 && d2 > 0.0)) return kNothing;
    const double y0 = centre_.x(), y1 = centre_.y() - l10 * y0, y2 = centre_.z() - l20 * y0 - l21 * y1;
    const double inside = 1.0 - (y0 * y0 / d0 + y1 * y1 / d1 + y2 * y2 / d2);
    return inside > 0.0 ? std::sqrt(s * inside) : kNothing;
  }

 private:
  struct Core {
    const Shape& shape;
    Matrix3d axes;
    Vector3d origin;
    Vector3d witness;
    double side;    ///< 1: core a; -1: core b, whose negative is part of the CSO
    double shrunk;  ///< 1 over an upper bound of the norm of `axes`
  };

  static double shrunkBy(const Matrix3d& axes) {
    return 1.0 / (1.0 + (axes.transpose() * axes - Matrix3d::Identity()).norm());
  }

  struct Segment {
    double half;  ///< [m]
    Vector3d along;
    double at;      ///< [m] place of the witness point on it, in the CSO
    double height;  ///< [m] half its length along the normal
  };

  void add(const Core& core) {
    const Vector3d at = core.axes.transpose() * (core.witness - core.origin);
    const Vector3d& half = core.shape.halfExtents();
    centre_ += core.side * core.origin;
    switch (core.shape.kind()) {
      case Kind::Point:
        return;
      case Kind::Segment:
        return addSegment(core, 2, at);
      case Kind::Box:
        for (int axis = 0; axis < 3; ++axis) addSegment(core, axis, at);
        return;
      case Kind::Cylinder:
        addDisc(core, at);
        return addSegment(core, 2, at);
      case Kind::Ellipsoid:
        return addPart(core, core.axes * half.asDiagonal() * core.axes.transpose());
      case Kind::Cone:
        return addCone(core, at);
      case Kind::Hull:
      case Kind::Sweep:
        centre_ += core.side * (core.witness - core.origin);
    }
  }

  void addSegment(const Core& core, int axis, const Vector3d& at) {
    const Vector3d along = core.axes.col(axis);
    const double half = core.shape.halfExtents()[axis], height = half * along.dot(normal_);
    segments_[segment_count_++] = {core.shrunk * half, along, core.side * std::clamp(at[axis], -half, half), height};
  }

  /// Takes the end of each segment that lies farthest along the normal, and nothing of the rest.
  void addEnds() {
    for (std::size_t i = 0; i < segment_count_; ++i) {
      const Segment& segment = segments_[i];
      if (isSplit(segment))
        centre_ += segment.at * segment.along;
      else
        centre_ += std::copysign(segment.half, segment.height) * segment.along;
    }
  }

  bool isSplit(const Segment& segment) const { return std::abs(segment.height) <= touching_; }

  /// Adds the segments. Two of them span a parallelogram, which holds an ellipse: for |k| <= 1, |x| + |y| is at least
  /// the root of x^2 + y^2 + 2 k x y. It touches each side at the part k of half its length.
  void addSegments(double depth) {
    const Segment &p = segments_[0], &q = segments_[1];
    if (segment_count_ == 2 && isSplit(p) && isSplit(q)) {
      // The nearer k is to 1, the longer and narrower is the ellipse. It is made long enough for a ball of this depth.
      const Segment rest_p = split(p), rest_q = split(q);
      const double squares = rest_p.half * rest_p.half + rest_q.half * rest_q.half;
      const double product = 2.0 * rest_p.half * rest_q.half, length = 0.5 * (rest_p.half + rest_q.half + depth);
      const double k = product > 0.0 ? std::clamp((length * length - squares) / product, 0.0, 1.0) : 0.0;
      return addEllipse(rest_p, rest_q, std::copysign(k, p.along.dot(q.along)));
    }
    if (segment_count_ == 2 && isSplit(p) != isSplit(q)) {
      const Segment &touched = isSplit(p) ? p : q, &other = isSplit(p) ? q : p;
      const double part = touched.half > 0.0 ? std::clamp(touched.at / touched.half, -1.0, 1.0) : 0.0;
      return addEllipse(p, q, std::copysign(part, part * other.height));
    }
    for (std::size_t i = 0; i < segment_count_; ++i) {
      const Segment rest = isSplit(segments_[i]) ? split(segments_[i]) : segments_[i];
      parts_[count_++] = rest.half * rest.along * rest.along.transpose();
    }
  }

  Segment split(Segment segment) {
    centre_ += segment.at * segment.along;
    segment.half = std::max(segment.half - std::abs(segment.at), 0.0);
    return segment;
  }

  void addEllipse(const Segment& p, const Segment& q, double k) {
    const Vector3d u = p.half * p.along, v = q.half * q.along, across = u.cross(v);
    Matrix3d squared = u * u.transpose() + v * v.transpose() + k * (u * v.transpose() + v * u.transpose());
    // The root of a 2 x 2 matrix E is (E + d) / sqrt(trace E + 2 d), with d the root of the determinant of E.
    const double area = across.norm(), d = area * std::sqrt(std::max(1.0 - k * k, 0.0));
    if (d > 0.0) squared += d * (Matrix3d::Identity() - across * across.transpose() / (area * area));
    const double root = std::sqrt(squared.trace());
    if (root > 0.0) parts_[count_++] = squared / root;
  }

  void addDisc(const Core& core, const Vector3d& at) {
    double radius = core.shape.halfExtents().x();
    const Matrix3d across = core.axes.leftCols<2>() * core.axes.leftCols<2>().transpose();
    if (radius * (across * normal_).norm() <= touching_) {
      const double radial = at.head<2>().norm(), t = std::min(radial, radius);
      if (radial > 0.0) centre_ += core.side * core.axes.leftCols<2>() * (t / radial * at.head<2>());
      radius -= t;
    }
    addPart(core, radius * across);
  }

  void addCone(const Core& core, const Vector3d& at) {
    const Vector3d& half = core.shape.halfExtents();
    const Vector3d n = core.side * (core.axes.transpose() * normal_);
    const double apex_over_rim = 2.0 * half.z() * n.z() - half.x() * n.head<2>().norm();
    if (std::abs(apex_over_rim) <= touching_) {
      const Spheroid inside = insideCone(half, at.head<2>().norm());
      centre_ += core.side * inside.height * core.axes.col(2);
      const Vector3d radii(inside.radial, inside.radial, inside.axial);
      return addPart(core, core.axes * radii.asDiagonal() * core.axes.transpose());
    }
    centre_ += core.side * std::copysign(half.z(), apex_over_rim) * core.axes.col(2);
    if (apex_over_rim < 0.0) addDisc(core, at);
  }

  /// Adds a part R D R'. Its support function is |D R' n|, which may be less than |R D R' n| if R is not a rotation to
  /// the last digit.
  void addPart(const Core& core, const Matrix3d& s) { parts_[count_++] = core.shrunk * s; }

  /// Sums up the parts, each turned so that the support points along the normal have one direction.
  void sumUp() {
    std::array<Vector3d, kMaxParts> points;
    Vector3d longest = Vector3d::Zero();
    for (std::size_t i = 0; i < count_; ++i) {
      points[i] = parts_[i] * normal_;
      if (points[i].squaredNorm() > longest.squaredNorm()) longest = points[i];
    }
    const Vector3d direction = longest.normalized();
    for (std::size_t i = 0; i < count_; ++i) q_ += turnedTo(direction, points[i], parts_[i]);
    m_ = q_.transpose() * q_;
  }

  /// A part turned by the smallest rotation that takes its support point into the direction.
  Matrix3d turnedTo(const Vector3d& direction, const Vector3d& point, const Matrix3d& part) const {
    const double length = point.norm();
    if (length <= touching_) return part;
    const Vector3d from = point / length, axis = from.cross(direction);
    const double cosine = from.dot(direction);
    // A part that would turn farther is left out. That is safe, because its support function is not negative.
    constexpr double kSmallestCosine = -0.5;
    if (cosine < kSmallestCosine) return Matrix3d::Zero();
    Matrix3d turned;
    for (int i = 0; i < 3; ++i) {
      const Vector3d v = part.col(i);
      const Vector3d across = axis.cross(v);
      turned.col(i) = v + across + axis.cross(across) / (1.0 + cosine);
    }
    return turned;
  }

  static constexpr std::size_t kMaxParts = 6;
  const Vector3d normal_;
  const double touching_;  ///< [m] a support function along the normal that is less than this counts as zero
  std::size_t count_ = 0;
  std::array<Matrix3d, kMaxParts> parts_;
  std::size_t segment_count_ = 0;
  std::array<Segment, kMaxParts> segments_;
  Vector3d centre_ = Vector3d::Zero();
  Matrix3d q_ = Matrix3d::Zero();
  Matrix3d m_;
};

}  // namespace

double depthOfInnerEllipsoid(const Cso& cso, const StationaryDirection& direction, double depth, double tolerance) {
  double best = kNothing;
  for (const Segments segments : {Segments::Whole, Segments::Ends}) {
    const InnerEllipsoid ellipsoid(cso, direction, depth, segments);
    best = std::max({best, ellipsoid.radius(depth), ellipsoid.radius(depth - 0.25 * tolerance)});
    if (best >= depth - 0.5 * tolerance) break;
  }
  return best - 2.0 * cso.rounding();
}

}  // namespace proximity_server::narrowphase
