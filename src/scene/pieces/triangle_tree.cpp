#include "scene/pieces/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

/// The point of the segment from a to b that is nearest to p. `ab`: b - a, `ap`: p - a.
Vector3d nearestPointOnSegment(const Vector3d& a, const Vector3d& b, const Vector3d& ab, const Vector3d& ap) {
  const double along = ab.dot(ap);
  if (!(along > 0)) return a;
  const double whole = ab.squaredNorm();
  return along < whole ? Vector3d(a + along / whole * ab) : b;
}

/// The nearest to p of the points offered.
struct NearestOffered {
  NearestOffered(const Vector3d& from, const Vector3d& first)
      : p(from), point(first), squared((first - from).squaredNorm()) {}

  void offer(const Vector3d& candidate) {
    const double its_squared = (candidate - p).squaredNorm();
    if (!(its_squared < squared)) return;
    point = candidate;
    squared = its_squared;
  }

  const Vector3d& p;
  Vector3d point;
  double squared;  ///< [m^2] its squared distance from p
};

/// The place of a triangle among others: three times its centroid.
Vector3d placeOf(const Triangle& t) { return t[0] + t[1] + t[2]; }

/// True if planes perpendicular to `axis` keep both triangles apart in spite of rounding. The rounding of a scalar
/// product of three terms is at most 3/2 eps of the sum of their sizes, and the rounding of the coordinates 1/2 eps;
/// there are two products. Rounded up to 8.
bool separates(const Vector3d& axis, const Triangle& s, const Triangle& t) {
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  const Eigen::Array3d along_s(axis.dot(s[0]), axis.dot(s[1]), axis.dot(s[2]));
  const Eigen::Array3d along_t(axis.dot(t[0]), axis.dot(t[1]), axis.dot(t[2]));
  const double gap = std::max(along_s.minCoeff() - along_t.maxCoeff(), along_t.minCoeff() - along_s.maxCoeff());
  if (!(gap > 0.0)) return false;
  double size = 0.0;
  for (const Triangle* triangle : {&s, &t})
    for (const Vector3d& corner : *triangle) size = std::max(size, axis.cwiseAbs().dot(corner.cwiseAbs()));
  return gap > kRounding * size;
}

/// True if a plane perpendicular to one of these axes is proven to keep the triangles apart: both normals, the cross
/// products of an edge of each, and the normals of the edges within their planes. For triangles with an area that do
/// not touch within rounding, one of these axes separates, as in Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996,
/// Theorem 1. For triangles without an area there may be no such axis.
bool areApart(const Triangle& s, Triangle t) {
  // The nearer the triangles are to the origin, the smaller is the rounding.
  Triangle at_origin;
  for (std::size_t i = 0; i < 3; ++i) at_origin[i] = s[i] - s[0];
  for (Vector3d& corner : t) corner -= s[0];
  const auto edges = [](const Triangle& of) {
    return std::array<Vector3d, 3>{of[1] - of[0], of[2] - of[1], of[0] - of[2]};
  };
  const std::array<Vector3d, 3> of_s = edges(at_origin), of_t = edges(t);
  const Vector3d normal_s = of_s[0].cross(of_s[1]), normal_t = of_t[0].cross(of_t[1]);
  const auto is_axis = [&](const Vector3d& axis) { return separates(axis, at_origin, t); };
  if (is_axis(normal_s) || is_axis(normal_t)) return true;
  for (const Vector3d& a : of_s)
    for (const Vector3d& b : of_t)
      if (is_axis(a.cross(b))) return true;
  for (std::size_t i = 0; i < 3; ++i)
    if (is_axis(normal_s.cross(of_s[i])) || is_axis(normal_t.cross(of_t[i]))) return true;
  return false;
}

}  // namespace

