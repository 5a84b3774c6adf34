#include "oracle/oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

namespace proximity_server::narrowphase {
namespace {

constexpr long double kRounding = std::numeric_limits<long double>::epsilon();

Vector3l discSupport(long double radius, long double z, const Vector3l& n) {
  const long double radial = std::hypot(n.x(), n.y());
  if (radial == 0) return {radius, 0, z};
  return {radius * n.x() / radial, radius * n.y() / radial, z};
}

/// In double first: only vertices within its rounding of the farthest are compared in long double.
Vector3l hullSupport(const ConvexHull& hull, const Vector3l& n) {
  const Eigen::Vector3d rounded = n.cast<double>();
  double highest = -std::numeric_limits<double>::infinity(), largest = 0;
  for (const Eigen::Vector3d& vertex : hull.vertices()) {
    highest = std::max(highest, vertex.dot(rounded));
    largest = std::max(largest, vertex.cwiseAbs().maxCoeff());
  }
  const double enough = highest - 32 * std::numeric_limits<double>::epsilon() * largest * rounded.norm();
  const Eigen::Vector3d* best = nullptr;
  long double farthest = 0;
  for (const Eigen::Vector3d& vertex : hull.vertices()) {
    if (vertex.dot(rounded) < enough) continue;
    const long double along = vertex.cast<long double>().dot(n);
    if (best && !(along > farthest)) continue;
    farthest = along;
    best = &vertex;
  }
  return best->cast<long double>();
}

/// Lowest point of the CSO b - a (cores only) along n, in the frame of a.
Vector3l lowestCsoPoint(const ShapePair& pair, const Vector3l& n) {
  const Matrix3l rotation = pair.a_T_b.linear().cast<long double>();
  const Vector3l on_b = rotation * coreSupport(pair.b, -(rotation.transpose() * n));
  return on_b + pair.a_T_b.translation().cast<long double>() - coreSupport(pair.a, n);
}

/// A direction and the lowest CSO point along it.
struct Sample {
  Vector3l n;
  Vector3l c;
};

Sample sample(const ShapePair& pair, const Vector3l& direction) {
  const Vector3l n = direction.normalized();
  return {n, lowestCsoPoint(pair, n)};
}

/// All unit vectors within an angle below 90 degrees of n0.
struct Cap {
  Vector3l n0;
  long double sin_angle;
  long double cos_angle;

  long double largestDot(const Vector3l& c) const {
    const long double along = c.dot(n0), across = c.cross(n0).norm();
    if (along * sin_angle >= across * cos_angle) return c.norm();
    return along * cos_angle + across * sin_angle;
  }
};

Cap circumscribedCap(const Vector3l& n0, const std::array<Sample, 3>& corners) {
  long double sin_angle = 0;
  for (const Sample& corner : corners) sin_angle = std::max(sin_angle, n0.cross(corner.n).norm());
  sin_angle += 8 * kRounding;
  return {n0, sin_angle, std::sqrt(1 - sin_angle * sin_angle)};
}

/// The point of the segment c d nearest to the axis through 0 along the unit vector n0.
Vector3l nearestToAxis(const Vector3l& n0, const Vector3l& c, const Vector3l& d) {
  const Vector3l step = d - c - n0 * n0.dot(d - c);
  const long double t = step.squaredNorm() > 0 ? -c.dot(step) / step.squaredNorm() : 0;
  return c + std::clamp(t, 0.0L, 1.0L) * (d - c);
}

/// Returns the point in which the axis through 0 along n0 meets the triangle; the first corner if it does not meet it.
Vector3l onAxis(const Vector3l& n0, const std::array<Vector3l, 3>& triangle) {
  const auto& [c, d, e] = triangle;
  const Vector3l weights(n0.dot(d.cross(e)), n0.dot(e.cross(c)), n0.dot(c.cross(d)));
  const bool inside = weights.minCoeff() >= 0 || weights.maxCoeff() <= 0;
  if (!inside || weights.sum() == 0) return c;
  return (weights.x() * c + weights.y() * d + weights.z() * e) / weights.sum();
}

/// Upper bound of the gap along every direction of the cap. Each point c of the CSO gives one, the largest c . n; so
/// does each convex combination of such points, and one near the axis of the cap gives a tight one. A bound of at most
/// `enough` is not improved.
long double boundOfGap(const Cap& cap, const std::array<Vector3l, 4>& c, long double enough) {
  long double bound = std::numeric_limits<long double>::infinity();
  const auto isEnough = [&](const Vector3l& of_cso) {
    bound = std::min(bound, cap.largestDot(of_cso));
    return bound <= enough;
  };
  for (std::size_t i = 0; i < 4; ++i) {
    if (isEnough(c[i]) || isEnough(onAxis(cap.n0, {c[i], c[(i + 1) % 4], c[(i + 2) % 4]}))) return bound;
    for (std::size_t j = 0; j < i; ++j)
      if (isEnough(nearestToAxis(cap.n0, c[i], c[j]))) return bound;
  }
  return bound;
}

/// A triangle of directions with the gap along its centre and a bound of the gap along every direction in it.
struct Cell {
  std::array<Sample, 3> corners;
  Sample centre;
  long double gap;
  long double bound;

