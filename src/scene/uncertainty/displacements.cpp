#include "scene/uncertainty/displacements.h"

#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proximity_server::scene {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using narrowphase::Shape;

namespace {

/// The corners of a polygon about the unit circle. The tangents of the circle on which its edges lie are dense about
/// the x axis: to first order the lowest point of a circle that is displaced is near to where it is now.
struct PolygonAboutCircle {
  static constexpr std::array<double, 10> kTangents{0.0,  1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 0.125,
                                                    0.25, 0.5,        1.0,        2.0,        3.2};
  static constexpr int kCorners = 2 * (kTangents.size() - 1);

  PolygonAboutCircle() {
    for (std::size_t i = 0; i + 1 < kTangents.size(); ++i) {
      const auto middle = narrowphase::sineAndCosine(0.5 * (kTangents[i] + kTangents[i + 1]));
      const double radius =
          (1.0 + kPoseRounding) / narrowphase::sineAndCosine(0.5 * (kTangents[i + 1] - kTangents[i])).cosine;
      corners[2 * i] = radius * Eigen::Vector2d(middle.cosine, middle.sine);
      corners[2 * i + 1] = radius * Eigen::Vector2d(middle.cosine, -middle.sine);
    }
  }
  std::array<Eigen::Vector2d, kCorners> corners;
};

/// Visits points whose convex hull contains the circle |(x, y)| = radius at height z.
template <class Visit>
void visitCircle(double radius, double z, const Vector3d& n, const Visit& visit) {
  static const PolygonAboutCircle polygon;
  const double radial = narrowphase::support::radialPart(n);
  const Eigen::Vector2d down = radial < narrowphase::support::kShortest
                                   ? Eigen::Vector2d(radius, 0.0)
                                   : Eigen::Vector2d(-radius / radial * n.x(), -radius / radial * n.y());
  for (const Eigen::Vector2d& corner : polygon.corners)
    visit({corner.x() * down.x() - corner.y() * down.y(), corner.x() * down.y() + corner.y() * down.x(), z}, 0.0);
}

/// Calls visit(point, within) for points whose convex hull contains the core. A core without corners has one point, its
/// lowest one along n, and is contained in the ball `within` about its centre.
template <class Visit>
void visitCorners(const Shape& shape, const Vector3d& n, const Visit& visit) {
  const Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return visit(Vector3d::Zero(), 0.0);
    case Shape::Kind::Segment:
      visit(half, 0.0);
      return visit(-half, 0.0);
    case Shape::Kind::Box:
      for (int i = 0; i < 8; ++i) visit(narrowphase::support::corner(half, i), 0.0);
      return;
    case Shape::Kind::Hull: {
      // The lowest vertex first: it excludes most of the others.
      visit(shape.hull().vertices()[static_cast<std::size_t>(shape.hullSupport().farthestVertex(-n))], 0.0);
      for (const Vector3d& vertex : shape.hull().vertices()) visit(vertex, 0.0);
      return;
    }
    case Shape::Kind::Cylinder:
      visitCircle(half.x(), half.z(), n, visit);
      return visitCircle(half.x(), -half.z(), n, visit);
    case Shape::Kind::Cone:
      visit({0.0, 0.0, half.z()}, 0.0);
      return visitCircle(half.x(), -half.z(), n, visit);
    case Shape::Kind::Ellipsoid:
    case Shape::Kind::Sweep:
      break;
  }
  int vertex = 0;
  visit(supportPoint(shape, -n, vertex), 2.0 * shape.coreRadius());
}

}  // namespace

void Displacement::displaceAfter(Eigen::Isometry3d& motion, double position) const {
  if (kind == Kind::Slide) {
    motion.translation() += position * (motion.linear() * axis);
    return;
  }
  const Vector3d fixed = motion * origin;
  motion.linear() = motion.linear() * rotationAbout(axis, position);
  motion.translation() = fixed - motion.linear() * origin;
}

void Displacements::begin(const Bounds& bounds, const Eigen::Isometry3d& body) {
  bounds_ = &bounds;
  body_ = body;
  list_.clear();
  travel_ = rounding_ = angles_ = 0.0;
}

void Displacements::add(const Displacement& next) {
  if (next.width == 0.0) return;
  Placed own(next);
  own.radius += kPoseRounding;
  own.beyond = travel_;
  if (next.turns()) {
    const SeenBounds seen(*bounds_, body_, next.origin);
    own.radius = next.kind == Displacement::Kind::Turn ? radiusAbout(next.axis, seen) : radiusAboutOrigin(seen);
    own.centre = seen.centre;
    own.rounding = seen.rounding + kPoseRounding * (seen.centre.norm() + seen.radius);
    edges_ = seen.edges;
    // lossAt() sums products of lengths up to the distance of a point from the origin, which is off by as much.
    rounding_ += next.width * own.rounding;
    angles_ += next.width;
  }
  own.turned = angles_;
  travel_ += next.width * own.radius;
  list_.push_back(own);
}

