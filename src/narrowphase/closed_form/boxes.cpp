#include "narrowphase/closed_form/boxes.h"

#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// The corner of a box farthest along `direction`. Returns nullopt if an edge or a face is as far, within the
/// tolerance.
std::optional<Vector3d> onlyCorner(const Vector3d& half, const Vector3d& direction, double tolerance) {
  if ((2.0 * half.cwiseProduct(direction).cwiseAbs()).minCoeff() <= tolerance) return std::nullopt;
  return half.cwiseProduct(direction.cwiseSign());
}

/// The middle of the edge parallel to `axis` that lies farthest along `direction`, which is perpendicular to it.
/// Returns nullopt if a face is as far, within the tolerance.
std::optional<Vector3d> onlyEdge(Vector3d half, Vector3d direction, Eigen::Index axis, double tolerance) {
  direction[axis] = std::numeric_limits<double>::infinity();
  const double thinnest = (2.0 * half.cwiseProduct(direction).cwiseAbs()).minCoeff();
  if (thinnest <= tolerance) return std::nullopt;
  half[axis] = 0.0;
  direction[axis] = 1.0;
  return half.cwiseProduct(direction.cwiseSign());
}

bool isInside(const Vector3d& point, const Vector3d& half, double rounding) {
  return ((point.cwiseAbs() - half).array() <= rounding).all();
}

/// A vector with a zero behind it, which fills the registers of the processor.
using Padded = Eigen::Array4d;

/// A column of a pose. It is read as a whole: where its parts are stored one by one, reading them together waits.
Padded column(const Eigen::Isometry3d& pose, Eigen::Index i) {
  return pose.matrix().col(i).array() * Padded(1.0, 1.0, 1.0, 0.0);
}

/// The point of a box nearest to a point.
Padded nearestIn(const Padded& half, const Padded& point) { return point.max(-half).min(half); }

/// Smaller numbers count as zero; the products of all lengths of a query that are not zero are larger.
constexpr double kSmallest = 1e-300;

/// Moves a point along an edge to where it is the nearest to a box, but not beyond an end of the edge: one step of
/// Newton's method. `place` is where the point is, `half_length` where the ends are.
inline void moveAlong(const Padded& edge, double half_length, const Padded& half, Padded& point, double& place) {
  const Padded difference = point - nearestIn(half, point);
  // 1 for the coordinates outside of the box, which the squared distance depends on, and 0 for the others.
  const Padded counts = (difference.abs() * (1.0 / kSmallest)).min(1.0);
  const double slope = (edge * difference).sum(), curvature = (edge.square() * counts).sum();
  const double next = std::clamp(place - slope / std::max(curvature, kSmallest), -half_length, half_length);
  point += (next - place) * edge;
  place = next;
}

}  // namespace

BoxPair::BoxPair(const Vector3d& half_a, const Vector3d& half_b, const Eigen::Isometry3d& a_T_b)
    : half_a_(half_a), half_b_(half_b), a_T_b_(a_T_b) {
  const auto axes_b = a_T_b.linear();
  const Vector3d t = a_T_b.translation();
  const Eigen::Matrix3d overlap = axes_b.cwiseAbs();
  const Vector3d reach_on_a = half_a + overlap * half_b;
  const Vector3d reach_on_b = half_b + overlap.transpose() * half_a;
  const Vector3d t_on_b = axes_b.transpose() * t;
  for (int i = 0; i < 3; ++i) measure(i, std::abs(t[i]) - reach_on_a[i]);
  for (int j = 0; j < 3; ++j) measure(3 + j, std::abs(t_on_b[j]) - reach_on_b[j]);
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3, l = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const double nk = -axes_b(l, j), nl = axes_b(k, j);  // the product has no component along edge i
      const double length2 = nk * nk + nl * nl;
      double reach = half_a[k] * std::abs(nk) + half_a[l] * std::abs(nl);
      for (int m = 1; m < 3; ++m) {
        const int other = (j + m) % 3;
        reach += half_b[other] * std::abs(axes_b(k, other) * nk + axes_b(l, other) * nl);
      }
      const double separation = (std::abs(t[k] * nk + t[l] * nl) - reach) / std::sqrt(length2);
      // The product of parallel edges has no direction; a face normal then has the same separation.
      constexpr double kParallel = std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon();
      measure(6 + 3 * i + j, length2 > kParallel ? separation : -std::numeric_limits<double>::infinity());
    }
  }
}

void BoxPair::measure(int axis, double separation) {
  PROXIMITY_ASSERT(isPlace(axis, separations_.size()), "There are six normals of faces and nine products of edges.");
  separations_[axis] = separation;
  if (separation > separations_[best_]) best_ = axis;
}

