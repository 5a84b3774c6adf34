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

/// A direction in the frame of the search: z is the axis of a, and the axis of b is tilted towards x; if a has none, z
/// is the axis of b.
struct Direction {
  Latitude latitude;
  Complex azimuth;  ///< of length 1
};

/// The circle of latitude of a core through its support point. For an ellipsoid it may be an ellipse; for a core
/// without an axis is the support point alone.
struct Circle {
  double radius;    ///< [m] the mean one of an ellipse
  double excess;    ///< [m] half the difference between the radii of an ellipse
  Vector3d centre;  ///< in the frame of the search
  Complex azimuth;  ///< of the point of the unit circle that becomes the support point
};

constexpr int kNoAxis = -1;

/// A core, or the mirror image of b's, about an axis that is tilted towards x, if it has one.
class TiltedCore {
 public:
  /// `axes` are the axes of the core in the frame of the search, `axis` is the number of the axis of revolution; `side`
  /// is 1 for a and -1 for b.
  TiltedCore(const Shape& shape, int axis, const Matrix3d& axes, double side)
      : shape_(shape), axis_(axis), mirrored_axes_(side * axes) {
    if (shape.kind() == Kind::Ellipsoid) ball_ = ballOf(shape.halfExtents(), axis);
    if (axis == kNoAxis) return;
    const Vector3d up = axes.col(axis);
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

  /// [m] The radius of a ball to which a convex rest can be added so that the sum is the core: the smallest radius of
  /// curvature of an ellipsoid, unless its circles are ellipses; 0 for other cores.
  double ball() const { return ball_; }

  /// The circle of the core without `part` of its ball.
  Circle circle(const Direction& n, double part_of_ball) const {
    const Complex across_a = n.latitude.x() * n.azimuth;
    if (axis_ == kNoAxis) {
      const Vector3d direction(across_a.real(), across_a.imag(), n.latitude.y());
      int vertex = 0;
      const Vector3d point = mirrored_axes_ * supportPoint(shape_, mirrored_axes_.transpose() * direction, vertex);
      return {0.0, 0.0, point - part_of_ball * ball_ * direction, 1.0};
    }
    const Complex radial(cosine_ * across_a.real() - sine_ * n.latitude.y(), across_a.imag());
    const double along = sine_ * across_a.real() + cosine_ * n.latitude.y();
    if (shape_.kind() != Kind::Ellipsoid) {
      int vertex = 0;
      const Vector3d point = supportPoint(shape_, {std::abs(radial), 0.0, mirrored_ * along}, vertex);
      return {point.x(), 0.0, onAxis(mirrored_ * point.z()), normalized(radial)};
    }
    const Vector3d& radii = shape_.halfExtents();
    const double first = radii[(axis_ + 1) % 3], second = radii[(axis_ + 2) % 3];
    const double mean = 0.5 * (first + second), excess = 0.5 * (first - second);
    const Complex across = mean * radial + excess * of_excess_ * std::conj(radial);
    const double up = radii[axis_] * along, length = std::hypot(std::abs(across), up);
    const double part = std::abs(across) / length;
    const double ball = part_of_ball * ball_;
    return {part * mean - ball * std::abs(radial), part * excess, onAxis(radii[axis_] * up / length - ball * along),
            normalized(across)};
  }

 private:
  static double ballOf(const Vector3d& radii, int axis) {
    const double least = radii.minCoeff(), largest = radii.maxCoeff();
    const bool has_ellipses = axis != kNoAxis && radii[(axis + 1) % 3] != radii[(axis + 2) % 3];
    return has_ellipses ? 0.0 : least * least / largest;
  }
  Vector3d onAxis(double height) const { return {sine_ * height, 0.0, cosine_ * height}; }

  const Shape& shape_;
  int axis_;
  Matrix3d mirrored_axes_;
  double mirrored_ = 1.0;  ///< -1: the axis in the frame of the core points the other way
  double sine_ = 0.0, cosine_ = 1.0;
  double ball_ = 0.0;
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

/// The lower bound L of the support function by the circles through the support points in one direction, less `part` of
/// the balls.
class CircleBound {
 public:
  CircleBound(const TiltedCore& a, const TiltedCore& b, const Vector3d& offset, const Direction& n, double part) {
    add(a, n, part);
    add(b, n, part);
    addPoint(-offset, n);
  }

  Harmonics at(const Direction& n) const { return n.latitude.x() * radial_ + n.latitude.y() * axial_; }

 private:
  /// With the tilt (s, k), the azimuth m of the direction and w of the support point: adds the height of the point of
  /// the circle at the azimuth w e^(ix) along the direction with the azimuth m e^(ix).
  void add(const TiltedCore& body, const Direction& n, double part) {
    const Circle circle = body.circle(n, part);
    const double s = body.sine(), k = body.cosine();
    const Complex &m = n.azimuth, &w = circle.azimuth, excess = circle.excess * std::conj(body.ofExcess());
    radial_.constant += 0.5 * (w * std::conj(m) * ((1.0 + k) * circle.radius - (1.0 - k) * excess)).real();
    radial_.second += 0.5 * w * m * ((1.0 + k) * excess - (1.0 - k) * circle.radius);
    axial_.first -= s * w * (circle.radius + excess);
    addPoint(circle.centre, n);
  }

  void addPoint(const Vector3d& point, const Direction& n) {
    radial_.first += Complex(point.x(), -point.y()) * n.azimuth;
    axial_.constant += point.z();
  }

  Harmonics radial_, axial_;
};

struct Patch {
  Latitude low, high;
  Complex middle;      ///< the azimuth
  Complex half_width;  ///< the rotation by half of the range of azimuths, at most 45 degrees
  /// [m] The patch with the smallest order is looked at first: a lower bound of h, or from the depth on for the last ones.
  double order = kNothing;

  bool operator<(const Patch& other) const { return order < other.order; }
};

/// The part of x in x + y, both of which are positive but for rounding.
double partOf(double x, double y) { return x + y > 0.0 ? std::clamp(x / (x + y), 0.0, 1.0) : 0.5; }

/// The lower bound of the support function h in a patch. The share `part` of the balls is left out.
class PatchBound {
 public:
  PatchBound(const TiltedCore& a, const TiltedCore& b, const Vector3d& offset, const Patch& patch, double part)
      : low_{patch.low, patch.middle}, high_{patch.high, patch.middle}, balls_(part * (a.ball() + b.ball())) {
    const CircleBound by_low(a, b, offset, low_, part), by_high(a, b, offset, high_, part);
    const Harmonics low_by_low = by_low.at(low_), low_by_high = by_high.at(low_);
    const Harmonics high_by_low = by_low.at(high_), high_by_high = by_high.at(high_);
    depth_low_ = low_by_low.inTheMiddle();
    depth_high_ = high_by_high.inTheMiddle();
    crossing_ = partOf(depth_low_ - low_by_high.inTheMiddle(), depth_high_ - high_by_low.inTheMiddle());
    // The weights make the lower one of both ends as high as possible.
    const auto smallest = [&](const Harmonics& h) { return h.minimumWithin(patch.half_width); };
    const double weight =
        partOf(smallest(high_by_high) - smallest(low_by_high), smallest(low_by_low) - smallest(high_by_low));
    const Harmonics at_low = weight * low_by_low + (1.0 - weight) * low_by_high;
    const Harmonics at_high = weight * high_by_low + (1.0 - weight) * high_by_high;
    const double smallest_low = smallest(at_low), smallest_high = smallest(at_high);
    minimum_ = std::min(smallest_low, smallest_high);
    in_the_middle_ = (smallest_low < smallest_high ? at_low : at_high).inTheMiddle();
  }

  /// -infinity if the bound without the balls is not positive: then it proves nothing between low and high.
  double minimum() const { return minimum_ > 0.0 ? minimum_ + balls_ : kNothing; }

  /// h in the shallower one of both directions.
  double depth() const { return std::min(depth_low_, depth_high_) + balls_; }
  const Direction& shallower() const { return depth_low_ < depth_high_ ? low_ : high_; }
  const Direction& deeper() const { return depth_low_ < depth_high_ ? high_ : low_; }

  bool losesMoreAcross() const {
    return std::min(depth_low_, depth_high_) - in_the_middle_ > in_the_middle_ - minimum_;
  }

  /// The part of the way from low to high at which the bounds by both are equal; not too near to either.
  double crossing() const { return std::clamp(crossing_, 0.05, 0.95); }

 private:
  const Direction low_, high_;
  const double balls_;  ///< [m] left out of the following
  double depth_low_, depth_high_, crossing_, minimum_, in_the_middle_;
};

/// The difference of the support points along a direction and against it.
Vector3d chord(const Shape& shape, const Vector3d& direction) {
  int vertex = 0;
  return supportPoint(shape, direction, vertex) - supportPoint(shape, -direction, vertex);
}

/// The direction of the longest chord along an axis: nearly the direction of a needle. UnitZ for a point.
Vector3d longestChord(const Shape& shape) {
  Vector3d longest = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d along = chord(shape, Vector3d::Unit(axis));
    if (along.squaredNorm() > longest.squaredNorm()) longest = along;
  }
  return longest.norm() > support::kShortest ? Vector3d(longest.normalized()) : Vector3d(Vector3d::UnitZ());
}

/// The numbers of the axes about which the cores are round, or kNoAxis.
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

