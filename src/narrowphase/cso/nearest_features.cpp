#include "narrowphase/cso/nearest_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// The vertices of a feature, by their numbers.
struct Vertices {
  std::array<int, 3> numbers{};  ///< ascending
  int count = 0;

  bool has(int number) const {
    return (count > 0 && numbers[0] == number) || (count > 1 && numbers[1] == number) ||
           (count > 2 && numbers[2] == number);
  }
  void add(int number) {
    if (has(number)) return;
    int place = count++;
    for (; place > 0 && numbers[place - 1] > number; --place) numbers[place] = numbers[place - 1];
    numbers[place] = number;
  }
};

/// The vertices of a core: a hull, or a box, a segment or a point, which are boxes without width.
class Corners {
 public:
  explicit Corners(const Shape& core)
      : hull_(core.kind() == Shape::Kind::Hull ? &core.hull() : nullptr), half_(core.halfExtents()) {}

  /// The vertex that a number stands for, see vertexOf(). A box without width along an axis has two numbers for each of
  /// its points; the lower one is taken.
  int numberOf(int number) const {
    if (hull_ != nullptr) return number >= 0 && number < hull_->size() ? number : 0;
    number &= 7;
    for (int axis = 0; axis < 3; ++axis)
      if (half_[axis] == 0.0) number &= ~(1 << axis);
    return number;
  }
  Vector3d operator[](int number) const {
    return hull_ != nullptr ? hull_->vertices()[static_cast<std::size_t>(number)] : support::corner(half_, number);
  }
  /// True if all vertices beside the feature are farther than `behind` [m] behind its support plane along the
  /// direction.
  bool areOthersBehind(const Vertices& feature, const Vector3d& direction, double behind) const {
    return hull_ != nullptr ? areOthersOfHullBehind(feature, direction, behind)
                            : areOthersOfBoxBehind(feature, direction, behind);
  }

 private:
  bool areOthersOfHullBehind(const Vertices& feature, const Vector3d& direction, double behind) const {
    const Vector3d* const vertices = hull_->vertices().data();
    const double x = direction.x(), y = direction.y(), z = direction.z();
    const auto height = [&](int number) {
      const double* const v = vertices[number].data();
      return v[0] * x + v[1] * y + v[2] * z;
    };
    const double limit = height(feature.numbers[0]) - behind;
    for (int i = 0; i < feature.count; ++i)
      for (const int other : hull_->neighbours(feature.numbers[i]))
        if (!(height(other) < limit) && !feature.has(other)) return false;
    return true;
  }

  /// From each corner of a box the direction falls along the edges.
  bool areOthersOfBoxBehind(const Vertices& feature, const Vector3d& direction, double behind) const {
    const Vector3d fall = 2.0 * half_.cwiseProduct(direction);
    for (int i = 0; i < feature.count; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const int bit = 1 << axis, corner = feature.numbers[i];
        const bool is_behind = ((corner & bit) != 0 ? -fall[axis] : fall[axis]) > behind;
        if (half_[axis] > 0.0 && !is_behind && !feature.has(corner ^ bit)) return false;
      }
    return true;
  }

  const ConvexHull* hull_;
  const Vector3d& half_;
};

/// How near the features of two cores at a distance d [m] may be to others, so that every search tells them apart. A
/// search ends when its bounds differ by no more than four roundings r. Its point on the CSO, at a height of at most
/// d + 4 r over the support plane of the nearest point, then is
///  - no farther from the nearest point than the root of 2 d 4 r + (4 r)^2: if the nearest point is farther than this
///    from the ends of its features, both points lie on the same ones; and
///  - a mean of vertices, in which one that lies farther behind the plane has a weight of at most 4 r / behind. Such a
///    vertex brings no progress. The subalgorithm sees this by the sign of a product of d and `behind`, the rounding
///    error of which is at most a few r times the size of the CSO.
struct Separation {
  /// [m] GJK takes cores that are nearer than some roundings for touching ones, and EPA answers. With a reserve.
  static double least(double rounding) { return 100.0 * rounding; }

