#include "benchmark/subalgorithms.h"

#include "narrowphase/cso/simplex.h"

#include <Eigen/Dense>

#include <cmath>
#include <limits>

namespace proximity_server::benchmark {

using namespace narrowphase;
namespace {

using Eigen::Vector3d;

std::size_t index(int i) { return static_cast<std::size_t>(i); }
unsigned bit(int i) { return 1u << i; }
bool has(unsigned subset, int i) { return (subset >> i & 1u) != 0; }

/// Keeps the nearest of all candidates.
class NearestSoFar {
 public:
  void offer(const NearestInSet& candidate) {
    const double norm2 = candidate.point.squaredNorm();
    if (!(norm2 < best_norm2_)) return;
    best_norm2_ = norm2;
    best_ = candidate;
  }
  const NearestInSet& best() const { return best_; }

 private:
  double best_norm2_ = std::numeric_limits<double>::infinity();
  NearestInSet best_;
};

// ---- Johnson

/// delta[X][i]: the determinant of point i in the subset X, proportional to its weight.
class Determinants {
 public:
  explicit Determinants(const PointSet& set) : set_(set), subsets_(1u << set.size) {
    for (int i = 0; i < set.size; ++i)
      for (int j = 0; j <= i; ++j)
        dots_[index(i)][index(j)] = dots_[index(j)][index(i)] = set.points[index(i)].dot(set.points[index(j)]);
    for (unsigned subset = 1; subset < subsets_; ++subset)
      for (int j = 0; j < set.size; ++j)
        if (has(subset, j)) delta_[subset][index(j)] = determinant(subset & ~bit(j), j);
  }

  bool allPositive(unsigned subset) const {
    for (int i = 0; i < set_.size; ++i)
      if (has(subset, i) && !(delta_[subset][index(i)] > 0.0)) return false;
    return true;
  }

  bool isNearest(unsigned subset) const {
    if (!allPositive(subset)) return false;
    for (int j = 0; j < set_.size; ++j)
      if (!has(subset, j) && delta_[subset | bit(j)][index(j)] > 0.0) return false;
    return true;
  }

  NearestInSet nearestOf(unsigned subset) const {
    NearestInSet nearest{Vector3d::Zero(), subset};
    double sum = 0.0;
    for (int i = 0; i < set_.size; ++i) {
      if (!has(subset, i)) continue;
      sum += delta_[subset][index(i)];
      nearest.point += delta_[subset][index(i)] * set_.points[index(i)];
    }
    nearest.point /= sum;
    return nearest;
  }

 private:
  /// Returns the determinant of j in rest + {j}: the sum over i in rest of delta_i(rest) (y_i . y_k - y_i . y_j), k the
  /// first of rest.
  double determinant(unsigned rest, int j) const {
    if (rest == 0) return 1.0;
    int k = 0;
    while (!has(rest, k)) ++k;
    double sum = 0.0;
    for (int i = 0; i < set_.size; ++i)
      if (has(rest, i)) sum += delta_[rest][index(i)] * (dots_[index(i)][index(k)] - dots_[index(i)][index(j)]);
    return sum;
  }

