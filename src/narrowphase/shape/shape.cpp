#include "proximity_server/narrowphase/shape/shape.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::narrowphase {
namespace {

// Written as !(value > 0) so that NaN is refused, too.
double positive(double value, const char* what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " must be positive and finite, not " + std::to_string(value));
  return value;
}

double notNegative(double value, const char* what) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " must be finite and not negative, not " + std::to_string(value));
  return value;
}

Eigen::Vector3d positive(const Eigen::Vector3d& sizes, const char* what) {
  return {positive(sizes.x(), what), positive(sizes.y(), what), positive(sizes.z(), what)};
}

Eigen::Vector3d roundExtents(double radius, double length, const char* radius_name, const char* length_name) {
  positive(radius, radius_name);
  return {radius, radius, 0.5 * positive(length, length_name)};
}

}  // namespace

Shape::Shape(Kind kind, double margin, const Eigen::Vector3d& half_extents, double core_radius)
    : kind_(kind), margin_(margin), core_radius_(core_radius), core_reach_(core_radius), half_extents_(half_extents) {}

Shape::Shape(const Sphere& sphere)
    : Shape(Kind::Point, positive(sphere.radius, "sphere radius"), Eigen::Vector3d::Zero(), 0.0) {}

Shape::Shape(const Capsule& capsule)
    : Shape(Kind::Segment, positive(capsule.radius, "capsule radius"),
            {0.0, 0.0, 0.5 * notNegative(capsule.length, "capsule length")}, 0.5 * capsule.length) {
  if (capsule.length == 0.0) *this = Shape(Sphere{capsule.radius});
}

Shape::Shape(const Box& box) : Shape(Kind::Box, 0.0, 0.5 * positive(box.size, "box size"), 0.5 * box.size.norm()) {}

Shape::Shape(const Cylinder& cylinder)
    : Shape(Kind::Cylinder, 0.0, roundExtents(cylinder.radius, cylinder.length, "cylinder radius", "cylinder length"),
            std::hypot(cylinder.radius, 0.5 * cylinder.length)) {}

Shape::Shape(const Cone& cone)
    : Shape(Kind::Cone, 0.0, roundExtents(cone.radius, cone.length, "cone radius", "cone length"),
            std::hypot(cone.radius, 0.5 * cone.length)) {}

Shape::Shape(const Ellipsoid& ellipsoid)
    : Shape(Kind::Ellipsoid, 0.0, positive(ellipsoid.radii, "ellipsoid radius"), ellipsoid.radii.maxCoeff()) {
  if (ellipsoid.radii.minCoeff() == ellipsoid.radii.maxCoeff()) *this = Shape(Sphere{ellipsoid.radii.x()});
}

Shape::Shape(ConvexHull hull) : Shape(Kind::Hull, 0.0, Eigen::Vector3d::Zero(), 0.0) {
  for (const Eigen::Vector3d& vertex : hull.vertices()) centre_ += vertex / hull.size();
  for (const Eigen::Vector3d& vertex : hull.vertices())
    core_radius_ = std::max(core_radius_, (vertex - centre_).norm());
  core_reach_ = centre_.norm() + core_radius_;
  hull_ = std::make_shared<const HullSupport>(std::move(hull));
}

Shape Shape::sweptTo(const Eigen::Isometry3d& end) const {
  Shape core = *this;
  core.margin_ = 0.0;
  const Eigen::Vector3d half_way = 0.5 * (end * centre_ - centre_);
  Shape shape(Kind::Sweep, margin_, Eigen::Vector3d::Zero(), core_radius_ + half_way.norm());
  shape.centre_ = centre_ + half_way;
  // Twice the reach, as the points of a sweep are rounded once more than others before they enter a CSO.
  shape.core_reach_ = 2.0 * (shape.centre_.norm() + shape.core_radius_);
  shape.sweep_ = std::make_shared<const Sweep>(Sweep{core, end});
  return shape;
}

bool Shape::isPolytope() const {
  if (kind_ == Kind::Sweep) return sweep_->shape.isPolytope();
  return kind_ != Kind::Cylinder && kind_ != Kind::Cone && kind_ != Kind::Ellipsoid;
}

Shape Shape::padded(double padding) const {
  Shape shape = *this;
  shape.margin_ = notNegative(margin_ + padding, "margin with padding");
  return shape;
}

}  // namespace proximity_server::narrowphase
