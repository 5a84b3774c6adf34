#include "oracle/point_oracle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;
using Section = PointOracle::Section;

constexpr long double kEndless = std::numeric_limits<long double>::infinity();
constexpr long double kFlat = 1e-15L;  // a polygon of this size is flat within this
constexpr long double kLongRounding = 32 * std::numeric_limits<long double>::epsilon();

Section everything() { return {-kEndless, kEndless, Vector3l::Zero()}; }
Section nothing() { return {kEndless, -kEndless, Vector3l::Zero()}; }

/// The part of the section that is behind a plane.
void clip(const Vector3l& normal, long double height, const Vector3l& origin, const Vector3l& direction,
          Section& section) {
  const long double along = normal.dot(direction), behind = height - normal.dot(origin);
  if (along == 0) {
    if (behind < 0) section = nothing();
    return;
  }
  const long double at = behind / along;
  if (along > 0) {
    section.end = std::min(section.end, at);
  } else if (at > section.begin) {
    section.begin = at;
    section.entry_normal = normal;
  }
}

/// The section of a line and a ball about the origin, or a cylinder about the z axis if both vectors have z = 0.
Section roundSection(long double radius, const Vector3l& origin, const Vector3l& direction) {
  const long double squared = direction.squaredNorm();
  if (squared == 0) return origin.norm() <= radius ? everything() : nothing();
  const long double middle = -origin.dot(direction) / squared;
  const long double across = (origin + middle * direction).norm();
  if (across > radius) return nothing();
  const long double half = std::sqrt((radius - across) * (radius + across) / squared);
  return {middle - half, middle + half, (origin + (middle - half) * direction) / radius};
}

Section cylinderSection(long double radius, long double half, const Vector3l& origin, const Vector3l& direction) {
  const Vector3l across(1, 1, 0);
  Section section = roundSection(radius, origin.cwiseProduct(across), direction.cwiseProduct(across));
  clip(Vector3l::UnitZ(), half, origin, direction, section);
  clip(-Vector3l::UnitZ(), half, origin, direction, section);
  return section;
}

Section capsuleSection(long double radius, long double half, const Vector3l& origin, const Vector3l& direction) {
  Section section = cylinderSection(radius, half, origin, direction);
  for (const long double z : {-half, half}) {
    const Section cap = roundSection(radius, origin - Vector3l(0, 0, z), direction);
    if (cap.isEmpty()) continue;
    const long double end = section.isEmpty() ? cap.end : std::max(section.end, cap.end);
    if (section.isEmpty() || cap.begin < section.begin) section = cap;
    section.end = end;
  }
  return section;
}

Section boxSection(const Vector3l& half, const Vector3l& origin, const Vector3l& direction) {
  Section section = everything();
  for (int i = 0; i < 3; ++i)
    for (const long double sign : {-1.0L, 1.0L}) clip(sign * Vector3l::Unit(i), half[i], origin, direction, section);
  return section;
}

/// The signed distance of a point from an intersection of solids with perpendicular faces, by those from each solid.
template <int count>
long double farthestOf(const Eigen::Matrix<long double, count, 1>& beyond) {
  const long double largest = beyond.maxCoeff();
  return largest > 0 ? beyond.cwiseMax(0.0L).norm() : largest;
}

}  // namespace

template <typename Real>
Eigen::Matrix<Real, 3, 1> nearestOf(const std::array<Eigen::Matrix<Real, 3, 1>, 3>& corners,
                                    const Eigen::Matrix<Real, 3, 1>& p) {
  using Vector = Eigen::Matrix<Real, 3, 1>;
  const Vector normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  bool is_above = normal.squaredNorm() > 0;
  Vector nearest = corners[0];
  Real squared = (p - nearest).squaredNorm();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector side = corners[(i + 1) % 3] - corners[i], from = p - corners[i];
    is_above = is_above && normal.dot(side.cross(from)) >= 0;
    const Real length = side.squaredNorm(), t = length > 0 ? side.dot(from) / length : Real(0);
    const Vector here = corners[i] + std::clamp(t, Real(0), Real(1)) * side;
    if (!((p - here).squaredNorm() < squared)) continue;
    squared = (p - here).squaredNorm();
    nearest = here;
  }
  return is_above ? Vector(p - normal * (normal.dot(p - corners[0]) / normal.squaredNorm())) : nearest;
}
template Vector3l nearestOf(const std::array<Vector3l, 3>& corners, const Vector3l& p);
template Vector3d nearestOf(const std::array<Vector3d, 3>& corners, const Vector3d& p);

PointOracle::PointOracle(const Shape& shape) : shape_(shape) {
  using Kind = Shape::Kind;
  const Kind kind = shape.kind();
  const bool has_ball = kind == Kind::Point || kind == Kind::Segment;
  if (kind == Kind::Cone || kind == Kind::Ellipsoid || kind == Kind::Sweep || (shape.margin() != 0.0 && !has_ball))
    throw std::invalid_argument("PointOracle knows no cone, ellipsoid and sweep, and no margin of others");
  radius_ = shape.halfExtents().cast<long double>().norm() + shape.margin();
  if (kind == Kind::Hull) addHull();
}

void PointOracle::addPlane(const Vector3l& normal) {
  if (!(normal.squaredNorm() > 0)) return;
  const Vector3l unit = normal.normalized();
  planes_.push_back({unit, coreSupport(shape_, unit).dot(unit)});
}

