#include "scene/derivative/plane_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

struct Edge {
  Vector2d start, along;
};

/// Calls `visit(edge)` for each edge. A segment has one edge, a point has none.
template <class Visit>
void forEachEdge(const PlaneFigure& polygon, const Visit& visit) {
  const std::vector<Vector2d>& corners = polygon.corners();
  const std::size_t edges = corners.size() > 2 ? corners.size() : corners.empty() ? 0 : corners.size() - 1;
  for (std::size_t i = 0; i < edges; ++i) visit(Edge{corners[i], corners[(i + 1) % corners.size()] - corners[i]});
}

double distanceFrom(const Edge& edge, const Vector2d& point) {
  const double squared = edge.along.squaredNorm();
  const double at = squared > 0.0 ? std::clamp(edge.along.dot(point - edge.start) / squared, 0.0, 1.0) : 0.0;
  return (edge.start + at * edge.along - point).norm();
}

/// True if a ray from the point along x crosses the edge.
bool isLeftOf(const Vector2d& point, const Edge& edge) {
  const Vector2d end = edge.start + edge.along;
  if ((edge.start.y() > point.y()) == (end.y() > point.y())) return false;
  return point.x() < edge.start.x() + edge.along.x() * (point.y() - edge.start.y()) / edge.along.y();
}

/// Visits all common points that may be the lowest one, some of them twice.
class Lowest {
 public:
  Lowest(const Vector2d& slope, double tolerance) : slope_(slope), tolerance_(tolerance) {}

  double value() const { return value_; }

  /// Offers the corners of one figure, or the lowest point of a disc, if they lie in the other figure.
  void offerOwn(const PlaneFigure& figure, const PlaneFigure& other) {
    for (const Vector2d& corner : figure.corners())
      if (other.contains(corner, tolerance_)) offer(corner);
    if (!figure.isDisc()) return;
    const Vector2d lowest = figure.centre() - figure.radius() * slope_.normalized();
    if (other.contains(lowest, tolerance_)) offer(lowest);
  }

  void offerCrossings(const PlaneFigure& a, const PlaneFigure& b) {
    if (a.isDisc() && b.isDisc()) return offerCirclesCrossing(a, b);
    if (a.isDisc()) return offerCrossings(b, a);
    forEachEdge(a, [&](const Edge& edge) {
      if (b.isDisc()) offerCrossing(edge, b);
      forEachEdge(b, [&](const Edge& other) { offerCrossing(edge, other); });
    });
  }

 private:
  void offer(const Vector2d& point) { value_ = std::min(value_, slope_.dot(point)); }

  /// The point of an edge that is nearest to the point at the fraction `part` of its line.
  static Vector2d pointOn(const Edge& edge, double part) {
    return edge.start + std::clamp(part, 0.0, 1.0) * edge.along;
  }

  /// True if the point at `at` [m] from the start of an edge belongs to it.
  bool isOn(double at, double length) const { return at >= -tolerance_ && at <= length + tolerance_; }

  void offerCrossing(const Edge& e, const Edge& f) {
    const double sine = cross(e.along, f.along);
    if (sine == 0.0) return;
    const Vector2d apart = f.start - e.start;
    const Vector2d on_e = pointOn(e, cross(apart, f.along) / sine), on_f = pointOn(f, cross(apart, e.along) / sine);
    // If the edges are nearly parallel, rounding makes the crossing useless; but then the ends of one edge are in the
    // other figure.
    if ((on_e - on_f).norm() <= tolerance_) offer(on_e);
  }

  void offerCrossing(const Edge& edge, const PlaneFigure& disc) {
    const double length = edge.along.norm();
    if (length == 0.0) return;
    const Vector2d along = edge.along / length;
    const double foot = along.dot(disc.centre() - edge.start);
    const double distance = std::abs(cross(along, disc.centre() - edge.start));
    if (distance > disc.radius() + tolerance_) return;
    const double half_chord = std::sqrt(std::max(0.0, (disc.radius() - distance) * (disc.radius() + distance)));
    for (const double at : {foot - half_chord, foot + half_chord})
      if (isOn(at, length)) offer(edge.start + std::clamp(at, 0.0, length) * along);
  }

