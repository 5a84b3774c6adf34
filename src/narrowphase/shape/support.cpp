#include "proximity_server/narrowphase/shape/support.h"

#include <cmath>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// The feature at a vertex of a hull. Returns nullopt if a neighbour is farther along the direction.
std::optional<SupportFeature> featureAt(const ConvexHull& hull, const Vector3d& direction, double tolerance,
                                        int vertex) {
  const Vector3d& top = hull.vertices()[vertex];
  SupportFeature feature{0, Vector3d::Zero()};
  for (const int v : hull.neighbours(vertex)) {
    const Vector3d edge = hull.vertices()[v] - top;
    const double ahead = edge.dot(direction);
    if (ahead > tolerance) return std::nullopt;
    if (-ahead > tolerance || feature.dimension == 2) continue;
    if (feature.dimension == 1 && edge.cross(feature.along).norm() > tolerance * feature.along.norm())
      feature = {2, Vector3d::Zero()};
    else if (edge.squaredNorm() > feature.along.squaredNorm())
      feature = {1, edge};
  }
  return feature;
}

SupportFeature hullFeature(const HullSupport& support, const Vector3d& direction, double tolerance, int vertex) {
  const ConvexHull& hull = support.hull();
  if (vertex >= 0 && vertex < hull.size())
    if (const auto feature = featureAt(hull, direction, tolerance, vertex)) return *feature;
  const SupportFeature only_vertex{0, Vector3d::Zero()};
  return featureAt(hull, direction, tolerance, support.farthestVertex(direction)).value_or(only_vertex);
}

/// The feature of the end that lies farther along the direction. If both ends are as far, within the tolerance, it is
/// spanned by the feature of one end and the edge between the ends.
SupportFeature sweptFeature(const Shape::Sweep& sweep, const Vector3d& direction, double tolerance) {
  const Eigen::Matrix3d turn = sweep.end.linear();
  const Vector3d direction_at_end = turn.transpose() * direction;
  int at_start = 0, at_end = 0;
  const Vector3d start = supportPoint(sweep.shape, direction, at_start);
  const Vector3d along = sweep.end * supportPoint(sweep.shape, direction_at_end, at_end) - start;
  const double ahead = along.dot(direction);
  SupportFeature of_end = supportFeature(sweep.shape, direction_at_end, tolerance, at_end);
  of_end.along = turn * of_end.along;
  if (ahead > tolerance) return of_end;
  const SupportFeature of_start = supportFeature(sweep.shape, direction, tolerance, at_start);
  if (ahead < -tolerance || along.norm() <= tolerance) return of_start;
  for (const SupportFeature& feature : {of_start, of_end})
    if (feature.dimension == 2 ||
        (feature.dimension == 1 && feature.along.cross(along).norm() > tolerance * along.norm()))
      return {2, Vector3d::Zero()};
  return {1, along};
}

}  // namespace

namespace support {

Vector3d sweptPoint(const Shape::Sweep& sweep, const Vector3d& direction, int& vertex) {
  int at_start = 0, at_end = 0;
  const Vector3d start = supportPoint(sweep.shape, direction, at_start);
  const Vector3d end = sweep.end * supportPoint(sweep.shape, sweep.end.linear().transpose() * direction, at_end);
  const bool is_end = (end - start).dot(direction) > 0.0;
  vertex = is_end ? 2 * at_end + 1 : 2 * at_start;
  return is_end ? end : start;
}

Vector3d sweptVertex(const Shape::Sweep& sweep, int number) {
  const Vector3d vertex = vertexOf(sweep.shape, number >> 1);
  return (number & 1) != 0 ? Vector3d(sweep.end * vertex) : vertex;
}

}  // namespace support

SupportFeature supportFeature(const Shape& shape, const Vector3d& direction, double tolerance, int vertex) {
  const Vector3d& half = shape.halfExtents();
  const Vector3d full = 2.0 * half;
  // Difference of the heights along the direction between both ends, for each axis of the core.
  const Vector3d fall = full.cwiseProduct(direction).cwiseAbs();
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
    case Shape::Kind::Sweep:
      return sweptFeature(shape.sweep(), direction, tolerance);
    case Shape::Kind::Hull:
      break;
  }
  return hullFeature(shape.hullSupport(), direction, tolerance, vertex);
}

}  // namespace proximity_server::narrowphase