double Displacements::remainder(const Vector3d& n) const {
  constexpr double kMuch = 1e-4;  // [m]
  const double simple = simpleRemainder(n);
  return simple > kMuch ? std::min(simple, directedRemainder(n)) : simple;
}

/// Point 5 of Displacements.
double Displacements::simpleRemainder(const Vector3d& n) const {
  double velocities = 0.0;  // the sum of u_j |v_j| over the displacements beyond this one
  double sum = 0.0;
  for (const Placed& own : list_) {
    const double velocity = own.width * own.speed();
    if (own.turns()) {
      const double across =
          own.kind == Displacement::Kind::Turn
              ? std::min(1.0, n.cross(own.axis).norm() + std::max(0.0, angles_ - own.turned) + kPoseRounding)
              : 1.0;
      sum += own.width * across * (0.5 * velocity + velocities);
    }
    velocities += velocity;
  }
  // The sums of positive numbers are off by a relative error. The angles are off by the error of the sum of all of
  // them.
  return (1.0 + 2.0 * roundingOfSums()) * sum + roundingOfSums() * (angles_ * velocities + travel_) + rounding_;
}

/// Point 6 of Displacements.
double Displacements::directedRemainder(const Vector3d& n) const {
  double velocities = 0.0, sum = 0.0;
  for (auto outer = list_.begin(); outer != list_.end(); ++outer) {
    velocities += outer->width * outer->speed();
    if (!outer->turns()) continue;
    const Vector3d across = n.cross(outer->axis);
    for (auto own = list_.begin(); own != outer; ++own)
      sum += outer->width * own->width * secondOrder(across, *outer, *own);
    sum += 0.5 * outer->width * outer->width * secondOrder(across, *outer, *outer);
  }
  return (1.0 + 4.0 * roundingOfSums()) * sum + roundingOfSums() * (angles_ * velocities + travel_) + rounding_;
}

/// [m] An upper bound of -n.(a_i x v_j) in all states if both are the same, and else of its absolute value. `outer` is
/// i, which turns, and `across` is n x a_i now.
double Displacements::secondOrder(const Vector3d& across, const Placed& outer, const Placed& own) const {
  if (outer.kind == Displacement::Kind::Tilt) return own.speed();
  const double sine = across.norm() + kPoseRounding;
  const double within_outer = std::max(0.0, angles_ - outer.turned), within_own = std::max(0.0, angles_ - own.turned);
  const double simple = std::min(1.0, sine + within_outer) * own.speed();
  double now = 0.0;
  if (own.kind == Displacement::Kind::Slide) {
    now = std::abs(across.dot(own.axis)) + kPoseRounding;
  } else if (own.kind == Displacement::Kind::Turn) {
    const Vector3d along = across.cross(own.axis);  // n.(a_i x (a_j x r)) = ((n x a_i) x a_j).r
    const double centre = along.dot(own.centre), spread = (edges_.transpose() * along).cwiseAbs().sum();
    now = (&own == &outer ? std::max(0.0, spread - centre) : std::abs(centre) + spread) + own.rounding;
  } else {
    return simple;
  }
  const double change = within_own * own.speed() + (own.turns() ? own.beyond : 0.0);
  return std::min(simple, now + within_outer * own.speed() + sine * change);
}

/// `from_body` is the origin of the piece minus the origin of its body, in the frame of the poses, and n is in the
/// frame of the piece.
void Displacements::findChanges(const Matrix3d& rotation, const Vector3d& from_body, const Vector3d& n) {
  changes_.clear();
  shift_ = 0.0;
  for (const Placed& own : list_) {
    if (own.kind == Displacement::Kind::Shift) {
      shift_ += own.width;
      continue;
    }
    const Vector3d origin = rotation.transpose() * ((own.origin - body_.translation()) - from_body);
    if (own.kind == Displacement::Kind::Tilt) {
      changes_.push_back({own.width, true, 0.0, origin});
      continue;
    }
    const Vector3d axis = rotation.transpose() * own.axis;
    const bool slides = own.kind == Displacement::Kind::Slide;
    const Vector3d gradient = slides ? Vector3d(Vector3d::Zero()) : Vector3d(n.cross(axis));
    const double constant = slides ? n.dot(axis) : -gradient.dot(origin);
    int& sum = sum_of_group_[own.group];
    if (sum < 0) {
      sum = static_cast<int>(changes_.size());
      changes_.push_back({own.width / std::abs(own.multiplier), false, 0.0, Vector3d::Zero()});
    }
    changes_[sum].constant += own.multiplier * constant;
    changes_[sum].vector += own.multiplier * gradient;
  }
  for (const Placed& own : list_)
    if (own.group >= 0) sum_of_group_[own.group] = -1;
}

