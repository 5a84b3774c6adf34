#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

namespace support {

/// The square of a smaller length loses digits.
constexpr double kShortest = 1e-150;

inline double radialPart(const Eigen::Vector3d& direction) {
  return std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
}

/// The corner of a box by its number: bit k is set if coordinate k is negative.
inline Eigen::Vector3d corner(const Eigen::Vector3d& half_extents, int number) {
  return {(number & 1) != 0 ? -half_extents.x() : half_extents.x(),
          (number & 2) != 0 ? -half_extents.y() : half_extents.y(),
          (number & 4) != 0 ? -half_extents.z() : half_extents.z()};
}

inline int cornerTowards(const Eigen::Vector3d& direction) {
  return static_cast<int>(std::signbit(direction.x())) | static_cast<int>(std::signbit(direction.y())) << 1 |
         static_cast<int>(std::signbit(direction.z())) << 2;
}

/// Point of the circle |(x, y)| = radius at height z that lies farthest along the direction, or the centre of the
/// circle if it lies as far.
inline Eigen::Vector3d rimPoint(double radius, double z, const Eigen::Vector3d& direction, double radial) {
  // Otherwise the point would not lie on the circle.
  if (radial < kShortest) return {0.0, 0.0, z};
  const double scale = radius / radial;
  return {scale * direction.x(), scale * direction.y(), z};
}

/// Support point and vertex of a sweep. Vertex n of the shape has the number 2 n at the start of the sweep, and 2 n + 1
/// at its end.
Eigen::Vector3d sweptPoint(const Shape::Sweep& sweep, const Eigen::Vector3d& direction, int& vertex);
Eigen::Vector3d sweptVertex(const Shape::Sweep& sweep, int number);

}  // namespace support

/// Point of the core that lies farthest along `direction` (not zero), in the shape's frame.
///
/// If the core is a polytope, `vertex` becomes the number of the point, for vertexOf(). Its value before does not
/// matter.
///
/// Error:  the coordinate of the point along the direction is within 4 eps coreRadius() of the true maximum.
/// Source: van den Bergen, A Fast and Robust GJK Implementation for Collision Detection of Convex Objects, J. Graphics
///         Tools 1999 (closed forms). That of hulls is in hull_support.h.
inline Eigen::Vector3d supportPoint(const Shape& shape, const Eigen::Vector3d& direction, int& vertex) {
  const Eigen::Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:  // points and segments are boxes without width
      vertex = support::cornerTowards(direction);
      return {std::copysign(half.x(), direction.x()), std::copysign(half.y(), direction.y()),
              std::copysign(half.z(), direction.z())};
    case Shape::Kind::Cylinder:
      return support::rimPoint(half.x(), std::copysign(half.z(), direction.z()), direction,
                               support::radialPart(direction));
    case Shape::Kind::Cone: {
      const double radial = support::radialPart(direction);
      if (2.0 * half.z() * direction.z() >= half.x() * radial) return {0.0, 0.0, half.z()};
      return support::rimPoint(half.x(), -half.z(), direction, radial);
    }
    case Shape::Kind::Ellipsoid: {
      const Eigen::Vector3d stretched = half.cwiseProduct(direction);
      const double length = stretched.norm();
      if (length > support::kShortest) return half.cwiseProduct(stretched) / length;
      // The ellipsoid is thinner along the direction than the rounding of the other shape.
      const double size = stretched.cwiseAbs().maxCoeff();
      return size > 0.0 ? Eigen::Vector3d(half.cwiseProduct((stretched / size).normalized())) : Eigen::Vector3d::Zero();
    }
    case Shape::Kind::Sweep:
      return support::sweptPoint(shape.sweep(), direction, vertex);
    case Shape::Kind::Hull:
      break;
  }
  vertex = shape.hullSupport().farthestVertex(direction);
  return shape.hull().vertices()[vertex];
}

/// Vertex of a polytope by its number. A number out of range gives one of its vertices, too.
inline Eigen::Vector3d vertexOf(const Shape& polytope, int number) {
  if (polytope.kind() == Shape::Kind::Sweep) return support::sweptVertex(polytope.sweep(), number);
  if (polytope.kind() != Shape::Kind::Hull) return support::corner(polytope.halfExtents(), number);
  const ConvexHull& hull = polytope.hull();
  return hull.vertices()[number >= 0 && number < hull.size() ? static_cast<std::size_t>(number) : 0];
}

/// The vertex, edge or face of the core that lies within `tolerance` [m] of the support plane of the unit `direction`.
/// `vertex` is the number that supportPoint() found along this direction, if it is known: it saves the search in a
/// hull. Any number is legal.
struct SupportFeature {
  int dimension;          ///< 0 vertex or curved surface, 1 edge, 2 face
  Eigen::Vector3d along;  ///< from one end of an edge to the other, in the shape's frame; only if dimension is 1
};
SupportFeature supportFeature(const Shape& shape, const Eigen::Vector3d& direction, double tolerance, int vertex);

/// [m] How far the feature along a unit direction may lie beside the feature of the true direction, if both support
/// heights differ by no more than `width` [m]. This is not 0 for the line on the mantle of a cone, whose end is on the
/// rim: a direction that is turned about the axis by t lowers the rim by radius * t^2 / 2 times the part of the
/// direction that is perpendicular to the axis; this part is taken from the mantle's normal here. Other lines do not
/// move.
inline double sidewaysError(const Shape& shape, const Eigen::Vector3d& direction, double width) {
  if (shape.kind() != Shape::Kind::Cone || !(direction.z() > 0.0)) return 0.0;
  const double radius = shape.halfExtents().x(), length = 2.0 * shape.halfExtents().z();
  const double across = length / std::hypot(length, radius);
  return std::sqrt(2.0 * std::max(width, 0.0) * radius / across);
}

}  // namespace proximity_server::narrowphase
