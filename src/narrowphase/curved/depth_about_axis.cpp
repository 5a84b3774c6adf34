#include "narrowphase/curved/depth_about_axis.h"

#include "narrowphase/closed_form/parallel_axes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Complex = std::complex<double>;  // a vector of the plane across the axis, or a rotation about the axis
using Kind = Shape::Kind;

/// A vector of length 1; 1 if the vector is too short to have a direction.
Complex normalized(const Complex& z) {
  const double length = std::abs(z);
  return length > support::kShortest ? z / length : Complex(1.0);
}

constexpr double kNothing = -std::numeric_limits<double>::infinity();

/// The latitude, from -90 to 90 degrees, as a unit vector (cosine, sine). Angles have no other form here: the last
/// digit of a sine is not the same on every processor.
using Latitude = Vector2d;

/// A direction in the frame of the search: z is the axis of a, and that of b is tilted towards x.
struct Direction {
  Latitude latitude;
  Complex azimuth;  ///< of length 1
};

/// The circle of latitude of a core through its support point. That of an ellipsoid may be an ellipse.
struct Circle {
  double radius;    ///< [m] the mean one of an ellipse
  double excess;    ///< [m] half the difference between the radii of an ellipse
  double height;    ///< [m] of its centre on the axis
  Complex azimuth;  ///< of the point of the unit circle that becomes the support point
};

/// A core, or the mirror image of b's, about an axis that is tilted towards x.
class TiltedCore {
 public:
  /// `axes` are those of the core in the frame of the search, `axis` is the number of that of revolution; `side` is 1
  /// for a and -1 for b.
  TiltedCore(const Shape& shape, int axis, const Matrix3d& axes, double side) : shape_(shape), axis_(axis) {
    const Vector3d up = shape.kind() == Kind::Point ? Vector3d(Vector3d::UnitZ()) : Vector3d(axes.col(axis));
    const double upwards = std::copysign(1.0, up.z());
    mirrored_ = side * upwards;
    sine_ = upwards * up.x();
    cosine_ = upwards * up.z();
    const Vector3d across = axes.col((axis + 1) % 3);
    const Complex first = normalized({cosine_ * across.x() - sine_ * across.z(), across.y()});
    of_excess_ = first * first;
  }

  double sine() const { return sine_; }      ///< of the tilt
  double cosine() const { return cosine_; }  ///< of the tilt
  /// The square of the azimuth of the axis in which the radius of an ellipse is larger by the excess.
  const Complex& ofExcess() const { return of_excess_; }

  Circle circle(const Direction& n) const {
    const Complex across_a = n.latitude.x() * n.azimuth;
    const Complex radial(cosine_ * across_a.real() - sine_ * n.latitude.y(), across_a.imag());
    const double along = sine_ * across_a.real() + cosine_ * n.latitude.y();
    if (shape_.kind() != Kind::Ellipsoid) {
      int vertex = 0;
      const Vector3d point = supportPoint(shape_, {std::abs(radial), 0.0, mirrored_ * along}, vertex);
      return {point.x(), 0.0, mirrored_ * point.z(), normalized(radial)};
    }
    const Vector3d& radii = shape_.halfExtents();
    const double first = radii[(axis_ + 1) % 3], second = radii[(axis_ + 2) % 3];
    const double mean = 0.5 * (first + second), excess = 0.5 * (first - second);
    const Complex across = mean * radial + excess * of_excess_ * std::conj(radial);
    const double up = radii[axis_] * along, length = std::hypot(std::abs(across), up);
    const double part = std::abs(across) / length;
    return {part * mean, part * excess, radii[axis_] * up / length, normalized(across)};
  }

 private:
  const Shape& shape_;
  int axis_;
  double mirrored_;  ///< -1: the axis in the frame of the core points the other way
  double sine_, cosine_;
  Complex of_excess_;
};

/// A function of the azimuth: constant + Re(first e^(ix) + second e^(2ix)), with the azimuth x from the middle of a
/// patch.
struct Harmonics {
  double constant = 0.0;
  Complex first = 0.0, second = 0.0;

  double inTheMiddle() const { return constant + first.real() + second.real(); }

  /// A lower bound of the minimum over -d <= x <= d, with half_width = e^(id) and d below a right angle. The second
  /// harmonic is replaced by its tangent: Re(s e^(2ix)) is Re(s) - 2 Im(s) sin(x) - 2 Re(s) sin^2(x)
  /// + 2 Im(s) sin(x) (1 - cos(x)), and 1 - cos(x) is at most sin^2(x).
  double minimumWithin(const Complex& half_width) const {
    const double cosine = first.real(), sine = std::abs(first.imag() + 2.0 * second.imag());
    const double across = half_width.real(), along = half_width.imag();
    const bool is_inside = -cosine * along > sine * across;
    const double smallest = is_inside ? -std::hypot(cosine, sine) : cosine * across - sine * along;
    const double rest = 2.0 * along * along * (std::abs(second.real()) + std::abs(second.imag()) * along);
    return constant + second.real() - rest + smallest;
  }
};

