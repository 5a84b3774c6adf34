#include "proximity_server/narrowphase/support.h"

#include <cmath>
#include <limits>

namespace proximity_server {
namespace {

using Eigen::Vector3d;

Vector3d signedCorner(const Vector3d& half_extents, const Vector3d& direction) {
  return {std::copysign(half_extents.x(), direction.x()), std::copysign(half_extents.y(), direction.y()),
          std::copysign(half_extents.z(), direction.z())};
}

/// Point of the circle |(x, y)| = radius at height z that lies farthest along the direction.
Vector3d rimPoint(double radius, double z, const Vector3d& direction, double radial) {
  if (radial == 0.0) return {0.0, 0.0, z};
  const double scale = radius / radial;
  return {scale * direction.x(), scale * direction.y(), z};
}

double radialPart(const Vector3d& direction) {
  return std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
}

bool isCurved(Shape::Kind kind) {
  return kind == Shape::Kind::Cylinder || kind == Shape::Kind::Cone || kind == Shape::Kind::Ellipsoid;
}

SupportFeature hullFeature(const ConvexHull& hull, const Vector3d& direction, double tolerance, int vertex) {
  const Vector3d& top = hull.vertices()[static_cast<std::size_t>(vertex)];
  SupportFeature feature{0, Vector3d::Zero()};
  for (const int v : hull.neighbours(vertex)) {
    const Vector3d edge = hull.vertices()[static_cast<std::size_t>(v)] - top;
    if (-edge.dot(direction) > tolerance) continue;
    if (feature.dimension == 1 && edge.cross(feature.along).norm() > tolerance * feature.along.norm())
      return {2, Vector3d::Zero()};
    if (edge.squaredNorm() > feature.along.squaredNorm()) feature = {1, edge};
  }
  return feature;
}

}  // namespace

Vector3d supportPoint(const Shape& shape, const Vector3d& direction, int& vertex) {
  const Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return Vector3d::Zero();
    case Shape::Kind::Segment:
      return {0.0, 0.0, std::copysign(half.z(), direction.z())};
    case Shape::Kind::Box:
      return signedCorner(half, direction);
    case Shape::Kind::Cylinder:
      return rimPoint(half.x(), std::copysign(half.z(), direction.z()), direction, radialPart(direction));
    case Shape::Kind::Cone: {
      const double radial = radialPart(direction);
      if (2.0 * half.z() * direction.z() >= half.x() * radial) return {0.0, 0.0, half.z()};
      return rimPoint(half.x(), -half.z(), direction, radial);
    }
    case Shape::Kind::Ellipsoid: {
      const Vector3d stretched = half.cwiseProduct(direction);
      return half.cwiseProduct(stretched) / stretched.norm();
    }
    case Shape::Kind::Hull:
      break;
  }
  vertex = shape.hull().farthestVertex(direction, vertex);
  return shape.hull().vertices()[static_cast<std::size_t>(vertex)];
}

SupportFeature supportFeature(const Shape& shape, const Vector3d& direction, double tolerance, int& vertex) {
  const Vector3d& half = shape.halfExtents();
  const Vector3d full = 2.0 * half;
  const Vector3d fall = full.cwiseProduct(direction).cwiseAbs();  // from one end to the other, along each axis
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Ellipsoid:
      return {0, Vector3d::Zero()};
    case Shape::Kind::Segment:
      if (full.z() > tolerance && fall.z() <= tolerance) return {1, {0.0, 0.0, full.z()}};
      return {0, Vector3d::Zero()};
    case Shape::Kind::Box: {
      SupportFeature feature{0, Vector3d::Zero()};
      for (int axis = 0; axis < 3; ++axis) {
        if (fall[axis] > tolerance) continue;
        ++feature.dimension;
        feature.along = full[axis] * Vector3d::Unit(axis);
      }
      return feature;
    }
    case Shape::Kind::Cylinder:
      if (full.x() * radialPart(direction) <= tolerance) return {2, Vector3d::Zero()};
      if (fall.z() <= tolerance) return {1, {0.0, 0.0, full.z()}};
      return {0, Vector3d::Zero()};
    case Shape::Kind::Cone: {
      const double radial = radialPart(direction);
      if (direction.z() < 0.0 && full.x() * radial <= tolerance) return {2, Vector3d::Zero()};
      if (std::abs(full.z() * direction.z() - half.x() * radial) <= tolerance)
        return {1, Vector3d(0.0, 0.0, full.z()) - rimPoint(half.x(), 0.0, direction, radial)};
      return {0, Vector3d::Zero()};
    }
    case Shape::Kind::Hull:
      break;
  }
  vertex = shape.hull().farthestVertex(direction, vertex);
  return hullFeature(shape.hull(), direction, tolerance, vertex);
}

double csoRounding(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  // To first order in eps, with r how far a shape reaches from its origin and t the offset: a support point is off by
  // 2 eps r, its rotation by 3 eps r, the sums by 2 eps and the dot product or norm by 2 eps of what they add up: less
  // than 8 eps of it all. |t|_1 is never less than |t|, and margins join the sums last.
  const double reach = a.coreReach() + b.coreReach() + a.margin() + b.margin();
  return 8.0 * std::numeric_limits<double>::epsilon() * (reach + a_T_b.translation().lpNorm<1>());
}

Cso::Cso(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, WarmStart& warm_start)
    : a_(a),
      b_(b),
      b_axes_(a_T_b.linear()),
      b_origin_(a_T_b.translation()),
      warm_start_(warm_start),
      centre_difference_(b_axes_ * b.centre() + b_origin_ - a.centre()),
      rounding_(csoRounding(a, b, a_T_b)),
      is_polytope_(!isCurved(a.kind()) && !isCurved(b.kind())) {}

}  // namespace proximity_server