Vector3d BoxPair::axisOf(int axis) const {
  PROXIMITY_ASSERT(isPlace(axis, separations_.size()), "There are six normals of faces and nine products of edges.");
  if (axis < 3) return Vector3d::Unit(axis);
  if (axis < 6) return a_T_b_.linear().col(axis - 3).normalized();
  const Vector3d edge_a = Vector3d::Unit((axis - 6) / 3), edge_b = a_T_b_.linear().col((axis - 6) % 3);
  return edge_a.cross(edge_b).normalized();
}

Vector3d BoxPair::normalOf(int axis) const {
  const Vector3d direction = axisOf(axis);
  return direction.dot(a_T_b_.translation()) >= 0.0 ? direction : Vector3d(-direction);
}

/// True if all axes with the greatest separation, within the tolerance, are near the best one; see isUnique() of
/// epa.cpp.
bool BoxPair::isUnique(const Vector3d& best, double tolerance) const {
  constexpr double kSameDirection = 1e-2;
  int as_shallow = 0;
  for (const double separation : separations_) as_shallow += separation >= separations_[best_] - tolerance ? 1 : 0;
  if (as_shallow == 1) return best.dot(a_T_b_.translation()) > tolerance;
  for (int axis = 0; axis < kAxes; ++axis) {
    if (separations_[axis] < separation() - tolerance) continue;
    const Vector3d other = axisOf(axis);
    if (other.cross(best).norm() > kSameDirection) return false;
    if (std::abs(other.dot(a_T_b_.translation())) <= tolerance) return false;  // the opposite direction is as short
  }
  return true;
}

std::optional<Vector3d> BoxPair::vertexInFaceOfA(const Vector3d& normal, double tolerance) const {
  const std::optional<Vector3d> corner = onlyCorner(half_b_, -(a_T_b_.linear().transpose() * normal), tolerance);
  if (!corner) return std::nullopt;
  return Vector3d(a_T_b_ * *corner - separation() * normal);
}

std::optional<Vector3d> BoxPair::vertexInFaceOfB(const Vector3d& normal, double tolerance) const {
  return onlyCorner(half_a_, normal, tolerance);
}

std::optional<Vector3d> BoxPair::onCrossingEdges(const Vector3d& normal, double tolerance) const {
  const int i = (best_ - 6) / 3, j = (best_ - 6) % 3;
  const std::optional<Vector3d> on_a = onlyEdge(half_a_, normal, i, tolerance);
  const std::optional<Vector3d> on_b = onlyEdge(half_b_, -(a_T_b_.linear().transpose() * normal), j, tolerance);
  if (!on_a || !on_b) return std::nullopt;
  // The plane through b's edge along the normal intersects a's edge in this point.
  const Vector3d across = a_T_b_.linear().col(j).cross(normal);
  Vector3d point = *on_a;
  point[i] = across.dot(a_T_b_ * *on_b - *on_a) / across[i];
  return point;
}

std::optional<Vector3d> BoxPair::deepestOnA(const Vector3d& normal, double tolerance) const {
  if (best_ < 3) return vertexInFaceOfA(normal, tolerance);
  if (best_ < 6) return vertexInFaceOfB(normal, tolerance);
  return onCrossingEdges(normal, tolerance);
}

std::optional<SignedDistance> BoxPair::distanceAlongNormal(double tolerance, double rounding) const {
  SignedDistance result;
  result.normal = normal();
  const std::optional<Vector3d> on_a = deepestOnA(result.normal, tolerance);
  if (!on_a) return std::nullopt;
  result.distance = separation();
  result.point_a = on_a->cwiseMin(half_a_).cwiseMax(-half_a_);
  result.point_b = result.point_a + result.distance * result.normal;
  const Vector3d in_b = a_T_b_.linear().transpose() * (result.point_b - a_T_b_.translation());
  // If the boxes just touch, the points prove the upper bound, so they must lie in the boxes within its rounding.
  if (!isInside(*on_a, half_a_, 2.0 * rounding) || !isInside(in_b, half_b_, 0.5 * rounding)) return std::nullopt;
  result.unique = isUnique(result.normal, tolerance);
  return result;
}

