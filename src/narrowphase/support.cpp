#include "proximity_server/narrowphase/support.h"

#include <cmath>
#include <limits>

namespace proximity_server {
namespace {

using Eigen::Vector3d;

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
      if (full.x() * support::radialPart(direction) <= tolerance) return {2, Vector3d::Zero()};
      if (fall.z() <= tolerance) return {1, {0.0, 0.0, full.z()}};
      return {0, Vector3d::Zero()};
    case Shape::Kind::Cone: {
      const double radial = support::radialPart(direction);
      if (direction.z() < 0.0 && full.x() * radial <= tolerance) return {2, Vector3d::Zero()};
      if (std::abs(full.z() * direction.z() - half.x() * radial) <= tolerance)
        return {1, Vector3d(0.0, 0.0, full.z()) - support::rimPoint(half.x(), 0.0, direction, radial)};
      return {0, Vector3d::Zero()};
    }
    case Shape::Kind::Hull:
      break;
  }
  vertex = shape.hull().farthestVertex(direction, vertex);
  return hullFeature(shape.hull(), direction, tolerance, vertex);
}

Cso::Cso(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double rounding, WarmStart& warm_start)
    : a_(a),
      b_(b),
      a_T_b_(a_T_b),
      warm_start_(warm_start),
      rounding_(rounding),
      is_polytope_(!isCurved(a.kind()) && !isCurved(b.kind())) {}

}  // namespace proximity_server
