#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "proximity_server/narrowphase/shape.h"
#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server {

/// Point of the core that lies farthest along `direction` (not zero), in the shape's frame.
///
/// `vertex` is where the search on a large hull begins and ends; any value is legal, the last answer is the best.
/// Error:  the point's coordinate along the direction is within 4 eps coreRadius() of the true maximum.
/// Source: van den Bergen, A Fast and Robust GJK Implementation for Collision Detection of Convex Objects, J. Graphics
///         Tools 1999 (closed forms); Cameron, Enhancing GJK, ICRA 1997 (hill climbing over the adjacency).
Eigen::Vector3d supportPoint(const Shape& shape, const Eigen::Vector3d& direction, int& vertex);

/// The flat part of the core that lies within `tolerance` [m] of the support plane of the unit `direction`.
struct SupportFeature {
  int dimension;          ///< 0 vertex or curved, 1 edge, 2 face
  Eigen::Vector3d along;  ///< of an edge: one end to the other, in the shape's frame
};
SupportFeature supportFeature(const Shape& shape, const Eigen::Vector3d& direction, double tolerance, int& vertex);

/// Vertex of the configuration space obstacle (Minkowski difference) A - B of two cores, with the points that made it.
struct CsoVertex {
  Eigen::Vector3d point;  ///< the point on a minus that on b
  Eigen::Vector3d on_a;
  Eigen::Vector3d onB() const { return on_a - point; }
};

/// [m] what rounding may add to or take from the coordinate of a CSO vertex along a unit vector, or from its norm.
double csoRounding(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

/// The CSO of two cores by its support mapping. Frame: that of a.
class Cso {
 public:
  /// `warm_start` gives the first vertices of large hulls, and takes the last.
  Cso(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, WarmStart& warm_start);

  /// Vertex farthest along `direction`: the one that A shows towards B when direction is the normal a to b.
  CsoVertex vertex(const Eigen::Vector3d& direction) {
    const Eigen::Vector3d on_a = supportPoint(a_, direction, warm_start_.vertex_a);
    const Eigen::Vector3d towards_a = -(b_axes_.transpose() * direction);
    const Eigen::Vector3d on_b = b_axes_ * supportPoint(b_, towards_a, warm_start_.vertex_b) + b_origin_;
    return {on_a - on_b, on_a};
  }

  /// From the centre of a's core to that of b's.
  const Eigen::Vector3d& centreDifference() const { return centre_difference_; }

  /// [m] the gap between the bounds at which a search may end, if it gets there: better than the tolerance, as a search
  /// on a polytope ends on a true face, edge or vertex, and Newton's method on a curve doubles the digits.
  double finalGap(double tolerance) const { return std::min(tolerance, (is_polytope_ ? 4.0 : 1024.0) * rounding_); }

  /// [m] see csoRounding.
  double rounding() const { return rounding_; }

  bool isPolytope() const { return is_polytope_; }
  const Shape& a() const { return a_; }
  const Shape& b() const { return b_; }
  const Eigen::Matrix3d& bAxes() const { return b_axes_; }
  const Eigen::Vector3d& bOrigin() const { return b_origin_; }

 private:
  const Shape& a_;
  const Shape& b_;
  const Eigen::Matrix3d b_axes_;
  const Eigen::Vector3d b_origin_;
  WarmStart& warm_start_;
  Eigen::Vector3d centre_difference_;
  double rounding_;
  bool is_polytope_;
};

}  // namespace proximity_server