Vector3d nearestPoint(const Triangle& triangle, const Vector3d& p) {
  const auto& [a, b, c] = triangle;
  const Vector3d ab = b - a, bc = c - b, ca = a - c, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const Vector3d normal = ab.cross(ac);
  const bool above_face = normal.dot(ab.cross(ap)) > 0 && normal.dot(bc.cross(bp)) > 0 && normal.dot(ca.cross(cp)) > 0;
  // The square of a smaller normal underflows. Such a triangle is no wider than 1e-77 m: its edges are near enough.
  const double squared = normal.squaredNorm();
  if (above_face && squared >= std::numeric_limits<double>::min()) return p - normal.dot(ap) / squared * normal;

  NearestOffered best(p, nearestPointOnSegment(a, b, ab, ap));
  best.offer(nearestPointOnSegment(b, c, bc, bp));
  best.offer(nearestPointOnSegment(c, a, ca, cp));
  return best.point;
}

Vector3d nearestCombination(const Triangle& triangle, const Vector3d& p) {
  const auto& [a, b, c] = triangle;
  const Vector3d ab = b - a, bc = c - b, ca = a - c, ap = p - a, bp = p - b, cp = p - c;
  const Vector3d normal = ab.cross(c - a), on_ab = nearestPointOnSegment(a, b, ab, ap);
  const double of_a = normal.dot(bc.cross(bp)), of_b = normal.dot(ca.cross(cp)), of_c = normal.dot(ab.cross(ap));
  const bool above_face = of_a > 0 && of_b > 0 && of_c > 0;
  NearestOffered best(p, above_face ? Vector3d((of_a * a + of_b * b + of_c * c) / (of_a + of_b + of_c)) : on_ab);
  if (above_face) best.offer(on_ab);
  best.offer(nearestPointOnSegment(b, c, bc, bp));
  best.offer(nearestPointOnSegment(c, a, ca, cp));
  return best.point;
}

namespace {

/// A measure of the queries that visit a box: half of its surface.
double visitsOf(const Eigen::AlignedBox3d& box) {
  const Vector3d size = box.sizes();
  return size.x() * size.y() + size.z() * (size.x() + size.y());
}

/// Bins of equal width along one axis, into which triangles are sorted by their places.
struct Bins {
  static constexpr int kCount = 16;

  int of(const Triangle& triangle) const {
    return std::clamp(static_cast<int>((placeOf(triangle)[axis] - low) * bins_per_length), 0, kCount - 1);
  }

  /// Returns the first bin above the boundary between bins where the sum of triangles times visits is smallest, or 0 if one
  /// bin has all triangles.
  int cheapestBoundary(const Triangle* begin, const Triangle* end) const {
    std::array<Eigen::AlignedBox3d, kCount> boxes;
    std::array<int, kCount> counts{};
    for (const Triangle* triangle = begin; triangle != end; ++triangle) {
      const int bin = of(*triangle);
      ++counts[bin];
      for (const Vector3d& corner : *triangle) boxes[bin].extend(corner);
    }
    std::array<double, kCount> costs_above{};
    Eigen::AlignedBox3d above, below;
    for (int i = kCount - 1, count = 0; i > 0; --i) {
      above.extend(boxes[i]);
      count += counts[i];
      costs_above[i] = count > 0 ? count * visitsOf(above) : 0.0;
    }
    int cheapest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 1, count = 0; i < kCount; ++i) {
      below.extend(boxes[i - 1]);
      count += counts[i - 1];
      if (count == 0 || count == end - begin) continue;
      const double cost = count * visitsOf(below) + costs_above[i];
      if (!(cost < least)) continue;
      least = cost;
      cheapest = i;
    }
    return cheapest;
  }

  Eigen::Index axis;
  double low, bins_per_length;  // of all bins
};

}  // namespace

TriangleBoxes::TriangleBoxes(std::vector<Triangle> all) : triangles(std::move(all)) {
  nodes.push_back({{}, 0, static_cast<int>(triangles.size())});
  // split() appends the children, which the loop splits later.
  std::vector<int> levels{0};
  for (int node = 0; node < static_cast<int>(nodes.size()); ++node) {
    split(node, levels[node]);
    levels.resize(nodes.size(), levels[node] + 1);
  }
}

