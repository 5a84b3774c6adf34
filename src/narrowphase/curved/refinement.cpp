#include "narrowphase/curved/refinement.h"

#include "narrowphase/curved/stationary_rims.h"
#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = Shape::Kind;
using Tangents = Eigen::Matrix<double, 3, 2>;

constexpr double kNothingProven = 1.0;

/// Cosine of the widest of six caps, all below 90 degrees, for which holds(cosine) is true; kNothingProven if there is
/// none.
template <typename Holds>
double widestCap(Holds holds) {
  for (const double cosine : {0.05, 0.5, 0.8, 0.94, 0.985, 0.996})
    if (holds(cosine)) return cosine;
  return kNothingProven;
}

Tangents tangentsOf(const Vector3d& normal) {
  Tangents tangents;
  tangents.col(0) = normal.unitOrthogonal();
  tangents.col(1) = normal.cross(tangents.col(0));
  return tangents;
}

/// True if a support function stays above `height` in a cap, if at the angle s from its middle it is at least
/// height cos(s) + climb sin(s). The condition is climb sin(s) >= height (1 - cos(s)).
bool climbHolds(double height, double climb, double cosine) {
  return climb * (1.0 + cosine) >= height * std::sqrt(1.0 - cosine * cosine);
}

double capOfClimb(double height, double climb) {
  return widestCap([&](double cosine) { return climbHolds(height, climb, cosine); });
}

/// The curve of one core along a normal: its support point relative to the centre, and the second derivative of its
/// support function in the tangent plane.
struct CurveAt {
  Vector3d point = Vector3d::Zero();
  Matrix2d curvature = Matrix2d::Zero();
  double length = 1.0;   ///< |S^T n| along this normal, see Curve
  double largest = 1.0;  ///< the largest |S^T n| along any normal

  /// The factor by which the curvature has to be multiplied to be a lower bound in all of a cap.
  double kept(double cosine) const {
    constexpr double kHalfRightAngle = 0.71;  // up to 45 degrees, |S^T n| is bounded by its bound on the cap's edge
    if (cosine < kHalfRightAngle) return length / largest;
    return length / std::min(largest, length * cosine + largest * std::sqrt(1.0 - cosine * cosine));
  }
};

/// The curved part of a core: the circle of a rim, or an ellipsoid. Both are the image of a ball under a matrix S, with
/// the support function |S^T n|. In the direction m at an angle s from n, the support function exceeds its tangent at n
/// by at least 1/2 sin^2(s) times its curvature times |S^T n| / |S^T m|, as 1 - cos(x) >= 1/2 sin^2(x).
class Curve {
 public:
  Curve(const Shape& shape, const Matrix3d& axes) : radii_(Vector3d::Zero()), axes_(axes) {
    if (shape.kind() == Kind::Ellipsoid) radii_ = shape.halfExtents();
    if (shape.kind() == Kind::Cylinder || shape.kind() == Kind::Cone)
      radii_.head<2>().setConstant(shape.halfExtents().x());
  }

  CurveAt along(const Vector3d& normal, const Tangents& tangents) const {
    if (radii_.x() == 0.0) return {};
    if (radii_.z() == 0.0) return ofCircle(normal, tangents);
    const double largest = radii_.maxCoeff();
    const Vector3d stretched = radii_.cwiseProduct(axes_.transpose() * normal);
    const double length = stretched.norm();
    if (!(length > support::kShortest)) return atNoPoint();
    const Vector3d unit = stretched / length;
    const Tangents across = radii_.asDiagonal() * (axes_.transpose() * tangents);
    const Vector2d slope = across.transpose() * unit;
    return {axes_ * radii_.cwiseProduct(unit), (across.transpose() * across - slope * slope.transpose()) / length,
            length, largest};
  }

 private:
  /// Along the axis of a circle, or where digits are lost: NaN, with which the steps of Newton's method end.
  static CurveAt atNoPoint() {
    CurveAt none;
    none.point.setConstant(std::numeric_limits<double>::quiet_NaN());
    return none;
  }

  /// The curvature of a circle is that along its tangent.
  CurveAt ofCircle(const Vector3d& normal, const Tangents& tangents) const {
    const auto plane = axes_.leftCols<2>();
    const Vector2d inside = plane.transpose() * normal;
    const double length = inside.norm(), radius = radii_.x();
    if (!(length > support::kShortest)) return atNoPoint();
    const Vector2d unit = inside / length;
    const Vector2d along = tangents.transpose() * (plane * Vector2d(-unit.y(), unit.x()));
    return {plane * (radius * unit), radius / length * along * along.transpose(), radius * length, radius};
  }