  /// The depth in all directions is at least the returned one, which is `width` below a known one.
  double run(double depth, double width, const RefineDirection& refine) {
    int misses = 0;
    for (int patches = 0; count_ > 0; ++patches) {
      if (patches == kMaxPatches || misses == kMaxMisses || count_ >= kMaxOpen || !(depth > width)) return kNothing;
      const Patch patch = next();
      const PatchBound bound(a_, b_, offset_, patch, partOfBalls(depth - kFarFromZero * width));
      if (bound.minimum() >= depth - width) continue;
      if (bound.depth() < depth - 0.5 * width)
        depth = refine({inFrameOfA(bound.shallower()), inFrameOfA(bound.deeper())});
      // If the CSO reaches farther here than the inner cores, try all other patches before the parts of this one, and
      // the large ones first.
      const bool is_missed = bound.depth() < depth - width;
      misses += is_missed ? 1 : 0;
      divide(patch, bound, is_missed ? depth * misses : bound.minimum());
    }
    return depth - width;
  }

 private:
  static constexpr double kFarFromZero = 4.0;  // more than 1, so that a bound that proves the depth is positive
  static constexpr std::size_t kMaxOpen = 256;
  // Evidence: of 4000 searches in ./dev stress, 2 that converge need more than 1000 patches, none more than 2000. A prism of
  // a hundred sides, with a hundred nearly equal depths, would take thousands.
  static constexpr int kMaxPatches = 2000;
  static constexpr int kMaxMisses = 64;

