#include "scene/certificate/axis_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A disc in the plane of (cos(q), sin(q)).
struct Disc {
  double x, y, radius;
};

Disc pointAt(double angle, double distance) { return {distance * std::cos(angle), distance * std::sin(angle), 0.0}; }

/// The corners of a polygon that contains the arc of half the angle `half` about `middle` [rad].
std::vector<Disc> polygonAbout(double middle, double half) {
  constexpr double kLongest = 0.6;  // [rad] half of the arc between two tangents, which meet 21 % beyond it
  if (half == 0.0) return {pointAt(middle, 1.0)};
  const int arcs = static_cast<int>(std::ceil(half / kLongest));
  const double part = half / arcs;
  std::vector<Disc> corners{pointAt(middle - half, 1.0), pointAt(middle + half, 1.0)};
  for (int i = 0; i < arcs; ++i) corners.push_back(pointAt(middle - half + (2 * i + 1) * part, 1.0 / std::cos(part)));
  return corners;
}

/// A disc that contains the arc. Up to half a turn the chord between its ends is a diameter.
Disc discAbout(double middle, double half) {
  if (half >= 0.5 * kPi) return {0.0, 0.0, 1.0};
  Disc disc = pointAt(middle, std::cos(half));
  disc.radius = std::sin(half);
  return disc;
}

/// The largest d . p of the points p of a core.
double supportHeight(const Shape& shape, const Vector3d& d) {
  const Vector3d& half = shape.halfExtents();
  const double across = std::hypot(d.x(), d.y());
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return 0.0;
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
      return d.cwiseAbs().dot(half);
    case Shape::Kind::Cylinder:
      return half.x() * across + half.z() * std::abs(d.z());
    case Shape::Kind::Cone:
      return std::max(half.z() * d.z(), half.x() * across - half.z() * d.z());
    case Shape::Kind::Ellipsoid:
      return half.cwiseProduct(d).norm();
    case Shape::Kind::Sweep: {
      const Shape::Sweep& sweep = shape.sweep();
      const Vector3d at_end = sweep.end.linear().transpose() * d;
      return std::max(supportHeight(sweep.shape, d),
                      supportHeight(sweep.shape, at_end) + d.dot(sweep.end.translation()));
    }
    case Shape::Kind::Hull:
      break;
  }
  double highest = -std::numeric_limits<double>::infinity();
  for (const Vector3d& vertex : shape.hull().vertices()) highest = std::max(highest, d.dot(vertex));
  return highest;
}

}  // namespace

std::vector<JointRange> withInterval(std::vector<JointRange> box, const JointRange& interval) {
  for (JointRange& own : box)
    if (own.joint == interval.joint) own = interval;
  return box;
}

AxisHeights::AxisHeights(const RobotModel& robot, const std::vector<JointRange>& box, int from, int to,
                         const Vector3d& direction)
    : heights_{{direction}} {
  for (const int number : jointsBetween(robot, from, to)) {
    const Joint& joint = robot.joints[number];
    const Joint::Mimic leader = robot.leaderOf(number);
    const JointRange& leading = *intervalOf(box, leader.joint);
    const double one = leader.offset + leader.multiplier * leading.lower,
                 other = leader.offset + leader.multiplier * leading.upper;
    const JointRange interval{number, std::min(one, other), std::max(one, other)};
    steps_ += 1.0 + std::abs(leader.offset) + std::max(std::abs(one), std::abs(other));
    const Isometry3d parent_T_joint = robot.links[joint.parent_link].body_T_link * joint.parent_T_joint;
    lengths_ +=
        robot.links[joint.parent_link].body_T_link.translation().norm() + joint.parent_T_joint.translation().norm();
    const int below = robot.links[joint.child_link].body;
    if (from == below) {
      from = robot.links[joint.parent_link].body;
      move(joint, interval, -1.0);
      enter(parent_T_joint.inverse(Eigen::Isometry));
    } else {
      from = below;
      enter(parent_T_joint);
      move(joint, interval, 1.0);
    }
  }
}