  Vector3d radii_;
  Matrix3d axes_;
};

/// Centre of the smooth piece of a core on which `point` lies, in the core's frame. For an apex or a corner it is the
/// point itself.
struct Centre {
  Vector3d point;
  bool curved;
};

Centre centreOf(const Shape& shape, const Vector3d& point) {
  const Vector3d end(0.0, 0.0, std::copysign(shape.halfExtents().z(), point.z()));
  switch (shape.kind()) {
    case Kind::Cylinder:
      return {end, true};
    case Kind::Cone:
      return {end, point.z() < 0.0};
    case Kind::Ellipsoid:
      return {Vector3d::Zero(), true};
    default:
      return {point, false};
  }
}

/// A smooth piece of the CSO: the sum of a smooth piece of a and one of -b, in the frame of a.
struct SmoothPiece {
  Centre of_a, of_b;
  double weight;
  Vector2d slope;  ///< gradient of its support function at the normal, along the tangents
  double height;   ///< [m] of its support plane over the origin
};

/// The smooth pieces of the CSO near the stationary direction, and the steps of Newton's method.
///
/// Let w_i(n) be the support point of piece i, l_i weights of sum 1, and h the common height. The equation is
/// sum l_i w_i(n) = h n, with the unknowns n, l and h; the derivative of w_i is the curvature C_i. In the tangent plane
/// of n a step turns n by t, with (sum l_i C_i - h) t + sum l_i slope_i = 0 and slope_i . t + height_i equal for all i.
class Pieces {
 public:
  Pieces(const Cso& cso, const Simplex& simplex)
      : cso_(cso), curve_a_(cso.a(), Matrix3d::Identity()), curve_b_(cso.b(), cso.bAxes()) {
    for (int place = 0; place < 4; ++place)
      if (simplex.has(place)) add(simplex[place]);
    for (int i = 0; i < count_; ++i) piece(i).weight = 1.0 / count_;
  }

  Pieces(const Cso& cso, const StationaryRims& rims)
      : cso_(cso), curve_a_(cso.a(), Matrix3d::Identity()), curve_b_(cso.b(), cso.bAxes()) {
    const Vector3d on_b = cso.bAxes().transpose() * (rims.direction.points.on_b - cso.bOrigin());
    for (const RimWeight& of_a : rimsOf(cso.a(), rims.ends.of_a, rims.direction.points.on_a.z()))
      for (const RimWeight& of_b : rimsOf(cso.b(), rims.ends.of_b, on_b.z())) {
        if (of_a.weight == 0.0 || of_b.weight == 0.0) continue;
        const Vector3d centre_b = cso.bAxes() * of_b.centre + cso.bOrigin();
        const bool curved_a = cso.a().kind() == Kind::Cylinder, curved_b = cso.b().kind() == Kind::Cylinder;
        piece(count_++) = {
            {of_a.centre, curved_a}, {centre_b, curved_b}, of_a.weight * of_b.weight, Vector2d::Zero(), 0.0};
      }
    lookAlong(rims.direction.normal);
  }

  void lookAlong(const Vector3d& normal) {
    normal_ = normal;
    tangents_ = tangentsOf(normal);
    a_ = curve_a_.along(normal, tangents_);
    b_ = curve_b_.along(normal, tangents_);
    height_ = 0.0;
    for (int i = 0; i < count_; ++i) {
      SmoothPiece& p = piece(i);
      const Vector3d w = onA(p) - onB(p);
      p.slope = tangents_.transpose() * w;
      p.height = normal.dot(w);
      height_ += p.weight * p.height;
    }
  }

  /// True if the weighted slopes vanish, up to rounding.
  bool isStationary() const {
    Vector2d slope = Vector2d::Zero();
    for (int i = 0; i < count_; ++i) slope += piece(i).weight * piece(i).slope;
    return slope.norm() <= kMaxBeside * cso_.rounding();
  }

  /// Sets the weights of two pieces so that the slope across their kink vanishes, if they can. The curvature along the
  /// kink depends on them, and with it whether there is a minimum.
  void weighTwo() {
    if (count_ != 2) return;
    const Kink k = kink();
    piece(1).weight = std::clamp(-k.across.dot(piece(0).slope) / k.width, 0.0, 1.0);
    piece(0).weight = 1.0 - piece(1).weight;
    height_ = piece(0).weight * piece(0).height + piece(1).weight * piece(1).height;
  }