Harmonics operator*(double factor, const Harmonics& h) {
  return {factor * h.constant, factor * h.first, factor * h.second};
}
Harmonics operator+(const Harmonics& g, const Harmonics& h) {
  return {g.constant + h.constant, g.first + h.first, g.second + h.second};
}

/// The lower bound L of the support function by the circles through the support points in one direction.
class CircleBound {
 public:
  CircleBound(const TiltedCore& a, const TiltedCore& b, const Vector3d& offset, const Direction& n) {
    add(a, n);
    add(b, n);
    radial_.first -= Complex(offset.x(), -offset.y()) * n.azimuth;
    axial_.constant -= offset.z();
  }

  Harmonics at(const Direction& n) const { return n.latitude.x() * radial_ + n.latitude.y() * axial_; }

 private:
  /// With the tilt (s, k), the azimuth m of the direction and w of the support point: adds the height of the point of
  /// the circle at the azimuth w e^(ix) along the direction with the azimuth m e^(ix).
  void add(const TiltedCore& body, const Direction& n) {
    const Circle circle = body.circle(n);
    const double s = body.sine(), k = body.cosine();
    const Complex &m = n.azimuth, &w = circle.azimuth, excess = circle.excess * std::conj(body.ofExcess());
    radial_.constant += 0.5 * (w * std::conj(m) * ((1.0 + k) * circle.radius - (1.0 - k) * excess)).real();
    radial_.first += s * circle.height * m;
    radial_.second += 0.5 * w * m * ((1.0 + k) * excess - (1.0 - k) * circle.radius);
    axial_.constant += k * circle.height;
    axial_.first -= s * w * (circle.radius + excess);
  }

  Harmonics radial_, axial_;
};

struct Patch {
  Latitude low, high;
  Complex middle;      ///< the azimuth
  Complex half_width;  ///< the rotation by half of the range of azimuths, at most 45 degrees
};

/// The part of x in x + y, both of which are positive but for rounding.
double partOf(double x, double y) { return x + y > 0.0 ? std::clamp(x / (x + y), 0.0, 1.0) : 0.5; }

/// The lower bound of the support function h in a patch.
class PatchBound {
 public:
  PatchBound(const TiltedCore& a, const TiltedCore& b, const Vector3d& offset, const Patch& patch)
      : low_{patch.low, patch.middle}, high_{patch.high, patch.middle} {
    const CircleBound by_low(a, b, offset, low_), by_high(a, b, offset, high_);
    const Harmonics low_by_low = by_low.at(low_), low_by_high = by_high.at(low_);
    const Harmonics high_by_low = by_low.at(high_), high_by_high = by_high.at(high_);
    depth_low_ = low_by_low.inTheMiddle();
    depth_high_ = high_by_high.inTheMiddle();
    crossing_ = partOf(depth_low_ - low_by_high.inTheMiddle(), depth_high_ - high_by_low.inTheMiddle());
    // The weights make the lower one of both ends as high as possible.
    const auto smallest = [&](const Harmonics& h) { return h.minimumWithin(patch.half_width); };
    const double part =
        partOf(smallest(high_by_high) - smallest(low_by_high), smallest(low_by_low) - smallest(high_by_low));
    const Harmonics at_low = part * low_by_low + (1.0 - part) * low_by_high;
    const Harmonics at_high = part * high_by_low + (1.0 - part) * high_by_high;
    const double smallest_low = smallest(at_low), smallest_high = smallest(at_high);
    minimum_ = std::min(smallest_low, smallest_high);
    in_the_middle_ = (smallest_low < smallest_high ? at_low : at_high).inTheMiddle();
  }

  double minimum() const { return minimum_; }

  /// h in the shallower one of both directions.
  double depth() const { return std::min(depth_low_, depth_high_); }
  const Direction& shallower() const { return depth_low_ < depth_high_ ? low_ : high_; }
  const Direction& deeper() const { return depth_low_ < depth_high_ ? high_ : low_; }

  bool losesMoreAcross() const { return depth() - in_the_middle_ > in_the_middle_ - minimum_; }

  /// The part of the way from low to high at which the bounds by both are equal; not too near to either.
  double crossing() const { return std::clamp(crossing_, 0.05, 0.95); }

 private:
  const Direction low_, high_;
  double depth_low_, depth_high_, crossing_, minimum_, in_the_middle_;
};

