#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <vector>

namespace proximity_server::narrowphase {

/// A shape with all of its lengths multiplied by a factor.
inline Shape scaled(const Shape& shape, double factor) {
  const Eigen::Vector3d half = factor * shape.halfExtents();
  const double margin = factor * shape.margin();
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return Sphere{margin};
    case Shape::Kind::Segment:
      return Capsule{margin, 2.0 * half.z()};
    case Shape::Kind::Box:
      return Shape(Box{2.0 * half}).padded(margin);
    case Shape::Kind::Cylinder:
      return Shape(Cylinder{half.x(), 2.0 * half.z()}).padded(margin);
    case Shape::Kind::Cone:
      return Shape(Cone{half.x(), 2.0 * half.z()}).padded(margin);
    case Shape::Kind::Ellipsoid:
      return Shape(Ellipsoid{half}).padded(margin);
    case Shape::Kind::Sweep: {
      Eigen::Isometry3d end = shape.sweep().end;
      end.translation() *= factor;
      return scaled(shape.sweep().shape.padded(shape.margin()), factor).sweptTo(end);
    }
    case Shape::Kind::Hull:
      break;
  }
  std::vector<Eigen::Vector3d> vertices;
  for (const Eigen::Vector3d& vertex : shape.hull().vertices()) vertices.push_back(factor * vertex);
  return Shape(ConvexHull(vertices)).padded(margin);
}

}  // namespace proximity_server::narrowphase