/// [m] An upper bound of how far a point can come down along n to first order, and all points that are `within` [m] of
/// it.
double Displacements::lossAt(const Vector3d& point, const Vector3d& n, double within) const {
  double loss = shift_;
  for (const Change& change : changes_) {
    const double here =
        change.is_tilt ? n.cross(point - change.vector).norm() : std::abs(change.constant + change.vector.dot(point));
    loss += change.width * (within > 0.0 ? here + within * (change.is_tilt ? 1.0 : change.vector.norm()) : here);
  }
  return loss;
}

/// The most by which lossAt() can differ between two points, for each metre between them.
double Displacements::steepness() const {
  double sum = 0.0;
  for (const Change& change : changes_) sum += change.width * (change.is_tilt ? 1.0 : change.vector.norm());
  return sum;
}

Displacements::Lowest Displacements::lowest(const Piece& piece, const Vector3d& n, const Vector3d& from) {
  const Matrix3d rotation = body_.linear() * piece.body_T_piece.linear();
  const Vector3d from_body = body_.linear() * piece.body_T_piece.translation();
  const Vector3d n_piece = rotation.transpose() * n;
  findChanges(rotation, from_body, n_piece);
  Lowest lowest{kInfinity, kInfinity, 0.0, Vector3d::Zero()};
  // [m] No point loses more. The points about a circle are outside of it by less than a quarter of its radius.
  double largest = travel() + 0.25 * angles_ * piece.shape.coreRadius();
  const double variation = 2.5 * piece.shape.coreRadius() * steepness();
  visitCorners(piece.shape, n_piece, [&](const Vector3d& point, double within) {
    const double height = n_piece.dot(point);
    if (height - largest >= lowest.displaced) return;
    const double loss = lossAt(point, n_piece, within);
    largest = std::min(largest, (1.0 + roundingOfSums()) * (loss + variation) + rounding_);
    if (height < lowest.present) {
      lowest.present = height;
      lowest.loss = loss;
    }
    if (height - loss >= lowest.displaced) return;
    lowest.displaced = height - loss;
    lowest.point = point;
  });
  const Vector3d origin = (body_.translation() - from) + from_body;
  const double offset = n.dot(origin) - piece.shape.margin();
  return {lowest.present + offset, lowest.displaced + offset, lowest.loss, origin + rotation * lowest.point};
}

Vector3d Displacements::lowestStep(const Vector3d& point, const Vector3d& n) {
  Vector3d step = Vector3d::Zero();
  const auto velocityAt = [&](const Placed& own) -> Vector3d { return own.multiplier * own.velocityAt(point); };
  std::fill(speed_.begin(), speed_.end(), 0.0);
  for (const Placed& own : list_)
    if (own.group >= 0) speed_[own.group] += n.dot(velocityAt(own));
  for (const Placed& own : list_) {
    if (own.group >= 0) {
      step -= std::copysign(own.width / std::abs(own.multiplier), speed_[own.group]) * velocityAt(own);
    } else if (own.kind == Displacement::Kind::Tilt) {
      const Vector3d lever_arm = point - own.origin, axis = lever_arm.cross(n);
      step -= own.width / std::max(axis.norm(), narrowphase::support::kShortest) * axis.cross(lever_arm);
    } else {
      step -= own.width * n;
    }
  }
  return step;
}

double Displacements::displacedHeight(const Vector3d& point, const Vector3d& n, const Vector3d& from) {
  const Vector3d n_body = body_.linear().transpose() * n;
  findChanges(body_.linear(), Vector3d::Zero(), n_body);
  return n_body.dot(point) - lossAt(point, n_body, 0.0) + n.dot(body_.translation() - from);
}

double Displacements::largestLoss(const Vector3d& n) {
  const Matrix3d rotation = body_.linear() * bounds_->axes;
  const Vector3d n_box = rotation.transpose() * n;
  findChanges(rotation, body_.linear() * bounds_->centre, n_box);
  double largest = 0.0;
  for (int i = 0; i < 8; ++i)
    largest = std::max(largest, lossAt(narrowphase::support::corner(bounds_->half, i), n_box, 0.0));
  return largest;
}

}  // namespace proximity_server::scene