  bool operator<(const Cell& other) const { return bound < other.bound; }
};

Cell makeCell(const ShapePair& pair, const std::array<Sample, 3>& corners, long double enough) {
  const Sample centre = sample(pair, corners[0].n + corners[1].n + corners[2].n);
  const Cap cap = circumscribedCap(centre.n, corners);
  return {corners, centre, centre.c.dot(centre.n),
          boundOfGap(cap, {centre.c, corners[0].c, corners[1].c, corners[2].c}, enough)};
}

/// Turned away from the axes of both shapes: where an edge of a cell runs along the seam between two faces, its samples
/// see only one of them, and the bound stays loose.
std::vector<Cell> octahedron(const ShapePair& pair) {
  const Matrix3l turn = Eigen::Quaternion<long double>(0.83L, 0.31L, -0.37L, 0.29L).normalized().toRotationMatrix();
  std::vector<Cell> cells;
  for (const long double x : {-1.0L, 1.0L})
    for (const long double y : {-1.0L, 1.0L})
      for (const long double z : {-1.0L, 1.0L})
        cells.push_back(makeCell(
            pair, {sample(pair, x * turn.col(0)), sample(pair, y * turn.col(1)), sample(pair, z * turn.col(2))},
            -std::numeric_limits<long double>::infinity()));
  return cells;
}

/// Four triangles that cover the cell: cut at the middles of its sides.
std::array<Cell, 4> split(const ShapePair& pair, const Cell& cell, long double enough) {
  const auto& [p, q, r] = cell.corners;
  const Sample pq = sample(pair, p.n + q.n), qr = sample(pair, q.n + r.n), rp = sample(pair, r.n + p.n);
  return {makeCell(pair, {p, pq, rp}, enough), makeCell(pair, {pq, q, qr}, enough), makeCell(pair, {rp, qr, r}, enough),
          makeCell(pair, {pq, qr, rp}, enough)};
}

/// Distance of (x, z) to the segment from (x0, z0) to (x1, z1).
long double distanceToSegment(long double x, long double z, long double x0, long double z0, long double x1,
                              long double z1) {
  const long double dx = x1 - x0, dz = z1 - z0;
  const long double t = std::clamp(((x - x0) * dx + (z - z0) * dz) / (dx * dx + dz * dz), 0.0L, 1.0L);
  return std::hypot(x - x0 - t * dx, z - z0 - t * dz);
}

long double outsideCone(const Vector3l& half, const Vector3l& p) {
  const long double radial = std::hypot(p.x(), p.y());
  const bool under_slant = radial * 2 * half.z() <= half.x() * (half.z() - p.z());
  if (under_slant && p.z() >= -half.z()) return 0;
  return std::min(distanceToSegment(radial, p.z(), 0, -half.z(), half.x(), -half.z()),
                  distanceToSegment(radial, p.z(), half.x(), -half.z(), 0, half.z()));
}

/// The foot of p is r^2 p / (t + r^2), componentwise, for the root t of sum (r p / (t + r^2))^2 = 1. The sum is convex
/// and decreasing in t, so Newton's steps from 0 approach the root from below.
long double outsideEllipsoid(const Vector3l& radii, const Vector3l& p) {
  const Vector3l squares = radii.cwiseAbs2();
  long double t = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3l scaled = (radii.cwiseProduct(p).array() / (squares.array() + t)).matrix();
    const long double excess = scaled.squaredNorm() - 1;
    const long double step = excess / (2 * (scaled.array().square() / (squares.array() + t)).sum());
    if (!(excess > 0) || !(t + step > t)) break;
    t += step;
  }
  return (t * p.array() / (squares.array() + t)).matrix().norm();
}

/// Distance of p to the triangle: to its plane where p stands above it, else to its sides.
long double distanceToTriangle(const Vector3l& p, const std::array<Vector3l, 3>& corners) {
  const Vector3l normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  bool above = normal.squaredNorm() > 0;
  long double nearest = std::numeric_limits<long double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3l &from = corners[i], side = corners[(i + 1) % 3] - from;
    above = above && normal.dot(side.cross(p - from)) >= 0;
    const long double t = side.squaredNorm() > 0 ? side.dot(p - from) / side.squaredNorm() : 0;
    nearest = std::min(nearest, (p - from - std::clamp(t, 0.0L, 1.0L) * side).norm());
  }
  return above ? std::abs(normal.dot(p - corners[0])) / normal.norm() : nearest;
}