  /// [m^2] The square of the distance between the point and the ends of the features.
  static double inside2(double distance, double rounding) { return 64.0 * rounding * (distance + rounding); }

  /// [m] The height of the other vertices over the support plane.
  static double behind(double distance, double rounding, double tolerance) {
    // Vertices of a hull that was computed by qhull may lie beyond the plane of their neighbours by 2e-14 of its size.
    constexpr double kFarBeyondQhull = 1e-10;
    const double size = rounding / (8.0 * std::numeric_limits<double>::epsilon());  // see csoRounding()
    return std::max({tolerance, kFarBeyondQhull * size, 16.0 * rounding * size / distance});
  }
};

/// The points of a feature, in the frame of a.
using Points = std::array<Vector3d, 3>;

/// The nearest points of two features.
struct Foot {
  double distance;  ///< [m]
  Vector3d normal;  ///< unit, from the first feature towards the second one
  Vector3d first, second;
  bool is_inside = true;  ///< the point of the CSO is farther from the ends of the features than Separation asks for
};

double square(double x) { return x * x; }

/// Two vertices.
std::optional<Foot> footOnVertex(const Vector3d& p, const Vector3d& q) {
  const Vector3d towards_q = q - p;
  const double distance = towards_q.norm();
  if (!(distance > 0.0)) return std::nullopt;
  return Foot{distance, towards_q / distance, p, q};
}

/// A vertex p and the edge from q[0] to q[1]. The normal is computed by products as in nearestToOrigin(), which keep it
/// accurate if the distance is small.
std::optional<Foot> footOnEdge(const Vector3d& p, const Points& q, double rounding) {
  const Vector3d edge = q[1] - q[0], to_p = p - q[0];
  const double edge2 = edge.squaredNorm(), along = to_p.dot(edge);
  const double inside = std::min(along, edge2 - along);
  const Vector3d across = edge.cross(to_p.cross(edge));  // edge2 times the perpendicular from the edge to p
  const double length = across.norm();
  if (!(inside > 0.0) || !(length > 0.0)) return std::nullopt;
  const double distance = length / edge2;
  return Foot{distance, across * (-1.0 / length), p, q[0] + (along / edge2) * edge,
              square(inside) > Separation::inside2(distance, rounding) * edge2};
}

/// A vertex p and the triangle q.
std::optional<Foot> footOnTriangle(const Vector3d& p, const Points& q, double rounding) {
  const Vector3d e01 = q[1] - q[0], e12 = q[2] - q[1], e20 = q[0] - q[2];
  const Vector3d to_0 = q[0] - p, to_1 = q[1] - p, to_2 = q[2] - p, area = e01.cross(e12);
  // The weights of the corners, times area2: the parts of the area that the foot spans with the opposite edges.
  const double of_0 = area.dot(to_1.cross(e12)), of_1 = area.dot(to_2.cross(e20)), of_2 = area.dot(to_0.cross(e01));
  const double area2 = area.squaredNorm(), height = area.dot(to_0);
  if (!(std::min({of_0, of_1, of_2}) > 0.0) || height == 0.0) return std::nullopt;
  const double scale = std::copysign(1.0 / std::sqrt(area2), height), distance = height * scale;
  // A weight times the height of its corner over the opposite edge is the distance from this edge.
  const double inside2 = Separation::inside2(distance, rounding) * area2;
  const bool is_inside = square(of_0) > inside2 * e12.squaredNorm() && square(of_1) > inside2 * e20.squaredNorm() &&
                         square(of_2) > inside2 * e01.squaredNorm();
  return Foot{distance, area * scale, p, q[0] + (of_1 * e01 - of_2 * e20) / area2, is_inside};
}