/// The numbers of the axes about which the cores are round.
struct Axes {
  int of_a, of_b;
};

/// Branch and bound over patches of directions.
class PatchSearch {
 public:
  PatchSearch(const Cso& cso, const Axes& axes)
      : frame_(frameOf(cso, axes)),
        a_(cso.a(), axes.of_a, frame_.transpose(), 1.0),
        b_(cso.b(), axes.of_b, frame_.transpose() * cso.bAxes(), -1.0),
        offset_(frame_.transpose() * cso.bOrigin()) {
    const double part = std::sqrt(0.5);
    for (const double x : {-part, part})
      for (const double y : {-part, part})
        for (const double pole : {-1.0, 1.0}) {
          // Beside the pole by less than rounding: from there the support point lies on the rim.
          const Latitude equator(1.0, 0.0), end(1e-16, pole);
          open_[count_++] = {pole < 0.0 ? end : equator, pole < 0.0 ? equator : end, {x, y}, {part, part}};
        }
  }

  /// The depth in all directions is at least the returned one, which is `gap` below a known one.
  double run(double depth, double gap, const RefineDirection& refine) {
    int misses = 0;
    for (int patches = 0; count_ > 0; ++patches) {
      if (patches == kMaxPatches || misses == kMaxMisses || count_ >= kMaxOpen || !(depth > gap)) return kNothing;
      const Patch patch = open_[--count_];
      const PatchBound bound(a_, b_, offset_, patch);
      if (bound.minimum() >= depth - gap) continue;
      divide(patch, bound);
      if (!(bound.depth() < depth - 0.5 * gap)) continue;
      depth = refine({inFrameOfA(bound.shallower()), inFrameOfA(bound.deeper())});
      if (!(bound.depth() < depth - gap)) continue;
      // The CSO reaches farther here than the inner cores. Try all other patches before the parts of this one.
      ++misses;
      std::rotate(open_.begin(), open_.begin() + count_ - 2, open_.begin() + count_);
    }
    return depth - gap;
  }

 private:
  static constexpr std::size_t kMaxOpen = 256;
  static constexpr int kMaxPatches = 10000;
  static constexpr int kMaxMisses = 64;

  /// The axes of the frame of the search, in the frame of a.
  static Matrix3d frameOf(const Cso& cso, const Axes& axes) {
    const Vector3d of_b = cso.bAxes().col(axes.of_b).normalized();
    Matrix3d frame;
    frame.col(2) = cso.a().kind() == Kind::Point ? of_b : Vector3d(Vector3d::Unit(axes.of_a));
    const auto across = [&](const Vector3d& v) { return Vector3d(v - v.dot(frame.col(2)) * frame.col(2)); };
    // Twice, as the first time may leave nothing but rounding, in any direction.
    const Vector3d tilt = across(across(of_b).stableNormalized());
    frame.col(0) = tilt.norm() > 0.5 ? Vector3d(tilt.normalized()) : Vector3d(frame.col(2).unitOrthogonal());
    frame.col(1) = frame.col(2).cross(frame.col(0));
    return frame;
  }

  Vector3d inFrameOfA(const Direction& n) const {
    const Complex across = n.latitude.x() * n.azimuth;
    return (frame_ * Vector3d(across.real(), across.imag(), n.latitude.y())).normalized();
  }

  void divide(const Patch& patch, const PatchBound& bound) {
    if (bound.losesMoreAcross()) {
      const double part = bound.crossing();
      const Latitude between = ((1.0 - part) * patch.low + part * patch.high).normalized();
      open_[count_++] = {patch.low, between, patch.middle, patch.half_width};
      open_[count_++] = {between, patch.high, patch.middle, patch.half_width};
    } else {
      const Complex half = normalized(1.0 + patch.half_width);  // half of the angle
      open_[count_++] = {patch.low, patch.high, normalized(patch.middle * std::conj(half)), half};
      open_[count_++] = {patch.low, patch.high, normalized(patch.middle * half), half};
    }
  }

  const Matrix3d frame_;
  const TiltedCore a_, b_;
  const Vector3d offset_;
  std::size_t count_ = 0;
  std::array<Patch, kMaxOpen> open_;
};

/// True if a core is round about this axis, or nearly: then it is an ellipsoid.
bool isRoundAbout(const Shape& shape, int axis, double rounding) {
  constexpr double kNearly = 0.05;  // of the radius
  if (shape.kind() == Kind::Ellipsoid) {
    const double first = shape.halfExtents()[(axis + 1) % 3], second = shape.halfExtents()[(axis + 2) % 3];
    return std::abs(first - second) <= kNearly * first;
  }
  if (axis != 2) return false;
  if (shape.kind() != Kind::Sweep) return isSolidOfRevolution(shape.kind());
  const Shape& swept = shape.sweep().shape;
  const Isometry3d& end = shape.sweep().end;
  const Vector3d tip = end.translation() + swept.coreReach() * end.linear().col(2);
  const bool is_round = swept.kind() == Kind::Ellipsoid ? swept.halfExtents().x() == swept.halfExtents().y()
                                                        : isRoundAbout(swept, 2, rounding);
  return is_round && tip.head<2>().norm() <= rounding && end.translation().head<2>().norm() <= rounding;
}

