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

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  nodes_.push_back({{}, 0, static_cast<int>(triangles_.size())});
  // split() appends the children, which are then visited in turn.
  for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) split(node);
}

/// Fits the box of a node and halves its triangles along the box's longest edge.
void TriangleTree::split(int index) {
  constexpr int kLeafSize = 4;
  Node& node = nodes_[index];
  for (int i = node.begin; i < node.end; ++i) {
    for (const Vector3d& corner : triangles_[i]) node.box.extend(corner);
  }
  if (node.end - node.begin <= kLeafSize) return;

  Eigen::Index axis;
  node.box.sizes().maxCoeff(&axis);
  const int begin = node.begin, end = node.end, middle = (begin + end) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle, triangles_.begin() + end,
                   [axis](const Triangle& s, const Triangle& t) { return centroid(s)[axis] < centroid(t)[axis]; });
  node.left = static_cast<int>(nodes_.size());
  nodes_.push_back({{}, begin, middle});
  nodes_.push_back({{}, middle, end});
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3d& p, Effort& effort) const {
  constexpr std::size_t kStepsPerNode = 4, kStepsPerTriangle = 20;
  std::size_t steps = 0;
  Vector3d best = triangles_.front()[0];
  const Triangle* best_triangle = &triangles_.front();
  double best_squared = (best - p).squaredNorm();
  // Halving leaves at most 31 levels below an int's worth of triangles; each holds one sibling back.
  std::array<int, 64> pending{0};
  for (int count = 1; count > 0;) {
    const Node& node = nodes_[pending[--count]];
    steps += kStepsPerNode;
    if (node.box.squaredExteriorDistance(p) >= best_squared) continue;
    if (node.left >= 0) {
      const bool left_first =
          nodes_[node.left].box.squaredExteriorDistance(p) < nodes_[node.left + 1].box.squaredExteriorDistance(p);
      pending[count++] = left_first ? node.left + 1 : node.left;
      pending[count++] = left_first ? node.left : node.left + 1;
      continue;
    }
    steps += kStepsPerTriangle * static_cast<std::size_t>(node.end - node.begin);
    for (int i = node.begin; i < node.end; ++i) {
      const Vector3d candidate = nearestPoint(triangles_[i], p);
      const double squared = (candidate - p).squaredNorm();
      if (squared >= best_squared) continue;
      best_squared = squared;
      best = candidate;
      best_triangle = &triangles_[i];
    }
  }
  effort.spend(steps);
  return {best, best_triangle, std::sqrt(best_squared)};
}

}  // namespace proximity_server::scene