  const PointSet& set_;
  unsigned subsets_;
  std::array<std::array<double, 4>, 4> dots_;
  std::array<std::array<double, 4>, 16> delta_;
};

// ---- explicit solve

template <int n>
void offerSolution(const PointSet& set, const std::array<int, 4>& places, NearestSoFar& nearest) {
  Eigen::Matrix<double, 3, n> y;
  unsigned members = 0;
  for (int i = 0; i < n; ++i) {
    y.col(i) = set.points[index(places[index(i)])];
    members |= bit(places[index(i)]);
  }
  Eigen::Matrix<double, n, n> a;
  a.row(0).setOnes();
  for (int i = 1; i < n; ++i) a.row(i) = (y.col(i) - y.col(0)).transpose() * y;
  const Eigen::Matrix<double, n, 1> lambda = a.inverse().col(0);  // b = (1, 0, ...)
  if (lambda.minCoeff() >= 0.0) nearest.offer({y * lambda, members});
}

void offerSubset(const PointSet& set, unsigned subset, NearestSoFar& nearest) {
  std::array<int, 4> places{};
  int count = 0;
  for (int i = 0; i < set.size; ++i)
    if (has(subset, i)) places[index(count++)] = i;
  switch (count) {
    case 1:
      return nearest.offer({set.points[index(places[0])], subset});
    case 2:
      return offerSolution<2>(set, places, nearest);
    case 3:
      return offerSolution<3>(set, places, nearest);
    default:
      return offerSolution<4>(set, places, nearest);
  }
}

// ---- signed volumes

bool sameSign(double x, double y) { return (x > 0.0 && y > 0.0) || (x < 0.0 && y < 0.0); }

NearestInSet volumesOfEdge(const PointSet& set, int i, int j) {
  const Vector3d &p = set.points[index(i)], &q = set.points[index(j)], edge = q - p;
  const Vector3d foot = p - (p.dot(edge) / edge.squaredNorm()) * edge;
  int axis;
  edge.cwiseAbs().maxCoeff(&axis);
  const double length = edge[axis], of_p = q[axis] - foot[axis], of_q = foot[axis] - p[axis];
  if (sameSign(length, of_p) && sameSign(length, of_q))
    return {(of_p / length) * p + (of_q / length) * q, bit(i) | bit(j)};
  return sameSign(length, of_p) ? NearestInSet{p, bit(i)} : NearestInSet{q, bit(j)};
}

NearestInSet volumesOfTriangle(const PointSet& set, const std::array<int, 3>& t) {
  const Vector3d &p = set.points[index(t[0])], &q = set.points[index(t[1])], &r = set.points[index(t[2])];
  const Vector3d normal = (q - p).cross(r - p);
  const Vector3d foot = (p.dot(normal) / normal.squaredNorm()) * normal;
  int axis;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto area = [&](const Vector3d& x, const Vector3d& y, const Vector3d& z) {
    return (y[u] - x[u]) * (z[v] - x[v]) - (y[v] - x[v]) * (z[u] - x[u]);
  };
  const double whole = area(p, q, r);
  const std::array<double, 3> of = {area(foot, q, r), area(p, foot, r), area(p, q, foot)};
  if (sameSign(whole, of[0]) && sameSign(whole, of[1]) && sameSign(whole, of[2]))
    return {(of[0] * p + of[1] * q + of[2] * r) / whole, bit(t[0]) | bit(t[1]) | bit(t[2])};
  NearestSoFar nearest;
  for (std::size_t k = 0; k < 3; ++k)
    if (!sameSign(whole, of[k])) nearest.offer(volumesOfEdge(set, t[(k + 1) % 3], t[(k + 2) % 3]));
  return nearest.best();
}

NearestInSet volumesOfTetrahedron(const PointSet& set) {
  const auto& [p, q, r, s] = set.points;
  const auto volume = [](const Vector3d& x, const Vector3d& y, const Vector3d& z) { return x.dot(y.cross(z)); };
  const std::array<double, 4> of = {volume(q, s, r), volume(p, r, s), volume(p, s, q), volume(p, q, r)};
  const double whole = of[0] + of[1] + of[2] + of[3];
  NearestSoFar nearest;
  bool inside = true;
  for (int k = 0; k < 4; ++k) {
    if (sameSign(whole, of[index(k)])) continue;
    inside = false;
    nearest.offer(volumesOfTriangle(set, {(k + 1) % 4, (k + 2) % 4, (k + 3) % 4}));
  }
  return inside ? NearestInSet{Vector3d::Zero(), 15u} : nearest.best();
}

}  // namespace

NearestInSet nearestByJohnson(const PointSet& set) {
  const Determinants determinants(set);
  const unsigned subsets = 1u << set.size;
  for (unsigned subset = 1; subset < subsets; ++subset)
    if (determinants.isNearest(subset)) return determinants.nearestOf(subset);
  NearestSoFar nearest;
  for (unsigned subset = 1; subset < subsets; ++subset)
    if (determinants.allPositive(subset)) nearest.offer(determinants.nearestOf(subset));
  return nearest.best();
}

NearestInSet nearestByExplicitSolve(const PointSet& set) {
  NearestSoFar nearest;
  for (unsigned subset = 1; subset < 1u << set.size; ++subset) offerSubset(set, subset, nearest);
  return nearest.best();
}

NearestInSet nearestByVoronoiRegions(const PointSet& set) {
  Simplex simplex;
  for (int i = 0; i < set.size; ++i) simplex[i].point = set.points[index(i)];
  const int newest = set.size - 1;
  simplex.members = bit(newest) - 1;
  const Nearest nearest = nearestToOrigin(simplex, newest);
  if (nearest.encloses_origin) return {Vector3d::Zero(), nearest.members};
  return {-nearest.distance * nearest.normal(), nearest.members};
}

NearestInSet nearestBySignedVolumes(const PointSet& set) {
  switch (set.size) {
    case 1:
      return {set.points[0], 1u};
    case 2:
      return volumesOfEdge(set, 0, 1);
    case 3:
      return volumesOfTriangle(set, {0, 1, 2});
    default:
      return volumesOfTetrahedron(set);
  }
}

}  // namespace proximity_server::benchmark