  /// The axes of the frame of the search, in the frame of a. If no core has an axis, z is along a polytope.
  static Matrix3d frameOf(const Cso& cso, const Axes& axes) {
    Vector3d of_b = cso.bAxes().col(std::max(axes.of_b, 0)).normalized();
    if (axes.of_a == kNoAxis && axes.of_b == kNoAxis)
      of_b = cso.a().isPolytope() ? longestChord(cso.a()) : Vector3d(cso.bAxes() * longestChord(cso.b())).normalized();
    Matrix3d frame;
    frame.col(2) = axes.of_a == kNoAxis ? of_b : Vector3d(Vector3d::Unit(axes.of_a));
    const auto across = [&](const Vector3d& v) { return Vector3d(v - v.dot(frame.col(2)) * frame.col(2)); };
    // Twice, as the first time may leave nothing but rounding, in any direction.
    const Vector3d tilt = across(across(of_b).stableNormalized());
    frame.col(0) = tilt.norm() > 0.5 ? Vector3d(tilt.normalized()) : Vector3d(frame.col(2).unitOrthogonal());
    frame.col(1) = frame.col(2).cross(frame.col(0));
    return frame;
  }

  /// The part of the balls that is left out, so that what is left of the depth [m] to prove stays positive.
  double partOfBalls(double most) const {
    const double balls = a_.ball() + b_.ball();
    return balls > 0.0 ? std::clamp(most / balls, 0.0, 1.0) : 0.0;
  }

  Vector3d inFrameOfA(const Direction& n) const {
    const Complex across = n.latitude.x() * n.azimuth;
    return (frame_ * Vector3d(across.real(), across.imag(), n.latitude.y())).normalized();
  }

  /// Takes a patch from the open ones: the first in their order, or where many are open the newest, which leaves few.
  Patch next() {
    const auto last = open_.begin() + --count_;
    if (count_ < kMaxOpen / 2) std::iter_swap(last, std::min_element(open_.begin(), last + 1));
    return *last;
  }

  void divide(const Patch& patch, const PatchBound& bound, double order) {
    if (bound.losesMoreAcross()) {
      const double part = bound.crossing();
      const Latitude between = ((1.0 - part) * patch.low + part * patch.high).normalized();
      open_[count_++] = {patch.low, between, patch.middle, patch.half_width, order};
      open_[count_++] = {between, patch.high, patch.middle, patch.half_width, order};
    } else {
      const Complex half = normalized(1.0 + patch.half_width);  // half of the angle
      open_[count_++] = {patch.low, patch.high, normalized(patch.middle * std::conj(half)), half, order};
      open_[count_++] = {patch.low, patch.high, normalized(patch.middle * half), half, order};
    }
  }

  const Matrix3d frame_;
  const TiltedCore a_, b_;
  const Vector3d offset_;
  std::size_t count_ = 0;
  std::array<Patch, kMaxOpen> open_;
};

/// The difference of the radii of an ellipsoid across this axis, as a part of the radius; 0 for other cores.
double departureFromRound(const Shape& shape, int axis) {
  const double first = shape.halfExtents()[(axis + 1) % 3], second = shape.halfExtents()[(axis + 2) % 3];
  return shape.kind() == Kind::Ellipsoid ? std::abs(first - second) / first : 0.0;
}