  /// Solves for the turn of the normal in the tangent plane, and sets the weights. The turn is NaN if the curvature
  /// shows that there is no minimum of the depth near this direction.
  Vector2d step() {
    const Matrix2d hessian = curvature(1.0, 1.0) - height_ * Matrix2d::Identity();
    return count_ == 1 ? stepOfOne(hessian) : count_ == 2 ? stepOfTwo(hessian) : stepOfThree(hessian);
  }

  Vector3d turned(const Vector2d& turn) const { return (normal_ + tangents_ * turn).normalized(); }

  /// Removes the piece with the most negative weight: the stationary direction does not lie on it. Returns false if
  /// there is none.
  bool removeUnused() {
    int smallest = 0;
    for (int i = 1; i < count_; ++i)
      if (piece(i).weight < piece(smallest).weight) smallest = i;
    if (count_ == 1 || !(piece(smallest).weight <= -kSmallWeight)) return false;
    piece(smallest) = piece(--count_);
    for (int i = 0; i < count_; ++i) piece(i).weight = 1.0 / count_;
    return true;
  }

  /// The stationary direction after the last step. Returns nullopt if a weight is negative, or if the weighted point
  /// does not lie on the normal.
  std::optional<StationaryDirection> result() {
    double sum = 0.0;
    for (int i = 0; i < count_; ++i) {
      double& weight = piece(i).weight;
      if (!(weight > -kSmallWeight)) return std::nullopt;
      sum += weight = std::max(weight, 0.0);
    }
    WitnessPoints points{Vector3d::Zero(), Vector3d::Zero()};
    for (int i = 0; i < count_; ++i) {
      points.on_a += piece(i).weight / sum * onA(piece(i));
      points.on_b += piece(i).weight / sum * onB(piece(i));
    }
    const Vector3d w = points.on_a - points.on_b;
    const double height = normal_.dot(w);
    // The weights of nearly equal pieces are ill-conditioned, and the point may miss the normal.
    if (!((w - height * normal_).norm() <= kMaxBeside * cso_.rounding())) return std::nullopt;
    return StationaryDirection{normal_, height, points, height > 0.0 ? provenCap(height) : kNothingProven};
  }

  /// Cosine of a cap in which the CSO reaches at least as far as `height`. At an angle s from the normal, in the
  /// tangent direction v, the CSO reaches at least height cos(s) + max_i slope_i . v sin(s), and at least
  /// height cos(s) + 1/2 q(v) sin^2(s), where q is the weighted curvature times CurveAt::kept(). If all pieces have the
  /// same curvature, both terms may be added.
  double provenCap(double height) const {
    if (count_ == 3) return capOfClimb(height, climbOfThree());
    return widestCap([&](double cosine) {
      const Matrix2d kept = curvature(a_.kept(cosine), b_.kept(cosine));
      return count_ == 1 ? holdsOfOne(height, kept, cosine) : holdsOfTwo(height, kept, cosine);
    });
  }

 private:
  /// A rim of a cylinder, or an end of a segment, and the part that it has in a point.
  struct RimWeight {
    Vector3d centre;
    double weight;
  };
  /// The rim at `end`, or both rims, in proportion to the height of a point between them, if `end` is 0.
  static std::array<RimWeight, 2> rimsOf(const Shape& shape, double end, double height) {
    const Vector3d up(0.0, 0.0, shape.halfExtents().z());
    const double part = end == 0.0 ? 0.5 * height / up.z() : 0.5 * end;
    return {{{up, 0.5 + part}, {-up, 0.5 - part}}};
  }

  static constexpr double kSmallWeight = 1e-9;   // a weight this small may be zero, up to rounding
  static constexpr double kMaxBeside = 32.0;     // accepted distance of the point from the normal, in roundings
  static constexpr double kFlatSlope = 8.0;      // a slope of so many roundings is none; less than kMaxBeside
  static constexpr double kTurnAlongRing = 0.4;  // [rad] longest step; less than kMaxTurn

  SmoothPiece& piece(int i) { return pieces_[i]; }
  const SmoothPiece& piece(int i) const { return pieces_[i]; }
  Vector3d onA(const SmoothPiece& p) const { return p.of_a.curved ? Vector3d(p.of_a.point + a_.point) : p.of_a.point; }
  Vector3d onB(const SmoothPiece& p) const { return p.of_b.curved ? Vector3d(p.of_b.point - b_.point) : p.of_b.point; }