/// From here into a frame whose coordinates x have the coordinates here_T_next * x here.
void AxisHeights::enter(const Isometry3d& here_T_next) {
  const double length = here_T_next.translation().norm();
  for (Height& height : heights_) {
    height.offset += height.direction.dot(here_T_next.translation());
    height.offset_error += height.direction_error * length;
    height.direction = here_T_next.linear().transpose() * height.direction;
  }
}

/// From before the motion of a joint to behind it for a sign of 1, and back for -1.
void AxisHeights::move(const Joint& joint, const JointRange& interval, double sign) {
  if (joint.type == Joint::Type::Prismatic)
    slide(sign * joint.axis, interval);
  else
    turn(-sign * joint.axis, interval);  // R(q) x has the height d . R(q) x = (R(-q) d) . x
}

void AxisHeights::turn(const Vector3d& axis, const JointRange& angles) {
  constexpr std::size_t kMostHeights = 10000;
  const double middle = 0.5 * (angles.lower + angles.upper);
  const double half = std::min(kPi, std::max(angles.upper - middle, middle - angles.lower));
  std::vector<Disc> corners = polygonAbout(middle, half);
  if (heights_.size() * corners.size() > kMostHeights) corners = {discAbout(middle, half)};
  std::vector<Height> turned;
  for (const Height& before : heights_) {
    const Vector3d along = axis.dot(before.direction) * axis, across = before.direction - along;
    const Vector3d sideways = axis.cross(before.direction);
    for (const Disc& corner : corners)
      turned.push_back({along + corner.x * across + corner.y * sideways, before.offset,
                        before.direction_error + corner.radius * across.norm(), before.offset_error});
  }
  heights_ = std::move(turned);
}

void AxisHeights::slide(const Vector3d& axis, const JointRange& way) {
  const double farthest = std::max(std::abs(way.lower), std::abs(way.upper));
  lengths_ += farthest;
  std::vector<double> ends{way.lower};
  if (way.upper != way.lower) ends.push_back(way.upper);
  std::vector<Height> moved;
  for (const Height& before : heights_)
    for (const double end : ends)
      moved.push_back({before.direction, before.offset + end * axis.dot(before.direction), before.direction_error,
                       before.offset_error + before.direction_error * farthest});
  heights_ = std::move(moved);
}

/// [m] How far rounding can change a height.
///
/// Each joint with its fixed transform turns a direction by at most 32 eps (1 + |q|), relative to its length: 8 eps for
/// two products with matrices, 8 eps for the turn, |q| eps for its angle, and 8 eps by which the matrices of the model
/// are no rotations. A height multiplies this with all lengths on the way, and its own products and sums add less than
/// as much again. No turn makes |direction| + direction_error smaller, so the last one is the largest.
double AxisHeights::rounding(const Height& height, double reach) const {
  return kChainRounding * steps_ * (height.direction.norm() + height.direction_error) * (lengths_ + reach);
}

double AxisHeights::highest(const Shape& shape, const Isometry3d& body_T_shape, double reach) const {
  constexpr double kMost = 1e30;  // [m] and 1 + |q|: beyond it products may overflow
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (!(steps_ < kMost && lengths_ + reach < kMost)) return kUnknown;
  double highest = -kUnknown;
  for (const Height& height : heights_) {
    const double core = supportHeight(shape, body_T_shape.linear().transpose() * height.direction) +
                        height.direction.dot(body_T_shape.translation()) + height.offset;
    const double bound = core + height.direction_error * reach + height.offset_error + rounding(height, reach);
    if (std::isnan(bound)) return kUnknown;
    highest = std::max(highest, bound);
  }
  return highest + shape.margin();  // the margin is a ball: it reaches as far along each unit vector
}

double AxisHeights::of(const Vector3d& point) const {
  return heights_.front().direction.dot(point) + heights_.front().offset;
}

}  // namespace proximity_server::scene