/// True if a core is round about this axis, or nearly: then it is an ellipsoid.
bool isRoundAbout(const Shape& shape, int axis, double rounding) {
  constexpr double kNearly = 0.05;  // of the radius
  if (shape.kind() == Kind::Ellipsoid) return departureFromRound(shape, axis) <= kNearly;
  if (axis != 2 || shape.kind() == Kind::Point) return false;
  if (shape.kind() != Kind::Sweep) return isSolidOfRevolution(shape.kind());
  const Shape& swept = shape.sweep().shape;
  const Isometry3d& end = shape.sweep().end;
  const Vector3d tip = end.translation() + swept.coreReach() * end.linear().col(2);
  const bool is_round = swept.kind() == Kind::Ellipsoid ? swept.halfExtents().x() == swept.halfExtents().y()
                                                        : isRoundAbout(swept, 2, rounding);
  return is_round && tip.head<2>().norm() <= rounding && end.translation().head<2>().norm() <= rounding;
}

/// True if the search needs no axis of a core: a polytope that is thin beside both cores, so that the kinks of h between
/// its vertices are slight, or nearly a ball. `size` [m] is the size of both cores.
bool needsNoAxis(const Shape& shape, double size) {
  constexpr double kThin = 5e-3, kNearlyABall = 0.9;
  const Vector3d& radii = shape.halfExtents();
  if (!shape.isPolytope())
    return shape.kind() == Kind::Ellipsoid && radii.minCoeff() >= kNearlyABall * radii.maxCoeff();
  const Vector3d along = longestChord(shape), u = along.unitOrthogonal(), v = along.cross(u);
  return std::max(u.dot(chord(shape, u)), v.dot(chord(shape, v))) <= kThin * size;
}

/// The axis about which a curved core is the roundest; kNoAxis if it is not round, or if it needs none and is not quite
/// round.
int axisOf(const Shape& shape, double rounding, bool needs_none) {
  int roundest = kNoAxis;
  double least = needs_none ? 0.0 : 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double departure = departureFromRound(shape, axis);
    if (shape.isPolytope() || !isRoundAbout(shape, axis, rounding) || departure > least) continue;
    roundest = axis;
    least = departure;
  }
  return roundest;
}

/// The two axes that are tilted least against each other, or the axis of one core if the other one needs none. Returns
/// nullopt if the tilt is large.
std::optional<Axes> axesOf(const Cso& cso) {
  double greatest = 1.0 - 2e-4;  // cosine of 0.02 rad
  std::optional<Axes> axes;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double cosine = std::abs(cso.bAxes()(i, j));
      if (!(cosine > greatest)) continue;
      if (!isRoundAbout(cso.a(), i, cso.rounding()) || !isRoundAbout(cso.b(), j, cso.rounding())) continue;
      greatest = cosine;
      axes = Axes{i, j};
    }
  if (axes) return axes;
  const double size = cso.a().coreRadius() + cso.b().coreRadius();
  const bool a_needs_none = needsNoAxis(cso.a(), size), b_needs_none = needsNoAxis(cso.b(), size);
  const int of_a = axisOf(cso.a(), cso.rounding(), a_needs_none), of_b = axisOf(cso.b(), cso.rounding(), b_needs_none);
  if (of_a != kNoAxis && b_needs_none) return Axes{of_a, kNoAxis};
  if (of_b != kNoAxis && a_needs_none) return Axes{kNoAxis, of_b};
  if (a_needs_none && b_needs_none) return Axes{kNoAxis, kNoAxis};
  return std::nullopt;
}

/// The core itself, or the start of a curved sweep that is not along the axis.
const Shape& innerCore(const Shape& shape, double rounding) {
  const bool is_kept = shape.kind() != Kind::Sweep || shape.isPolytope() || isRoundAbout(shape, 2, rounding);
  return is_kept ? shape : shape.sweep().shape;
}

}  // namespace

double depthAboutAxis(const Cso& cso, double depth, double tolerance, const RefineDirection& refine) {
  if (cso.isPolytope()) return kNothing;
  const Shape &a = innerCore(cso.a(), cso.rounding()), &b = innerCore(cso.b(), cso.rounding());
  WarmStart none;
  const Cso inner(a, b, cso.pose(), cso.rounding(), none);
  const std::optional<Axes> axes = axesOf(inner);
  if (!axes) return kNothing;
  // The axes of b need not be perpendicular unit vectors to the last digit.
  const double skew = (inner.bAxes().transpose() * inner.bAxes() - Matrix3d::Identity()).norm();
  const double reach = a.coreReach() + b.coreReach() + inner.bOrigin().norm();
  // Four of them are for the inner cores.
  const double rounding = 16.0 * cso.rounding() + skew * reach, width = 0.5 * tolerance - rounding;
  return width > rounding ? PatchSearch(inner, *axes).run(depth, width, refine) - rounding : kNothing;
}

}  // namespace proximity_server::narrowphase
