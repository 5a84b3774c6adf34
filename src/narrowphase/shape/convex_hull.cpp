#include "proximity_server/narrowphase/shape/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "proximity_server/narrowphase/assertion.h"

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Triangles = std::vector<std::array<int, 3>>;

Points withoutDuplicates(Points points) {
  const auto lexicographic = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(points.begin(), points.end(), lexicographic);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Affine frame of a cloud: orthonormal axes, and the reach of the cloud along each.
struct AffineFrame {
  Vector3d origin;
  std::array<Vector3d, 3> axes;
  std::array<double, 3> reach{};
  int dimension = 0;

  double coordinate(const Vector3d& point, std::size_t axis) const {
    return axes[axis].dot(point - origin) / reach[axis];
  }
};

/// The part of v perpendicular to the first `axes` axes. It is projected twice: the first projection leaves the
/// rounding error of a long vector in a short one, which would tilt the next axis, and a second one is enough.
/// Source: Giraud, Langou, Rozloznik, The Loss of Orthogonality in the Gram-Schmidt Orthogonalization Process,
///         Computers and Mathematics with Applications 2005.
Vector3d acrossAxes(Vector3d v, const AffineFrame& frame, std::size_t axes) {
  for (int pass = 0; pass < 2; ++pass)
    for (std::size_t k = 0; k < axes; ++k) v -= frame.axes[k] * frame.axes[k].dot(v);
  return v;
}

/// Finds the frame greedily: each axis points to the point farthest from the span of the axes before it. There is no
/// further axis if this distance is within the rounding of the coordinates, a few eps of the largest one (4 covers the
/// projections onto two axes).
AffineFrame affineFrame(const Points& points) {
  AffineFrame frame;
  frame.origin = points.front();
  double largest = 0.0;
  for (const Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * largest;

  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vector3d farthest = Vector3d::Zero();
    for (const Vector3d& p : points) {
      const Vector3d rest = acrossAxes(p - frame.origin, frame, axis);
      if (rest.squaredNorm() > farthest.squaredNorm()) farthest = rest;
    }
    const double reach = farthest.norm();
    if (reach <= rounding) return frame;
    frame.axes[axis] = axis == 2 ? frame.axes[0].cross(frame.axes[1]) : Vector3d(farthest / reach);
    frame.reach[axis] = reach;
    frame.dimension = static_cast<int>(axis) + 1;
  }
  return frame;
}

/// Indices of the two ends of a collinear cloud.
std::vector<int> segmentEnds(const Points& points, const AffineFrame& frame) {
  const auto along = [&](const Vector3d& a, const Vector3d& b) {
    return frame.coordinate(a, 0) < frame.coordinate(b, 0);
  };
  const auto ends = std::minmax_element(points.begin(), points.end(), along);
  return {static_cast<int>(ends.first - points.begin()), static_cast<int>(ends.second - points.begin())};
}

/// Indices of the corners of a flat cloud, counter-clockwise about the frame's third axis.
/// Source: Andrew, Another Efficient Algorithm for Convex Hulls in Two Dimensions, 1979.
std::vector<int> polygonCorners(const Points& points, const AffineFrame& frame) {
  struct Flat {
    double x, y;
    int index;
  };
  std::vector<Flat> flat;
  for (std::size_t i = 0; i < points.size(); ++i)
    flat.push_back({frame.coordinate(points[i], 0), frame.coordinate(points[i], 1), static_cast<int>(i)});
  std::sort(flat.begin(), flat.end(),
            [](const Flat& a, const Flat& b) { return std::make_pair(a.x, a.y) < std::make_pair(b.x, b.y); });
  const auto turnsLeft = [](const Flat& o, const Flat& a, const Flat& b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x) > 0.0;
  };
  const auto chain = [&](auto first, auto last) {
    std::vector<Flat> corners;
    for (auto p = first; p != last; ++p) {
      while (corners.size() > 1 && !turnsLeft(corners[corners.size() - 2], corners.back(), *p)) corners.pop_back();
      corners.push_back(*p);
    }
    corners.pop_back();  // the first corner of the other chain
    return corners;
  };
  std::vector<int> corners;
  for (const Flat& p : chain(flat.begin(), flat.end())) corners.push_back(p.index);
  for (const Flat& p : chain(flat.rbegin(), flat.rend())) corners.push_back(p.index);
  return corners;
}

Triangles fan(int corners) {
  PROXIMITY_ASSERT(corners >= 3, "A polygon has at least three corners: points on a line become a segment.");
  Triangles triangles;
  for (int i = 2; i < corners; ++i) triangles.push_back({0, i - 1, i});
  return triangles;
}

