#include "scene/pieces/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

Vector3d nearestPointOnSegment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const Vector3d ab = b - a;
  const double along = ab.dot(p - a);
  if (!(along > 0)) return a;
  const double whole = ab.squaredNorm();
  return along < whole ? Vector3d(a + along / whole * ab) : b;
}

Vector3d centroid(const Triangle& t) { return (t[0] + t[1] + t[2]) / 3.0; }

}  // namespace

Vector3d nearestPoint(const Triangle& triangle, const Vector3d& p) {
  const auto& [a, b, c] = triangle;
  const Vector3d normal = (b - a).cross(c - a);
  const bool above_face = normal.dot((b - a).cross(p - a)) > 0 && normal.dot((c - b).cross(p - b)) > 0 &&
                          normal.dot((a - c).cross(p - c)) > 0;
  if (above_face) return p - normal.dot(p - a) / normal.squaredNorm() * normal;

  Vector3d best = nearestPointOnSegment(a, b, p);
  for (const Vector3d& candidate : {nearestPointOnSegment(b, c, p), nearestPointOnSegment(c, a, p)}) {
    if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
  }
  return best;
}

Vector3d nearestCombination(const Triangle& triangle, const Vector3d& p) {
  const auto& [a, b, c] = triangle;
  const Vector3d normal = (b - a).cross(c - a);
  const double of_a = normal.dot((c - b).cross(p - b)), of_b = normal.dot((a - c).cross(p - c)),
               of_c = normal.dot((b - a).cross(p - a));
  const bool above_face = of_a > 0 && of_b > 0 && of_c > 0;
  Vector3d best =
      above_face ? Vector3d((of_a * a + of_b * b + of_c * c) / (of_a + of_b + of_c)) : nearestPointOnSegment(a, b, p);
  for (const Vector3d& candidate :
       {nearestPointOnSegment(a, b, p), nearestPointOnSegment(b, c, p), nearestPointOnSegment(c, a, p)}) {
    if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
  }
  return best;
}

TriangleBoxes::TriangleBoxes(std::vector<Triangle> all, SplitAxes axes) : triangles(std::move(all)) {
  nodes.push_back({{}, 0, static_cast<int>(triangles.size())});
  // split() appends the children, which are then split in turn.
  for (int node = 0; node < static_cast<int>(nodes.size()); ++node) split(node, axes);
}

/// Fits the box of a node and halves its triangles.
void TriangleBoxes::split(int index, SplitAxes axes) {
  constexpr int kLeafSize = 4;
  Node& node = nodes[index];
  for (int i = node.begin; i < node.end; ++i) {
    for (const Vector3d& corner : triangles[i]) node.box.extend(corner);
  }
  if (node.end - node.begin <= kLeafSize) return;

  Eigen::Index axis;
  node.box.sizes().head(static_cast<Eigen::Index>(axes)).maxCoeff(&axis);
  const int begin = node.begin, end = node.end, middle = (begin + end) / 2;
  std::nth_element(triangles.begin() + begin, triangles.begin() + middle, triangles.begin() + end,
                   [axis](const Triangle& s, const Triangle& t) { return centroid(s)[axis] < centroid(t)[axis]; });
  node.left = static_cast<int>(nodes.size());
  nodes.push_back({{}, begin, middle});
  nodes.push_back({{}, middle, end});
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3d& p, Effort& effort) const {
  constexpr std::size_t kStepsPerNode = 4, kStepsPerTriangle = 20;
  std::size_t steps = 0;
  const auto& [triangles, nodes] = tree_;
  Vector3d best = triangles.front()[0];
  const Triangle* best_triangle = &triangles.front();
  double best_squared = (best - p).squaredNorm();
  // Halving leaves at most 31 levels below an int's worth of triangles; each holds one sibling back.
  std::array<int, 64> pending{0};
  for (int count = 1; count > 0;) {
    const TriangleBoxes::Node& node = nodes[pending[--count]];
    steps += kStepsPerNode;
    if (node.box.squaredExteriorDistance(p) >= best_squared) continue;
    if (node.left >= 0) {
      const bool left_first =
          nodes[node.left].box.squaredExteriorDistance(p) < nodes[node.left + 1].box.squaredExteriorDistance(p);
      pending[count++] = left_first ? node.left + 1 : node.left;
      pending[count++] = left_first ? node.left : node.left + 1;
      continue;
    }
    steps += kStepsPerTriangle * static_cast<std::size_t>(node.end - node.begin);
    for (int i = node.begin; i < node.end; ++i) {
      const Vector3d candidate = nearestPoint(triangles[i], p);
      const double squared = (candidate - p).squaredNorm();
      if (squared >= best_squared) continue;
      best_squared = squared;
      best = candidate;
      best_triangle = &triangles[i];
    }
  }
  effort.spend(steps);
  return {best, best_triangle, std::sqrt(best_squared)};
}

}  // namespace proximity_server::scene