TriangleBoxes::TriangleBoxes(const TriangleBoxes& tree, const Eigen::Matrix3d& turn)
    : triangles(tree.triangles), nodes(tree.nodes) {
  for (Triangle& triangle : triangles)
    for (Vector3d& corner : triangle) corner = turn * corner;
  // A child stands behind its parent.
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
    node->box.setEmpty();
    if (node->left >= 0) node->box.extend(nodes[node->left].box).extend(nodes[node->left + 1].box);
    for (int i = node->begin; node->left < 0 && i < node->end; ++i)
      for (const Vector3d& corner : triangles[i]) node->box.extend(corner);
  }
}

/// Fits the box of a node and divides its triangles.
void TriangleBoxes::split(int index, int level) {
  constexpr int kLeafSize = 2;
  Node& node = nodes[index];
  Eigen::AlignedBox3d places;
  for (int i = node.begin; i < node.end; ++i) {
    for (const Vector3d& corner : triangles[i]) node.box.extend(corner);
    places.extend(placeOf(triangles[i]));
  }
  if (node.end - node.begin <= kLeafSize) return;

  constexpr double kShortest = 1e-12;  // [m]; below it rounding decides on the bins
  Eigen::Index axis;
  const double length = places.sizes().maxCoeff(&axis);
  Triangle *const begin = triangles.data() + node.begin, *const end = triangles.data() + node.end;
  Triangle* middle = begin + (end - begin) / 2;
  const Bins bins{axis, places.min()[axis], Bins::kCount / length};
  const int boundary = level < kMostUnequal && length > kShortest ? bins.cheapestBoundary(begin, end) : 0;
  if (boundary > 0) {
    middle = std::partition(begin, end, [&](const Triangle& t) { return bins.of(t) < boundary; });
  } else {
    std::nth_element(begin, middle, end,
                     [axis](const Triangle& s, const Triangle& t) { return placeOf(s)[axis] < placeOf(t)[axis]; });
  }
  const int first = node.begin, second = static_cast<int>(middle - triangles.data()), last = node.end;
  node.left = static_cast<int>(nodes.size());
  nodes.push_back({{}, first, second});
  nodes.push_back({{}, second, last});
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3d& p, Effort& effort, const Triangle* guess,
                                            const Range& range) const {
  constexpr std::size_t kStepsPerNode = 4, kStepsPerTriangle = 20;
  std::size_t steps = 0;
  const Triangle* best_triangle = guess ? guess : &tree_.triangles.front();
  Vector3d best = nearestPoint(*best_triangle, p);
  double best_squared = (best - p).squaredNorm();
  if (const double far_squared = range.far * range.far; !(best_squared < far_squared)) {
    best_squared = far_squared;
    best_triangle = nullptr;
  }
  constexpr double kClearly = 1.0 - 1e-14;  // the root of what ends the search is within `enough` in spite of rounding
  const double enough_squared = range.enough > 0.0 ? kClearly * range.enough * range.enough : -1.0;
  const auto isFar = [&](double squared) {
    steps += kStepsPerNode;
    return squared >= best_squared || best_squared <= enough_squared;
  };
  tree_.lookAround(p, isFar, [&](const TriangleBoxes::Node& leaf) {
    steps += kStepsPerTriangle * static_cast<std::size_t>(leaf.end - leaf.begin);
    for (int i = leaf.begin; i < leaf.end; ++i) {
      const Vector3d candidate = nearestPoint(tree_.triangles[i], p);
      const double squared = (candidate - p).squaredNorm();
      if (squared >= best_squared) continue;
      best_squared = squared;
      best = candidate;
      best_triangle = &tree_.triangles[i];
    }
  });
  effort.spend(steps);
  return {best, best_triangle, std::sqrt(best_squared)};
}

bool TriangleTree::mayMeet(const Triangle& other, Effort& effort) const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& corner : other) box.extend(corner);
  return anyIn(box, effort, [&](const Triangle& triangle) { return !areApart(triangle, other); });
}

}  // namespace proximity_server::scene
