#include "proximity_server/narrowphase/shape/shape.h"

#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

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

Vector3d positive(const Vector3d& sizes, const char* what) {
  return {positive(sizes.x(), what), positive(sizes.y(), what), positive(sizes.z(), what)};
}

Vector3d roundExtents(double radius, double length, const char* radius_name, const char* length_name) {
  positive(radius, radius_name);
  return {radius, radius, 0.5 * positive(length, length_name)};
}

/// True if the triangles are a closed surface: every edge is passed equally often in both directions.
bool isClosed(const ConvexHull& hull) {
  const int* const first = hull.neighbours(0).begin();
  std::vector<int> passed(static_cast<std::size_t>(hull.neighbours(hull.size() - 1).end() - first), 0);
  const auto edge = [&](int from, int to) -> int& {
    const ConvexHull::Range ends = hull.neighbours(from);
    return passed[std::lower_bound(ends.begin(), ends.end(), to) - first];
  };
  for (const auto& t : hull.triangles())
    for (std::size_t i = 0; i < 3; ++i) {
      const int from = t[i], to = t[(i + 1) % 3];
      ++edge(from, to);
      --edge(to, from);
    }
  return std::all_of(passed.begin(), passed.end(), [](int times) { return times == 0; });
}

/// [m] Distance of a point inside of a solid from the plane of a triangle (p, q, r), less the rounding error. Negative
/// or NaN if the point does not lie on the inner side for certain.
///
/// The product of two edges has an error of 4 eps of the product of their lengths, which turns the unit normal by twice
/// this over the length of the product. The offset and the sums add less than 4 eps of the offset.
double depthBelow(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& point) {
  const Vector3d u = q - p, v = r - p, area = u.cross(v), offset = p - point;
  const double length2 = area.squaredNorm(), length = std::sqrt(length2);
  constexpr double kLosesDigits = 1e-280;  // [m^4]
  if (!(length2 > kLosesDigits)) return 0.0;
  const double error = 8.0 * std::numeric_limits<double>::epsilon() * (1.0 + u.norm() * v.norm() / length);
  return area.dot(offset) / length - error * offset.norm();
}

/// [m] Least distance of a face of a hull from a point inside of it; 0 if no face is known to be beyond the point.
///
/// If a closed surface has the point on the inner side of each of its triangles, it winds about the point, so each ray
/// from there meets a triangle, which lies in the hull. The ray is at least as long as the distance of its plane.
double smallestDepth(const ConvexHull& hull, const Vector3d& point) {
  if (hull.dimension() < 3 || hull.triangles().empty() || !isClosed(hull)) return 0.0;
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& t : hull.triangles()) {
    const auto corner = [&](std::size_t i) { return hull.vertices()[t[i]]; };
    const double depth = depthBelow(corner(0), corner(1), corner(2), point);
    if (!(depth > 0.0)) return 0.0;
    smallest = std::min(smallest, depth);
  }
  return smallest;
}

}  // namespace

Shape::Shape(Kind kind, double margin, const Vector3d& half_extents, double core_radius, double inner_radius)
    : kind_(kind),
      margin_(margin),
      core_radius_(core_radius),
      inner_radius_(inner_radius),
      core_reach_(core_radius),
      half_extents_(half_extents) {}

Shape::Shape(const Sphere& sphere)
    : Shape(Kind::Point, positive(sphere.radius, "sphere radius"), Vector3d::Zero(), 0.0, 0.0) {}

Shape::Shape(const Capsule& capsule)
    : Shape(Kind::Segment, positive(capsule.radius, "capsule radius"),
            {0.0, 0.0, 0.5 * notNegative(capsule.length, "capsule length")}, 0.5 * capsule.length, 0.0) {
  if (capsule.length == 0.0) *this = Shape(Sphere{capsule.radius});
}

Shape::Shape(const Box& box)
    : Shape(Kind::Box, 0.0, 0.5 * positive(box.size, "box size"), 0.5 * box.size.norm(), 0.5 * box.size.minCoeff()) {}

Shape::Shape(const Cylinder& cylinder)
    : Shape(Kind::Cylinder, 0.0, roundExtents(cylinder.radius, cylinder.length, "cylinder radius", "cylinder length"),
            std::hypot(cylinder.radius, 0.5 * cylinder.length), std::min(cylinder.radius, 0.5 * cylinder.length)) {}

// The inner ball of a cone touches its side: the distance of the centre from a line of the side, which goes from the
// base to the apex, along (-radius, length).
Shape::Shape(const Cone& cone)
    : Shape(Kind::Cone, 0.0, roundExtents(cone.radius, cone.length, "cone radius", "cone length"),
            std::hypot(cone.radius, 0.5 * cone.length),
            0.5 * cone.length * (cone.radius / std::hypot(cone.radius, cone.length))) {}

Shape::Shape(const Ellipsoid& ellipsoid)
    : Shape(Kind::Ellipsoid, 0.0, positive(ellipsoid.radii, "ellipsoid radius"), ellipsoid.radii.maxCoeff(),
            ellipsoid.radii.minCoeff()) {
  if (ellipsoid.radii.minCoeff() == ellipsoid.radii.maxCoeff()) *this = Shape(Sphere{ellipsoid.radii.x()});
}

Shape::Shape(ConvexHull hull) : Shape(Kind::Hull, 0.0, Vector3d::Zero(), 0.0, 0.0) {
  for (const Vector3d& vertex : hull.vertices()) centre_ += vertex / hull.size();
  for (const Vector3d& vertex : hull.vertices()) core_radius_ = std::max(core_radius_, (vertex - centre_).norm());
  core_reach_ = centre_.norm() + core_radius_;
  // Each sum of the mean has an error of half an eps, which may move the centre out of a flat hull.
  const double mean_error = (hull.size() + 2) * std::numeric_limits<double>::epsilon() * core_reach_;
  const double depth = smallestDepth(hull, centre_);
  inner_radius_ = depth > 0.0 ? depth : -mean_error;
  // Nearer hulls are not worth the memory of a copy: their place adds less than 4096 times the rounding of their size,
  // which is far below 1e-9 m for a hull of 10 m. The copy reaches no farther than three of its radii, and has no copy
  // of its own.
  constexpr double kFar = 4096.0;
  if (centre_.norm() > kFar * core_radius_)
    near_origin_ = std::make_shared<const Shape>(hull.movedBy(-hull.vertices().front()));
  hull_ = std::make_shared<const HullSupport>(std::move(hull));
}

Shape Shape::sweptTo(const Eigen::Isometry3d& given_end) const {
  const std::optional<Eigen::Isometry3d> rigid = rigidPose(given_end);
  if (!rigid) throw std::invalid_argument("the end of a sweep is not finite, or its axes are no rotation");
  const Eigen::Isometry3d& end = *rigid;
  Shape core = *this;
  core.margin_ = 0.0;
  const Vector3d half_way = 0.5 * (end * centre_ - centre_);
  // The sweep contains the inner ball at the start, at the end, and so half-way.
  Shape shape(Kind::Sweep, margin_, Vector3d::Zero(), core_radius_ + half_way.norm(), inner_radius_);
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

Shape Shape::nearOrigin() const { return isFarFromOrigin() ? near_origin_->padded(margin_) : *this; }

Shape Shape::padded(double padding) const {
  Shape shape = *this;
  shape.margin_ = notNegative(margin_ + padding, "margin with padding");
  return shape;
}

}  // namespace proximity_server::narrowphase