void PointOracle::addHull() {
  const ConvexHull& hull = shape_.hull();
  for (int i = 0; i < hull.size(); ++i) centre_ += corner(i) / hull.size();
  radius_ = 0;
  for (int i = 0; i < hull.size(); ++i) radius_ = std::max(radius_, (corner(i) - centre_).norm());
  long double largest = 0;
  for (const std::array<int, 3>& triangle : hull.triangles()) {
    const std::array<Vector3l, 3> corners{corner(triangle[0]), corner(triangle[1]), corner(triangle[2])};
    const Vector3l normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    addPlane(normal);
    if (hull.dimension() < 3) addPlane(-normal);
    if (normal.norm() > largest) normal_ = normal / (largest = normal.norm());
    triangles_.push_back(corners);
  }
  if (triangles_.empty()) triangles_.push_back({corner(0), corner(hull.size() - 1), corner(hull.size() - 1)});
  for (const std::array<Vector3l, 3>& t : triangles_) {
    const std::array<Vector3d, 3> corners{t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>()};
    const Vector3d centre = (corners[0] + corners[1] + corners[2]) / 3.0;
    double radius = 0.0;
    for (const Vector3d& corner : corners) radius = std::max(radius, (corner - centre).norm());
    rounded_.push_back({corners, centre, radius});
  }
}

DistanceBounds PointOracle::distance(const Vector3l& p) const {
  const Vector3l half = shape_.halfExtents().cast<long double>();
  const long double rounding = kLongRounding * (p.norm() + half.norm() + shape_.margin());
  const auto closedForm = [&](long double distance) {
    return DistanceBounds{distance - shape_.margin() - rounding, distance - shape_.margin() + rounding};
  };
  switch (shape_.kind()) {
    case Shape::Kind::Point:
      return closedForm(p.norm());
    case Shape::Kind::Segment:
      return closedForm(Vector3l(p.x(), p.y(), std::max(std::abs(p.z()) - half.z(), 0.0L)).norm());
    case Shape::Kind::Box:
      return closedForm(farthestOf<3>(p.cwiseAbs() - half));
    case Shape::Kind::Cylinder:
      return closedForm(farthestOf<2>({std::hypot(p.x(), p.y()) - half.x(), std::abs(p.z()) - half.z()}));
    default:
      return hullDistance(p);
  }
}

/// Only triangles are measured in long double that double cannot tell from the nearest one.
DistanceBounds PointOracle::hullDistance(const Vector3l& p) const {
  long double highest = -kEndless;
  for (const Plane& plane : planes_) highest = std::max(highest, plane.normal.dot(p) - plane.height);
  const Vector3d p_rounded = p.cast<double>();
  const double in_doubt = 1e-9 * (shape_.coreReach() + p_rounded.norm());  // of slivers, too
  double enough = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    if ((p_rounded - rounded_[i].centre).norm() - rounded_[i].radius > enough) continue;
    near.emplace_back((p_rounded - nearestOf(rounded_[i].corners, p_rounded)).norm(), i);
    enough = std::min(enough, near.back().first + in_doubt);
  }
  Vector3l nearest = p;
  long double smallest = kEndless;
  for (const auto& [distance, triangle] : near) {
    if (distance > enough) continue;
    const Vector3l here = nearestOf(triangles_[triangle], p);
    if (!((p - here).norm() < smallest)) continue;
    smallest = (p - here).norm();
    nearest = here;
  }
  const long double rounding = kLongRounding * (p.norm() + shape_.coreReach());
  const bool is_inside = shape_.hull().dimension() == 3 && highest < 0;
  if (is_inside) return {highest - rounding, std::max(highest, -smallest) + rounding};
  long double low = planes_.empty() ? 0.0L : highest;  // a point and a segment have no inside
  if (smallest > 0) {
    const Vector3l direction = (p - nearest) / smallest;
    low = std::max(low, direction.dot(p) - coreSupport(shape_, direction).dot(direction));
  }
  return {low - rounding, smallest + rounding};
}

Section PointOracle::polygonSection(const Vector3l& origin, const Vector3l& direction) const {
  const long double along = normal_.dot(direction);
  if (along == 0) return nothing();
  const long double at = normal_.dot(corner(0) - origin) / along;
  const long double rounding = kFlat * shape_.coreReach() + kLongRounding * origin.norm();
  const bool is_on = hullDistance(origin + at * direction).high <= rounding;
  return is_on ? Section{at, at, along > 0 ? Vector3l(-normal_) : normal_} : nothing();
}

Section PointOracle::section(const Vector3l& origin, const Vector3l& direction) const {
  const Vector3l half = shape_.halfExtents().cast<long double>();
  switch (shape_.kind()) {
    case Shape::Kind::Point:
      return roundSection(shape_.margin(), origin, direction);
    case Shape::Kind::Segment:
      return capsuleSection(shape_.margin(), half.z(), origin, direction);
    case Shape::Kind::Box:
      return boxSection(half, origin, direction);
    case Shape::Kind::Cylinder:
      return cylinderSection(half.x(), half.z(), origin, direction);
    default:
      break;
  }
  if (shape_.hull().dimension() < 3) return polygonSection(origin, direction);
  Section section = everything();
  for (const Plane& plane : planes_) {
    clip(plane.normal, plane.height, origin, direction, section);
    if (section.isEmpty()) break;
  }
  return section;
}

}  // namespace proximity_server::narrowphase