  void offerCirclesCrossing(const PlaneFigure& a, const PlaneFigure& b) {
    const Vector2d apart = b.centre() - a.centre();
    const double distance = apart.norm();
    if (distance == 0.0 || distance > a.radius() + b.radius() + tolerance_) return;
    if (distance < std::abs(a.radius() - b.radius()) - tolerance_) return;
    const Vector2d along = apart / distance;
    const double foot = 0.5 * (distance + (a.radius() - b.radius()) * ((a.radius() + b.radius()) / distance));
    const double half_chord = std::sqrt(std::max(0.0, (a.radius() - foot) * (a.radius() + foot)));
    const Vector2d across(-along.y(), along.x());
    for (const double side : {-half_chord, half_chord}) offer(a.centre() + foot * along + side * across);
  }

  const Vector2d slope_;
  const double tolerance_;
  double value_ = std::numeric_limits<double>::infinity();
};

}  // namespace

void PlaneFigure::reserve(std::size_t points) {
  points_.reserve(points);
  corners_.reserve(2 * points + 1);
}

void PlaneFigure::begin() {
  points_.clear();
  corners_.clear();
  radius_ = 0.0;
}

/// Source: Andrew, Another Efficient Algorithm for Convex Hulls in Two Dimensions, 1979.
void PlaneFigure::close() {
  const auto isBefore = [](const Vector2d& p, const Vector2d& q) {
    return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
  };
  std::sort(points_.begin(), points_.end(), isBefore);
  points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
  const auto extend = [&](const Vector2d& point, std::size_t first) {
    while (corners_.size() > first + 1) {
      const Vector2d& last = corners_.back();
      if (cross(last - corners_[corners_.size() - 2], point - last) > 0.0) break;
      corners_.pop_back();
    }
    corners_.push_back(point);
  };
  for (const Vector2d& point : points_) extend(point, 0);
  if (points_.size() < 2) return;
  const std::size_t lower = corners_.size() - 1;
  for (auto point = points_.rbegin() + 1; point != points_.rend(); ++point) extend(*point, lower);
  corners_.pop_back();  // the first one, which was added again
}

void PlaneFigure::becomeDisc(const Vector2d& centre, double radius) {
  begin();
  centre_ = centre;
  radius_ = radius;
}

bool PlaneFigure::contains(const Vector2d& point, double tolerance) const {
  if (isDisc()) return (point - centre_).norm() <= radius_ + tolerance;
  if (corners_.size() == 1) return (point - corners_[0]).norm() <= tolerance;
  // It is not enough to test the side of each edge: rounding turns short edges, and far from them that would matter.
  bool is_near = false, is_inside = false;
  forEachEdge(*this, [&](const Edge& edge) {
    is_near = is_near || distanceFrom(edge, point) <= tolerance;
    if (isLeftOf(point, edge)) is_inside = !is_inside;
  });
  return is_near || (corners_.size() > 2 && is_inside);
}

double minimumOn(const PlaneFigure& figure, const Vector2d& slope) {
  if (figure.isDisc()) return slope.dot(figure.centre()) - figure.radius() * slope.norm();
  double smallest = std::numeric_limits<double>::infinity();
  for (const Vector2d& corner : figure.corners()) smallest = std::min(smallest, slope.dot(corner));
  return smallest;
}

double minimumInCommon(const PlaneFigure& a, const PlaneFigure& b, const Vector2d& slope, double tolerance) {
  Lowest lowest(slope, tolerance);
  lowest.offerOwn(a, b);
  lowest.offerOwn(b, a);
  lowest.offerCrossings(a, b);
  return lowest.value();
}

}  // namespace proximity_server::scene
