#pragma once

#include <Eigen/Core>

#include <vector>

namespace proximity_server::scene {

/// A convex figure in a plane: a polygon, a segment, a point, or a disc. [m]
///
/// It keeps its memory, so that it can be made anew without allocations, see reserve().
class PlaneFigure {
 public:
  void reserve(std::size_t points);

  /// Becomes the convex hull of points that are added one by one, in any order: begin(), add() ..., close().
  void begin();
  void add(const Eigen::Vector2d& point) { points_.push_back(point); }
  void close();

  void becomeDisc(const Eigen::Vector2d& centre, double radius);

  bool isDisc() const { return radius_ > 0.0; }
  const Eigen::Vector2d& centre() const { return centre_; }
  double radius() const { return radius_; }

  /// Counter-clockwise; a segment has two, and a disc none.
  const std::vector<Eigen::Vector2d>& corners() const { return corners_; }

  /// True if the point is in the figure, or no farther from it than `tolerance` [m].
  bool contains(const Eigen::Vector2d& point, double tolerance) const;

 private:
  std::vector<Eigen::Vector2d> points_, corners_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double radius_ = 0.0;  ///< 0: it is not a disc
};

/// The smallest value of slope . x over the points x of a figure; infinity if it is empty.
double minimumOn(const PlaneFigure& figure, const Eigen::Vector2d& slope);

/// The smallest value of slope . x over the points x that two figures have in common; infinity if there are none.
/// Corners that are outside of the other figure by no more than `tolerance` [m] count as common, so the result is
/// smaller than the true value by at most |slope| * tolerance.
///
/// A linear function is smallest at a corner of the intersection: a corner of one figure in the other one, a crossing
/// of the two outlines, or the point of a disc that is farthest against the slope.
double minimumInCommon(const PlaneFigure& a, const PlaneFigure& b, const Eigen::Vector2d& slope, double tolerance);

}  // namespace proximity_server::scene