  void add(const CsoVertex& vertex) {
    SmoothPiece next{centreOf(cso_.a(), vertex.on_a),
                     centreOf(cso_.b(), cso_.bAxes().transpose() * (vertex.onB() - cso_.bOrigin())), 0.0,
                     Vector2d::Zero(), 0.0};
    next.of_b.point = next.of_b.curved ? Vector3d(cso_.bAxes() * next.of_b.point + cso_.bOrigin()) : vertex.onB();
    const auto same = [&](const Vector3d& p, const Vector3d& q) {
      return (p - q).squaredNorm() <= cso_.rounding() * cso_.rounding();
    };
    for (int i = 0; i < count_; ++i)
      if (same(piece(i).of_a.point, next.of_a.point) && same(piece(i).of_b.point, next.of_b.point)) return;
    if (count_ < static_cast<int>(pieces_.size())) piece(count_++) = next;
  }

  /// Curvature of the weighted pieces; the curvatures of a and b are multiplied by the given factors.
  Matrix2d curvature(double part_a, double part_b) const {
    double of_a = 0.0, of_b = 0.0;
    for (int i = 0; i < count_; ++i) {
      if (piece(i).of_a.curved) of_a += piece(i).weight;
      if (piece(i).of_b.curved) of_b += piece(i).weight;
    }
    return part_a * of_a * a_.curvature + part_b * of_b * b_.curvature;
  }

  static bool sameCurves(const SmoothPiece& p, const SmoothPiece& q) {
    return p.of_a.curved == q.of_a.curved && p.of_b.curved == q.of_b.curved;
  }

  static Vector2d none() { return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()); }

  /// The step along a direction in which the depth hardly changes, as in a ring of directions that have the same depth
  /// but for an offset or a tilt of the shapes. There the depth varies like a sine, so a step downhill of at most
  /// kTurnAlongRing is made where Newton's would lead to the maximum. Slopes that are rounding need no step.
  double stepAlongRing(double slope, double curvature) const {
    if (std::abs(slope) <= kFlatSlope * cso_.rounding()) return 0.0;
    const double newton = slope / std::abs(curvature);
    return -std::clamp(newton, -kTurnAlongRing, kTurnAlongRing);
  }

  Vector2d stepOfOne(const Matrix2d& hessian) const {
    const double mean = 0.5 * hessian.trace();
    const double spread = std::hypot(0.5 * (hessian(0, 0) - hessian(1, 1)), hessian(0, 1));
    const double smallest = mean - spread, largest = mean + spread;
    if (!(largest > 0.0) || smallest < -kRing * largest) return none();
    const Vector2d& slope = pieces_[0].slope;
    if (smallest > kRing * largest) return -(hessian.inverse() * slope);
    const Matrix2d across = (hessian - smallest * Matrix2d::Identity()) / (2.0 * spread);
    const Vector2d ring = (Matrix2d::Identity() - across).col(across(0, 0) < 0.5 ? 0 : 1).normalized();
    return -(across * slope) / largest + stepAlongRing(ring.dot(slope), smallest) * ring;
  }

  /// The kink between two pieces: the tangent directions across it, where the heights determine the step, and along it,
  /// where the curvature does.
  struct Kink {
    Vector2d across, along;
    double width;  ///< [m] distance of the support points of the two pieces
  };
  Kink kink() const {
    const Vector2d between = pieces_[1].slope - pieces_[0].slope;
    const double width = between.norm();
    const Vector2d across = between / width;
    return {across, {-across.y(), across.x()}, width};
  }

  Vector2d stepOfTwo(const Matrix2d& hessian) {
    const Kink k = kink();
    const Vector2d from_across = hessian * k.across;
    const double along2 = k.along.dot(hessian * k.along);
    const double ring = kRing * height_;
    if (!(along2 > -ring)) return none();
    const double across = (pieces_[0].height - pieces_[1].height) / k.width;
    const double slope = k.along.dot(pieces_[0].slope + across * from_across);
    const double along = along2 > ring ? -slope / along2 : stepAlongRing(slope, along2);
    const Vector2d turn = across * k.across + along * k.along;
    pieces_[1].weight = -k.across.dot(pieces_[0].slope + hessian * turn) / k.width;
    pieces_[0].weight = 1.0 - pieces_[1].weight;
    return turn;
  }

  Vector2d stepOfThree(const Matrix2d& hessian) {
    Matrix2d between;
    between << pieces_[1].slope - pieces_[0].slope, pieces_[2].slope - pieces_[0].slope;
    const Matrix2d inverse = between.inverse();
    const Vector2d turn =
        inverse.transpose() * Vector2d(pieces_[0].height - pieces_[1].height, pieces_[0].height - pieces_[2].height);
    const Vector2d weights = -(inverse * (pieces_[0].slope + hessian * turn));
    pieces_[0].weight = 1.0 - weights.sum();
    pieces_[1].weight = weights.x();
    pieces_[2].weight = weights.y();
    return turn;
  }

  /// The condition is height (1 - cos(s)) <= 1/2 q sin^2(s).
  static bool holdsOfOne(double height, const Matrix2d& kept, double cosine) {
    const double smallest = 0.5 * kept.trace() - std::hypot(0.5 * (kept(0, 0) - kept(1, 1)), kept(0, 1));
    return smallest * (1.0 + cosine) >= 2.0 * height;
  }

  /// Let x be the component of v across the kink. The condition is that |x| climb + 1/2 sin(s) ((1 - x^2) q_along -
  /// 2 |x| q_mixed) exceeds height sin(s) / (1 + cos(s)). The left side is concave in |x|, so 0 and 1 suffice.
  bool holdsOfTwo(double height, const Matrix2d& kept, double cosine) const {
    const Kink k = kink();
    double climb = std::min(-k.across.dot(pieces_[0].slope), k.across.dot(pieces_[1].slope));
    double along = k.along.dot(kept * k.along), mixed = std::abs(k.across.dot(kept * k.along));
    const double needed = 2.0 * height / (1.0 + cosine);
    if (!sameCurves(pieces_[0], pieces_[1])) {  // the terms may not be added, but a weighted mean of both holds
      const double of_climb = 0.5 * (1.0 - needed / along);
      climb *= of_climb;
      along *= 1.0 - of_climb;
      mixed *= 1.0 - of_climb;
    }
    return along >= needed && climb >= std::sqrt(1.0 - cosine * cosine) * (mixed + 0.5 * needed);
  }

  /// The smallest over all tangent directions of the steepest slope of the three pieces.
  double climbOfThree() const {
    double climb = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector2d &from = pieces_[i].slope, edge = pieces_[(i + 1) % 3].slope - from;
      climb = std::min(climb, std::abs(edge.x() * from.y() - edge.y() * from.x()) / edge.norm());
    }
    return climb;
  }

  const Cso& cso_;
  const Curve curve_a_, curve_b_;
  int count_ = 0;
  std::array<SmoothPiece, 3> pieces_;
  Vector3d normal_;
  Tangents tangents_;
  CurveAt a_, b_;
  double height_ = 0.0;
};