/// Distance of p to the nearest triangle of the hull, or to all there is of a segment or point. The corners are
/// vertices of the hull, so whatever triangles there are, p lies no farther from the hull than this.
long double distanceToTriangles(const ConvexHull& hull, const Vector3l& p) {
  const auto corner = [&](int i) -> const Eigen::Vector3d& { return hull.vertices()[i]; };
  const auto distance = [&](int i, int j, int k) {
    return distanceToTriangle(
        p, {corner(i).cast<long double>(), corner(j).cast<long double>(), corner(k).cast<long double>()});
  };
  const Eigen::Vector3d rounded = p.cast<double>();
  // Most triangles are farther than the nearest so far by their bounding box alone.
  const auto boxIsFarther = [&](const std::array<int, 3>& t, double than) {
    const Eigen::Vector3d low = corner(t[0]).cwiseMin(corner(t[1])).cwiseMin(corner(t[2]));
    const Eigen::Vector3d high = corner(t[0]).cwiseMax(corner(t[1])).cwiseMax(corner(t[2]));
    return (low - rounded).cwiseMax(rounded - high).maxCoeff() > than;
  };
  const int last = hull.size() - 1;
  long double nearest = distance(0, last, last);
  for (const std::array<int, 3>& t : hull.triangles())
    if (!boxIsFarther(t, static_cast<double>(nearest))) nearest = std::min(nearest, distance(t[0], t[1], t[2]));
  return nearest;
}

/// Whether p sees every triangle of a solid hull from inside: then it lies in what they enclose.
bool seesAllFromInside(const ConvexHull& hull, const Vector3l& p) {
  const auto corner = [&](int i) { return hull.vertices()[i].cast<long double>(); };
  return hull.dimension() == 3 && std::all_of(hull.triangles().begin(), hull.triangles().end(), [&](const auto& t) {
           const Vector3l a = corner(t[0]) - p, b = corner(t[1]) - p, c = corner(t[2]) - p;
           return a.dot(b.cross(c)) > 8 * kRounding * a.norm() * b.norm() * c.norm();
         });
}

/// By the oracle, which is slow. On a flat face whole arcs of directions are equally good, and the search gives up with
/// the best that it knows: no more than the truth.
long double outsideByDirections(const Shape& shape, const Eigen::Vector3d& point, int max_cells) {
  const Shape just_the_point = ConvexHull({point});
  const Truth truth = signedDistanceOracle({shape, just_the_point, Eigen::Isometry3d::Identity()}, max_cells);
  return std::max(truth.distance + shape.margin(), 0.0L);
}

/// A point on a triangle of the hull or well inside needs no more proof.
long double outsideHull(const Shape& shape, const Eigen::Vector3d& point) {
  const long double to_triangles = distanceToTriangles(shape.hull(), point.cast<long double>());
  if (to_triangles <= std::numeric_limits<double>::epsilon() * shape.coreRadius()) return to_triangles;
  if (seesAllFromInside(shape.hull(), point.cast<long double>())) return 0;
  return outsideByDirections(shape, point, 10000);
}

}  // namespace