/// The two axes that are tilted least against each other. Returns nullopt if the tilt is large.
std::optional<Axes> nearlyParallelAxes(const Cso& cso) {
  double greatest = 1.0 - 2e-4;  // cosine of 0.02 rad
  std::optional<Axes> axes;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const bool has_point = cso.a().kind() == Kind::Point || cso.b().kind() == Kind::Point;
      const double cosine = has_point ? 1.0 : std::abs(cso.bAxes()(i, j));
      if (!(cosine > greatest)) continue;
      if (!isRoundAbout(cso.a(), i, cso.rounding()) || !isRoundAbout(cso.b(), j, cso.rounding())) continue;
      greatest = cosine;
      axes = Axes{i, j};
    }
  return axes;
}

/// A core that lies inside of another one, and its pose in the frame of that.
struct InnerCore {
  Shape core;
  Isometry3d pose = Isometry3d::Identity();
};

/// The segment between two vertices of a hull from which no vertex is farther than `radius` [m]. Returns nullopt if the
/// hull is thicker or has no length.
std::optional<InnerCore> innerSegment(const ConvexHull& hull, double radius) {
  const auto farthestFrom = [&](const Vector3d& point) {
    return *std::max_element(hull.vertices().begin(), hull.vertices().end(), [&](const Vector3d& p, const Vector3d& q) {
      return (p - point).squaredNorm() < (q - point).squaredNorm();
    });
  };
  const Vector3d start = farthestFrom(hull.vertices()[0]), end = farthestFrom(start);
  const double length = (end - start).norm();
  if (!(length > radius)) return std::nullopt;
  const Vector3d axis = (end - start) / length;
  for (const Vector3d& vertex : hull.vertices())
    if (!((vertex - start).cross(axis).norm() <= radius)) return std::nullopt;
  // The shortest rotation of z into one of the two directions of the axis, which is no more than a right angle.
  const Vector3d up = axis.z() < 0.0 ? Vector3d(-axis) : axis;
  const Eigen::Quaterniond turn = Eigen::Quaterniond(1.0 + up.z(), -up.y(), up.x(), 0.0).normalized();
  return InnerCore{Capsule{1.0, length}, Eigen::Translation3d(start + 0.5 * length * axis) * turn};
}

/// Returns the core itself, or an inner core that may be round: the segment inside of a hull that is as thin as a
/// quarter of the tolerance, or the start of a sweep.
InnerCore innerCore(const Shape& shape, double rounding, double tolerance) {
  if (shape.kind() == Kind::Hull) return innerSegment(shape.hull(), 0.25 * tolerance).value_or(InnerCore{shape});
  if (shape.kind() == Kind::Sweep && !isRoundAbout(shape, 2, rounding)) return {shape.sweep().shape};
  return {shape};
}

}  // namespace

double depthAboutAxis(const Cso& cso, double depth, double tolerance, const RefineDirection& refine) {
  if (cso.isPolytope()) return kNothing;
  const InnerCore a = innerCore(cso.a(), cso.rounding(), tolerance), b = innerCore(cso.b(), cso.rounding(), tolerance);
  const Isometry3d pose = a.pose.inverse() * cso.pose() * b.pose;
  WarmStart none;
  const Cso inner(a.core, b.core, pose, cso.rounding(), none);
  const std::optional<Axes> axes = nearlyParallelAxes(inner);
  if (!axes) return kNothing;
  const auto refineOuter = [&](const std::array<Vector3d, 2>& directions) {
    return refine({a.pose.linear() * directions[0], a.pose.linear() * directions[1]});
  };
  // The axes of b need not be perpendicular unit vectors to the last digit.
  const double skew = (inner.bAxes().transpose() * inner.bAxes() - Matrix3d::Identity()).norm();
  const double reach = a.core.coreReach() + b.core.coreReach() + inner.bOrigin().norm();
  // Four of them are for the inner cores and their pose.
  const double rounding = 16.0 * cso.rounding() + skew * reach, gap = 0.5 * tolerance - rounding;
  return gap > rounding ? PatchSearch(inner, *axes).run(depth, gap, refineOuter) - rounding : kNothing;
}

}  // namespace proximity_server::narrowphase