/// The flat end of a cylinder or cone to which `normal` (outwards, in its frame) points: 1 for the upper, -1 for the
/// lower end. Returns 0 if the normal is not near the axis, or if this end is an apex.
double flatEnd(const Shape& shape, const Vector3d& normal) {
  constexpr double kNear = 0.2;  // sine of the angle; a more inclined normal rarely ends at the axis
  const bool has_end = shape.kind() == Kind::Cylinder || (shape.kind() == Kind::Cone && normal.z() < 0.0);
  return has_end && normal.head<2>().norm() < kNear ? std::copysign(1.0, normal.z()) : 0.0;
}

/// The axis of a cylinder or cone, if the support point of the other core lies over its flat end. Returns nullopt if
/// this holds for neither core.
std::optional<StationaryDirection> onFlatEnd(Cso& cso, const Vector3d& normal) {
  if (const double end = flatEnd(cso.a(), normal); end != 0.0) {
    const Vector3d axis = end * Vector3d::UnitZ();
    const Vector3d on_b = cso.vertex(axis).onB();
    const double climb = cso.a().halfExtents().x() - on_b.head<2>().norm();
    const Vector3d on_a(on_b.x(), on_b.y(), end * cso.a().halfExtents().z());
    const double height = end * (on_a.z() - on_b.z());
    if (climb > 0.0) return StationaryDirection{axis, height, {on_a, on_b}, capOfClimb(height, climb)};
  }
  if (const double end = flatEnd(cso.b(), cso.bAxes().transpose() * -normal); end != 0.0) {
    const Vector3d axis = -end * cso.bAxes().col(0).cross(cso.bAxes().col(1)).normalized();
    const Vector3d on_a = cso.vertex(axis).on_a;
    const Vector3d from_end = on_a - (cso.bOrigin() + end * cso.b().halfExtents().z() * cso.bAxes().col(2));
    const double height = from_end.dot(axis);
    const double climb = cso.b().halfExtents().x() - (from_end - height * axis).norm();
    if (climb > 0.0) return StationaryDirection{axis, height, {on_a, on_a - height * axis}, capOfClimb(height, climb)};
  }
  return std::nullopt;
}