Vector3l coreSupport(const Shape& shape, const Vector3l& n) {
  const Vector3l half = shape.halfExtents().cast<long double>();
  const long double upper_or_lower = std::copysign(half.z(), n.z());
  switch (shape.kind()) {
    case Shape::Kind::Point:
      return Vector3l::Zero();
    case Shape::Kind::Segment:
      return {0, 0, upper_or_lower};
    case Shape::Kind::Box:
      return {std::copysign(half.x(), n.x()), std::copysign(half.y(), n.y()), upper_or_lower};
    case Shape::Kind::Cylinder:
      return discSupport(half.x(), upper_or_lower, n);
    case Shape::Kind::Cone: {
      const Vector3l apex(0, 0, half.z()), rim = discSupport(half.x(), -half.z(), n);
      return apex.dot(n) > rim.dot(n) ? apex : rim;
    }
    case Shape::Kind::Ellipsoid: {
      const Vector3l scaled = half.cwiseProduct(n);
      return half.cwiseProduct(scaled) / scaled.norm();
    }
    case Shape::Kind::Hull:
      return hullSupport(shape.hull(), n);
    case Shape::Kind::Sweep: {
      const Eigen::Transform<long double, 3, Eigen::Isometry> end = shape.sweep().end.cast<long double>();
      const Vector3l first = coreSupport(shape.sweep().shape, n);
      const Vector3l last = end * coreSupport(shape.sweep().shape, end.linear().transpose() * n);
      return first.dot(n) > last.dot(n) ? first : last;
    }
  }
  return Vector3l::Zero();
}

double ShapePair::scale() const {
  const double reach_a = a.centre().norm() + a.coreRadius() + a.margin();
  const double reach_b = b.centre().norm() + b.coreRadius() + b.margin();
  return std::max(reach_a, a_T_b.translation().norm() + reach_b);
}

long double ShapePair::gapAlong(const Vector3l& n) const {
  return lowestCsoPoint(*this, n).dot(n) - n.norm() * (static_cast<long double>(a.margin()) + b.margin());
}

Truth signedDistanceOracle(const ShapePair& pair, int max_cells) {
  const long double rounding = 16 * kRounding * pair.scale();
  std::priority_queue<Cell> open;
  Sample best{};
  long double gap = -std::numeric_limits<long double>::infinity();
  const auto take = [&](const Cell& cell) {
    if (cell.gap > gap) {
      gap = cell.gap;
      best = cell.centre;
    }
    if (cell.bound > gap + rounding) open.push(cell);
  };
  for (const Cell& cell : octahedron(pair)) take(cell);
  for (int cells = 8; !open.empty() && open.top().bound > gap + rounding && cells < max_cells; cells += 4) {
    const Cell widest = open.top();
    open.pop();
    for (const Cell& cell : split(pair, widest, gap + rounding)) take(cell);
  }
  const long double unproven = open.empty() ? 0.0L : std::max(open.top().bound - gap, 0.0L);
  const long double margins = static_cast<long double>(pair.a.margin()) + pair.b.margin();
  return {gap - margins, unproven + rounding, best.n};
}

long double outsideBy(const Shape& shape, const Eigen::Vector3d& point) {
  const Vector3l p = point.cast<long double>(), half = shape.halfExtents().cast<long double>();
  const Vector3l outside_box = (p.cwiseAbs() - half).cwiseMax(0.0L);
  const auto outside_core = [&]() -> long double {
    switch (shape.kind()) {
      case Shape::Kind::Point:
      case Shape::Kind::Segment:
      case Shape::Kind::Box:
        return outside_box.norm();
      case Shape::Kind::Cylinder:
        return std::hypot(std::max(std::hypot(p.x(), p.y()) - half.x(), 0.0L), outside_box.z());
      case Shape::Kind::Cone:
        return outsideCone(half, p);
      case Shape::Kind::Ellipsoid:
        return outsideEllipsoid(half, p);
      case Shape::Kind::Hull:
        return outsideHull(shape, point);
      case Shape::Kind::Sweep:
        return outsideByDirections(shape, point, 500);
    }
    return std::numeric_limits<long double>::quiet_NaN();
  };
  return outside_core() - shape.margin();
}

long double outsideByAtMost(const Shape& shape, const Eigen::Vector3d& point) {
  if (shape.kind() != Shape::Kind::Hull) return outsideBy(shape, point);
  return distanceToTriangles(shape.hull(), point.cast<long double>()) - shape.margin();
}

}  // namespace proximity_server::narrowphase