double overlapByAxes(const Vector3d& half_a, const Vector3d& half_b, const Eigen::Isometry3d& a_T_b, double rounding) {
  const auto axes_b = a_T_b.linear();
  const Vector3d t = a_T_b.translation();
  const Eigen::Matrix3d sizes = axes_b.cwiseAbs();
  const Vector3d by_a = t.cwiseAbs() - half_a - sizes * half_b;
  const Vector3d by_b = (axes_b.transpose() * t).cwiseAbs() - half_b - sizes.transpose() * half_a;
  Vector3d greatest = by_a.cwiseMax(by_b);
  for (int j = 0; j < 3; ++j) {
    const Vector3d edge = sizes.col(j);
    const Vector3d reach_a(half_a.y() * edge.z() + half_a.z() * edge.y(), half_a.z() * edge.x() + half_a.x() * edge.z(),
                           half_a.x() * edge.y() + half_a.y() * edge.x());
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    const Vector3d reach_b = half_b[k] * sizes.col(l) + half_b[l] * sizes.col(k);
    const Vector3d offset = t.cross(axes_b.col(j)).cwiseAbs();
    greatest = greatest.cwiseMax(offset - reach_a - reach_b);
  }
  constexpr double kRoundings = 64.0, kParallel = 1e-3;
  const double upper = greatest.maxCoeff() + kRoundings * rounding;
  if (upper < 0.0) return upper;
  // With a small tilt each axis of b has one large component, along the axis of a to which it is nearly parallel. With
  // a larger one the products of edges are long enough to decide.
  const double tilt = std::max((sizes.rowwise().sum() - sizes.rowwise().maxCoeff()).maxCoeff(),
                               (sizes.colwise().sum() - sizes.colwise().maxCoeff()).maxCoeff());
  const double shrink = tilt * half_b.maxCoeff();
  const double parallel = by_a.maxCoeff() + 2.0 * shrink + kRoundings * rounding;
  const bool is_proven = tilt < kParallel && half_b.minCoeff() >= shrink && parallel < 0.0;
  return is_proven ? parallel : std::numeric_limits<double>::infinity();
}

std::optional<NearestOfBoxes> nearestOfBoxes(const Vector3d& half_a, const Vector3d& half_b,
                                             const Eigen::Isometry3d& a_T_b, double tolerance) {
  constexpr int kMaxSweeps = 4;
  constexpr double kShortest = 1e-140;
  const Padded x = column(a_T_b, 0), y = column(a_T_b, 1), z = column(a_T_b, 2), centre = column(a_T_b, 3);
  Padded half = half_a.z() * Padded(0.0, 0.0, 1.0, 0.0);
  half.head<2>() = half_a.head<2>();
  const Padded towards_a = nearestIn(half, centre) - centre;
  const auto along = [&](const Padded& v) { return Vector3d((x * v).sum(), (y * v).sum(), (z * v).sum()); };
  const auto at = [&](const Vector3d& in_b) -> Padded { return centre + in_b.x() * x + in_b.y() * y + in_b.z() * z; };
  Vector3d in_b = along(towards_a).cwiseMin(half_b).cwiseMax(-half_b);
  Padded on_b = at(in_b);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    moveAlong(x, half_b.x(), half, on_b, in_b.x());
    moveAlong(y, half_b.y(), half, on_b, in_b.y());
    moveAlong(z, half_b.z(), half, on_b, in_b.z());
    on_b = at(in_b);
    const Padded on_a = nearestIn(half, on_b), difference = on_b - on_a;
    const double distance = std::sqrt(difference.square().sum());
    if (!(distance > kShortest)) return std::nullopt;  // the boxes overlap, or squares lose digits
    const double gap =
        ((difference * centre).sum() - (half * difference.abs()).sum() - half_b.dot(along(difference).cwiseAbs())) /
        distance;
    if (distance - gap <= tolerance)  // false for NaN
      return NearestOfBoxes{on_a.matrix().head<3>(), on_b.matrix().head<3>(), distance, gap};
  }
  return std::nullopt;
}

bool boxesMeetInOnePoint(const Vector3d& half_a, const Vector3d& half_b, const Eigen::Isometry3d& a_T_b,
                         const Vector3d& normal, double tolerance) {
  const Vector3d normal_b = a_T_b.linear().transpose() * normal;
  // The edges perpendicular to the normal: their number, and the last one.
  int edges_a = 0, edges_b = 0, edge_a = 0, edge_b = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_level_a = std::abs(2.0 * half_a[axis] * normal[axis]) <= tolerance;
    const bool is_level_b = std::abs(2.0 * half_b[axis] * normal_b[axis]) <= tolerance;
    edges_a += static_cast<int>(is_level_a);
    edges_b += static_cast<int>(is_level_b);
    edge_a = is_level_a ? axis : edge_a;
    edge_b = is_level_b ? axis : edge_b;
  }
  if (edges_a == 0 || edges_b == 0) return true;
  if (edges_a + edges_b > 2) return false;
  const double length_a = 2.0 * half_a[edge_a], length_b = 2.0 * half_b[edge_b];
  const double sine = Vector3d::Unit(edge_a).cross(a_T_b.linear().col(edge_b)).norm();
  return std::min(length_a, length_b) * sine > tolerance;
}

}  // namespace proximity_server::narrowphase