/// Two edges: the points p + s along_p and q + t along_q whose difference is perpendicular to both.
std::optional<Foot> footOfEdges(const Points& p, const Points& q, double rounding) {
  const Vector3d along_p = p[1] - p[0], along_q = q[1] - q[0], to_q = q[0] - p[0], across = along_p.cross(along_q);
  const double across2 = across.squaredNorm(), height = across.dot(to_q);
  const double s = across.dot(to_q.cross(along_q)), t = across.dot(to_q.cross(along_p));
  const double inside_p = std::min(s, across2 - s), inside_q = std::min(t, across2 - t);
  if (!(std::min(inside_p, inside_q) > 0.0) || height == 0.0) return std::nullopt;
  const double scale = std::copysign(1.0 / std::sqrt(across2), height), distance = height * scale;
  // The distances of the point of the CSO from the sides of the parallelogram that the edges span.
  const double inside2 = Separation::inside2(distance, rounding) * across2;
  const bool is_inside =
      square(inside_p) > inside2 * along_q.squaredNorm() && square(inside_q) > inside2 * along_p.squaredNorm();
  return Foot{distance, across * scale, p[0] + (s / across2) * along_p, q[0] + (t / across2) * along_q, is_inside};
}

/// The first feature has no more points than the second one.
std::optional<Foot> footOf(const Points& p, int count_p, const Points& q, int count_q, double rounding) {
  if (count_p == 2 && count_q == 2) return footOfEdges(p, q, rounding);
  if (count_p != 1) return std::nullopt;
  if (count_q == 1) return footOnVertex(p[0], q[0]);
  return count_q == 2 ? footOnEdge(p[0], q, rounding) : footOnTriangle(p[0], q, rounding);
}

/// True for a core with stored neighbours, and for a box, a segment or a point. A sweep has none.
bool knowsNeighbours(const Shape& polytope) {
  switch (polytope.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
    case Shape::Kind::Hull:
      return true;
    case Shape::Kind::Cylinder:
    case Shape::Kind::Cone:
    case Shape::Kind::Ellipsoid:
    case Shape::Kind::Sweep:
      break;
  }
  return false;
}

}  // namespace

std::optional<DistanceOfFeatures> distanceOfFeatures(const Cso& cso, const WarmStart& last, double tolerance) {
  if (!knowsNeighbours(cso.a()) || !knowsNeighbours(cso.b())) return std::nullopt;
  const Corners corners_a(cso.a()), corners_b(cso.b());
  Vertices of_a, of_b;
  for (int i = 0; i < std::clamp(last.simplex_size, 0, 3); ++i) {
    of_a.add(corners_a.numberOf(last.simplex[i].a));
    of_b.add(corners_b.numberOf(last.simplex[i].b));
  }
  Points a, b;
  for (int i = 0; i < of_a.count; ++i) a[i] = corners_a[of_a.numbers[i]];
  for (int i = 0; i < of_b.count; ++i) b[i] = cso.bAxes() * corners_b[of_b.numbers[i]] + cso.bOrigin();
  const double rounding = cso.rounding();
  const bool in_order = of_a.count <= of_b.count;
  const std::optional<Foot> foot =
      in_order ? footOf(a, of_a.count, b, of_b.count, rounding) : footOf(b, of_b.count, a, of_a.count, rounding);
  if (!foot || !foot->is_inside || !(foot->distance > Separation::least(rounding))) return std::nullopt;
  const Vector3d normal = in_order ? foot->normal : Vector3d(-foot->normal);
  const double behind = Separation::behind(foot->distance, rounding, tolerance);
  if (!corners_a.areOthersBehind(of_a, normal, behind) ||
      !corners_b.areOthersBehind(of_b, -(cso.bAxes().transpose() * normal), behind))
    return std::nullopt;
  double highest = normal.dot(a[0]), lowest = normal.dot(b[0]);
  for (int i = 1; i < of_a.count; ++i) highest = std::max(highest, normal.dot(a[i]));
  for (int i = 1; i < of_b.count; ++i) lowest = std::min(lowest, normal.dot(b[i]));
  return DistanceOfFeatures{
      foot->distance, lowest - highest - rounding, normal,
      in_order ? WitnessPoints{foot->first, foot->second} : WitnessPoints{foot->second, foot->first}};
}

}  // namespace proximity_server::narrowphase