/// The common perpendicular of the axes of two cylinders or segments, if the axes cross at it, and if the normal is
/// nearly perpendicular to both. If the axes are nearly parallel, it may be far from the normal along the ring of
/// directions across them. Returns nullopt if the support points do not lie on the mantles.
std::optional<StationaryDirection> acrossAxes(const Cso& cso, const Vector3d& normal) {
  constexpr double kNear = 0.2;  // as for the flat ends
  if (!haveMantles(cso)) return std::nullopt;
  const Vector3d axis_a = Vector3d::UnitZ(), axis_b = cso.bAxes().col(2);
  if (std::abs(normal.z()) > kNear || std::abs(normal.dot(axis_b)) > kNear) return std::nullopt;
  const Vector3d product = axis_a.cross(axis_b);
  const double sine = product.norm();
  if (!(sine > support::kShortest)) return std::nullopt;
  const Vector3d across = std::copysign(1.0 / sine, product.dot(normal)) * product,
                 perpendicular = across.cross(axis_a);
  // The axes cross, as seen along the perpendicular, at these places.
  const double on_axis_b = -cso.bOrigin().dot(perpendicular) / axis_b.dot(perpendicular);
  const double on_axis_a = cso.bOrigin().z() + on_axis_b * axis_b.z();
  const double rest_a = cso.a().halfExtents().z() - std::abs(on_axis_a);
  const double rest_b = cso.b().halfExtents().z() - std::abs(on_axis_b);
  if (!(rest_a > 0.0 && rest_b > 0.0)) return std::nullopt;
  const Vector3d on_a = cso.a().halfExtents().x() * across + on_axis_a * axis_a;
  const Vector3d on_b = cso.bOrigin() + on_axis_b * axis_b - cso.b().halfExtents().x() * across;
  const double height = across.dot(on_a - on_b);
  // In a tangent direction v the CSO climbs by rest_a |axis_a . v| + rest_b |axis_b . v|, least across one of the axes.
  const double cap = height > 0.0 ? capOfClimb(height, std::min(rest_a, rest_b) * sine) : kNothingProven;
  return StationaryDirection{across, height, {on_a, on_b}, cap};
}

/// A curved sweep has smooth pieces at both of its ends, which CsoVertex does not distinguish.
bool isCurvedSweep(const Shape& shape) { return shape.kind() == Kind::Sweep && !shape.isPolytope(); }

/// The direction with its cap, if it is a depth.
StationaryDirection withCap(const Cso& cso, const StationaryRims& rims) {
  StationaryDirection direction = rims.direction;
  if (!(direction.height > 0.0)) return direction;
  const Pieces pieces(cso, rims);
  if (pieces.isStationary()) direction.cos_proven = pieces.provenCap(direction.height);
  return direction;
}

std::optional<StationaryDirection> onPieces(const Cso& cso, const Simplex& simplex, const Vector3d& normal) {
  constexpr int kMaxSteps = 16;
  constexpr double kMaxTurn = 0.5;
  Pieces pieces(cso, simplex);
  pieces.lookAlong(normal);
  pieces.weighTwo();
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vector2d turn = pieces.step();
    const double angle = turn.norm();
    if (!(angle < kMaxTurn)) return std::nullopt;
    pieces.lookAlong(pieces.turned(turn));
    if (angle < kLastTurn && !pieces.removeUnused()) return pieces.result();
  }
  return std::nullopt;
}

}  // namespace

std::optional<StationaryDirection> refine(Cso& cso, const Simplex& simplex, const Vector3d& normal) {
  PROXIMITY_ASSERT(isUnit(normal), "The normal has another length than 1: normalise it before it is refined.");
  PROXIMITY_ASSERT(simplex.members != 0, "The simplex is empty: Newton's method begins with its vertices.");
  if (isCurvedSweep(cso.a()) || isCurvedSweep(cso.b())) return std::nullopt;
  if (const auto flat = onFlatEnd(cso, normal)) return flat;
  if (const auto crossing = acrossAxes(cso, normal)) return crossing;
  if (const auto rims = stationaryRims(cso, simplex, normal)) return withCap(cso, *rims);
  return onPieces(cso, simplex, normal);
}

}  // namespace proximity_server::narrowphase