/// Outward triangles of the hull of a solid cloud. The cloud is scaled to unit size along its own axes before qhull
/// works on it: an affine map does not change which points are vertices, and a thin plate becomes as well conditioned
/// as a cube.
Triangles solidTriangles(const Points& points, const AffineFrame& frame) {
  std::vector<coordT> coordinates;
  for (const Vector3d& p : points)
    for (std::size_t axis = 0; axis < 3; ++axis) coordinates.push_back(frame.coordinate(p, axis));

  std::array<char, 256> messages;  // which nobody reads; what does not fit is lost
  const std::unique_ptr<FILE, int (*)(FILE*)> silent(fmemopen(messages.data(), messages.size(), "w"), &std::fclose);
  qhT state;
  qh_zero(&state, silent.get());
  qhT* qh = &state;
  char command[] = "qhull Qt Pp";
  const int failed =
      qh_new_qhull(qh, 3, static_cast<int>(points.size()), coordinates.data(), False, command, nullptr, silent.get());
  Triangles triangles;
  if (!failed) {
    facetT* facet;
    FORALLfacets {
      setT* corners = qh_facet3vertex(qh, facet);
      const auto corner = [&](int i) { return qh_pointid(qh, static_cast<vertexT*>(corners->e[i].p)->point); };
      triangles.push_back({corner(2), corner(1), corner(0)});  // qhull turns clockwise from outside
      qh_settempfree(qh, &corners);
    }
  }
  qh_freeqhull(qh, !qh_ALL);
  int long_blocks = 0, long_bytes = 0;
  qh_memfreeshort(qh, &long_blocks, &long_bytes);
  return triangles;
}

}  // namespace

ConvexHull::ConvexHull(const std::vector<Vector3d>& input) {
  if (input.empty()) throw std::invalid_argument("a convex hull needs at least one point");
  for (const Vector3d& p : input)
    if (!p.allFinite()) throw std::invalid_argument("a convex hull needs finite points");

  const Points points = withoutDuplicates(input);
  const AffineFrame frame = affineFrame(points);
  dimension_ = frame.dimension;
  std::vector<int> corners;
  switch (dimension_) {
    case 0:
      corners = {0};
      break;
    case 1:
      corners = segmentEnds(points, frame);
      break;
    case 2:
      corners = polygonCorners(points, frame);
      break;
    default:
      triangles_ = solidTriangles(points, frame);
  }
  if (dimension_ == 3) {
    for (const auto& triangle : triangles_) corners.insert(corners.end(), triangle.begin(), triangle.end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  }
  // If qhull fails, all points are kept: a support mapping needs no more.
  if (corners.empty()) {
    corners.resize(points.size());
    std::iota(corners.begin(), corners.end(), 0);
  }
  for (const int corner : corners) vertices_.push_back(points[corner]);
  for (auto& triangle : triangles_)
    for (int& v : triangle) v = static_cast<int>(std::lower_bound(corners.begin(), corners.end(), v) - corners.begin());
  if (dimension_ == 2) triangles_ = fan(size());
  connectNeighbours();
}

void ConvexHull::connectNeighbours() {
  std::vector<std::array<int, 2>> edges;
  for (const auto& [a, b, c] : triangles_) edges.insert(edges.end(), {{a, b}, {b, c}, {c, a}});
  if (triangles_.empty())
    for (int a = 0; a < size(); ++a)
      for (int b = 0; b < a; ++b) edges.push_back({a, b});

  std::vector<int> ends(vertices_.size() + 1, 0);  // of the neighbours of each vertex, which most edges name twice
  for (const auto& [a, b] : edges) ++ends[a + 1], ++ends[b + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<int> named(2 * edges.size()), begins = ends;
  for (const auto& [a, b] : edges) named[ends[a]++] = b, named[ends[b]++] = a;
  offsets_.assign(1, 0);
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    std::sort(named.begin() + begins[v], named.begin() + ends[v]);
    std::unique_copy(named.begin() + begins[v], named.begin() + ends[v], std::back_inserter(neighbours_));
    offsets_.push_back(static_cast<int>(neighbours_.size()));
  }
}

ConvexHull ConvexHull::movedBy(const Vector3d& offset) const {
  ConvexHull moved = *this;
  for (Vector3d& vertex : moved.vertices_) vertex += offset;
  return moved;
}

double ConvexHull::volume() const {
  if (dimension_ < 3) return 0.0;
  double six_volumes = 0.0;
  const auto corner = [&](int v) { return Vector3d(vertices_[v] - vertices_.front()); };
  for (const auto& t : triangles_) six_volumes += corner(t[0]).dot(corner(t[1]).cross(corner(t[2])));
  return six_volumes / 6.0;
}

}  // namespace proximity_server::narrowphase
